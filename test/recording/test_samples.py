"""A bag as samples: poses and twists that come late, twice, alone or without stamps, and the numbers of segments."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bags import write_bag

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import Recording, read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.recording.samples import _HELD_BACK, Batches, Block, numbered_blocks, paired
from lie_rigid_body.recording.segments import declared_segments
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment, Simulation, SimulationStep

COUNT = 4 * _HELD_BACK
PERIOD_NS = 10_000_000


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return read_bag(write_bag(tmp_path_factory.mktemp("bag") / "bag.mcap", COUNT, rate=100.0))


def segments_of(recording: Recording) -> list[Segment]:
    return [*declared_segments((text for _, text in recording.scenario_texts), recording.name).values()]


def batches(recording: Recording, poses: Integers, twists: Integers, size: int = 500) -> Batches:
    for begin in range(0, max(len(poses), len(twists)), size):
        yield recording.poses[poses[begin : begin + size]], recording.twists[twists[begin : begin + size]]


def samples(recording: Recording, given: Batches) -> Block:
    return Block.joined([block for _, block in paired(recording, segments_of(recording), given)])


def shuffled(seed: int, reach: int) -> Integers:
    """All numbers, none farther than some places from its own."""
    return np.argsort(np.arange(COUNT) + np.random.default_rng(seed).uniform(0.0, reach, COUNT), kind="stable")


def test_messages_that_come_late_are_samples_in_the_order_of_their_stamps(recording: Recording) -> None:
    found = samples(recording, batches(recording, shuffled(1, _HELD_BACK - 500), shuffled(2, _HELD_BACK - 500)))
    np.testing.assert_array_equal(found.stamps_ns, PERIOD_NS * np.arange(COUNT))
    np.testing.assert_array_equal(found.states.attitude_xyzw, recording.poses.values[:, 3:])
    np.testing.assert_array_equal(found.states.body_rate, recording.twists.values[:, 3:])


def test_messages_that_come_again_or_too_late_are_left_out(recording: Recording) -> None:
    """Behind so many others that their samples have been given on."""
    numbers = np.arange(COUNT)
    again = np.concatenate([np.delete(numbers, 7), numbers[:40]])
    found = samples(recording, batches(recording, again, again))
    np.testing.assert_array_equal(found.stamps_ns, PERIOD_NS * np.delete(numbers, 7))


def test_bare_twists_have_their_log_times_or_the_stamps_of_the_poses(recording: Recording) -> None:
    bare = replace(recording, stamped=False, library="libmcap 1", expected_samples=None)
    late = replace(bare, twists=replace(bare.twists, log_times_ns=bare.twists.log_times_ns + 12_345))
    numbers = np.arange(COUNT)
    without_one = np.delete(numbers, 300)
    np.testing.assert_array_equal(samples(bare, batches(bare, numbers, without_one)).stamps_ns, PERIOD_NS * without_one)
    np.testing.assert_array_equal(samples(late, batches(late, numbers, numbers)).stamps_ns, PERIOD_NS * numbers)
    with pytest.raises(BagError, match="cannot be paired"):
        samples(late, batches(late, numbers, without_one))


def test_samples_are_numbered_by_the_clock_of_their_segment(tmp_path: Path) -> None:
    simulation = Simulation(Scenario.from_parameters({"motion": "closed_form", "rate": 10.0}))
    with BagWriter(tmp_path / "bag.mcap", stamped_twist=True) as bag:
        for rate, count in ((10.0, 25), (40.0, 50), (4.0, 6)):
            if rate != 10.0:
                simulation.reset(Scenario.from_parameters({"motion": "closed_form", "rate": rate}))
            bag.begin_segment(simulation.segment)
            bag.write(BatchEncoder(simulation.segment.scenario).encode(SimulationStep(simulation.take(count))))
    read = read_bag(tmp_path / "bag.mcap")

    def found() -> Iterator[tuple[int, int, int]]:
        for place, block in numbered_blocks(read, segments_of(read)):
            yield place, int(block.samples[0]), len(block.samples)
            assert (np.diff(block.samples) == 1).all()

    assert [*found()] == [(0, 0, 25), (1, 0, 50), (2, 0, 6)]
