"""Drake: a free body in a MultibodyPlant without gravity, discrete and continuous.

The discrete plant is what Drake recommends for contact; its velocity takes one explicit step of first order. The
continuous plant is integrated by a Runge–Kutta scheme: of third order with error control, which is Drake's default, or
of fifth order with a fixed step, which is its most accurate one here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

from peers.contender import Contender, step_text
from peers.task import ATTITUDE, INERTIA, NS, RATE, Task

STEPS: Final = (0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0001)
FIFTH_ORDER_STEPS: Final = (0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
"""With shorter ones it is at round-off."""

ACCURACIES: Final = (1e-3, 1e-6, 1e-9, 1e-12)
LONGEST_STEP: Final = 0.1
WXYZ: Final = (3, 0, 1, 2)
XYZW: Final = (1, 2, 3, 0)
"""A free body's position begins with the quaternion, which Drake writes scalar first."""


def contenders(task: Task) -> Iterator[Contender]:
    """The discrete plant and fixed steps at each step that fits, and each accuracy of the error control."""
    for step in STEPS:
        if step <= task.smallest_interval:
            yield Contender("Drake, discrete", step_text(step), step, _runner(task, Simulator(_world(step))))
    for accuracy in ACCURACIES:
        simulator = Simulator(_world(0.0))
        ResetIntegratorFromFlags(simulator, "runge_kutta3", LONGEST_STEP).set_target_accuracy(accuracy)
        yield Contender("Drake, continuous RK3", f"{accuracy:.0e}", accuracy, _runner(task, simulator))
    for step in FIFTH_ORDER_STEPS:
        if step <= task.smallest_interval:
            simulator = Simulator(_world(0.0))
            ResetIntegratorFromFlags(simulator, "runge_kutta5", step).set_fixed_step_mode(True)
            yield Contender("Drake, continuous RK5", step_text(step), step, _runner(task, simulator))


def _world(step: float) -> Any:
    """A plant with one body, which is continuous if the step is 0."""
    plant = MultibodyPlant(step)
    plant.AddRigidBody("body", SpatialInertia(1.0, np.zeros(3), UnitInertia(*INERTIA)))
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    return plant


def _runner(task: Task, simulator: Any) -> Callable[[], NDArray[np.float64]]:
    plant, context = simulator.get_system(), simulator.get_mutable_context()
    position = np.concatenate([ATTITUDE[list(WXYZ)], np.zeros(3)])
    velocity = np.concatenate([RATE, np.zeros(3)])  # in the world, which the body's frame is at the start
    times = (task.times_ns / NS).tolist()

    def run() -> NDArray[np.float64]:
        context.SetTime(0.0)
        plant.SetPositions(context, position)
        plant.SetVelocities(context, velocity)
        simulator.Initialize()
        found = np.empty((len(times), 4))
        for row, t in zip(found, times, strict=True):
            simulator.AdvanceTo(t)
            row[:] = plant.GetPositions(context)[list(XYZW)]
        return found

    return run
