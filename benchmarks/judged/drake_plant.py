"""Drake: a free body in a MultibodyPlant, discrete, and continuous with fixed steps. Rates are in the world's axes."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from importlib.metadata import version

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RotationalInertia, SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

from judged.own import Answer
from lie_rigid_body.conformance import EngineCase
from lie_rigid_body.conformance.results import Simulate
from lie_rigid_body.lie import quaternion

VERSION = version("drake")


def engines() -> Iterator[tuple[str, Simulate]]:
    yield f"Drake {VERSION}, discrete", partial(simulate, integrator="")
    for integrator in ("runge_kutta3", "runge_kutta5"):
        yield f"Drake {VERSION}, {integrator}, fixed steps", partial(simulate, integrator=integrator)


def simulate(case: EngineCase, step: float, integrator: str) -> Answer:
    plant = MultibodyPlant(0.0 if integrator else step)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = case.inertia.tolist()
    unit = UnitInertia(RotationalInertia(xx, yy, zz, xy, xz, yz))
    plant.AddRigidBody("body", SpatialInertia(1.0, np.zeros(3), unit))
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    simulator = Simulator(plant)
    if integrator:
        ResetIntegratorFromFlags(simulator, integrator, step).set_fixed_step_mode(True)
    context = simulator.get_mutable_context()
    plant.SetPositions(context, body_positions(case))
    plant.SetVelocities(context, np.concatenate([case.world_rate, np.zeros(3)]))
    simulator.Initialize()
    count = round(case.duration / step)
    attitude, rate = np.empty((count, 4)), np.empty((count, 3))
    for n in range(count):
        simulator.AdvanceTo((n + 1) * step)
        attitude[n] = plant.GetPositions(context)[[1, 2, 3, 0]]
        rate[n] = plant.GetVelocities(context)[:3]
    attitude = quaternion.normalize(attitude)
    return step * np.arange(1, count + 1), attitude, quaternion.rotate(quaternion.conjugate(attitude), rate)


def body_positions(case: EngineCase) -> np.ndarray:
    return np.concatenate([case.attitude_wxyz, np.zeros(3)])
