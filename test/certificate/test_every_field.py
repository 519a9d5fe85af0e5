"""Every field of the table in docs/reference/fields.md is altered, and what its row says is demanded."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from forgeries import (
    COUNT,
    RATE,
    Forgery,
    hidden_file,
    in_bytes,
    in_payload,
    in_records,
    in_yaml,
    json_value,
    number,
    patched,
    renamed,
    shortened,
    text,
)
from forging import copy
from mcap.writer import CompressionType
from phrases import telling

from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.messages import encode_string
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.report.certificates import as_json, as_table
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "fields.md"
CAUGHT = "refused, or a law broken"
CERTIFIED = "certified, and not all of it"
LATER = 3 * 10**9
POSE, TWIST = "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/TwistStamped"


def rows() -> dict[tuple[str, str], str]:
    """The table of the page: by record and field, what the field is held against."""
    text = PAGE.read_text(encoding="utf-8")
    found = re.findall(r"^\| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", text, re.MULTILINE)
    return {(record, field): against for record, field, against in found if record not in ("record", "---")}


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "honest.mcap"
    parameters: dict[str, object] = {
        "motion": "closed_form",
        "rate": RATE,
        "epoch_ns": 10**18,
        "imu_rate": 4.0,
        "magnetometer_rate": 2.0,
        "accelerometer_lever_arm": [0.1, 0.2, 0.0],
        "gyro_noise_density": 1e-3,
        "gyro_bias_random_walk": 1e-3,
        "magnetometer_noise_density": 1e-8,
        "magnetometer_temperature_drift": 1e-9,
        "attitude_sensor_rate": 4.0,
        "attitude_sensor_roll_noise": 1e-3,
        "sun_sensor_rate": 2.0,
    }
    simulation = Simulation(Scenario.from_parameters(parameters))
    with BagWriter(path, stamped_twist=True) as bag:
        bag.begin_segment(simulation.segment)
        last = simulation.clock.stamp_ns(COUNT - 1)
        bag.write(BatchEncoder(simulation.segment.scenario).encode(simulation.take_until(last, COUNT)))
    return path


FORGERIES: dict[tuple[str, str], Forgery] = {
    ("Magic", "start"): in_bytes(b"MCAP0", b"MCAP1"),
    ("Magic", "end"): in_bytes(b"MCAP0", b"MCAP1", -1),
    ("Header", "profile"): text("Header", "profile", "ros2", "ros1"),
    ("Header", "library"): text("Header", "library", "lie_rigid_body", "lie_rigid_bard"),
    ("Schema", "id"): in_records(Schema=lambda r: {"id": r.id + 20}),
    ("Schema", "name"): text("Schema", "name", "PoseStamped", "PoseStumped"),
    ("Schema", "encoding"): text("Schema", "encoding", "ros2msg", "ros2idl"),
    ("Schema", "data"): in_records(
        Schema=lambda r: {"data": r.data.replace(b"float64 x 0\nfloat64 y 0", b"float64 y 0\nfloat64 x 0")}
    ),
    ("Schema", "a repeat in the summary"): in_bytes(b"PoseStamped", b"PoseStumped", -1),
    ("Channel", "id"): in_records(Channel=lambda r: {"id": r.id + 20}),
    ("Channel", "schema_id"): in_records(Channel=lambda r: {"schema_id": r.schema_id % 3 + 1}),
    ("Channel", "topic"): text("Channel", "topic", "/twist", "/twiss"),
    ("Channel", "message_encoding"): text("Channel", "message_encoding", "cdr", "xml"),
    ("Channel", "metadata"): in_records(
        Channel=lambda r: {"metadata": {k: v.replace("10", "11") for k, v in r.metadata.items()}}
    ),
    ("Channel", "a repeat in the summary"): in_bytes(b"/pose", b"/pase", -1),
    ("Message", "channel_id"): number("Message", "channel_id"),
    ("Message", "sequence"): number("Message", "sequence"),
    ("Message", "the last ones, cut off"): shortened(count=COUNT),
    ("Message", "the last ones, cut off, and every count with them"): shortened(),
    ("Message", "log_time"): in_records(Message=lambda r: {"log_time": 2**64 - 1}),
    ("Message", "publish_time"): number("Message", "publish_time"),
    ("Chunk", "uncompressed_size"): number("Chunk", "uncompressed_size"),
    ("Chunk", "uncompressed_crc"): number("Chunk", "uncompressed_crc"),
    ("Chunk", "compression"): in_bytes(b"zstd", b"zst4", 0, CompressionType.ZSTD),
    ("Chunk", "data"): in_records(Chunk=lambda r: {"data": b"\x0b" + r.data[1:]}),
    ("Attachment", "name"): text("Attachment", "name", "photo", "proto"),
    ("Attachment", "media_type"): text("Attachment", "media_type", "png", "gif"),
    ("Attachment", "log_time"): in_records(
        Attachment=lambda r: {"log_time": 5}, AttachmentIndex=lambda r: {"log_time": 5}
    ),
    ("Attachment", "create_time"): in_records(
        Attachment=lambda r: {"create_time": 5}, AttachmentIndex=lambda r: {"create_time": 5}
    ),
    ("Attachment", "data"): in_records(Attachment=lambda r: {"data": b"sixpel"}),
    ("Metadata", "name"): text("Metadata", "name", "lie_rigid_body", "lie_rigid_bard"),
    ("Metadata", "metadata"): in_records(Metadata=lambda r: {"metadata": {"samples": "13"}}),
    ("DataEnd", "data_section_crc"): number("DataEnd", "data_section_crc"),
    ("CDR", "encapsulation"): in_payload("/pose", patched(1, "B", lambda v: 3)),
    ("CDR", "options"): in_payload("/pose", patched(3, "B", lambda v: 1)),
    ("CDR", "padding"): in_payload("/pose", patched(22, "B", lambda v: 7)),
    ("PoseStamped", "header.stamp.sec"): in_payload("/pose", patched(4, "<i", lambda v: v + 1)),
    ("PoseStamped", "header.stamp.nanosec"): in_payload("/pose", patched(8, "<I", lambda v: v + 1)),
    ("PoseStamped", "header.frame_id"): in_payload("/pose", lambda data: data.replace(b"world", b"wurld")),
    ("PoseStamped", "pose.position"): in_payload("/pose", patched(-56, "<d", lambda v: v + 1e-300)),
    ("PoseStamped", "pose.orientation"): in_payload("/pose", patched(-24, "<d", lambda v: v + 1e-13)),
    ("TwistStamped", "header.stamp.sec"): in_payload("/twist", patched(4, "<i", lambda v: v + 1)),
    ("TwistStamped", "header.stamp.nanosec"): in_payload("/twist", patched(8, "<I", lambda v: v + 1)),
    ("TwistStamped", "header.frame_id"): in_payload("/twist", lambda data: data.replace(b"base", b"bass")),
    ("TwistStamped", "twist.linear"): in_payload("/twist", patched(-48, "<d", lambda v: v + 1e-300)),
    ("TwistStamped", "twist.angular"): in_payload("/twist", patched(-16, "<d", lambda v: v * (1 + 1e-13))),
    **{
        (record, f"header.{field}"): in_payload(topic, change, 2)
        for record, topic, frame in (
            ("Imu", "/imu/data_raw", b"imu_link"),
            ("MagneticField", "/imu/mag", b"imu_link"),
            ("PoseWithCovarianceStamped", "/attitude/pose", b"world"),
            ("Vector3Stamped", "/sun/direction", b"base_link"),
        )
        for field, change in (
            ("stamp.sec", patched(4, "<i", lambda v: v + 1)),
            ("stamp.nanosec", patched(8, "<I", lambda v: v + 1)),
            ("frame_id", renamed(frame)),
        )
    },
    ("PoseWithCovarianceStamped", "pose.position"): in_payload("/attitude/pose", patched(-344, "<d", lambda v: 1.0), 2),
    ("PoseWithCovarianceStamped", "pose.orientation"): in_payload(
        "/attitude/pose", patched(-320, "<d", lambda v: v + 1e-9), 2
    ),
    ("PoseWithCovarianceStamped", "pose.covariance"): in_payload(
        "/attitude/pose", patched(-8, "<d", lambda v: 1.001 * v), 2
    ),
    ("Vector3Stamped", "vector"): in_payload("/sun/direction", patched(-8, "<d", lambda v: v + 1e-9), 2),
    ("Imu", "orientation"): in_payload("/imu/data_raw", patched(-37 * 8, "<d", lambda v: 0.1), 2),
    ("Imu", "orientation_covariance"): in_payload("/imu/bias", patched(-33 * 8, "<d", lambda v: 0.0), 2),
    ("Imu", "angular_velocity"): in_payload("/imu/data_raw", patched(-23 * 8, "<d", lambda v: v * (1 + 1e-8)), 2),
    ("Imu", "angular_velocity, a bias"): in_payload("/imu/bias", patched(-23 * 8, "<d", lambda v: v * (1 + 1e-8)), 2),
    ("Imu", "angular_velocity_covariance"): in_payload("/imu/data_raw", patched(-17 * 8, "<d", lambda v: 2 * v), 2),
    ("Imu", "linear_acceleration"): in_payload("/imu/data_raw", patched(-12 * 8, "<d", lambda v: v * (1 + 1e-8)), 2),
    ("Imu", "linear_acceleration_covariance"): in_payload("/imu/data_raw", patched(-8, "<d", lambda v: 1e-9), 2),
    ("MagneticField", "magnetic_field"): in_payload("/imu/mag", patched(-80, "<d", lambda v: v * (1 + 1e-8)), 2),
    ("MagneticField", "magnetic_field_covariance"): in_payload("/imu/mag", patched(-72, "<d", lambda v: 2 * v), 2),
    ("String", "length"): in_payload("/lie_rigid_body/scenario", patched(4, "<I", lambda v: v + 9), 0),
    ("String", "data"): in_payload("/lie_rigid_body/scenario", lambda data: data[:9] + b"\xff" + data[10:], 0),
    ("fault", "a message"): in_payload("/lie_rigid_body/faults", lambda data: data.replace(b'"x"', b'"y"'), 0),
    ("scenario", "software"): json_value("software", "lie_rigid_body 99"),
    ("scenario", "inertia"): json_value("inertia", [1.0, 2.0, 2.999]),
    ("scenario", "inertia, a common factor"): json_value("inertia", [2.0, 4.0, 6.0]),
    ("scenario", "initial_attitude_xyzw"): json_value("initial_attitude_xyzw", [0.0, 0.0, 0.0, -1.0]),
    ("scenario", "initial_body_rate"): json_value("initial_body_rate", [0.0100001, 1.0, 0.01]),
    ("scenario", "rate"): json_value("rate", 16.0),
    ("scenario", "motion"): json_value("motion", "moving_chart"),
    ("scenario", "method"): json_value("method", "dmv8"),
    ("scenario", "max_step"): json_value("max_step", 0.002),
    ("scenario", "world_frame"): json_value("world_frame", "wurld"),
    ("scenario", "body_frame"): json_value("body_frame", "bass_link"),
    ("scenario", "stamped_twist"): json_value("stamped_twist", value=False),
    ("scenario", "epoch_ns"): json_value("epoch_ns", 10**18 + 10_000_000),
    ("scenario", "first_sample"): json_value("first_sample", 5),
    ("scenario", "start_ns"): json_value("start_ns", 10**18 + 125_000_000),
    ("scenario", "a name twice"): in_payload(
        "/lie_rigid_body/scenario", lambda d: encode_string(d[8:-1].decode().replace("{", '{"rate": 9.0, ', 1)), 0
    ),
    ("scenario", "an unknown name"): json_value("inertial", [1.0, 2.0, 3.0]),
    ("scenario", "the sensors' parameters"): json_value("sensor_seed", 1),
    ("scenario", "those that no reading shows"): json_value("gravity", 1.62),
    ("metadata.yaml", "relative_file_paths"): hidden_file,
    ("metadata.yaml", "compression_mode"): in_yaml(lambda y: y.update(compression_mode="message")),
}


def test_the_page_names_every_field_that_is_altered_here():
    assert set(rows()) == set(FORGERIES)


@pytest.mark.parametrize("make", [copy, in_yaml(lambda y: None)], ids=["file", "folder"])
def test_the_honest_copy_is_certified_and_says_what_is_not(honest: Path, tmp_path: Path, make: Any):
    path = make(honest, tmp_path / "copy.mcap" if make is copy else tmp_path)
    found = certify(read_bag(path))
    assert found.passed, found.messages
    assert telling(found, "no checksum", count=1)
    assert found.sensors == ("/imu/data_raw", "/imu/bias", "/imu/mag", "/attitude/pose", "/sun/direction")
    assert telling(found, "attachments", count=1)


def test_of_every_bag_the_end_is_said_not_to_be_certified(honest: Path, tmp_path: Path):
    """A run that was cut short, and its counts with it, is one that was short from the beginning."""
    forged = certify(read_bag(shortened()(honest, tmp_path)))
    assert forged.passed, forged.messages
    assert forged.segments[0].samples == COUNT - 4
    for found in (forged, certify(read_bag(honest))):
        [end] = telling(found, "shortened")
        assert as_json("x.mcap", found)["not_certified"] == list(found.not_certified)
        assert end in " ".join(as_table("x.mcap", found).split())


def verdict(bag: Path) -> str:
    try:
        found = certify(read_bag(bag))
    except LieRigidBodyError:
        return CAUGHT
    if not found.passed:
        return CAUGHT
    return CERTIFIED if telling(found, "beside the messages") else "without a word"


@pytest.mark.parametrize("row", FORGERIES, ids=" ".join)
def test_an_altered_field_is_caught_or_named_as_not_certified(honest: Path, tmp_path: Path, row: tuple[str, str]):
    free = rows()[row].startswith("not certified")
    assert verdict(FORGERIES[row](honest, tmp_path)) == (CERTIFIED if free else CAUGHT)
