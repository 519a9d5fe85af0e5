"""Strategies of hypothesis for tests of attitude filters and of what consumes their messages.

Everything that they give is accepted by the package: bodies with an inertia that mass can have, starts of unit
quaternions, scenarios that pass as a whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from lie_rigid_body.evaluation.arguments import quantity
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import GRADES

__all__ = ["attitudes", "bodies", "scenarios", "sensor_grades", "starts"]

_SECOND_MOMENT = st.floats(0.05, 5.0)
"""∫ x² dm along a principal axis, kg m²: any three positive ones are those of a body."""


def attitudes() -> SearchStrategy[np.ndarray]:
    """Unit quaternions x, y, z, w of all rotations; simplest is no rotation."""
    four = st.tuples(*[st.floats(-1.0, 1.0)] * 4).map(np.array)
    return four.map(lambda q: quaternion.normalize(q) if quaternion.norm(q) > 0.1 else np.array([0.0, 0.0, 0.0, 1.0]))


@st.composite
def bodies(draw: st.DrawFn) -> RigidBody:
    """Bodies of any shape, symmetric and spherical tops among them, in any position on the body's axes."""
    x = draw(_SECOND_MOMENT)
    y = draw(_SECOND_MOMENT)
    z = draw(_SECOND_MOMENT)
    shape = draw(st.sampled_from(["any", "symmetric", "spherical"]))
    y = x if shape != "any" else y
    z = x if shape == "spherical" else z
    moments = np.array([y + z, z + x, x + y])
    if draw(st.booleans()):
        return RigidBody(moments)
    R = quaternion.to_matrix(draw(attitudes()))
    tensor = R @ np.diag(moments) @ R.T
    return RigidBody(0.5 * (tensor + tensor.T))


@st.composite
def starts(draw: st.DrawFn, max_rate: float = 2.0) -> State:
    """Attitudes and body rates, each component of the rate up to a limit, rad/s."""
    largest = quantity("max_rate", max_rate, "rad/s", "2.0", or_zero=True)
    rate = st.floats(-largest, largest)
    return State(draw(attitudes()), [draw(rate), draw(rate), draw(rate)])


def sensor_grades() -> SearchStrategy[str]:
    """The grades of sensors; simplest is ``perfect``."""
    return st.sampled_from(list(GRADES))


@st.composite
def scenarios(
    draw: st.DrawFn, /, max_rate: float = 2.0, grades: Sequence[str] | None = None, **parameters: Any
) -> Scenario:
    """Scenarios with an IMU and a magnetometer, for `lie_rigid_body.simulate`.

    Parameters
    ----------
    draw : callable
        Given by hypothesis.
    max_rate : float
        Largest component of the body rate at the start, rad/s.
    grades : sequence of str, optional
        Of the sensors; all by default.
    **parameters
        Parameters that are the same in all scenarios, by their public names.
    """
    if grades is not None and not (
        isinstance(grades, list | tuple) and grades and all(map(GRADES.__contains__, grades))
    ):
        raise InputError(f"grades: {shown(grades)}: give some of {listed(GRADES)}, in a list")
    start = draw(starts(max_rate))
    inertia = draw(bodies()).inertia
    return Scenario.from_parameters(
        {
            "inertia": inertia[np.triu_indices(3)].tolist(),
            "initial_attitude_xyzw": start.attitude_xyzw.tolist(),
            "initial_body_rate": start.body_rate.tolist(),
            "motion": draw(st.sampled_from(["closed_form", "moving_chart"])),
            "rate": draw(st.sampled_from([100.0, 50.0, 59.94])),
            "imu_rate": draw(st.sampled_from([100.0, 200.0, 333.3])),
            "magnetometer_rate": draw(st.sampled_from([50.0, 100.0])),
            "accelerometer_mode": draw(st.sampled_from(["pivot_gravity", "free_fall"])),
            "gyro_rate": draw(st.sampled_from(["integrated", "instantaneous"])),
            "sensor_grade": draw(sensor_grades() if grades is None else st.sampled_from(list(grades))),
            "sensor_seed": draw(st.integers(0, 2**31 - 1)),
            **parameters,
        }
    )
