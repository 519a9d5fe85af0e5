"""SciPy's RotationSpline through exact attitudes: the truth, logged at a lower rate, between its samples."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, RotationSpline

from lie_rigid_body import ClosedForm
from peers.contender import Contender, step_text
from peers.ours import BODY, START
from peers.task import NS, Task

SPACINGS: Final = (0.1, 0.05, 0.02, 0.01, 0.005, 0.002)
MOST_KNOTS: Final = 10_000


def contenders(task: Task) -> Iterator[Contender]:
    """Each spacing of the knots that leaves something to be interpolated; the knots themselves cost nothing."""
    for spacing in SPACINGS:
        if task.smallest_interval < spacing and task.span / spacing < MOST_KNOTS:
            yield Contender("SciPy, RotationSpline", f"knots {step_text(spacing)}", spacing, _runner(task, spacing))


def _runner(task: Task, spacing: float) -> Callable[[], NDArray[np.float64]]:
    knots_ns = np.arange(round(task.span / spacing) + 1) * round(NS * spacing)
    knots, times, wanted = ClosedForm(BODY, START).at(knots_ns).attitude_xyzw, knots_ns / NS, task.times_ns / NS

    def run() -> NDArray[np.float64]:
        return RotationSpline(times, Rotation.from_quat(knots))(wanted).as_quat()

    return run
