"""PyBullet: a free body without gravity or damping, in both of its formulations.

Its gyroscopic term is on by default in both: explicit in the multibody, whose error is that of MuJoCo's Euler, implicit
in the rigid body of ``useMaximalCoordinates``, whose error is that of MuJoCo's implicitfast.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
import pybullet
from numpy.typing import NDArray

from peers.contender import Contender, step_text
from peers.task import ATTITUDE, INERTIA, NS, RATE, Task

STEPS: Final = (2.0**-7, 2.0**-9, 2.0**-11, 2.0**-13)
"""Binary: it adds times up, and with others it drops a step now and then when it takes many in one call."""

STREAM_STEPS: Final = (0.001, 0.0005, 0.0002)
STEPS_A_CALL: Final = 1024


def contenders(task: Task) -> Iterator[Contender]:
    """Both formulations at each step that fits."""
    steps = STEPS if task.smallest_interval >= 1.0 else STREAM_STEPS
    for name, maximal in (("multibody", False), ("rigid body", True)):
        for step in steps:
            if step <= task.smallest_interval:
                yield Contender(f"PyBullet, {name}", step_text(step), step, _runner(task, maximal, step))


def _runner(task: Task, maximal: bool, step: float) -> Callable[[], NDArray[np.float64]]:
    counts = np.rint(np.diff(task.times_ns, prepend=0) / (NS * step)).astype(int).tolist()
    at_once = min(STEPS_A_CALL, min(counts)) if step in STEPS else 1
    world, body = _world(maximal, step, at_once)

    def run() -> NDArray[np.float64]:
        pybullet.resetBasePositionAndOrientation(body, [0, 0, 0], ATTITUDE.tolist(), physicsClientId=world)
        pybullet.resetBaseVelocity(body, [0, 0, 0], RATE.tolist(), physicsClientId=world)
        found = []
        for count in counts:
            for _ in range(count // at_once):
                pybullet.stepSimulation(physicsClientId=world)
            found.append(pybullet.getBasePositionAndOrientation(body, physicsClientId=world)[1])
        return np.array(found)

    return run


def _world(maximal: bool, step: float, at_once: int) -> tuple[int, int]:
    """A world with nothing in it but the body, and the body."""
    world = pybullet.connect(pybullet.DIRECT)
    substeps = at_once if at_once > 1 else 0
    pybullet.setPhysicsEngineParameter(fixedTimeStep=step * at_once, numSubSteps=substeps, physicsClientId=world)
    # without a shape a rigid body is not moved at all
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1, physicsClientId=world) if maximal else -1
    body = pybullet.createMultiBody(
        baseMass=1, baseCollisionShapeIndex=shape, useMaximalCoordinates=maximal, physicsClientId=world
    )
    pybullet.changeDynamics(
        body,
        -1,
        localInertiaDiagonal=INERTIA.tolist(),
        linearDamping=0,
        angularDamping=0,
        maxJointVelocity=1e9,
        physicsClientId=world,
    )
    return world, body
