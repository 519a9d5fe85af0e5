"""Every field of a message altered: one table of where, what, and the laws that it breaks.

The rows are those of docs/reference/fields.md. What stands around the messages is read or refused by `recording`.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from phrases import telling
from sensor_bags import AT, BIAS, EPOCH, IMU, MAG, MOTIONS, NOISY, broken, laws, write
from tampering import Change, at, declared, flipped, on, rotated, scaled_rate, tamper, with_numbers

from foreign_bags import Message, messages_of
from lie_rigid_body.certificate import Certificate, LawResult, certify
from lie_rigid_body.certificate.stamps import DISORDER, DUPLICATE, GAP, OFF_GRID
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.messages import encode_string
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import LIBRARY
from sampled import sampled

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "fields.md"
ATTITUDE, SUN = "/attitude/pose", "/sun/direction"
FAULTS, SCENARIO = "/lie_rigid_body/faults", "/lie_rigid_body/scenario"
REFUSED, CERTIFIED = {"refused"}, set[str]()
HERE = 9
"""Index of the message that is altered."""
GIVEN: dict[str, object] = {
    **NOISY,
    "motion": "closed_form",
    "accelerometer_lever_arm": [0.1, -0.2, 0.05],
    "imu_orientation": True,
    "imu_heading_noise": 1e-3,
    "attitude_sensor_rate": 40.0,
    "attitude_sensor_roll_noise": 1e-3,
    "sun_sensor_rate": 50.0,
    "magnetometer_temperature_drift": 1e-9,
}


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("bags") / "honest.mcap", (GIVEN, 0.25))


def one(topic: str, change: Callable[[Message], Message], index: int = HERE) -> Change:
    return on(topic, at(index, change))


def vector(from_end: int, change: Callable[[np.ndarray], object], count: int = 3) -> Callable[[Message], Message]:
    """Change some numbers that follow each other, the first counted from the end of a message."""
    changed = lambda numbers: np.append(np.asarray(change(numbers[:count])), numbers[count:])  # noqa: E731
    return lambda message: with_numbers(message, from_end, changed)


def number(from_end: int, change: Callable[[float], float]) -> Callable[[Message], Message]:
    """Change a number, counted from the end of a message."""
    return vector(from_end, lambda one: change(one[0]), 1)


def patched(place: int, code: str, by: int) -> Callable[[Message], Message]:
    """Add to a number of the header of a message."""

    def patch(message: Message) -> Message:
        data = bytearray(message.data)
        struct.pack_into(code, data, place, struct.unpack_from(code, data, place)[0] + by)
        return message._replace(data=bytes(data))

    return patch


def renamed(frame: bytes) -> Callable[[Message], Message]:
    return lambda m: m._replace(data=m.data.replace(frame, frame[::-1]))


def text(change: Callable[[str], str]) -> Callable[[Message], Message]:
    return lambda m: m._replace(data=encode_string(change(m.data[8:-1].decode())))


def headers() -> dict[tuple[str, str], tuple[Change, set[str]]]:
    """Stamps and frames of each type of message."""
    found = {}
    for record, topic, frame, title in (
        ("PoseStamped", "/pose", b"world", ""),
        ("TwistStamped", "/twist", b"base_link", ""),
        ("Imu", IMU, b"imu_link", "IMU"),
        ("MagneticField", MAG, b"imu_link", "magnetometer"),
        ("PoseWithCovarianceStamped", ATTITUDE, b"world", "attitude sensor"),
        ("Vector3Stamped", SUN, b"base_link", "sun sensor"),
    ):
        stamps = {f"{title} stamps".strip()}
        frames = {"IMU": "IMU frame and covariances", "magnetometer": "magnetometer frame and covariances"}.get(
            title, {"": "frames", "attitude sensor": "attitude sensor frame and position"}.get(title, f"{title} frame")
        )
        found[record, "header.stamp.sec"] = one(topic, patched(4, "<i", 1)), stamps
        found[record, "header.stamp.nanosec"] = one(topic, patched(8, "<I", 1)), stamps
        found[record, "header.frame_id"] = one(topic, renamed(frame)), {frames}
    return found


FORGERIES: dict[tuple[str, str], tuple[Change, set[str]]] = {
    ("Message", "one missing"): (on("/pose", lambda ms: [*ms[:HERE], *ms[HERE + 1 :]]), {"stamps"}),
    ("Message", "one twice"): (on("/twist", lambda ms: [*ms[: HERE + 1], *ms[HERE:]]), {"stamps"}),
    ("Message", "two exchanged"): (
        on("/pose", lambda ms: [*ms[:HERE], ms[HERE + 1], ms[HERE], *ms[HERE + 2 :]]),
        {"stamps"},
    ),
    ("Message", "log_time"): (one("/pose", lambda m: m._replace(log_time=m.log_time + 1)), {"log times"}),
    ("CDR", "encapsulation"): (one("/pose", lambda m: m._replace(data=b"\0\3" + m.data[2:])), REFUSED),
    ("CDR", "options"): (one("/pose", lambda m: m._replace(data=m.data[:3] + b"\1" + m.data[4:])), CERTIFIED),
    **headers(),
    ("PoseStamped", "pose.position"): (one("/pose", number(7, lambda x: x + 1e-300)), {"position"}),
    ("PoseStamped", "pose.orientation"): (one("/pose", rotated(1e-14, np.array([0.3, 0.8, -0.5]))), {"attitude"}),
    ("PoseStamped", "pose.orientation, its sign"): (one("/pose", flipped), {"sign continuity"}),
    ("PoseStamped", "pose.orientation, its norm"): (
        one("/pose", lambda m: with_numbers(m, 4, lambda q: (1.0 + 1e-14) * q)),
        {"unit norm"},
    ),
    ("TwistStamped", "twist.linear"): (
        one("/twist", number(6, lambda x: x + 1e-300)),
        {"velocity"},
    ),
    ("TwistStamped", "twist.angular"): (one("/twist", scaled_rate(1.0 + 1e-13)), {"body rate"}),
    ("Imu", "orientation"): (one(IMU, number(37, lambda x: x + 1e-11)), {"IMU orientation"}),
    ("Imu", "orientation_covariance"): (one(IMU, number(33, lambda x: x + 1e-12)), {"IMU frame and covariances"}),
    ("Imu", "angular_velocity"): (one(IMU, number(24, lambda x: x + 1e-9)), {"gyro"}),
    ("Imu", "angular_velocity, a bias"): (one(BIAS, number(24, lambda x: x + 1e-11)), {"gyro bias"}),
    ("Imu", "angular_velocity_covariance"): (one(IMU, number(21, lambda x: 2 * x)), {"IMU frame and covariances"}),
    ("Imu", "linear_acceleration"): (one(IMU, number(12, lambda x: x + 1e-9)), {"accelerometer"}),
    ("Imu", "linear_acceleration, a bias"): (one(BIAS, number(12, lambda x: x * (1 + 1e-9))), {"accelerometer bias"}),
    ("Imu", "linear_acceleration_covariance"): (one(IMU, number(9, lambda x: x + 1e-9)), {"IMU frame and covariances"}),
    ("MagneticField", "magnetic_field"): (one(MAG, number(12, lambda x: x + 1e-14)), {"magnetometer"}),
    ("MagneticField", "magnetic_field_covariance"): (
        one(MAG, number(9, lambda x: 2 * x)),
        {"magnetometer frame and covariances"},
    ),
    ("PoseWithCovarianceStamped", "pose.position"): (
        one(ATTITUDE, number(43, lambda x: 1.0)),
        {"attitude sensor frame and position"},
    ),
    ("PoseWithCovarianceStamped", "pose.orientation"): (
        one(ATTITUDE, number(40, lambda x: x + 1e-9)),
        {"attitude sensor"},
    ),
    ("PoseWithCovarianceStamped", "pose.covariance"): (
        one(ATTITUDE, number(1, lambda x: 1.001 * x)),
        {"attitude sensor covariance"},
    ),
    ("Vector3Stamped", "vector"): (one(SUN, number(1, lambda x: x + 1e-9)), {"sun sensor"}),
    ("String", "length"): (one(SCENARIO, patched(4, "<I", 9), 0), REFUSED),
    ("String", "data"): (one(SCENARIO, lambda m: m._replace(data=m.data[:9] + b"\xff" + m.data[10:]), 0), REFUSED),
    ("fault", "a message"): (one(FAULTS, text(lambda told: told.replace('"x"', '"y"')), 0), {"faults"}),
    ("scenario", "software"): (declared(software="lie_rigid_body 99"), CERTIFIED),
    ("scenario", "inertia"): (declared(inertia=[1.0, 0.1, -0.05, 1.4, 0.2, 1.9001]), {"attitude", "body rate"}),
    ("scenario", "inertia, an impossible one"): (declared(inertia=[1.0, 1.0, 5.0]), {"declaration"}),
    ("scenario", "inertia, a common factor"): (declared(inertia=[2.0, 0.2, -0.1, 2.8, 0.4, 3.8]), CERTIFIED),
    ("scenario", "initial_attitude_xyzw"): (declared(initial_attitude_xyzw=[0.0, 0.0, 0.0, -1.0]), {"sign continuity"}),
    ("scenario", "initial_body_rate"): (declared(initial_body_rate=[0.7000001, -1.3, 0.4]), {"attitude", "body rate"}),
    ("scenario", "kicks"): (declared(kicks=[0.1, 0.7, -1.3, 0.4]), {"attitude"}),
    ("scenario", "translation"): (declared(translation="thrown"), {"position", "velocity"}),
    ("scenario", "initial_position"): (declared(initial_position=[0.0, 0.0, 1e-300]), {"position"}),
    ("scenario", "rate"): (declared(rate=60.0), {"stamps"}),
    ("scenario", "motion"): (declared(motion="moving_chart"), CERTIFIED),
    ("scenario", "method"): (declared(method="dmv8"), CERTIFIED),
    ("scenario", "max_step"): (declared(max_step=0.002), CERTIFIED),
    ("scenario", "world_frame"): (declared(world_frame="wurld"), {"frames"}),
    ("scenario", "body_frame"): (declared(body_frame="bass_link"), {"frames"}),
    ("scenario", "stamped_twist"): (declared(stamped_twist=False), {"declaration"}),
    ("scenario", "epoch_ns"): (declared(epoch_ns=EPOCH + 10_000_000), REFUSED),
    ("scenario", "first_sample"): (declared(first_sample=5), REFUSED),
    ("scenario", "start_ns"): (declared(start_ns=EPOCH + 125_000_000), REFUSED),
    ("scenario", "a name twice"): (
        one(SCENARIO, text(lambda told: told.replace("{", '{"rate": 9.0, ', 1)), 0),
        REFUSED,
    ),
    ("scenario", "an unknown name"): (declared(inertial=[1.0, 2.0, 3.0]), {"declaration"}),
    ("scenario", "the sensors' parameters"): (declared(sensor_seed=1), {"gyro", "accelerometer", "magnetometer"}),
    ("scenario", "those that no reading shows"): (declared(gyro_range=1e3), CERTIFIED),
}


def rows() -> dict[tuple[str, str], str]:
    """The table of the page, of which a row may be of several records and fields: what each is held against."""
    found = re.findall(r"^\| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    told = [row for row in found if row[0] not in ("record", "---")]
    each = (
        (record, field, against)
        for records, fields, against in told
        for record in records.split(", ")
        for field in fields.split("; ")
    )
    return {(record, field): against for record, field, against in each}


def verdict(path: Path) -> tuple[set[str], Certificate | None]:
    try:
        found = certify(Bag(path))
    except LieRigidBodyError:
        return REFUSED, None
    return broken(found), found


def test_the_page_has_the_rows_of_the_table() -> None:
    assert set(rows()) == set(FORGERIES)
    for row, (_, expected) in FORGERIES.items():
        assert rows()[row].startswith("not certified") == (not expected), row


@pytest.mark.parametrize("row", FORGERIES, ids=" ".join)
def test_an_altered_field_breaks_its_law(honest: Path, tmp_path: Path, row: tuple[str, str]) -> None:
    change, expected = FORGERIES[row]
    found, certificate = verdict(tamper(honest, tmp_path / "forged.mcap", change, library=LIBRARY))
    depend = row[0] == "scenario" or "stamp" in row[1]  # on such a field more laws depend than its own
    assert found == expected or (depend and expected and expected <= found)
    if certificate is not None and certificate.segments:
        assert telling(certificate, "beside the messages")
        assert all(law.message for law in certificate.laws if not law.holds)


STAMPED = {
    IMU: ("IMU stamps", 333.3),
    BIAS: ("IMU stamps", 333.3),
    MAG: ("magnetometer stamps", 70.0),
    ATTITUDE: ("attitude sensor stamps", 40.0),
    SUN: ("sun sensor stamps", 50.0),
}


@pytest.mark.parametrize(("topic", "index"), sampled([(t, i) for t in STAMPED for i in (0, AT, -1)], every=4))
def test_a_reading_that_is_missing_doubled_displaced_or_exchanged_is_named(honest, tmp_path, topic, index):
    name, rate = STAMPED[topic]
    count = sum(message.topic == topic for message in messages_of(honest))
    index = min(index % count, count - 2)

    def law(change: Callable[[list[Message]], list[Message]]) -> LawResult:
        found, certificate = verdict(tamper(honest, tmp_path / "forged.mcap", on(topic, change)))
        assert found == {name}
        assert certificate is not None
        return laws(certificate, name)[0]

    missing = law(lambda ms: [*ms[:index], *ms[index + 1 :]])
    assert (missing.unit, missing.sample, missing.worst) == (GAP, index, 1)
    assert missing.stamp_ns == pytest.approx(EPOCH + index / rate * 1e9, abs=300)
    doubled = law(lambda ms: [*ms[: index + 1], *ms[index:]])
    assert (doubled.unit, doubled.sample) == (DUPLICATE, index)
    displaced = law(lambda ms: [*ms[:index], ms[index + 1], ms[index], *ms[index + 2 :]])
    assert (displaced.unit, displaced.sample) == (DISORDER, index + 1)
    off = law(at(index, patched(8, "<I", 1)))
    assert (off.unit, off.sample, off.worst) == (OFF_GRID, index, 1.0)


@pytest.mark.parametrize("value", [0.0, np.nan, np.inf, 123.0])
def test_impossible_numbers_break_laws(honest, tmp_path, value):
    for topic, end, count, law in (
        ("/pose", 4, 4, "attitude"),
        ("/twist", 3, 3, "body rate"),
        (IMU, 24, 3, "gyro"),
        (MAG, 12, 3, "magnetometer"),
        (ATTITUDE, 40, 4, "attitude sensor"),
        (SUN, 3, 3, "sun sensor"),
    ):
        change = one(topic, vector(end, partial(np.full_like, fill_value=value), count))
        assert law in verdict(tamper(honest, tmp_path / "forged.mcap", change))[0]


@pytest.mark.parametrize(("rate", "by"), [(333.3, 2e-9), (1000.0, 5e-9)])
@pytest.mark.parametrize("kind", ["instantaneous", "integrated"])
@pytest.mark.parametrize("motion", ["closed form", "dmv20"])
def test_a_noise_free_reading_moved_by_a_billionth_is_caught(tmp_path, motion, kind, rate, by):
    given = {**MOTIONS[motion], "imu_rate": rate, "gyro_rate": kind, "accelerometer_mode": "pivot_gravity"}
    path = write(tmp_path / "a.mcap", (given, 0.2))
    assert certify(Bag(path)).passed
    for end, law, size in ((24, "gyro", by if kind == "integrated" else 1e-9), (12, "accelerometer", 1e-9)):
        change = one(IMU, vector(end, partial(np.multiply, 1.0 + size)))
        assert verdict(tamper(path, tmp_path / "b.mcap", change))[0] == {law}
