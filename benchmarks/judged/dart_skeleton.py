"""DART: a skeleton of one body at a free joint, whose rates are in the world's axes. It has one integrator."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import version

import dartpy
import numpy as np
from scipy.spatial.transform import Rotation

from judged.own import Answer
from lie_rigid_body.conformance import EngineCase
from lie_rigid_body.conformance.results import Simulate
from lie_rigid_body.lie import quaternion

VERSION = version("dartpy")


def engines() -> Iterator[tuple[str, Simulate]]:
    yield f"DART {VERSION}", simulate


def simulate(case: EngineCase, step: float) -> Answer:
    world, skeleton = dartpy.simulation.World(), dartpy.dynamics.Skeleton("body")
    _, body = skeleton.createFreeJointAndBodyNodePair()
    body.setInertia(dartpy.dynamics.Inertia(1.0, np.zeros(3), case.inertia))
    world.setGravity(np.zeros(3))
    world.setTimeStep(step)
    world.addSkeleton(skeleton)
    skeleton.setPositions(np.concatenate([Rotation.from_quat(case.attitude_xyzw).as_rotvec(), np.zeros(3)]))
    skeleton.setVelocities(np.concatenate([case.world_rate, np.zeros(3)]))
    count = round(case.duration / step)
    attitude, rate = np.empty((count, 3, 3)), np.empty((count, 3))
    for n in range(count):
        world.step()
        attitude[n] = body.getWorldTransform().rotation()
        rate[n] = attitude[n].T @ skeleton.getVelocities()[:3]
    with np.errstate(all="ignore"):
        return step * np.arange(1, count + 1), quaternion.from_matrix(attitude), rate
