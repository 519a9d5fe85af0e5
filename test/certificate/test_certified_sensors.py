"""Readings of sensors are held against those that the scenario determines: honest ones pass, any other is named."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from tampering import Change, Message, at, on, tamper, with_numbers

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.certificate import Certificate, LawResult, certify, pairing, sensor_topics
from lie_rigid_body.certificate.readings import BiasReadings, Expected, ImuReadings
from lie_rigid_body.messages import encode_string
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording import bag_reader
from lie_rigid_body.recording.bag_reader import Bag, read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.recording.recovery import recover
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import Imu
from lie_rigid_body.sensors.quantisation import Converter
from lie_rigid_body.simulation import Simulation

EPOCH = 1_792_000_000_123_456_789
BODY = {"inertia": [1.0, 0.1, -0.05, 1.4, 0.2, 1.9], "initial_body_rate": [0.7, -1.3, 0.4], "epoch_ns": EPOCH}
RATES = {"rate": 59.94, "imu_rate": 333.3, "magnetometer_rate": 70.0}
NOISY: dict[str, object] = {
    "sensor_seed": 11,
    "gyro_noise_density": 1e-3,
    "gyro_bias_random_walk": 1e-3,
    "gyro_turn_on_bias": 0.01,
    "accelerometer_noise_density": 2e-3,
    "accelerometer_bias_random_walk": 2e-3,
    "accelerometer_turn_on_bias": 0.05,
    "magnetometer_noise_density": 1e-8,
}
SKEWED: dict[str, object] = {
    "gyro_scale_factor": [1.01, -0.98, 1.02],
    "gyro_misalignment": [0.01, -0.02, 0.03],
    "accelerometer_scale_factor": [1.01, 0.98, -1.02],
    "accelerometer_misalignment": [0.3, -0.02, 0.03],
    "magnetometer_hard_iron": [1e-6, 2e-6, -3e-6],
    "magnetometer_soft_iron": [1.1, 0.02, 0.01, -0.03, 0.95, 0.04, 0.05, 0.02, 1.05],
}
COARSE: dict[str, object] = {
    "gyro_resolution": 1e-3,
    "gyro_range": 1.2,
    "accelerometer_resolution": 0.02,
    "accelerometer_range": 9.0,
    "magnetometer_resolution": 1e-7,
    "magnetometer_range": 30e-6,
}
FORCE: dict[str, object] = {"accelerometer_mode": "pivot_gravity", "accelerometer_lever_arm": [0.1, -0.2, 0.05]}
SENSORS: dict[str, dict[str, object]] = {
    "perfect": {},
    "lever arm": {"accelerometer_lever_arm": [0.1, -0.2, 0.05]},
    "pivot": {"accelerometer_mode": "pivot_gravity", "gravity": 1.62},
    "integrated": {"gyro_rate": "integrated"},
    "noisy": NOISY,
    "skewed": {**FORCE, **SKEWED},
    "coarse": {**FORCE, **COARSE},
    "all errors": {**FORCE, **NOISY, **SKEWED, **COARSE, "gyro_rate": "integrated"},
    "mems": {**FORCE, "sensor_grade": "mems"},
    "tactical": {**FORCE, "sensor_grade": "tactical", "gyro_noise_density": 0.0},
    "another field": {"magnetic_field": [2e-5, -1e-5, 3e-5], "imu_frame": "sénsor"},
    "magnetometer alone": {"imu_rate": 0.0},
    "IMU alone": {"magnetometer_rate": 0.0},
    "slow": {"imu_rate": 3.0, "magnetometer_rate": 0.7},
}
MOTIONS: dict[str, dict[str, object]] = {
    "closed form": {"motion": "closed_form"},
    "dmv20": {"max_step": 0.01},
    "rkmk4": {"method": "rkmk4", "max_step": 0.002},
}
VALUES = ("gyro", "accelerometer", "gyro bias", "accelerometer bias", "magnetometer")
IMU, BIAS, MAG = "/imu/data_raw", "/imu/bias", "/imu/mag"


def write(path: Path, *stages: tuple[dict[str, object], float], chunk_size: int = 10_000) -> Path:
    """A bag as a node records it: a reset's scenario at once, readings left from before it later."""
    simulation = Simulation(Scenario.from_parameters({**BODY, **RATES, **stages[0][0]}))
    end = EPOCH
    with BagWriter(path, stamped_twist=True, chunk_size=chunk_size) as bag:
        for i, (parameters, seconds) in enumerate(stages):
            if i:
                simulation.reset(Scenario.from_parameters({**BODY, **RATES, **parameters}))
            bag.begin_segment(simulation.segment)
            encoder, end = BatchEncoder(simulation.segment.scenario), end + round(seconds * 1e9)
            while simulation.next_stamp_ns <= end:
                bag.write(encoder.encode(simulation.take_until(end, 40)))
    return path


