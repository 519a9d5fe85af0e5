"""A sensor of a test's own, declared in one entry, is a sensor like the others: from its parameters to the certificate.

`test_declared_sensor` runs these tests in a process of its own, into which `horizon_sensor` is imported first.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import horizon_sensor
from horizon_sensor import HORIZON, NADIR
from lie_rigid_body import Run, simulate
from lie_rigid_body.certificate import certify
from lie_rigid_body.cli import explain, plot, record
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.runs import SensorArrays
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import BY_NAME, PARAMETERS
from lie_rigid_body.sensors import SENSORS

ON: dict[str, Any] = {"horizon_sensor_rate": 20.0, "horizon_sensor_noise": 0.01, "sensor_seed": 3}
ALL = {**ON, "imu_rate": 50.0, "attitude_sensor_rate": 5.0, "sun_sensor_rate": 3.0, "sensor_grade": "mems"}


def assignments(**values: object) -> list[str]:
    return [part for name, value in values.items() for part in ("-p", f"{name}:={value}")]


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    path = tmp_path / "a.mcap"
    assert record.main([str(path), "--duration", "4", "--quiet", *assignments(**ALL)]) == 0
    return path


def test_it_reads_the_nadir_as_noisy_as_it_says() -> None:
    run = simulate(duration=200.0, motion="closed_form", **ON)
    assert run.horizon is not None
    assert run.horizon.nadir.shape == (4000, 3)
    truth = run.attitude().at(run.horizon.t_ns)
    true = Rotation.from_quat(truth).inv().apply(NADIR)
    off = np.linalg.norm(np.cross(run.horizon.nadir, true), axis=1)
    assert np.sqrt((off**2).mean() / 2) == pytest.approx(0.01, rel=5 / np.sqrt(4 * len(off)))


def test_a_bag_has_the_arrays_of_the_simulation(bag: Path, tmp_path: Path) -> None:
    read, made = Run.from_bag(bag), simulate(duration=4.0, **ALL)
    assert set(read.sensors) == set(made.sensors) == {"imu", "attitude_sensor", "sun", "horizon"}
    for name, arrays in vars(made.horizon).items():
        assert getattr(read.horizon, name).tobytes() == arrays.tobytes()
    made.to_bag(tmp_path / "b.mcap")
    assert (tmp_path / "b.mcap").read_bytes() == bag.read_bytes()
    assert read.scenario == made.scenario == Scenario.from_parameters(ALL)


def test_faults_of_its_delivery_are_its_own() -> None:
    losing = simulate(duration=10.0, horizon_sensor_dropout_probability=0.3, horizon_sensor_latency=0.1, **ON)
    whole = simulate(duration=10.0, **ON)
    lost = {fault.begin_ns for fault in losing.faults if fault.kind == "dropout"}
    assert {fault.sensor for fault in losing.faults} == {"horizon_sensor"}
    kept = np.array([t not in lost for t in whole.horizon.t_ns.tolist()])
    early = len(losing.horizon.t_ns)
    assert losing.horizon.nadir.tobytes() == whole.horizon.nadir[kept][:early].tobytes()
    assert (losing.horizon.arrival_ns - losing.horizon.t_ns == 100_000_000).all()


def test_it_bounds_the_error_of_every_estimator() -> None:
    given: dict[str, Any] = {"imu_rate": 20.0, "magnetometer_rate": 20.0, "sensor_grade": "tactical"}
    given["accelerometer_mode"] = "free_fall"
    without, beside = simulate(duration=5.0, **given), simulate(duration=5.0, **given, **ON)
    bounds = [run.cramer_rao_bound() for run in (without, beside)]
    assert bounds[0] is not None
    assert bounds[1] is not None
    assert np.trace(bounds[1].filtered[-1]) < 0.5 * np.trace(bounds[0].filtered[-1])
    assert simulate(duration=5.0, **given, horizon_sensor_rate=5.0).cramer_rao_bound() is None  # it has no noise


def test_tables_list_it(capsys: pytest.CaptureFixture[str]) -> None:
    names = [parameter.name for parameter in PARAMETERS]
    own = [name for name in names if name.startswith("horizon_sensor_")]
    assert own[:2] == ["horizon_sensor_rate", "horizon_sensor_noise"]
    assert {"horizon_sensor_dropout_probability", "horizon_sensor_clock_skew"} < set(own)
    assert all(name in BY_NAME for name in own)
    assert explain.main(assignments(**ON)) == 0
    assert re.search(r"horizon_sensor_noise +0\.01", capsys.readouterr().out)
    (idle,) = Scenario.from_parameters({"horizon_sensor_noise": 0.1}).without_effect
    assert "horizon_sensor_noise" in idle
    assert "horizon_sensor_rate" in idle


@pytest.mark.parametrize(
    "changed", [{"name": "limb"}, {"streams": {"limb": 101}}, {"name": "limb", "parameters": (), "topics": ()}]
)
def test_what_another_sensor_has_is_refused(changed: dict[str, Any]) -> None:
    tables = [dict(table) for table in (SENSORS, SENSORS.parameters, SENSORS.topics)]
    with pytest.raises(ValueError):
        SENSORS.register(replace(HORIZON, **changed))
    assert [SENSORS, SENSORS.parameters, SENSORS.topics] == tables


def test_what_has_none_is_as_it_was_without() -> None:
    with_entry = Scenario.from_parameters({"imu_rate": 10.0}).parameters()
    assert not any(name.startswith("horizon") for name in with_entry)
    assert simulate(duration=1.0, imu_rate=10.0).horizon is None


def test_a_campaign_varies_it(tmp_path: Path) -> None:
    file = tmp_path / "c.yaml"
    file.write_text(
        "runs: 2\nseed: 1\nduration: 1.0\nparameters: {horizon_sensor_rate: 10.0}\n"
        "vary: {horizon_sensor_noise: {distribution: uniform, low: 0.01, high: 0.1}}\n"
    )
    from lie_rigid_body.campaign.definition import Campaign

    found = Campaign.from_file(file)
    noises = {found.scenario_of(run).sensors.horizon_sensor.noise for run in range(2)}
    assert len(noises) == 2
    assert 0.01 <= min(noises) < max(noises) <= 0.1


@pytest.mark.slow
def test_a_picture_is_drawn_of_its_bag(bag: Path, tmp_path: Path) -> None:
    assert plot.main([str(bag), "-o", str(tmp_path / "a.png")]) == 0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("motion", ["closed_form", "moving_chart"])
def test_an_honest_bag_is_certified(motion: str, tmp_path: Path) -> None:
    given = {**ALL, "motion": motion, "horizon_sensor_dropout_probability": 0.2, "horizon_sensor_clock_skew": 1e-3}
    run = simulate(duration=4.0, **given)
    run.to_bag(tmp_path / "a.mcap")
    certificate = certify(Bag(tmp_path / "a.mcap"))
    assert certificate.passed
    laws = {law.name: law for segment in certificate.segments for law in segment.laws}
    assert laws["horizon sensor"].checked == len(run.horizon.t_ns) > 50
    assert laws["horizon sensor frame"].checked == laws["horizon sensor stamps"].checked == len(run.horizon.t_ns)


FORGERIES: dict[str, tuple[Callable[[SensorArrays], SensorArrays], str]] = {
    "a reading off by 1e-9": (lambda h: changed(h, nadir=moved(h.nadir, 1e-9)), "horizon sensor"),
    "zeros": (lambda h: changed(h, nadir=0.0 * h.nadir), "horizon sensor"),
    "not a number": (lambda h: changed(h, nadir=moved(h.nadir, np.nan)), "horizon sensor"),
    "a reading left out": (lambda h: changed(h, **{n: np.delete(a, 7, axis=0) for n, a in vars(h).items()}), "stamps"),
    "a stamp 1 ns late": (lambda h: changed(h, t_ns=h.t_ns + (np.arange(len(h.t_ns)) == 7)), "stamps"),
}


def changed(horizon: SensorArrays, **arrays: np.ndarray) -> SensorArrays:
    everything = {**vars(horizon), **arrays}
    return SensorArrays(everything.pop("t_ns"), everything.pop("arrival_ns"), everything)


def moved(vectors: np.ndarray, by: float) -> np.ndarray:
    return np.asarray(vectors + by * (np.arange(len(vectors)) == 7)[:, np.newaxis] * [0.0, 1.0, 0.0])


@pytest.mark.parametrize("forgery", FORGERIES)
def test_a_forged_bag_is_refused(forgery: str, tmp_path: Path) -> None:
    forge, law = FORGERIES[forgery]
    run = simulate(duration=2.0, motion="closed_form", **ON)
    forged = replace(run, sensors={"horizon": forge(run.horizon)})
    forged.to_bag(tmp_path / "a.mcap")
    certificate = certify(Bag(tmp_path / "a.mcap"))
    assert not certificate.passed
    broken = {law.name for segment in certificate.segments for law in segment.laws if not law.holds}
    assert any(name == law or name.endswith(law) for name in broken)
    assert all(name.startswith("horizon sensor") for name in broken)


@pytest.mark.ros
def test_the_node_plays_and_records_it(tmp_path: Path) -> None:
    import rclpy
    from geometry_msgs.msg import Vector3Stamped
    from rclpy.context import Context
    from rclpy.executors import SingleThreadedExecutor

    path, context = tmp_path / "live.mcap", Context()
    arguments = assignments(**ON, record_path=path, epoch_ns=1000)
    command = [sys.executable, horizon_sensor.__file__, "sim", *arguments]
    node = subprocess.Popen(command, stdout=subprocess.DEVNULL, env=os.environ.copy())
    rclpy.init(args=[], context=context)
    listener = rclpy.create_node("listener", context=context)
    executor, heard = SingleThreadedExecutor(context=context), list[Any]()
    try:
        executor.add_node(listener)
        listener.create_subscription(Vector3Stamped, "horizon/nadir", heard.append, 1000)
        end = time.monotonic() + 120.0
        while len(heard) < 20 and node.poll() is None and time.monotonic() < end:
            executor.spin_once(timeout_sec=1.0)
        node.send_signal(signal.SIGINT)
        assert node.wait(60.0) == 0
    finally:
        node.kill()
        executor.shutdown()
        listener.destroy_node()
        rclpy.shutdown(context=context)
    assert certify(Bag(path)).passed
    horizon = Run.from_bag(path).horizon
    assert horizon is not None
    rows = {t: row.tolist() for t, row in zip(horizon.t_ns.tolist(), horizon.nadir, strict=True)}
    assert len(heard) >= 20
    for message in heard:
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        assert rows[stamp] == [message.vector.x, message.vector.y, message.vector.z]
        assert message.header.frame_id == "base_link"
