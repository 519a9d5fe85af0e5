"""PyBullet: a free body without damping, as multibody and as rigid body. Its rates are in the world's axes.

It takes moments in a frame of the inertia: the body is the frame of the principal axes here, and answers are turned.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from importlib.metadata import version

import numpy as np
import pybullet

from judged.own import Answer
from lie_rigid_body.conformance import EngineCase
from lie_rigid_body.conformance.results import Simulate
from lie_rigid_body.lie import quaternion

VERSION = version("pybullet")


def engines() -> Iterator[tuple[str, Simulate]]:
    for name, maximal in (("multibody", False), ("rigid body", True)):
        yield f"PyBullet {VERSION}, {name}", partial(simulate, maximal=maximal, damping=0.0)
    yield f"PyBullet {VERSION}, multibody, damping as it comes", partial(simulate, maximal=False, damping=None)


def simulate(case: EngineCase, step: float, maximal: bool, damping: float | None) -> Answer:
    frame = np.roll(case.inertial_frame_wxyz, -1)
    world = pybullet.connect(pybullet.DIRECT)
    pybullet.setPhysicsEngineParameter(fixedTimeStep=step, numSubSteps=0, physicsClientId=world)
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1, physicsClientId=world) if maximal else -1
    body = pybullet.createMultiBody(1, shape, useMaximalCoordinates=maximal, physicsClientId=world)
    drag = {} if damping is None else {"linearDamping": damping, "angularDamping": damping}
    pybullet.changeDynamics(
        body,
        -1,
        localInertiaDiagonal=case.principal_moments.tolist(),
        maxJointVelocity=1e9,
        physicsClientId=world,
        **drag,
    )
    start = quaternion.multiply(case.attitude_xyzw, frame).tolist()
    pybullet.resetBasePositionAndOrientation(body, [0, 0, 0], start, physicsClientId=world)
    pybullet.resetBaseVelocity(body, [0, 0, 0], case.world_rate.tolist(), physicsClientId=world)
    count = round(case.duration / step)
    attitude, rate = np.empty((count, 4)), np.empty((count, 3))
    for n in range(count):
        pybullet.stepSimulation(physicsClientId=world)
        attitude[n] = pybullet.getBasePositionAndOrientation(body, physicsClientId=world)[1]
        rate[n] = pybullet.getBaseVelocity(body, physicsClientId=world)[1]
    pybullet.disconnect(world)
    attitude = quaternion.normalize(quaternion.multiply(attitude, quaternion.conjugate(frame)))
    return step * np.arange(1, count + 1), attitude, quaternion.rotate(quaternion.conjugate(attitude), rate)