def laws(found: Certificate, name: str) -> list[LawResult]:
    return [law for segment in found.segments for law in segment.laws if law.name == name]


def broken(found: Certificate) -> set[str]:
    return {law.name for part in (*(s.laws for s in found.segments), found.whole) for law in part if not law.holds}


WITH_STEPS = ("lever arm", "integrated", "all errors", "mems")


@pytest.mark.parametrize(
    ("motion", "sensors"),
    [("closed form", name) for name in SENSORS] + [(name, some) for name in ("dmv20", "rkmk4") for some in WITH_STEPS],
)
def test_honest_readings_are_certified(tmp_path, motion, sensors):
    parameters = {**MOTIONS[motion], **SENSORS[sensors]}
    found = certify(Bag(write(tmp_path / "a.mcap", (parameters, 1.0))))
    assert found.passed, found.messages
    scenario = found.segments[0].segment.scenario.sensors
    wanted = [IMU, BIAS] * (scenario.imu is not None) + [MAG] * (scenario.magnetometer is not None)
    assert list(found.sensors) == wanted
    held = [law for name in VALUES for law in laws(found, name)]
    assert len(held) == 4 * (scenario.imu is not None) + (scenario.magnetometer is not None)
    assert not any("imu/" in text for text in found.not_certified)
    if motion == "closed form":
        assert all(law.worst == 0.0 for law in held)  # the same numbers, to the bit
    for law in held:
        assert law.checked > 0
        assert law.worst <= 0.5 * law.limit or law.worst == 0.0


RESETS: dict[str, dict[str, object]] = {
    "the same": {},
    "another start": {"initial_body_rate": [0.3, 0.3, -1.0]},
    "another rate": {"imu_rate": 111.1, "rate": 80.0},
    "another frame": {"imu_frame": "other_link"},
    "another noise": {"gyro_noise_density": 0.5, "sensor_seed": 3, "magnetometer_resolution": 1e-6},
    "no magnetometer": {"magnetometer_rate": 0.0},
    "no IMU": {"imu_rate": 0.0},
    "no sensor": {"imu_rate": 0.0, "magnetometer_rate": 0.0},
}


@pytest.mark.parametrize("change", RESETS)
def test_resets_begin_the_noise_anew(tmp_path, change):
    first: dict[str, object] = {"motion": "closed_form", **FORCE, **NOISY}
    stages = [(first, 0.5), ({**first, **RESETS[change]}, 0.4), ({**first, **RESETS[change]}, 0.001), (first, 0.3)]
    path = write(tmp_path / "a.mcap", *stages)
    found = certify(Bag(path))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS, MAG)
    assert all(law.worst == 0.0 for name in VALUES for law in laws(found, name))
    late = tamper(path, tmp_path / "b.mcap", recorded(0.213, 0.06))
    found = certify(Bag(late))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS, MAG)


def recorded(late: float, early: float = 0.0) -> Change:
    """What a recorder would have that came late, s, and on each topic ended a little differently before the end."""

    def change(messages: list[Message]) -> list[Message]:
        last = messages[-1].log_time - early * 1e9
        ends = {topic: last - 3e6 * i for i, topic in enumerate((IMU, "/pose", BIAS, "/twist", MAG))}
        return [
            m._replace(log_time=m.log_time + 12_345)
            for m in messages
            if m.topic not in ends or EPOCH + late * 1e9 <= m.log_time <= ends[m.topic]
        ]

    return change


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("bags") / "honest.mcap"
    return write(path, ({**MOTIONS["dmv20"], **FORCE, **NOISY}, 0.995))


def certificate(bag: Path, folder: Path, change: Change) -> Certificate:
    return certify(Bag(tamper(bag, folder / "tampered.mcap", change)))


AT = 37
PLACES = {  # where a vector ends, in numbers from the end of the message, and the law that speaks of it
    (IMU, 24): "gyro",
    (IMU, 12): "accelerometer",
    (BIAS, 24): "gyro bias",
    (BIAS, 12): "accelerometer bias",
    (MAG, 12): "magnetometer",
}


