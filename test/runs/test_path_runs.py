"""Runs along a path: from the file to the bag, its certificate, and what sensors, filters and verbs are told of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lie_rigid_body import Campaign, Run, Scenario, certify, simulate
from lie_rigid_body.__main__ import main
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import LieRigidBodyError, ParameterError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.path import MAX_KNOTS, Knots
from lie_rigid_body.runs.blind_scenario import WithheldError
from lie_rigid_body.runs.ensemble import BlindRun
from lie_rigid_body.simulation import Segment

SENSORS: dict[str, Any] = {"imu_rate": 80.0, "accelerometer_lever_arm": [0.1, -0.2, 0.3], "sensor_grade": "mems"}
G = 9.80665


def turned(t_s: Array) -> Array:
    return quaternion.multiply(
        quaternion.exp(np.multiply.outer(np.sin(2.0 * t_s), [0.0, 0.0, 1.0])),
        quaternion.exp(np.multiply.outer(t_s, [1.0, 0.5, 0.0])),
    )


def knots(seed: int = 0) -> list[float]:
    """Numbers of a path of 2 s."""
    t_ns = np.arange(0, 2_000_000_001, 50_000_000)
    t_s = t_ns / 1e9 + 0.1 * seed
    position = np.stack([np.sin(3.0 * t_s), 2.0 * np.cos(t_s), t_s], axis=-1)
    return Knots(t_ns, position, turned(t_s)).numbers()


def run_of(**parameters: Any) -> Any:
    given: dict[str, Any] = {"motion": "path", "path_knots": knots(), **parameters}
    return simulate(duration=1.9, **given)


@pytest.fixture(scope="module")
def trajectory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("poses") / "hand.tum"
    np.savetxt(file, np.reshape(knots(), (-1, 8)), fmt="%.17g")
    return file


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "path.mcap"
    run_of(**SENSORS).to_bag(path)
    return path


def test_a_bag_needs_no_file_to_be_certified_and_read(tmp_path: Path) -> None:
    file = tmp_path / "hand.tum"
    np.savetxt(file, np.reshape(knots(), (-1, 8)), fmt="%.17g")
    given: dict[str, Any] = {"motion": "path", "path_file": str(file), "path_interval": 0.12, **SENSORS}
    run = simulate(duration=1.5, **{**given, "path_file": file})
    run.to_bag(tmp_path / "a.mcap")
    words = [word for name, value in given.items() for word in ("-p", f"{name}:={json.dumps(value)}")]
    assert main(["record", str(tmp_path / "b.mcap"), "--duration", "1.5", "--quiet", *words]) == 0
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()
    file.unlink()
    again = Run.from_bag(tmp_path / "b.mcap")
    assert again.scenario == run.scenario
    assert (again.truth.attitude_xyzw == run.truth.attitude_xyzw).all()
    assert (again.imu.specific_force == run.imu.specific_force).all()
    for name in ("position", "velocity", "acceleration"):
        assert (getattr(again, name) == getattr(run, name)).all()
    assert certify(tmp_path / "b.mcap").passed
    again.to_bag(tmp_path / "c.mcap")
    assert (tmp_path / "c.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


@pytest.mark.parametrize("mode", ["pivot_gravity", "free_fall"])
def test_the_accelerometer_reads_what_moves_the_body(mode: str) -> None:
    run = run_of(imu_rate=100.0, accelerometer_mode=mode, accelerometer_lever_arm=SENSORS["accelerometer_lever_arm"])
    path = run.scenario.path()
    assert path is not None
    at = run.imu.t_ns
    h = 20_000
    arm = np.array(SENSORS["accelerometer_lever_arm"])

    def place(t_ns: Array) -> Array:
        """Of the accelerometer in the world, m."""
        return path.mass_centre(t_ns).position + quaternion.rotate(path.at(t_ns).attitude_xyzw, arm)

    inside = (at > 2 * h) & (at % 50_000_000 > 4 * h) & (at % 50_000_000 < 50_000_000 - 4 * h)
    at = at[inside]
    acceleration = (place(at + h) - 2.0 * place(at) + place(at - h)) / (h * 1e-9) ** 2
    weight = [0.0, 0.0, G if mode == "pivot_gravity" else 0.0]
    goal = quaternion.rotate(quaternion.conjugate(path.at(at).attitude_xyzw), acceleration + weight)
    assert len(at) > 50
    assert np.abs(run.imu.specific_force[inside] - goal).max() < 2e-5


def test_an_integrated_gyro_reads_the_rotation_of_the_path() -> None:
    run = run_of(imu_rate=100.0, gyro_rate="integrated")
    found = [run.truth.attitude_xyzw[0]]
    for rate in run.imu.gyro[1:]:
        found.append(quaternion.multiply(found[-1], quaternion.exp(rate / 100.0)))
    assert np.abs(np.array(found) - run.truth.attitude_xyzw).max() < 1e-13


def test_without_gravity_and_arm_a_path_reads_its_acceleration() -> None:
    run = run_of(imu_rate=100.0, accelerometer_mode="free_fall")
    goal = quaternion.rotate(quaternion.conjugate(run.truth.attitude_xyzw), run.acceleration)
    assert np.abs(run.imu.specific_force - goal).max() < 1e-14


BESIDE: dict[str, Any] = {
    "inertia": [1.0, 2.0, 2.5],
    "initial_attitude_xyzw": [1.0, 0.0, 0.0, 0.0],
    "initial_body_rate": [0.0, 0.0, 1.0],
    "initial_position": [0.0, 0.0, 1.0],
    "initial_velocity": [0.0, 0.0, 1.0],
    "kicks": [1.0, 0.0, 0.0, 0.0],
    "kick_period": 2.0,
    "translation": "thrown",
}


@pytest.mark.parametrize("name", BESIDE)
def test_what_a_path_tells_itself_is_refused_beside_it(name: str) -> None:
    with pytest.raises(ParameterError) as refused:
        run_of(**{name: BESIDE[name]})
    assert refused.value.name == name


def test_a_path_without_poses_is_refused_and_a_file_without_a_path_told() -> None:
    for unread in ({}, {"path_file": "hand.tum"}):
        with pytest.raises(ParameterError) as refused:
            Scenario(motion="path", **unread)
        assert refused.value.name == "path_file"
    given: dict[str, Any] = {"path_file": "hand.tum", "path_interval": 0.1, "path_knots": knots()}
    told = Scenario(**given).without_effect
    assert [sentence.partition(" ")[0] for sentence in told] == [*given]


def test_a_longer_run_than_the_path_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given: dict[str, Any] = {"motion": "path", "path_knots": knots()}
    assert len(simulate(duration=2.0, **given).t_ns) == 200
    for refused in (
        lambda: simulate(duration=2.1, **given),
        lambda: Campaign(runs=1, seed=0, duration=2.1, parameters=given).scenario_of(0),
    ):
        with pytest.raises(LieRigidBodyError, match=r"2\.1 s .* 2 s"):
            refused()
    out = tmp_path / "a.mcap"
    words = [word for name, value in given.items() for word in ("-p", f"{name}:={json.dumps(value)}")]
    assert main(["record", str(out), "--duration", "2.1", *words]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not out.exists()


def test_a_filter_sees_nothing_of_the_path(trajectory: Path) -> None:
    truths = [
        run_of(**SENSORS),
        run_of(**SENSORS, path_file=str(trajectory), path_interval=0.0, path_knots=[]),
        run_of(**SENSORS, path_knots=knots(1)),
        simulate(duration=1.9, **SENSORS),
        simulate(duration=1.9, motion="closed_form", translation="thrown", kicks=[1.0, 0.0, 0.0, 0.0], **SENSORS),
    ]
    first, *others = (BlindRun.without_truth(run).scenario for run in truths)
    assert all(other.parameters() == first.parameters() for other in others)
    for name in ("motion", "path_file", "path_interval", "path_knots"):
        assert name not in first.parameters()
        with pytest.raises(WithheldError):
            getattr(first, name)
    for method in ("path", "exact_motion", "start", "mass_centre", "make_motion"):
        with pytest.raises(WithheldError):
            getattr(first, method)()
    shaken = run_of(**SENSORS, vibration_acceleration=[1.0, 0.0, 0.0])
    assert shaken.vibration is not None
    assert BlindRun.without_truth(shaken).vibration is None


def test_a_filter_that_is_given_the_first_attitude_gets_that_of_the_path() -> None:
    run = run_of(**SENSORS, path_knots=knots(3))
    given = BlindRun.without_truth(run, ("initial_attitude_xyzw",)).scenario.initial_attitude_xyzw
    assert np.abs(np.array(given) - run.truth.attitude_xyzw[0]).max() < 1e-15


def test_the_text_of_the_longest_path_is_read(tmp_path: Path) -> None:
    draw = np.random.default_rng(0)
    t_ns = np.cumsum(draw.integers(10**7, 2 * 10**8, MAX_KNOTS))
    attitude = turned(t_ns / 1e10)
    long = Knots(t_ns - t_ns[0], -1e3 * draw.uniform(size=(MAX_KNOTS, 3)), attitude).averaged(0)
    segment = Segment(Scenario(motion="path", path_knots=long.numbers()), 0, 0)
    again = Segment.from_json(segment.to_json())
    assert again == segment
    path = again.scenario.path()
    assert path is not None
    assert all((ours == theirs).all() for ours, theirs in zip(path.knots, long, strict=True))
    run = simulate(again.scenario, duration=0.1)
    run.to_bag(tmp_path / "long.mcap")
    assert Run.from_bag(tmp_path / "long.mcap").scenario == again.scenario


def test_another_file_takes_the_place_of_the_knots_of_a_scenario(trajectory: Path) -> None:
    own = Scenario(motion="path", path_knots=knots(1))
    assert simulate(own, duration=1.0).scenario.path_knots == own.path_knots
    other = simulate(own, duration=1.0, path_file=str(trajectory), path_interval=0.0).scenario.path_knots
    assert np.abs(np.array(other) - knots()).max() < 1e-15


def test_explain_tells_the_path(trajectory: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["-p", "motion:=path", "-p", f"path_file:={trajectory}", "-p", "path_interval:=0.0"]
    assert main(["explain", "--json", *words]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["path"]["knots"] == 41
    assert told["path"]["duration_s"] == 2.0
    run = run_of(rate=1000.0)
    rms = np.sqrt((run.acceleration**2).sum(axis=1).mean())
    assert told["path"]["rms_acceleration_m_s2"] == pytest.approx(rms, rel=0.05)
    assert main(["explain", *words]) == 0
    assert "kinetic energy" not in capsys.readouterr().out


def test_a_score_along_a_path_has_a_bound_without_dynamics() -> None:
    run = run_of(imu_rate=100.0, magnetometer_rate=50.0, sensor_grade="mems")
    bound = run.cramer_rao_bound()
    assert bound is not None
    assert bound.dynamic is None
    score = run.score(run.attitude().at(run.imu.t_ns))
    assert score.total_deg.max < 1e-6


def test_pages_and_pictures_of_a_path_have_no_energy(bag: Path, tmp_path: Path) -> None:
    assert main(["plot", str(bag), "-o", str(tmp_path / "a.png")]) == 0
    assert main(["check", str(bag), "--report", str(tmp_path / "a.html")]) == 0
    page = (tmp_path / "a.html").read_text("utf-8")
    assert "no polhode" in page
    assert "energy ellipsoid" not in page
    assert "angular momentum" not in page
