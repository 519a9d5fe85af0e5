"""Bags as others read them: two independent libraries, and the facts that rosbag2 insists on."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from bags import MakeBag, write_bag, write_samples
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from refused_bags import refused
from rosbags.highlevel import AnyReader

from lie_rigid_body import __version__
from lie_rigid_body.messages.definitions import BARE_TWIST, POSE_STAMPED, STRING, TWIST_STAMPED
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Samples, Segment, Simulation

EPOCH = 1_700_000_000_123_456_789
TOPICS = ["/pose", "/twist", "/lie_rigid_body/scenario"]
Read = list[tuple[str, int, Any]]
"""Topics, log times and messages."""


def expected(count: int, **parameters: object) -> Samples:
    return Simulation(Scenario.from_parameters({"motion": "closed_form", **parameters})).take(count)


def by_mcap_ros2(path: Path) -> Read:
    with path.open("rb") as stream:
        rows = list(make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages())
    assert all(row.message.log_time == row.message.publish_time for row in rows)
    for topic in TOPICS:
        numbers = [row.message.sequence for row in rows if row.channel.topic == topic]
        assert numbers == [*range(len(numbers))]
    return [(row.channel.topic, row.message.log_time, row.decoded_message) for row in rows]


def by_rosbags(path: Path) -> Read:
    with AnyReader([path]) as reader:
        return [(one.topic, time, reader.deserialize(data, one.msgtype)) for one, time, data in reader.messages()]


@pytest.mark.parametrize("stamped", [True, False])
@pytest.mark.parametrize("read", [by_mcap_ros2, by_rosbags])
def test_other_libraries_read_what_was_simulated(
    make_bag: MakeBag, read: Callable[[Path], Read], stamped: bool
) -> None:
    rows = read(make_bag(count=50, stamped_twist=stamped, epoch_ns=EPOCH))
    samples = expected(50, epoch_ns=EPOCH)
    poses, twists, scenarios = ([(time, m) for each, time, m in rows if each == topic] for topic in TOPICS)
    assert [time for time, _ in poses] == [time for time, _ in twists] == samples.stamps_ns.tolist()
    for k, ((_, pose), (_, twist)) in enumerate(zip(poses, twists, strict=True)):
        q, rate = pose.pose.orientation, (twist.twist if stamped else twist).angular
        assert [q.x, q.y, q.z, q.w] == samples.states.attitude_xyzw[k].tolist()
        assert [rate.x, rate.y, rate.z] == samples.states.body_rate[k].tolist()
        for message, frame in [(pose, "world"), (twist, "base_link")][: 1 + stamped]:
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == samples.stamps_ns[k]
            assert message.header.frame_id == frame
    [(time, scenario)] = scenarios
    assert time == EPOCH
    assert Segment.from_json(scenario.data).scenario.epoch_ns == EPOCH


@pytest.mark.parametrize("stamped", [True, False])
def test_our_reader_reads_what_was_simulated(make_bag: MakeBag, stamped: bool) -> None:
    path = make_bag(count=3000, stamped_twist=stamped, epoch_ns=EPOCH, world_frame="wörld")
    samples, recording = expected(3000, epoch_ns=EPOCH), read_bag(path)
    np.testing.assert_array_equal(recording.poses.stamps_ns, samples.stamps_ns)
    np.testing.assert_array_equal(recording.poses.log_times_ns, samples.stamps_ns)
    np.testing.assert_array_equal(recording.twists.log_times_ns, samples.stamps_ns)
    np.testing.assert_array_equal(recording.poses.values[:, 3:], samples.states.attitude_xyzw)
    np.testing.assert_array_equal(recording.twists.values[:, 3:], samples.states.body_rate)
    assert not recording.poses.values[:, :3].any()
    assert not recording.twists.values[:, :3].any()
    assert recording.poses.frame_ids == {"wörld"}
    assert recording.expected_samples == 3000
    assert recording.library == f"lie_rigid_body {__version__}"
    if stamped:
        np.testing.assert_array_equal(recording.twists.stamps_ns, samples.stamps_ns)
        assert recording.twists.frame_ids == {"base_link"}
    else:
        assert not recording.stamped
        assert recording.twists.frame_ids == set()


def test_the_same_run_gives_the_same_bytes_whatever_its_batches(make_bag: MakeBag) -> None:
    first, again, odd = make_bag("a.mcap", 2500), make_bag("b.mcap", 2500), make_bag("c.mcap", 2500, batch=37)
    assert first.read_bytes() == again.read_bytes() == odd.read_bytes()


@pytest.mark.parametrize(("stamped", "twist"), [(True, TWIST_STAMPED), (False, BARE_TWIST)])
def test_the_file_is_built_as_rosbag2_wants_it(make_bag: MakeBag, stamped: bool, twist: str) -> None:
    path = make_bag(count=4000, stamped_twist=stamped)
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        header, summary = reader.get_header(), reader.get_summary()
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    assert (header.profile, header.library) == ("ros2", f"lie_rigid_body {__version__}")
    assert summary is not None
    types = {channel.topic: summary.schemas[channel.schema_id].name for channel in summary.channels.values()}
    assert types == dict(zip(TOPICS, [POSE_STAMPED, twist, STRING], strict=True))
    assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    assert metadata == {"lie_rigid_body": {"samples": "4000"}}
    assert len(summary.chunk_indexes) > 1
    assert {index.compression for index in summary.chunk_indexes} == {"zstd"}
    assert all(index.uncompressed_size < 513 * 1024 for index in summary.chunk_indexes)


def test_qos_profiles_are_a_yaml_list_with_every_key_of_rosbag2(make_bag: MakeBag) -> None:
    with open(make_bag(), "rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    forever = {"sec": 9223372036, "nsec": 854775807}
    for channel in summary.channels.values():
        latched = channel.topic.endswith("scenario")
        assert yaml.safe_load(channel.metadata["offered_qos_profiles"]) == [
            {
                "history": "keep_last",
                "depth": 1 if latched else 10,
                "reliability": "reliable",
                "durability": "transient_local" if latched else "volatile",
                "deadline": forever,
                "lifespan": forever,
                "liveliness": "automatic",
                "liveliness_lease_duration": forever,
                "avoid_ros_namespace_conventions": False,
            }
        ]


def test_each_segment_begins_with_its_scenario_at_its_start(tmp_path: Path) -> None:
    scenario = Scenario.from_parameters({"motion": "closed_form", "epoch_ns": EPOCH})
    simulation = Simulation(scenario)
    with BagWriter(tmp_path / "two.mcap", stamped_twist=True) as bag:
        for _ in range(2):
            bag.begin_segment(simulation.segment)
            write_samples(bag, scenario, simulation.take(7))
            simulation.reset(scenario)
    texts = read_bag(tmp_path / "two.mcap").scenario_texts
    assert [time for time, _ in texts] == [EPOCH, EPOCH + 70_000_000]
    assert [Segment.from_json(text).first_sample for _, text in texts] == [0, 7]


def test_another_type_of_twist_and_what_comes_after_the_end_are_refused(tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "a.mcap", stamped_twist=True)
    with refused("type of the twist"):
        bag.begin_segment(Simulation(Scenario.from_parameters({"stamped_twist": False})).segment)
    bag.finish()
    bag.finish()
    with refused("finished"):
        bag.flush()


@pytest.mark.parametrize("taken", [0, 5])
def test_interruption_finishes_the_bag_and_replaces_another_by_one_with_samples(tmp_path: Path, taken: int) -> None:
    scenario = Scenario.from_parameters({"motion": "closed_form"})
    simulation, old = Simulation(scenario), write_bag(tmp_path / "a.mcap", count=7)

    def interrupted() -> None:
        with BagWriter(old, stamped_twist=True, overwrite=True) as bag:
            bag.begin_segment(simulation.segment)
            write_samples(bag, scenario, simulation.take(taken))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert read_bag(old).expected_samples == (taken or 7)