@pytest.mark.parametrize("place", PLACES, ids=PLACES.values())
@pytest.mark.parametrize(
    ("axis", "number"), [(0, lambda x: x * (1 + 1e-11)), (1, lambda x: 123.0), (2, lambda x: np.nan), (1, lambda x: -x)]
)
def test_a_changed_number_is_named(bag, tmp_path, place, axis, number):
    (topic, from_end), name = place, PLACES[place]

    def changed(numbers: np.ndarray) -> np.ndarray:
        numbers[axis] = number(numbers[axis])
        return numbers

    found = certificate(bag, tmp_path, on(topic, at(AT, lambda m: with_numbers(m, from_end, changed))))
    assert broken(found) == {name}
    [law] = laws(found, name)
    rate = 70.0 if topic == MAG else 333.3
    assert (law.sample, law.broken) == (AT, 1)
    assert law.stamp_ns == pytest.approx(EPOCH + AT / rate * 1e9, abs=300)
    [said] = found.messages
    assert said.startswith(f"{topic}: ")
    assert f"at reading {AT}, {AT / rate:.6f}"[:20] in said


@pytest.mark.parametrize(("motion", "narrow"), [("closed form", 2e-13), ("dmv20", 2e-13), ("rkmk4", 1e-9)])
def test_the_limits_are_as_narrow_as_the_motion_allows(tmp_path, motion, narrow):
    """Relative to the largest reading."""
    found = certify(Bag(write(tmp_path / "a.mcap", ({**MOTIONS[motion], **FORCE, **NOISY}, 1.0))))
    for name, size in zip(VALUES, (1.5, 10.0, 0.01, 0.05, 5e-5), strict=True):
        [law] = laws(found, name)
        assert law.limit <= narrow * size


TOPICS = [IMU, BIAS, MAG]


@pytest.mark.parametrize("topic", TOPICS)
@pytest.mark.parametrize("index", [0, AT, -1])
def test_a_missing_reading_is_named(bag, tmp_path, topic, index):
    def drop(ms: list[Message]) -> list[Message]:
        del ms[index]
        return ms

    found = certificate(bag, tmp_path, on(topic, drop))
    count = sum(message.topic == topic for message in messages_of(bag))
    assert found.messages == (f"{topic}: gap, reading {index % count} is missing",)
    assert broken(found) == {"magnetometer stamps" if topic == MAG else "IMU stamps"}


def messages_of(bag: Path) -> list[Message]:
    seen: list[Message] = []
    tamper(bag, bag.with_suffix(".copy"), lambda ms: seen.extend(ms) or ms)  # type: ignore[func-returns-value]
    return seen


@pytest.mark.parametrize("topic", TOPICS)
def test_a_doubled_or_displaced_reading_is_named(bag, tmp_path, topic):
    doubled = certificate(bag, tmp_path, on(topic, lambda ms: [*ms[: AT + 1], *ms[AT:]]))
    assert doubled.messages == (f"{topic}: duplicate of reading {AT}",)
    swapped = certificate(bag, tmp_path, on(topic, lambda ms: [*ms[:AT], ms[AT + 1], ms[AT], *ms[AT + 2 :]]))
    assert swapped.messages == (f"{topic}: out of order, reading {AT + 1} stands before {AT}",)


@pytest.mark.parametrize("topic", TOPICS)
def test_readings_under_each_others_stamps_are_named(bag, tmp_path, topic):
    def restamped(ms: list[Message]) -> list[Message]:
        a, b = ms[AT], ms[AT + 1]
        return [
            *ms[:AT],
            a._replace(data=a.data[:12] + b.data[12:]),
            b._replace(data=b.data[:12] + a.data[12:]),
            *ms[AT + 2 :],
        ]

    found = certificate(bag, tmp_path, on(topic, restamped))
    assert "stamps" not in "".join(broken(found))
    assert any(f"readings {AT}, {AT + 1}" in said and said.startswith(topic) for said in found.messages)


@pytest.mark.parametrize("topic", TOPICS)
def test_a_stamp_moved_by_a_nanosecond_is_named(bag, tmp_path, topic):
    def move(message: Message) -> Message:
        [nanosec] = struct.unpack("<I", message.data[8:12])
        return message._replace(data=message.data[:8] + struct.pack("<I", nanosec + 1) + message.data[12:])

    found = certificate(bag, tmp_path, on(topic, at(AT, move)))
    assert f"{'magnetometer' if topic == MAG else 'IMU'} stamps" in broken(found)
    assert any(f"{topic}: 1 stamps off the grid, reading {AT} stamped" in said for said in found.messages)


