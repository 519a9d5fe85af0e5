"""Honest bags are certified: every kind of motion, resets, late recorders, bare twists, random bodies."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from phrases import refused, telling
from scipy.spatial.transform import Rotation

from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import Recording
from lie_rigid_body.recording.topic_messages import TopicMessages
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Samples, Simulation
from said import numbers


def recording(*parts: tuple[str, int, Samples], log_delay: int = 0, stamped: bool = True) -> Recording:
    """What a reader would make of these segments."""
    stamps = np.concatenate([samples.stamps_ns for _, _, samples in parts])
    attitudes = np.concatenate([samples.states.attitude_xyzw for _, _, samples in parts])
    rates = np.concatenate([samples.states.body_rate for _, _, samples in parts])
    still, alike, logged = np.zeros((len(stamps), 3)), np.zeros(len(stamps), dtype=np.int64), stamps + log_delay
    sent = logged + (7 if log_delay and stamped else 0)
    body, told = ("base_link", stamps) if stamped else (None, sent)
    return Recording(
        pose_topic="/pose",
        twist_topic="/twist",
        stamped=stamped,
        library="test",
        scenario_texts=[(start + log_delay, text) for text, start, _ in parts],
        poses=TopicMessages(logged, stamps, np.hstack([still, attitudes]), (("world", b""),), alike),
        twists=TopicMessages(sent, told, np.hstack([still, rates]), ((body, b""),), alike),
    )


def part(simulation: Simulation, count: int) -> tuple[str, int, Samples]:
    segment = simulation.segment
    return segment.to_json(), segment.start_ns, simulation.take(count)


def run(parameters: dict[str, object], count: int) -> Recording:
    return recording(part(Simulation(Scenario.from_parameters(parameters)), count))


TILTED = [0.18257418583505536, 0.3651483716701107, 0.5477225575051661, 0.7302967433402214]
RODS = {"inertia": [1e-300, 1.0, 1.0], "motion": "closed_form"}
"""Without thickness: by their energy they may turn 5e148 rad between samples."""
LONG_STEPS = {"inertia": [1.0, 1.7, 2.6], "initial_body_rate": [1e-3, 2.0, -2e-3], "rate": 0.1, "max_step": 0.1}
MANY = {"rate": 0.17, "initial_body_rate": [0.0, 0.0, 2e4]}
"""Millions of steps in a steady rotation, in which every step has the same increment."""


def slow(**given: object) -> dict[str, object]:
    """Bodies whose roundings are the same at every step and add up linearly, as no random walk does."""
    return {"initial_attitude_xyzw": TILTED, **given}


def frail(size: float, rate: float, **given: object) -> dict[str, object]:
    """A body whose energy underflows."""
    rates = [rate, 0.01 * rate, -1e-12 * rate]
    return {"inertia": [size, 2.0 * size, 2.5 * size], "initial_body_rate": rates, **given}


def slender(motion: str) -> dict[str, object]:
    """A rod turned in its frame: its products of inertia lose nine digits of the rate about its axis."""
    rod = Rotation.from_rotvec([0.4, 1.1, -0.7]).as_matrix()
    tensor = (rod @ np.diag([1e-9, 1.0, 1.0]) @ rod.T)[np.triu_indices(3)]
    return {"motion": motion, "inertia": tensor.tolist(), "initial_body_rate": [-0.02, 4e-5, 0.0]}


HONEST: list[tuple[dict[str, object], int]] = [
    ({}, 1),
    ({"initial_body_rate": [0.0, 0.0, 0.0]}, 200),
    ({"initial_body_rate": [0.0, 1.0, 0.0]}, 200),
    ({"inertia": [2.0, 2.0, 2.0], "initial_body_rate": [0.3, 0.5, 1.1]}, 200),
    ({"inertia": [1e-7, 2e-7, 2.5e-7], "initial_body_rate": [0.3, 0.5, 1.1]}, 200),
    ({"initial_body_rate": [1e-5, 2e-5, 1e-5]}, 200),
    ({"initial_body_rate": [1e-153, 2e-153, 1e-153]}, 200),
    ({"motion": "closed_form", "initial_body_rate": [1e-6, 1.0, 1e-6]}, 200),
    ({"motion": "closed_form", "rate": 0.01, "initial_body_rate": [0.4, 1.0, 0.3]}, 200),
    ({"motion": "closed_form", "rate": 1e6, "inertia": [0.6, 0.8, 1.0]}, 200),
    ({"rate": 1024.0, "epoch_ns": 1_700_000_000_000_000_001}, 200),
    (slow(initial_body_rate=[0.001, 0.002, 0.0005]), 2000),
    (slow(initial_body_rate=[7.3e-5, 0.0, 0.0]), 2000),
    (slow(rate=200_000.0), 5000),
    (slow(rate=1e8, epoch_ns=1_700_000_000_000_000_001), 1000),
    (slow(inertia=[0.01, 0.02, 0.025], initial_body_rate=[0.001, 0.0011, 0.0]), 2000),
    ({**RODS, "initial_body_rate": [1e6, 1.0, 1e-6]}, 10),
    ({**RODS, "initial_body_rate": [0.4, 0.6, -0.3]}, 10),
    *((frail(1e-279, 3e-26, method=method), 10) for method in ("dmv20", "rkmk1", "rkmk4")),
    *((frail(1.0, 1e-200, method=method), 10) for method in ("dmv20", "rkmk1", "rkmk4")),
    *((frail(*given, motion="closed_form"), 10) for given in ((1e-279, 3e-26), (1.0, 1e-200))),
    *((slender(motion), 100) for motion in ("closed_form", "moving_chart")),
    # at and near the separatrix, a principal axis and symmetry, and where the stepper limits the step
    ({"initial_body_rate": [1e-9, 2.0, 3e-10], "rate": 2.0, "max_step": 0.01}, 150),
    ({"initial_body_rate": [1e-12, 2.0, -1e-12], "rate": 2.0, "max_step": 0.05}, 150),
    ({"inertia": [6.2, 5.9, 1.98], "initial_body_rate": [1e-11, 1e-11, 6.1], "rate": 10.0, "method": "dmv6"}, 150),
    ({"inertia": [1e-3, 1.0, 1.0], "initial_body_rate": [0.5, 2.0, 1.0], "method": "dmv4", "max_step": 0.01}, 150),
    ({"inertia": [3e-13, 4e-13, 5e-13], "initial_body_rate": [40.0, 2.0, 17.0], "max_step": 0.01}, 150),
    ({"inertia": [1.0, 1.0 + 2e-16, 1.5], "initial_body_rate": [1e-3, 2e-3, 1e-4], "rate": 1000.0}, 150),
    ({"inertia": [0.6, 0.8, 1.0], "initial_body_rate": [3.0, 0.5, -0.9], "max_step": 10.0, "rate": 0.1}, 150),
    ({"initial_body_rate": [3e3, 2e3, 1e2], "rate": 1e4, "max_step": 0.001}, 150),
    pytest.param(LONG_STEPS, 150, marks=pytest.mark.slow),  # type: ignore[list-item]
    *(pytest.param({**MANY, "inertia": [1.0, 1.0, c]}, 5, marks=pytest.mark.slow) for c in (1.0, 2.0)),  # type: ignore[list-item]
]


@pytest.mark.parametrize(("parameters", "count"), HONEST)
def test_all_kinds_of_motion_are_certified(parameters, count):
    if parameters.get("rate") == MANY["rate"]:
        pytest.importorskip("numba", reason="millions of steps need numba")
    found = certify(run(parameters, count))
    assert found.passed, found.messages
    assert found.attitude_accuracy < (1e-7 if "method" in parameters else 1e-9)


def test_what_turns_farther_than_phases_are_kept_is_not_certified():
    """Though equal to the bit: the closed form itself is some 1e-5 rad off there, as enclosures of the motion prove."""
    found = certify(run({"motion": "closed_form", "initial_body_rate": [1e45, 1e45, 1e45]}, 10))
    assert [law.name for law in found.laws if not law.holds] == ["attitude"]


def test_resets_begin_segments_also_at_another_rate():
    simulation = Simulation(Scenario.from_parameters({"rate": 300.0}))
    parts = [part(simulation, 50)]
    for change in ({"rate": 300.0}, {"rate": 70.0}, {"rate": 70.0, "inertia": [2.0, 2.0, 1.0]}):
        simulation.reset(Scenario.from_parameters(change))
        parts.append(part(simulation, 30))
    found = certify(recording(*parts))
    assert found.passed, found.messages
    assert [s.samples for s in found.segments] == [50, 30, 30, 30]


def test_last_sample_before_a_reset_is_not_missed_silently():
    simulation = Simulation(Scenario.from_parameters({}))
    text, start, samples = part(simulation, 50)
    shorter = Samples(samples.stamps_ns[:-1], samples.states[:-1])
    simulation.reset(Scenario.from_parameters({}))
    found = certify(recording((text, start, shorter), part(simulation, 30)))
    assert [numbers(message) for message in found.messages] == [[1, 49, 49]]


def test_a_reset_between_two_samples_leaves_no_trace():
    simulation = Simulation(Scenario.from_parameters({}))
    first = part(simulation, 20)
    simulation.reset(Scenario.from_parameters({"initial_body_rate": [1.0, 0.0, 0.0]}))
    unused = part(simulation, 0)
    simulation.reset(Scenario.from_parameters({"initial_body_rate": [0.0, 1.0, 0.5]}))
    found = certify(recording(first, unused, part(simulation, 20)))
    assert found.passed, found.messages


def test_a_recorder_that_came_late_and_left_between_topics_is_accepted_and_noted():
    whole = run({"epoch_ns": 10**18}, 200)
    late = replace(
        whole,
        scenario_texts=[(10**18 + 400_000_123, whole.scenario_texts[0][1])],
        poses=whole.poses[50:200],
        twists=whole.twists[53:199],
    )
    found = certify(late)
    assert found.passed, found.messages
    assert "53" in found.segments[0].notes[0]
    holed = replace(late, poses=whole.poses[np.r_[50:100, 101:200]])
    law = certify(holed).segments[0].law("stamps")
    assert (law.unit, law.sample, law.broken) == ("gap", 100, 1)


def test_a_recorder_that_came_late_still_needs_every_sample_before_a_reset():
    simulation = Simulation(Scenario.from_parameters({}))
    parts = [part(simulation, 50)]
    simulation.reset(Scenario.from_parameters({}))
    whole = recording(*parts, part(simulation, 30), log_delay=123_456)
    assert certify(whole).passed
    holed = replace(whole, poses=whole.poses[np.r_[0:49, 50:80]])
    law = certify(holed).segments[0].law("stamps")
    assert (law.unit, law.sample, law.broken) == ("gap", 49, 1)


def test_bare_twists_are_paired_by_log_time_or_by_order():
    simulation = Simulation(Scenario.from_parameters({"stamped_twist": False}))
    piece = part(simulation, 50)
    own, foreign = recording(piece, stamped=False), recording(piece, stamped=False, log_delay=123_457)
    assert certify(own).passed
    assert telling(certify(own), "bare twists") == []
    assert certify(foreign).passed
    assert telling(certify(foreign), "bare twists")
    with refused("unpaired", twists=49, poses=50):
        certify(replace(foreign, twists=foreign.twists[0:49]))


def test_samples_before_the_first_declaration_are_refused():
    simulation = Simulation(Scenario.from_parameters({}))
    simulation.take(10)
    text, start = simulation.segment.to_json(), simulation.segment.start_ns
    declared = text.replace(f'"start_ns": {start}', '"start_ns": 50000000').replace(
        '"first_sample": 0', '"first_sample": 5'
    )
    early = recording((declared, start, Simulation(Scenario.from_parameters({})).take(10)))
    with refused("too early"):
        certify(early)


def test_a_poor_stepper_is_told_how_far_it_is_and_what_would_do():
    found = certify(
        run({"method": "rkmk4", "rate": 20.0, "max_step": 0.05, "initial_body_rate": [2.0, 3.0, 1.0]}, 1000)
    )
    law = found.segments[0].law("attitude")
    assert not law.holds
    [message] = [message for message in found.messages if "attitude" in message]
    [step] = [float(number) for number in numbers_after(message, "max_step of ")]
    assert 1e-3 < step < 0.05
    given = {"method": "rkmk4", "rate": 20.0, "max_step": step, "initial_body_rate": [2.0, 3.0, 1.0]}
    assert certify(run(given, 1000)).passed
    assert not certify(run({"method": "rkmk1"}, 1000)).passed


def numbers_after(text: str, mark: str) -> list[str]:
    return re.findall(f"{mark}([-+.e0-9]+)", text)
