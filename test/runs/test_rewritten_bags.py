"""A run that is read from a bag and written again: the new bag is certified as the old one, or it is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import foreign_bags
from foreign_bags import Message, messages_of
from lie_rigid_body import InputError, Run, __version__, certify
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.recording.recovery import recover
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import SOFTWARE, Simulation
from untyped import simulate

NS = 10**9
SENSORS: dict[str, Any] = {
    "motion": "closed_form",
    "rate": 20.0,
    "imu_rate": 50.0,
    "imu_latency": 0.05,
    "imu_dropout_probability": 0.1,
    "gyro_noise_density": 1e-3,
    "magnetometer_rate": 25.0,
    "magnetometer_clock_offset": 0.03,
    "attitude_sensor_rate": 10.0,
}
ERRING = {"motion": "closed_form", "rate": 10.0, "magnetometer_rate": 50.0, "magnetometer_clock_offset": 0.05}
Heard = Callable[[int, str], int | None]
"""When a recorder received a message of a log time and a topic, ns; None if it did not."""


def late(log_time: int, topic: str) -> int | None:
    """Of a recorder that came 0.52 s after the start, with a clock that is half a minute ahead."""
    return log_time + 30 * NS if topic.endswith("scenario") or log_time > 0.52 * NS else None


def all_of_it(log_time: int, topic: str) -> int | None:
    return log_time + 30 * NS


def recorded(
    source: Path, target: Path, heard: Heard, library: str = "libmcap 1.4.1", text: bytes = b"", **options: Any
) -> Path:
    """The bag that a recorder made of what is in another, perhaps with another scenario message."""
    messages = list[Message]()
    for m in messages_of(source):
        received = heard(m.log_time, m.topic)
        if received is not None:
            data = text if text and m.topic.endswith("scenario") else m.data
            messages.append(m._replace(log_time=received, publish_time=received, data=data))
    target.write_bytes(foreign_bags.bag_of(messages, library, **options))
    return target


def bag_of(path: Path, *scenarios: dict[str, Any], each_ns: int = NS // 2, **options: Any) -> Path:
    """A bag of 0.5 s of each of the scenarios, or of another time, one reset after the other."""
    simulation = Simulation(Scenario.from_parameters(scenarios[0]))
    with BagWriter(path, stamped_twist=True, **options) as bag:
        for i, parameters in enumerate(scenarios):
            if i:
                simulation.reset(Scenario.from_parameters(parameters))
            bag.begin_segment(simulation.segment)
            last_ns = simulation.segment.start_ns + each_ns - 1
            bag.write(BatchEncoder(simulation.segment.scenario).encode(simulation.take_until(last_ns, 10**6)))
    return path


def rewritten(source: Path) -> Path:
    """The bag of the run of another, which is certified, and says no less of what is not."""
    target = source.with_name(f"again_{source.name}")
    run = Run.from_bag(source)
    run.to_bag(target)
    before, after = run.certificate(), Run.from_bag(target).certificate()
    assert before.passed
    assert after.messages == ()
    assert after.passed
    assert after.not_certified[1:] == before.not_certified[1:]  # the first one says who wrote it
    return target


@pytest.mark.parametrize("library", ["libmcap 1.4.1", "someone", ""])
@pytest.mark.parametrize("heard", [late, all_of_it])
def test_a_recording_stays_one(library: str, heard: Heard, tmp_path: Path) -> None:
    simulate(duration=2.0, **SENSORS).to_bag(tmp_path / "own.mcap")
    source = recorded(tmp_path / "own.mcap", tmp_path / "heard.mcap", heard, library)
    target = rewritten(source)
    written = Bag(target)
    assert written.library.startswith(f"{library}; rewritten by lie_rigid_body ")
    assert written.expected_samples is None
    assert rewritten(target).read_bytes() == target.read_bytes()


ORDERS: dict[str, Callable[[list[Message]], list[Message]]] = {
    "reversed": lambda heard: heard[::-1],
    "one log time": lambda heard: [m._replace(log_time=1, publish_time=1) for m in heard[::-1]],
}


@pytest.mark.parametrize("order", ORDERS)
def test_readings_count_in_the_order_of_their_log_times(order: str, tmp_path: Path) -> None:
    simulate(duration=0.5, imu_rate=50.0, magnetometer_rate=20.0).to_bag(source := tmp_path / "a.mcap")
    heard = recorded(source, tmp_path / "heard.mcap", all_of_it)
    Path(mixed := tmp_path / "mixed.mcap").write_bytes(foreign_bags.bag_of(ORDERS[order](messages_of(heard)), "x"))
    run, expected = Run.from_bag(mixed), Run.from_bag(heard)
    assert run.left_out == expected.left_out == {}
    for name in ("imu", "magnetometer"):
        for array, wanted in zip(vars(run.sensors[name]).values(), vars(expected.sensors[name]).values(), strict=True):
            np.testing.assert_array_equal(array, wanted)


def test_readings_that_are_stamped_before_one_that_came_are_left_out_and_counted(tmp_path: Path) -> None:
    simulate(duration=0.5, imu_rate=50.0).to_bag(source := tmp_path / "a.mcap")
    heard = recorded(source, tmp_path / "heard.mcap", lambda log_time, topic: log_time % 310_000_000 + 30 * NS)
    run = Run.from_bag(heard)
    assert run.left_out == {"imu": 9}
    assert "left_out" in repr(run)
    np.testing.assert_array_equal(run.sensors["imu"].t_ns, Run.from_bag(source).sensors["imu"].t_ns[:16])


def test_what_was_recovered_of_a_bag_is_not_called_whole(tmp_path: Path) -> None:
    """The last time that is left may lack a twist, or readings."""
    rates: dict[str, Any] = {f"{sensor}_rate": 20.0 for sensor in ("magnetometer", "attitude_sensor", "sun_sensor")}
    simulate(duration=1.0, rate=20.0, motion="closed_form", **rates).to_bag(tmp_path / "own.mcap")
    own = Bag(tmp_path / "own.mcap").library
    small = recorded(tmp_path / "own.mcap", tmp_path / "small.mcap", lambda time, _: time, own, chunk_size=1)
    content = small.read_bytes()
    for share in (0.4, 0.41, 0.42, 0.43, 0.44):
        (tmp_path / "cut").write_bytes(content[: int(share * len(content))])
        recover(tmp_path / "cut", tmp_path / f"{share}.mcap", overwrite=False)
        Run.from_bag(tmp_path / f"{share}.mcap").to_bag(tmp_path / f"{share}-again.mcap")
        assert Bag(tmp_path / f"{share}-again.mcap").was_cut_off
        assert certify(tmp_path / f"{share}-again.mcap").passed


def test_readings_of_a_clock_that_errs_stay_on_their_side_of_a_reset(tmp_path: Path) -> None:
    """Their stamps lie beyond it, where the sensor is gone, or is in another frame."""
    for after in ({"magnetometer_rate": 0.0}, {"magnetometer_clock_offset": 0.0, "imu_frame": "elsewhere"}):
        source = bag_of(tmp_path / f"{len(after)}.mcap", ERRING, {**ERRING, **after})
        rewritten(recorded(source, tmp_path / f"heard_{len(after)}.mcap", all_of_it))


def test_an_orientation_that_begins_with_a_reset_is_kept(tmp_path: Path) -> None:
    given = {"motion": "closed_form", "rate": 10.0, "imu_rate": 20.0}
    source = bag_of(tmp_path / "a.mcap", given, {**given, "imu_orientation": True})
    assert rewritten(source).read_bytes() == source.read_bytes()


@pytest.mark.parametrize("after", [{"initial_body_rate": [0.0, 0.0, 2.0]}, {"imu_dropout_probability": 0.5}])
def test_a_reset_without_a_sample_is_kept(after: dict[str, Any], tmp_path: Path) -> None:
    """A recorder that heard the scenario of a reset, readings after it and their faults, but no sample."""
    given: dict[str, Any] = {"motion": "closed_form", "rate": 10.0, "imu_rate": 20.0}
    source = bag_of(tmp_path / "a.mcap", given, {**given, **after})
    no_sample = recorded(
        source,
        tmp_path / "heard.mcap",
        lambda time, topic: None if time >= NS // 2 and topic in ("/pose", "/twist") else time + NS,
    )
    again = Run.from_bag(rewritten(no_sample))
    assert again.faults == Run.from_bag(no_sample).faults
    assert bool(again.faults) is ("imu_dropout_probability" in after)


def test_scenarios_keep_their_words_and_the_software_that_computed_the_readings(tmp_path: Path) -> None:
    run = simulate(duration=1.0, **SENSORS)
    text = run.segments[0].to_json().replace(f"{SOFTWARE} {__version__}", f"{SOFTWARE} 0.0.9")
    with BagWriter(tmp_path / "a.mcap", stamped_twist=True) as bag:
        bag.begin_segment(run.segments[0], text)
        simulation = Simulation(run.scenario)
        bag.write(BatchEncoder(run.scenario).encode(simulation.take_until(NS - 1, 10**6)))
    assert rewritten(tmp_path / "a.mcap").read_bytes() == (tmp_path / "a.mcap").read_bytes()


def test_readings_of_a_sensor_that_no_scenario_has_are_refused_in_a_line(tmp_path: Path) -> None:
    simulate(duration=1.0, magnetometer_rate=10.0).to_bag(tmp_path / "a.mcap")
    simulate(duration=1.0).to_bag(tmp_path / "b.mcap")
    (text,) = (m.data for m in messages_of(tmp_path / "b.mcap") if m.topic.endswith("scenario"))
    run = Run.from_bag(recorded(tmp_path / "a.mcap", tmp_path / "c.mcap", all_of_it, text=text))
    assert run.certificate().passed
    with pytest.raises(InputError, match=r"10 readings of a sensor, magnetometer"):
        run.to_bag(tmp_path / "e.mcap")
    assert not (tmp_path / "e.mcap").exists()
