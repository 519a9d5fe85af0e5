"""The limit L of each motion: small tampering is caught, its sample named, and honest motions are certified."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_certificate_accepts import run

from lie_rigid_body.certificate import SegmentCertificate, certify
from lie_rigid_body.lie import quaternion
from lie_rigid_body.recording.bag_reader import Recording

FAST = {"inertia": [0.6, 0.8, 1.0], "initial_body_rate": [3.0, 0.5, -0.9], "epoch_ns": 1_792_000_000_123_456_789}
TENSOR = {"inertia": [1.0, 0.1, -0.05, 1.4, 0.2, 1.9], "initial_body_rate": [0.4, -1.2, 0.7]}
MOTIONS: dict[str, tuple[float, dict[str, object]]] = {
    "closed form": (1e-14, {**FAST, "motion": "closed_form"}),
    "closed form of a tensor": (1e-14, {**TENSOR, "motion": "closed_form"}),
    "dmv20": (2e-12, {**FAST, "max_step": 0.01}),
    "dmv8": (2e-7, {**FAST, "method": "dmv8"}),
    "rkmk4": (2e-7, {**TENSOR, "method": "rkmk4"}),
}
"""The turn of a pose that is caught, rad, and the parameters, of each motion."""
AT = 170


@pytest.fixture(scope="module", params=MOTIONS)
def motion(request):
    caught, parameters = MOTIONS[request.param]
    return caught, run(parameters, 300)


def certified(recording: Recording, max_attitude: float | None = None) -> SegmentCertificate:
    return certify(recording, max_attitude=max_attitude).segments[0]


def turned(recording: Recording, angle: float, axis: list[float]) -> Recording:
    """One pose turned about an axis of the world."""
    values = recording.poses.values.copy()
    turn = quaternion.exp(angle * np.asarray(axis) / np.linalg.norm(axis))
    values[AT, 3:] = quaternion.multiply(turn, values[AT, 3:])
    return replace(recording, poses=replace(recording.poses, values=values))


def with_rate(recording: Recording, change: np.ndarray) -> Recording:
    """One body rate changed by a share of its size."""
    values = recording.twists.values.copy()
    values[AT, 3:] += change * np.linalg.norm(values[AT, 3:])
    return replace(recording, twists=replace(recording.twists, values=values))


def test_the_honest_recording_keeps_well_within_its_limits(motion):
    found = certified(motion[1])
    assert found.passed
    assert all(law.worst <= 0.5 * law.limit for law in found.laws)


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1.8, 0.4, -0.9]])
def test_a_turned_pose_is_caught_and_told(motion, axis):
    caught, recording = motion
    found = certified(turned(recording, caught, axis))
    law = found.law("attitude")
    assert {each.name for each in found.laws if not each.holds} == {"attitude"}
    assert (law.broken, law.sample) == (1, AT)
    assert found.time_s(law) == AT / 100
    assert certified(turned(recording, 0.25 * caught, axis)).passed
    assert certified(turned(recording, caught, axis), max_attitude=2.0 * caught).passed
    assert not certified(turned(recording, caught, axis), max_attitude=0.5 * caught).passed


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1.8, 0.4, -0.9]])
def test_the_angle_that_is_told_is_that_of_the_turn(motion, axis):
    found = certified(turned(motion[1], 0.01, axis), max_attitude=0.1)
    assert found.law("attitude").worst == pytest.approx(0.01, rel=1e-4)


def test_the_rate_of_a_slow_body_is_judged_beside_its_own_size():
    slow = run({**FAST, "motion": "closed_form", "initial_body_rate": [3e-3, 5e-4, -9e-4]}, 300)
    assert certified(slow).passed
    assert not certified(with_rate(slow, np.array([1e-13, 0.0, 0.0]))).passed


@pytest.mark.parametrize("change", [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.6, 0.8]])
def test_a_changed_rate_is_caught(motion, change):
    caught, recording = motion
    found = certified(with_rate(recording, 4.0 * caught * np.array(change)))
    law = found.law("body rate")
    assert {each.name for each in found.laws if not each.holds} == {"body rate"}
    assert (law.broken, law.sample) == (1, AT)
    assert certified(with_rate(recording, caught * np.array(change))).passed


def test_energy_and_momentum_are_reported_and_not_judged(motion):
    """They follow from attitude and rate: with a wide limit their drift is told, and breaks no law."""
    wide = certified(with_rate(motion[1], np.array([1e-3, 0.0, 0.0])), max_attitude=0.1)
    assert wide.passed
    for name in ("kinetic energy", "world momentum"):
        assert 1e-5 < wide.law(name).worst < 1e-2
        assert not wide.law(name).is_judged


@pytest.mark.slow
def test_three_million_steps_of_the_default_stepper_are_certified():
    found = certified(run({**FAST, "rate": 0.005, "max_step": 0.066}, 1000))
    assert found.passed
    assert found.law("attitude").worst < 1e-12
