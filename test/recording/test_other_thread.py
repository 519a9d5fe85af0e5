"""Work that another thread does: the same values in the same order, and the same errors."""

from __future__ import annotations

import threading

import pytest

from lie_rigid_body.recording.other_thread import Aside, ahead


@pytest.mark.parametrize("most", [0, 1, 3, 20])
def test_values_come_in_order_and_no_more_are_made_than_allowed(most):
    made: list[int] = []

    def square(number: int) -> int:
        made.append(number)
        return number * number

    values = ahead(square, range(10), most)
    for number in range(10):
        assert next(values) == number * number
        assert len(made) <= number + 1 + most
    assert list(values) == []


@pytest.mark.parametrize("most", [0, 2])
def test_an_error_comes_where_its_value_would(most):
    values = ahead(lambda number: 12 // number, (3, 2, 0, 1), most)
    assert [next(values), next(values)] == [4, 6]
    with pytest.raises(ZeroDivisionError):
        next(values)


def test_reading_that_stops_early_leaves_no_thread_behind():
    before = threading.active_count()
    values = ahead(abs, range(1000), 2)
    assert next(values) == 0
    values.close()
    assert threading.active_count() == before


@pytest.mark.parametrize("is_worth_it", [False, True])
def test_calls_aside_are_all_done_in_order(is_worth_it):
    done: list[int] = []
    with Aside(done.append, is_worth_it=is_worth_it) as add:
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
    aside: Aside[int] = Aside(lambda number: 1 // number, is_worth_it=is_worth_it)
    with aside as add:
        for number in numbers:
            if number is None:
                raise TypeError
            add(number)
