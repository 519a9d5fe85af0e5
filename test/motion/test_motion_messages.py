"""The wording of what motions refuse: the value, the limit and the remedy, in one line. Other tests assert on types."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from lie_rigid_body import ClosedForm, InputError, MovingChart, ParameterError, RigidBody, State
from lie_rigid_body.motion.munthe_kaas.tableau import CLASSICAL, Tableau
from lie_rigid_body.motion.time_steps import steps_to

BODY, START = RigidBody([1.0, 2.0, 3.0]), State([0.0, 0.0, 0.0, 1.0], [0.1, 0.2, 0.3])
FAST = [[0.1, 0.2, 0.3], [0.3, 0.5, 1.1], [3.0, 4e3, 0.0]]


WRONG: Any = [1, 2, 3]
MASKED = np.ma.masked_array([0, 1000], mask=[False, True])


def starts(rates: object) -> State:
    rates = np.asarray(rates, dtype=float)
    return State(np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*rates.shape[:-1], 4)), rates)


def reached(t_ns: int) -> MovingChart:
    motion = MovingChart(BODY, START)
    motion.at(t_ns)
    return motion


def chart(rates: object, *, moments: tuple[float, ...] = (1.0, 2.0, 3.0), step: float = 0.001) -> MovingChart:
    return MovingChart(RigidBody(list(moments)), starts(rates), method="rkmk4", max_step=step)


def bodies(*batch: int) -> RigidBody:
    return RigidBody(np.broadcast_to(np.diag([1.0, 2.0, 3.0]), (*batch, 3, 3)))


MESSAGES: list[tuple[Callable[[], object], type[Exception], str]] = [
    (lambda: MovingChart(WRONG, START), InputError, r"body \[1, 2, 3\] is not a RigidBody: give for example"),
    (lambda: ClosedForm(BODY, WRONG), InputError, r"start \[1, 2, 3\] is not a State: give for example"),
    (
        lambda: ClosedForm(bodies(2), starts(np.ones((3, 3)))),
        InputError,
        r"bodies of shape \(2,\) do not go with starts of shape \(3,\): give equal leading axes",
    ),
    (lambda: MovingChart(BODY, START, method="rkmk9"), ParameterError, r"method: .*rkmk9.*choose one of rkmk1, rkmk2"),
    (lambda: MovingChart(BODY, START, max_step=-1.0), ParameterError, r"max_step: -1.0 s is not a positive finite"),
    (lambda: ClosedForm(BODY, START).at(0.5), InputError, r"t_ns has type float64 and shape \(\): give integer"),
    (lambda: MovingChart(BODY, START).at([0.1]), InputError, r".*list, as np\.round\(t_s \* 1e9\).* of seconds$"),
    (lambda: ClosedForm(BODY, START).at([[1, 2], [3]]), InputError, r"t_ns: .* is not numbers: give an array"),
    (lambda: MovingChart(BODY, START, max_step=10**400), ParameterError, r"max_step: .* is not a positive finite time"),
    (lambda: reached(1000).at(999), InputError, r"t_ns 999 lies before 1000, which is already reached: give times"),
    (
        lambda: ClosedForm(BODY, START).at(np.arange(7), memory_limit=1000),
        InputError,
        r"memory_limit 1000 bytes is too little for 1 bodies at 7 times, which take \d+: ask for fewer",
    ),
    (
        lambda: MovingChart(BODY, START).at(0, memory_limit=WRONG),
        InputError,
        r"memory_limit \[1, 2, 3\] is not a number of bytes: give an integer",
    ),
    (
        lambda: chart([0.0, 1e6, 0.0]).at(10**9),
        InputError,
        r"a step of 0\.001 s goes 1e\+03 rad at the rate of its start, or more \(limit 3\.14 rad\): lower max_step",
    ),
    (lambda: chart(FAST).at(10**6), InputError, r"body 2: a step of 0\.001 s goes 4 rad .*lower max_step"),
    (lambda: chart([FAST]).at(10**6), InputError, r"body \(0, 2\): a step of 0\.001 s goes 4 rad .*lower max_step"),
    (
        lambda: chart([20.0, 30.0, 10.0], moments=(0.2, 1.0, 1.1), step=0.08).at(400 * 10**9),
        InputError,
        r"a step of 0\.08 s leads to infinity: lower max_step",
    ),
    (
        lambda: MovingChart(BODY, starts([[0.1, 0.2, 0.3], [1e9, 2e9, 1e9]]), max_step=1.0).at(10**18),
        InputError,
        r"body 1: 1000000000000000000 ns lie too many steps of .* s ahead: ask for an earlier time",
    ),
    (lambda: MovingChart(BODY, START).at(MASKED), InputError, r"t_ns: 1 of its numbers are masked: fill them in, or"),
    (lambda: ClosedForm(BODY, START).at(MASKED), InputError, r"t_ns: 1 of its numbers are masked: fill them in, or"),
    (lambda: steps_to(np.array([1]), 0, 1e-300), InputError, r"1 ns lie too many steps .*or use ClosedForm"),
    (
        lambda: Tableau("t", 4, CLASSICAL.a, (*CLASSICAL.b[:3], Fraction(1, 7))),
        ValueError,
        r"tableau t: order condition Σb gives 41/42, not 1",
    ),
    (
        lambda: Tableau("t", 1, (Fraction(1),), (Fraction(1),)),
        ValueError,
        r"tableau t: not one weight a stage, or one before the first",
    ),
]


@pytest.mark.parametrize(("refused", "kind", "said"), MESSAGES)
def test_what_is_refused_is_told_in_one_line(refused, kind, said) -> None:
    with pytest.raises(kind, match=f"^{said}") as caught:
        refused()
    assert not re.search("\n", str(caught.value))
