"""This package: every stepper of the moving chart, compiled where numba is installed, and the closed form."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.motion import METHODS
from lie_rigid_body.motion.moving_chart import DEFAULT_METHOD, DEFAULT_STEP
from peers.contender import Contender, step_text
from peers.task import ATTITUDE, INERTIA, RATE, Task

BODY: Final = RigidBody(INERTIA)
START: Final = State(ATTITUDE, RATE)
STEPS: Final = sorted({0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, DEFAULT_STEP}, reverse=True)


def contenders(task: Task) -> Iterator[Contender]:
    """The closed form, and each method of the moving chart at each step that fits."""
    for method in METHODS:
        MovingChart(BODY, START, method=method).compile()
    yield Contender("ours, closed form", "exact", 0.0, lambda: _closed_form(task), ours=True)
    for method in METHODS:
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

    unit = (method, step) == (DEFAULT_METHOD, DEFAULT_STEP)
    return Contender(f"ours, moving chart {method}", step_text(step), step, run, ours=True, unit=unit)
