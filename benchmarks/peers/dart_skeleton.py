"""DART: a skeleton of one body at a free joint, without gravity. A world has one integrator, semi-implicit Euler."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import dartpy
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from peers.contender import Contender, step_text
from peers.task import INERTIA, NS, RATE, Task

STEPS: Final = (0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0001)
"""At 50 ms the state is infinite within minutes, which DART tells anew at each step."""


def contenders(task: Task) -> Iterator[Contender]:
    """Each step that fits."""
    for step in STEPS:
        if step <= task.smallest_interval:
            yield Contender("DART, free joint", step_text(step), step, _runner(task, step))


def _runner(task: Task, step: float) -> Callable[[], NDArray[np.float64]]:
    counts = np.rint(np.diff(task.times_ns, prepend=0) / (NS * step)).astype(int).tolist()
    world, skeleton = dartpy.simulation.World(), dartpy.dynamics.Skeleton("body")
    _, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), np.diag(INERTIA)))
    world.setGravity(np.zeros(3))
    world.setTimeStep(step)
    world.addSkeleton(skeleton)

    def run() -> NDArray[np.float64]:
        skeleton.setPositions(np.zeros(6))
        skeleton.setVelocities(np.concatenate([RATE, np.zeros(3)]))
        found = np.empty((len(counts), 3, 3))
        for matrix, count in zip(found, counts, strict=True):
            for _ in range(count):
                world.step()
            matrix[:] = body.getWorldTransform().rotation()
        return Rotation.from_matrix(found).as_quat()

    return run