@pytest.mark.parametrize("topic", TOPICS)
def test_all_readings_later_by_one_are_caught(bag, tmp_path, topic):
    """Every stamp is right, and every number is that of the reading before."""

    def shift(ms: list[Message]) -> list[Message]:
        pairs = zip(ms, [ms[0], *ms], strict=False)
        return [m._replace(data=m.data[:12] + before.data[12:]) for m, before in pairs]

    assert broken(certificate(bag, tmp_path, on(topic, shift))) & set(VALUES)


FIXED = {
    (IMU, 37): "orientation",
    (IMU, 33): "orientation_covariance",
    (IMU, 21): "angular_velocity_covariance",
    (IMU, 9): "linear_acceleration_covariance",
    (BIAS, 33): "orientation_covariance of the bias",
    (BIAS, 1): "linear_acceleration_covariance of the bias",
    (MAG, 9): "magnetic_field_covariance",
}


@pytest.mark.parametrize("place", FIXED, ids=FIXED.values())
def test_another_covariance_or_orientation_is_named(bag, tmp_path, place):
    topic, from_end = place
    change = lambda numbers: np.concatenate([[numbers[0] + 1e-9], numbers[1:]])  # noqa: E731
    found = certificate(bag, tmp_path, on(topic, at(AT, lambda m: with_numbers(m, from_end, change))))
    [name] = broken(found)
    assert name.endswith("frame and covariances")
    assert f"{topic}: frame or covariances are not as declared, at reading {AT}," in found.messages[0]


@pytest.mark.parametrize("topic", TOPICS)
def test_another_frame_is_named(bag, tmp_path, topic):
    rename = lambda m: m._replace(data=m.data.replace(b"imu_link", b"imu_lunk"))  # noqa: E731
    found = certificate(bag, tmp_path, on(topic, at(AT, rename)))
    assert f"{topic}: frame or covariances are not as declared, at reading {AT}," in found.messages[0]
    assert len(broken(found)) == 1


def declared(**changes: object) -> Change:
    """The scenario message with other values."""

    def changed(message: Message) -> Message:
        return message._replace(data=encode_string(json.dumps({**json.loads(message.data[8:-1]), **changes})))

    return on("/lie_rigid_body/scenario", at(0, changed))


@pytest.mark.parametrize(
    ("name", "value", "law"),
    [
        ("sensor_seed", 12, "gyro bias"),
        ("gyro_noise_density", 1.0001e-3, "gyro"),
        ("gyro_bias_random_walk", 1.0001e-3, "gyro bias"),
        ("gyro_turn_on_bias", 0.0100001, "gyro bias"),
        ("gyro_misalignment", [0.0, 1e-9, 0.0], "gyro"),
        ("gyro_range", 1.0, "gyro"),
        ("gyro_rate", "integrated", "gyro"),
        ("accelerometer_lever_arm", [0.1, -0.2, 0.0500001], "accelerometer"),
        ("accelerometer_mode", "free_fall", "accelerometer"),
        ("gravity", 9.80666, "accelerometer"),
        ("accelerometer_scale_factor", [1.0, 1.0, 1.0 + 1e-8], "accelerometer"),
        ("magnetic_field", [1.5e-6, 21.0e-6, -43.50001e-6], "magnetometer"),
        ("magnetometer_soft_iron", [1.0, 1e-8, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], "magnetometer"),
        ("magnetometer_resolution", 1e-12, "magnetometer"),
        ("imu_rate", 333.0, "IMU stamps"),
        ("magnetometer_rate", 70.1, "magnetometer stamps"),
        ("imu_frame", "imu_lunk", "IMU frame and covariances"),
        ("imu_rate", 0.0, None),
    ],
)
def test_parameters_of_the_sensors_that_are_declared_otherwise_are_caught(bag, tmp_path, name, value, law):
    found = certificate(bag, tmp_path, declared(**{name: value}))
    if law is None:  # as if another program had recorded an IMU beside the body
        assert found.sensors == (MAG,)
        assert f"topic {IMU} (332 messages), a sensor that no scenario has" in found.not_certified
    else:
        assert law in broken(found)


def without(*topics: str) -> Change:
    return lambda ms: [m for m in ms if m.topic not in topics]


