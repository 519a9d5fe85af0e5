"""The limits are as narrow as the accuracy of each motion allows: small tampering is caught, and its sample named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_certificate_accepts import run

from lie_rigid_body.certificate import SegmentCertificate, certify
from lie_rigid_body.certificate.tolerance import tolerance
from lie_rigid_body.lie import quaternion
from lie_rigid_body.recording.bag_reader import Recording
from lie_rigid_body.scenario import Scenario

FAST = {"inertia": [0.6, 0.8, 1.0], "initial_body_rate": [3.0, 0.5, -0.9], "epoch_ns": 1_792_000_000_123_456_789}
MOTIONS: dict[str, dict[str, object]] = {
    "closed form": {**FAST, "motion": "closed_form"},
    "dmv20": {**FAST, "max_step": 0.01},
    "dmv8": {**FAST, "method": "dmv8"},
    "products": {"inertia": [1.0, 0.1, -0.05, 1.4, 0.2, 1.9], "initial_body_rate": [0.4, -1.2, 0.7]},
}
AT = 170


@pytest.fixture(scope="module", params=MOTIONS)
def honest(request):
    return run(MOTIONS[request.param], 300)


def certified(recording: Recording) -> SegmentCertificate:
    return certify(recording).segments[0]


def turned(recording: Recording, angle: float, axis: list[float]) -> Recording:
    """One pose turned about an axis of the world."""
    values = recording.poses.values.copy()
    turn = quaternion.exp(angle * np.asarray(axis) / np.linalg.norm(axis))
    values[AT, 3:] = quaternion.multiply(turn, values[AT, 3:])
    return replace(recording, poses=replace(recording.poses, values=values))


def scaled(recording: Recording, excess: float) -> Recording:
    """One twist longer than it should be."""
    values = recording.twists.values.copy()
    values[AT] *= 1.0 + excess
    return replace(recording, twists=replace(recording.twists, values=values))


def test_the_honest_recording_keeps_well_within_its_limits(honest):
    found = certified(honest)
    assert found.passed
    assert all(law.worst <= 0.5 * law.limit for law in found.laws)


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1.8, 0.4, -0.9]])
@pytest.mark.parametrize("angle", [1e-13, 1e-14])
def test_a_pose_turned_by_hardly_anything_is_caught(honest, angle, axis):
    found = certified(turned(honest, angle, axis))
    law = found.law("closed form")
    assert not law.holds
    assert (law.broken, law.sample) == (1, AT)


def test_a_turn_shows_between_neighbours(honest):
    law = certified(turned(honest, 1e-13, [0, 1, 0])).law("twist is the attitude's derivative")
    assert not law.holds
    assert law.sample in (AT, AT + 1)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_energy_off_by_hardly_anything_is_caught(honest, sign):
    law = certified(scaled(honest, sign * 0.5e-14)).law("kinetic energy")
    assert not law.holds
    assert (law.broken, law.sample) == (1, AT)


def test_a_rate_turned_by_hardly_anything_breaks_eulers_equations(honest):
    values = honest.twists.values.copy()
    values[AT, 3:] = quaternion.rotate(quaternion.exp(np.array([3e-14, -2e-14, 5e-14])), values[AT, 3:])
    found = certified(replace(honest, twists=replace(honest.twists, values=values)))
    assert not found.law("Euler's equations").holds


def test_the_worst_sample_is_named_though_the_law_holds(honest):
    found = certified(turned(honest, 3.5e-15, [0, 1, 0]))
    law = found.law("closed form")
    assert law.holds
    assert law.sample == AT
    assert found.time_s(law) == AT / 100


def test_round_off_of_the_best_stepper_is_a_random_walk():
    """Over a million and a hundred million steps of 10 ms: some twenty times what the stepper errs by."""
    scenario = Scenario.from_parameters({**FAST, "max_step": 0.01})
    limits = tolerance(scenario, 1e6)
    attitude = limits.attitude(np.array([1e-2, 1e4, 1e6]))
    assert attitude[0] < 6e-15
    assert attitude[1] < 8e-14
    assert attitude[2] < 1e-12
    assert limits.energy(np.array([1e6])).max() < 6e-15
    assert limits.world_momentum(np.array([1e6])).max() < 6e-15


@pytest.mark.long
@pytest.mark.parametrize("method", ["dmv2", "dmv4", "dmv6"])
def test_low_orders_err_in_phase_only(method):
    found = certified(run({**FAST, "method": method, "max_step": 5e-5}, 300))
    assert found.passed
    assert found.law("kinetic energy").limit < 6e-15
    assert found.law("world momentum x").limit < 6e-15


@pytest.mark.parametrize(
    "parameters",
    [
        {"inertia": [1.0, 2.0, 3.0], "initial_body_rate": [1e-9, 2.0, 3e-10], "rate": 2.0, "max_step": 0.01},
        {"inertia": [1.0, 2.0, 3.0], "initial_body_rate": [1e-12, 2.0, -1e-12], "rate": 2.0, "max_step": 0.05},
        pytest.param(
            {"inertia": [1.0, 1.7, 2.6], "initial_body_rate": [1e-3, 2.0, -2e-3], "rate": 0.1, "max_step": 0.1},
            marks=pytest.mark.slow,
        ),
        {"inertia": [6.2, 5.9, 1.98], "initial_body_rate": [1e-11, 1e-11, 6.1], "rate": 1.0, "method": "dmv6"},
        {"inertia": [1e-3, 1.0, 1.0], "initial_body_rate": [0.5, 2.0, 1.0], "method": "dmv4", "max_step": 0.01},
        {"inertia": [3e-13, 4e-13, 5e-13], "initial_body_rate": [40.0, 2.0, 17.0], "max_step": 0.01},
        {"inertia": [1.0, 1.0 + 2e-16, 1.5], "initial_body_rate": [1e-3, 2e-3, 1e-4], "rate": 1000.0},
        {**FAST, "max_step": 10.0, "rate": 0.1},
        {"inertia": [1.0, 2.0, 3.0], "initial_body_rate": [3e3, 2e3, 1e2], "rate": 1e4},
    ],
    ids=[
        "separatrix",
        "nearest separatrix",
        "long steps near the separatrix",
        "principal axis",
        "rod",
        "tiny and fast",
        "nearly symmetric",
        "steps limited by the stepper",
        "faster than max_step allows",
    ],
)
def test_difficult_motions_are_certified(parameters):
    parameters = {"max_step": 0.001, **parameters}
    found = certify(run(parameters, 150))
    assert found.passed, found.messages
