"""Sensor messages: the same bytes as rclpy's where it is installed, and what other libraries read in them."""

from __future__ import annotations

from functools import reduce
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_typestore

from lie_rigid_body.messages import ReadingEncoder, decode_string, encode_strings, numbers_of
from lie_rigid_body.messages.definitions import (
    IMU,
    MAGNETIC_FIELD,
    POSE_WITH_COVARIANCE_STAMPED,
    STRING,
    VECTOR3_STAMPED,
    definition,
    places,
)
from lie_rigid_body.messages.layout import Layout, Payloads, header
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import SENSORS, Sensor
from lie_rigid_body.simulation import SensorSamples

STORE = get_typestore(Stores.ROS2_JAZZY)
FRAMES = ["w", "ab", "imu", "imu_", "imu_l", "imu_li", "imu_lin", "imu_link", "å", "körper", "刚体"]
STAMPS = np.array([0, 1, 999_999_999, 10**9, (2**31 - 1) * 10**9 + 999_999_999])
RATES = np.array([[0.01, 1, 0.01], [-0.0, 5e-324, 1e308], [1 / 3, -2 / 3, 0.1], [0, 0, -0.0], [1e-9, 1e9, np.pi]])
FORCES = RATES[::-1] * [1.0, -0.5, 1.5]
FIELDS = RATES[[2, 0, 4, 1, 3]] * 1e-5
DIAGONAL = [0, 4, 8]
ATTITUDES = np.random.default_rng(1).normal(size=(len(STAMPS), 4))
COVARIANCES = np.random.default_rng(2).normal(size=(len(STAMPS), 3, 3))


NOISE: dict[str, Any] = {
    "gyro_noise_density": 0.1,
    "accelerometer_noise_density": 1 / 3,
    "magnetometer_noise_density": 1e-8,
}
"""Deviations of readings, as each sensor has one in a second."""


def encoder(sensor: str, frame: str = "imu_link", topic: int = 0, **given: object) -> ReadingEncoder:
    wanted = SENSORS[sensor].topics[topic]
    scenario = Scenario.from_parameters({f"{sensor}_rate": 1.0, "imu_frame": "elsewhere", wanted.frame: frame, **given})
    return ReadingEncoder(wanted, scenario.sensors.on[sensor], scenario)


def readings(**arrays: np.ndarray) -> SensorSamples:
    return SensorSamples(STAMPS, STAMPS, np.zeros(len(STAMPS), dtype=bool), arrays)


def imu_messages(frame: str = "imu_link") -> Payloads:
    return encoder("imu", frame, **NOISE).encode(readings(gyro=RATES, specific_force=FORCES))


def field_messages(frame: str = "imu_link") -> Payloads:
    return encoder("magnetometer", frame, **NOISE).encode(readings(field=FIELDS))


def decode_by_schema(message_type: str, payload: bytes) -> Any:
    schema = Schema(1, definition(message_type).encode(), "ros2msg", message_type)
    decode = DecoderFactory().decoder_for("cdr", schema)
    assert decode is not None
    return decode(payload)


def decode_by_rosbags(message_type: str, payload: bytes) -> Any:
    message: Any = STORE.deserialize_cdr(payload, message_type)
    return message


DECODERS = pytest.mark.parametrize("decode", [decode_by_schema, decode_by_rosbags])


def xyz(vector: SimpleNamespace) -> list[float]:
    return [vector.x, vector.y, vector.z]


def require_header(message: SimpleNamespace, k: int, frame: str) -> None:
    assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == STAMPS[k]
    assert message.header.frame_id == frame


def diagonal(variance: float) -> list[float]:
    return (np.eye(3) * variance).ravel().tolist()


@DECODERS
@pytest.mark.parametrize("frame", FRAMES)
def test_others_read_the_imu_and_the_magnetic_field(decode: Any, frame: str) -> None:
    for k, (imu, field) in enumerate(zip(imu_messages(frame), field_messages(frame), strict=True)):
        message = decode(IMU, imu)
        require_header(message, k, frame)
        assert (xyz(message.orientation), message.orientation.w) == ([0.0, 0.0, 0.0], 1.0)
        assert list(message.orientation_covariance) == [-1.0, *[0.0] * 8]
        assert xyz(message.angular_velocity) == RATES[k].tolist()
        assert list(message.angular_velocity_covariance) == diagonal(0.1**2)
        assert xyz(message.linear_acceleration) == FORCES[k].tolist()
        assert list(message.linear_acceleration_covariance) == diagonal((1 / 3) ** 2)
        message = decode(MAGNETIC_FIELD, field)
        require_header(message, k, frame)
        assert xyz(message.magnetic_field) == FIELDS[k].tolist()
        assert list(message.magnetic_field_covariance) == diagonal(1e-8**2)