def test_a_topic_that_was_taken_away_is_missed(bag, tmp_path):
    found = certificate(bag, tmp_path, without(BIAS))
    assert broken(found) == {"IMU stamps"}
    assert found.messages[0].startswith("imu/bias: gap, 332 readings from 0 to 331 are missing")
    late = recorded(0.1)
    found = certificate(bag, tmp_path, lambda ms: late(without(BIAS)(ms)))
    assert found.passed, found.messages
    assert found.sensors == (IMU, MAG)
    assert "imu/bias, which the scenario has: not in the bag" in found.not_certified


def test_a_recorder_that_lost_readings_is_told(bag, tmp_path):
    late, holed = recorded(0.2, 0.05), on(MAG, lambda ms: [*ms[:30], *ms[32:]])
    found = certificate(bag, tmp_path, lambda ms: holed(late(ms)))
    assert broken(found) == {"magnetometer stamps"}
    [law] = laws(found, "magnetometer stamps")
    assert (law.unit, law.worst) == ("gap", 2)


def test_a_recorder_that_came_too_late_for_a_walk_is_told(bag, tmp_path, monkeypatch):
    monkeypatch.setattr(sensor_topics, "MOST_LEFT_OUT", 50)
    found = certificate(bag, tmp_path, recorded(0.3))
    assert found.passed, found.messages
    assert found.sensors == (MAG,)
    assert not laws(found, "gyro")
    assert any(text.startswith(f"{IMU}: too many readings") for text in found.not_certified)


def test_a_scenario_of_another_version(bag, tmp_path):
    older = declared(software="lie_rigid_body 0.0.9")
    assert certificate(bag, tmp_path, older).sensors == (IMU, BIAS, MAG)  # it computes the same
    forged = on(MAG, at(AT, lambda m: with_numbers(m, 12, lambda x: np.concatenate([1.01 * x[:3], x[3:]]))))
    found = certificate(bag, tmp_path, lambda ms: forged(older(ms)))
    assert found.passed
    assert found.sensors == ()
    assert any("the scenario is of 'lie_rigid_body 0.0.9'" in text for text in found.not_certified)


def rewritten(bag: Path, target: Path, names: dict[str, str], twice: dict[str, str] | None = None) -> Path:
    """A bag with other names of topics, and with copies of topics under other names."""
    with bag.open("rb") as stream, target.open("wb") as out:
        writer, reader, channels = Writer(out), make_reader(stream), {}
        writer.start("ros2", "someone else")
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None
            copies = [names.get(channel.topic, channel.topic), (twice or {}).get(channel.topic)]
            for topic in filter(None, copies):
                if topic not in channels:
                    kind = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[topic] = writer.register_channel(topic, "cdr", kind, channel.metadata)
                writer.add_message(channels[topic], message.log_time, message.data, message.publish_time)
        writer.finish()
    return target


def test_topics_are_found_beside_the_poses_and_others_are_listed(bag, tmp_path):
    twice = {MAG: "/robot/imu/mag", IMU: "/robot/imu/data"}
    found = certify(Bag(rewritten(bag, tmp_path / "two.mcap", {}, twice)))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS, MAG)
    said = "; ".join(found.not_certified)
    assert "topic /robot/imu/mag (70 messages), which no scenario determines" in said
    assert "topic /robot/imu/data (332 messages), which no scenario determines" in said
    elsewhere = {topic: f"/a{topic}" for topic in ("/pose", "/twist", "/lie_rigid_body/scenario", *TOPICS)}
    found = certify(Bag(rewritten(bag, tmp_path / "elsewhere.mcap", elsewhere, {MAG: "/b/imu/mag"})))
    assert found.sensors == ("/a/imu/data_raw", "/a/imu/bias", "/a/imu/mag")
    apart = certify(Bag(rewritten(bag, tmp_path / "apart.mcap", {"/pose": "/truth/pose"})))
    assert apart.sensors == (IMU, BIAS, MAG)


def every_ninth(change) -> Change:
    return lambda ms: [change(m) if i % 9 == 5 else m for i, m in enumerate(ms)]


CHANGES: dict[str, Change] = {
    "honest": lambda ms: ms,
    "gap": on(IMU, lambda ms: [*ms[:100], *ms[117:]]),
    "doubled": on(BIAS, lambda ms: [*ms[:101], *ms[100:]]),
    "swapped": on(MAG, lambda ms: [*ms[:30], ms[31], ms[30], *ms[32:]]),
    "scaled": on(IMU, every_ninth(lambda m: with_numbers(m, 24, lambda x: 1.001 * x))),
    "framed": on(IMU, every_ninth(lambda m: m._replace(data=m.data.replace(b"imu_", b"abc_")))),
    "recorded": recorded(0.21, 0.1),
}


