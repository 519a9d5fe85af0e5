"""Calls that another thread does: all of them, in order, and with their errors."""

from __future__ import annotations

import pytest

from lie_rigid_body.certificate.aside import aside


@pytest.mark.parametrize("is_worth_it", [False, True])
def test_calls_aside_are_all_done_in_order(is_worth_it):
    done: list[int] = []
    with aside(done.append, is_worth_it=is_worth_it) as add:
        for number in range(100):
            add(number)
    assert done == list(range(100))


@pytest.mark.parametrize("is_worth_it", [False, True])
def test_the_error_of_a_call_aside_is_raised_here(is_worth_it):
    with pytest.raises(ZeroDivisionError):
        _divide_aside(0, is_worth_it=is_worth_it)


def test_an_error_of_the_caller_comes_before_that_of_a_call_aside():
    with pytest.raises(TypeError):
        _divide_aside(0, None, is_worth_it=True)


def _divide_aside(*numbers: int | None, is_worth_it: bool) -> None:
    def divide(number: int) -> int:
        return 1 // number

    with aside(divide, is_worth_it=is_worth_it) as add:
        for number in numbers:
            if number is None:
                raise TypeError
            add(number)