@DECODERS
@pytest.mark.parametrize("frame", FRAMES)
def test_others_read_attitudes_vectors_and_orientations(decode: object, frame: str) -> None:
    read = readings(attitude_xyzw=ATTITUDES, covariance=COVARIANCES)
    poses = encoder("attitude_sensor", frame).encode(read)
    vectors = encoder("sun_sensor", frame).encode(readings(direction=FIELDS))
    ahrs = encoder("imu", frame, imu_orientation=True, imu_inclination_noise=0.5, imu_heading_noise=2.0)
    oriented = ahrs.encode(readings(gyro=RATES, specific_force=FORCES, orientation_xyzw=ATTITUDES))
    for k in range(len(STAMPS)):
        pose = decode(POSE_WITH_COVARIANCE_STAMPED, poses[k])  # type: ignore[operator]
        vector = decode(VECTOR3_STAMPED, vectors[k])  # type: ignore[operator]
        imu = decode(IMU, oriented[k])  # type: ignore[operator]
        for message in (pose, vector, imu):
            require_header(message, k, frame)
        assert xyz(pose.pose.pose.position) == [0.0, 0.0, 0.0]
        for orientation in (pose.pose.pose.orientation, imu.orientation):
            assert [*xyz(orientation), orientation.w] == ATTITUDES[k].tolist()
        covariance = np.reshape(pose.pose.covariance, (6, 6))
        assert covariance[3:, 3:].tolist() == COVARIANCES[k].tolist()
        assert not covariance[:3].any()
        assert not covariance[:, :3].any()
        assert list(imu.orientation_covariance) == np.diag([0.25, 0.25, 4.0]).ravel().tolist()
        assert xyz(imu.angular_velocity) == RATES[k].tolist()
        assert xyz(vector.vector) == FIELDS[k].tolist()


@DECODERS
def test_others_read_texts_of_one_length(decode: object) -> None:
    told = ["", '{"kind": "stuck"}', "x" * 30]
    payloads = encode_strings(told, 30)
    assert [decode(STRING, payload).data.rstrip() for payload in payloads] == told  # type: ignore[operator]
    assert [decode_string(payload) for payload in payloads] == [text.ljust(30) for text in told]


def test_covariances_are_unknown_unless_given() -> None:
    read = readings(gyro=RATES, specific_force=FORCES, gyro_bias=RATES, accelerometer_bias=FORCES, field=FIELDS)
    imu, bias = (decode_by_schema(IMU, encoder("imu", topic=topic).encode(read)[0]) for topic in (0, 1))
    field = decode_by_schema(MAGNETIC_FIELD, encoder("magnetometer").encode(read)[0])
    for message in (imu, bias):
        assert list(message.orientation_covariance) == [-1.0, *[0.0] * 8]
        assert message.orientation.w == 1.0
    for covariance in (
        imu.angular_velocity_covariance,
        imu.linear_acceleration_covariance,
        bias.angular_velocity_covariance,
        bias.linear_acceleration_covariance,
        field.magnetic_field_covariance,
    ):
        assert list(covariance) == [0.0] * 9


def test_batches_of_any_size_give_the_same_bytes() -> None:
    imu, field = encoder("imu", **NOISE), encoder("magnetometer", **NOISE)
    one_by_one = [slice(k, k + 1) for k in range(len(STAMPS))]
    read = readings(gyro=RATES, specific_force=FORCES, field=FIELDS)
    assert [imu.encode(read[k])[0] for k in one_by_one] == list(imu_messages())
    assert [field.encode(read[k])[0] for k in one_by_one] == list(field_messages())
    assert len(imu.encode(read[:0])) == 0


@pytest.mark.ros
@pytest.mark.parametrize("frame", FRAMES)
def test_bytes_equal_rclpy_serialisation(frame: str) -> None:
    from rclpy.serialization import deserialize_message, serialize_message
    from sensor_msgs.msg import Imu, MagneticField
    from test_cdr import without_padding

    for k, (imu_bytes, field_bytes) in enumerate(zip(imu_messages(frame), field_messages(frame), strict=True)):
        imu, field = Imu(), MagneticField()
        for message in (imu, field):
            message.header.frame_id = frame
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(STAMPS[k].item(), 10**9)
        imu.orientation_covariance[0] = -1.0
        imu.angular_velocity_covariance[DIAGONAL] = 0.1**2
        imu.linear_acceleration_covariance[DIAGONAL] = (1 / 3) ** 2
        field.magnetic_field_covariance[DIAGONAL] = 1e-8**2
        for vector, values in (
            (imu.angular_velocity, RATES),
            (imu.linear_acceleration, FORCES),
            (field.magnetic_field, FIELDS),
        ):
            vector.x, vector.y, vector.z = values[k].tolist()
        assert without_padding(imu_bytes, frame) == without_padding(serialize_message(imu), frame)
        assert without_padding(field_bytes, frame) == without_padding(serialize_message(field), frame)
        assert deserialize_message(imu_bytes, Imu) == imu
        assert deserialize_message(field_bytes, MagneticField) == field


@pytest.mark.parametrize("sensor", SENSORS.values(), ids=SENSORS)
def test_fields_lie_where_rosbags_reads_them(sensor: Sensor) -> None:
    """Each number of each field, by its place in a message made of the numbers 0, 1, 2 and so on."""
    for topic in sensor.topics:
        numbers = np.arange(len(places(topic.message_type)[""]), dtype=np.float64)
        payload = next(
            iter(Layout(header("f"), [0.0] * len(numbers), [range(len(numbers))]).encode(STAMPS[:1], numbers))
        )
        message = decode_by_rosbags(topic.message_type, payload)
        for field in topic.fields:
            content = reduce(getattr, field.place.split("."), message)
            found = list(content) if isinstance(content, np.ndarray) else [*vars(content).values()][:-1]
            wanted = [found[i] for i in field.numbers or range(len(found))]
            assert list(numbers_of(topic, field)) == wanted