@pytest.mark.parametrize("change", CHANGES)
def test_batches_change_no_number(bag, tmp_path, monkeypatch, change):
    path = tamper(bag, tmp_path / "changed.mcap", CHANGES[change])
    whole = certify(read_bag(path))
    monkeypatch.setattr(bag_reader, "_BATCH", 50)
    monkeypatch.setattr(pairing, "_HELD_BACK", 4)
    monkeypatch.setattr(sensor_topics, "_HELD_BACK", 4)
    monkeypatch.setattr(sensor_topics, "BLOCK", 7)
    assert certify(Bag(path)) == whole


def test_readings_so_sparse_that_most_would_be_computed_in_vain_are_not(bag, tmp_path, monkeypatch):
    monkeypatch.setattr(sensor_topics, "_MOST_IN_VAIN", 100)
    found = certificate(bag, tmp_path, lambda ms: on(IMU, lambda own: own[::5])(recorded(0.0)(ms)))
    assert broken(found) == {"IMU stamps"}
    assert found.sensors == (BIAS, MAG)


def test_a_poor_stepper_is_to_blame(tmp_path):
    found = certify(Bag(write(tmp_path / "a.mcap", ({"method": "rkmk1", **FORCE}, 1.0))))
    assert "gyro" in broken(found)
    assert any(said.startswith(IMU) and "the declared stepper errs by up to" in said for said in found.messages)


def test_a_step_is_allowed_only_where_the_truth_may_be_on_either_side():
    step = Converter(0.5, 2.0)
    signal = np.array([[0.2499999, 0.2, 3.0]])
    expected = Expected(signal, np.full_like(signal, 1e-6), step)
    for recorded_, holds in (
        ([0.0, 0.0, 2.0], True),
        ([0.5, 0.0, 2.0], True),
        ([0.25, 0.0, 2.0], False),
        ([-0.5, 0.0, 2.0], False),
        ([0.0, 0.5, 2.0], False),
        ([0.0, 0.0, 2.5], False),
        ([0.0, np.nan, 2.0], False),
    ):
        residuals, limits = expected.residuals(np.array([recorded_]))
        assert bool((residuals <= limits).all()) == holds, recorded_


@pytest.mark.parametrize("cut", [0.3, 0.55, 0.8, 0.95])
def test_what_is_recovered_of_a_cut_off_bag_is_certified(bag, tmp_path, cut):
    data, broken_off = bag.read_bytes(), tmp_path / "cut.mcap"
    broken_off.write_bytes(data[: int(cut * len(data))])
    recover(broken_off, tmp_path / "fixed.mcap", overwrite=False)
    found = certify(Bag(tmp_path / "fixed.mcap"))
    assert found.passed, found.messages
    assert found.sensors == (IMU, BIAS, MAG)


def test_biases_are_the_same_with_the_readings_beside_them_and_alone():
    segment = Simulation(Scenario.from_parameters({**BODY, **RATES, **NOISY, "sensor_seed": 17})).segment
    alone, beside, readings = (of(segment, 9.0) for of in (BiasReadings, BiasReadings, ImuReadings))
    first, drawn = alone.next, []

    def draw(elapsed: Integers) -> tuple[Array, Array]:
        drawn.append(len(elapsed))
        return Imu.biases(beside._sensor, elapsed)

    beside._sensor.biases = draw
    wanted = [alone.take(first + begin, count) for begin, count in ((0, 90), (90, 200), (300, 10), (320, 60))]
    readings.take(first + 50, 50)
    readings = ImuReadings(segment, 9.0)
    readings.take(first, 100)
    found = [beside.take(first, 90)]
    readings.take(first + 100, 190)
    found += [beside.take(first + 90, 200)]
    assert not drawn
    readings.take(first + 310, 80)
    found += [beside.take(first + 300, 10)]
    assert drawn == [10]
    found += [beside.take(first + 320, 60)]
    assert drawn == [10]
    for one, other in zip(wanted, found, strict=True):
        for a, b in zip(one, other, strict=True):
            assert a.signal.tobytes() == b.signal.tobytes()
            assert a.uncertainty.tobytes() == b.uncertainty.tobytes()
