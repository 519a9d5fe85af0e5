"""What motions say when they refuse."""
# mypy: ignore-errors

from __future__ import annotations

import numpy as np

from lie_rigid_body import ClosedForm, InputError, MovingChart, ParameterError, RigidBody, State
from lie_rigid_body.motion.path import MAX_KNOTS, Knots, PosePath
from lie_rigid_body.motion.time_steps import steps_to

BODY = RigidBody([1.0, 2.0, 3.0])
START = State([0.0, 0.0, 0.0, 1.0], [0.1, 0.2, 0.3])
NO_STEPS = (-1.0, np.inf, np.nan, 10**400, "a", None, True, [0.1])
MASKED = np.ma.masked_array([0, 1000], mask=[False, True])


def starts(rates):
    rates = np.asarray(rates, dtype=float)
    return State(np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*rates.shape[:-1], 4)), rates)


def reached(t_ns):
    motion = MovingChart(BODY, START)
    motion.at(t_ns)
    return motion


def chart(rates, *, moments=(1.0, 2.0, 3.0), step=0.001):
    return MovingChart(RigidBody(list(moments)), starts(rates), method="rkmk4", max_step=step)


def path(*seconds, degrees=0.0, norm=1.0):
    half = np.radians(degrees) / 2.0 * np.arange(len(seconds))
    attitude = norm * np.stack([0.0 * half, 0.0 * half, np.sin(half), np.cos(half)], axis=-1)
    return PosePath(Knots((np.array(seconds) * 1e9).astype(np.int64), np.zeros((len(seconds), 3)), attitude))


REFUSED = {
    InputError: [
        *(lambda body=body: MovingChart(body, START) for body in ([1, 2, 3], np.eye(3), START)),
        *(lambda start=start: MovingChart(BODY, start) for start in ([1, 2, 3], None, BODY)),
        lambda: ClosedForm(START, START),
        lambda: ClosedForm(BODY, BODY),
        *(lambda t_ns=t_ns: ClosedForm(BODY, START).at(t_ns) for t_ns in (0.5, "1", [[1, 2]], None, [True, False])),
        lambda: MovingChart(BODY, START).at([2000, 1500]),
        lambda: MovingChart(BODY, START).at([0.1]),
        lambda: ClosedForm(BODY, START).at([[1, 2], [3]]),
        lambda: reached(1000).at(999),
        lambda: chart([0.0, 1e6, 0.0]).at(10**9),
        lambda: ClosedForm(BODY, starts(np.ones((3, 3)))),
        lambda: chart([20.0, 30.0, 10.0], moments=(0.2, 1.0, 1.1), step=0.08).at(400 * 10**9),
        lambda: MovingChart(BODY, starts([1e9, 2e9, 1e9]), max_step=1.0).at(10**18),
        lambda: MovingChart(BODY, START).at(MASKED),
        lambda: ClosedForm(BODY, START).at(MASKED),
        lambda: steps_to(np.array([1]), 0, 1e-300),
    ],
    ParameterError: [
        *(lambda method=method: MovingChart(BODY, START, method=method) for method in ("rkmk9", [], None)),
        *(lambda step=step: MovingChart(BODY, START, max_step=step) for step in NO_STEPS),
        lambda: path(0.0, 0.1, 0.2),
        lambda: path(*range(MAX_KNOTS + 1)),
        lambda: path(0.0, 0.2, 0.1, 0.3),
        lambda: path(0.0, 0.1, 0.2, 0.3, norm=0.9),
        lambda: path(0.0, 0.1, 0.2, 0.3, degrees=175.0),
    ],
}
