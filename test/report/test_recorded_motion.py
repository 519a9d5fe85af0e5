"""What is drawn of a recording: all of its samples, and the largest residuals, whatever the blocks are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body.certificate import certify
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.report.recorded_motion import MAX_PIECES, LawOverTime, ResidualsOverTime, recorded_segments
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation, SimulationStep


@pytest.mark.parametrize("block", [1, 7, 997, 10_000])
def test_no_peak_of_a_law_is_lost(block):
    """Whatever the blocks are, and in whichever order readings stand in a bag."""
    rng = np.random.default_rng(0)
    stamps = 5_000_000_000 + rng.permutation(3000) * 7_000_000
    residuals, limits = rng.random(3000), 0.5 + rng.random(3000)
    residuals[1234] = np.nan
    law = LawOverTime()
    for i in range(0, 3000, block):
        law.add(residuals[i : i + block], limits[i : i + block], stamps[i : i + block])
    t, largest, limit, broken = law.series(5_000_000_000)
    assert len(t) <= MAX_PIECES * -(-3000 // block)
    assert (np.diff(t) >= 0.0).all()
    assert 0.0 <= t[0] <= t[-1] <= 21.0
    finite = np.isfinite(largest)
    assert (largest[~finite].tolist(), largest[finite].max()) == ([np.inf], np.nanmax(residuals))
    assert limit.max() == limits.max()
    beyond = ~(residuals <= limits)
    assert broken.any()
    assert broken.sum() == beyond.sum() or block > 30


@pytest.fixture(scope="module")
def two_segments(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "bag.mcap"
    scenario = Scenario.from_parameters({"motion": "closed_form", "initial_body_rate": [0.3, 1.0, 0.2]})
    simulation = Simulation(scenario)
    with BagWriter(path, stamped_twist=True, chunk_size=10_000) as bag:
        for count in (1500, 700):
            bag.begin_segment(simulation.segment)
            bag.write(BatchEncoder(scenario).encode(SimulationStep(simulation.take(count))))
            simulation.reset(scenario)
    return path


def test_all_samples_are_drawn_of_the_segments_that_a_certificate_tells(two_segments):
    recording = read_bag(two_segments)
    found = recorded_segments(recording)
    told = recorded_segments(recording, certify(recording))
    assert [len(each.samples) for each in found] == [1500, 700]
    for one, other in zip(found, told, strict=True):
        assert one.segment == other.segment
        np.testing.assert_array_equal(one.stamps_ns, other.stamps_ns)
    np.testing.assert_array_equal(np.concatenate([each.stamps_ns for each in found]), recording.poses.stamps_ns)


def test_to_watch_changes_nothing_and_sees_the_worst(two_segments):
    recording, watch = read_bag(two_segments), ResidualsOverTime()
    certificate = certify(recording, watch=watch)
    assert certificate == certify(recording)
    assert set(watch.laws) == {law.name for law in certificate.segments[0].laws} - {"stamps"}
    for law in certificate.laws:
        if law.name in watch.laws:
            t, largest, _, broken = watch.laws[law.name].series(0)
            assert largest.max() == law.worst == max(s.law(law.name).worst for s in certificate.segments)
            assert not broken.any()
            assert 0.0 <= t[0] <= t[-1] <= 22.0
