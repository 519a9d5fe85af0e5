"""This package: the closed form, and four steppers of the moving chart, compiled where numba is installed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.motion.moser_veselov import MAX_TURN
from lie_rigid_body.motion.moving_chart import DEFAULT_MAX_STEP, DEFAULT_METHOD
from peers.contender import Contender, step_text
from peers.task import ATTITUDE, INERTIA, RATE, Task

BODY: Final = RigidBody(INERTIA)
START: Final = State(ATTITUDE, RATE)
SHOWN: Final = ("rkmk4", "dmv2", "dmv10", DEFAULT_METHOD)
"""Steppers that take part; the others are variants of these."""
STEPS: Final = (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005)
UNIT: Final = (DEFAULT_METHOD, 0.001)
"""Stepper and step, s, whose cost is 1."""
LONGEST_STEP: Final = MAX_TURN / float(np.linalg.norm(RATE))
"""About the step of the default stepper where none is asked for, s."""


def contenders(task: Task) -> Iterator[Contender]:
    """The closed form, the moving chart at its defaults, and each stepper at each step that fits; 1 ms is the unit."""
    for method in SHOWN:
        MovingChart(BODY, START, method=method).compile()
    yield Contender("ours, closed form", "exact", 0.0, lambda: _closed_form(task), ours=True)
    for method in SHOWN:
        if method == DEFAULT_METHOD:
            yield _moving_chart(task, method, DEFAULT_MAX_STEP)
        for step in STEPS:
            if step <= task.smallest_interval:
                yield _moving_chart(task, method, step)


def _closed_form(task: Task) -> NDArray[np.float64]:
    return ClosedForm(BODY, START).at(task.times_ns).attitude_xyzw


def _moving_chart(task: Task, method: str, step: float) -> Contender:
    def run() -> NDArray[np.float64]:
        try:
            return MovingChart(BODY, START, method=method, max_step=step).at(task.times_ns).attitude_xyzw
        except LieRigidBodyError:  # the step is too long for the method
            return np.full((len(task.times_ns), 4), np.nan)

    setting = step_text(step) if step else "default"
    return Contender(
        f"ours, moving chart {method}", setting, step or LONGEST_STEP, run, ours=True, unit=(method, step) == UNIT
    )
