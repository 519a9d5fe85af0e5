"""``check``: exit statuses, the table, the JSON, proofs, and one clear line for what cannot be judged."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.cli.check import main
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.report.certificates import law_cells
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation, SimulationStep


def write_bag(path: Path, count: int = 400, **parameters: object) -> Path:
    simulation = Simulation(Scenario.from_parameters(parameters))
    encoder = BatchEncoder(simulation.segment.scenario)
    with BagWriter(path, stamped_twist=True) as bag:
        bag.begin_segment(simulation.segment)
        samples = simulation.take(count)
        bag.write(encoder.encode(SimulationStep(samples)))
    return path


@pytest.fixture
def bag(tmp_path):
    return write_bag(tmp_path / "bag.mcap")


def test_the_arc_of_the_worst_attitude_is_told(tmp_path, capsys):
    """Also of a bag that breaks a law, by words."""
    kicks: dict[str, Any] = {"kicks": [1.0, 0.0, 0.0, 0.0, 2.5, 1.0, 2.0, 3.0], "kick_period": 3.0, "method": "rkmk1"}
    bag = write_bag(tmp_path / "bag.mcap", **kicks)
    assert main([str(bag), "--json", "--max-attitude", "1rad"]) == 0
    worst = json.loads(capsys.readouterr().out)["certified"]["attitude_worst"]
    begins = [0.0, 1.0, 2.5, 4.0, 5.5]
    assert worst["arc_begin_s"] == begins[worst["arc"]] <= worst["time_s"]
    assert worst["arc"] > 1
    assert main([str(bag)]) == 1
    assert f"in arc {worst['arc']}, which begins at {worst['arc_begin_s']:g} s" in capsys.readouterr().out


def test_json_is_for_programs_and_names_the_worst_sample_of_each_law(bag, capsys):
    assert main([str(bag), "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["passed"] is True
    assert 0 < content["certified"]["attitude_rad"] < 1e-10
    assert "proved" not in content
    assert content["segments"][0]["scenario"]["inertia"] == [1.0, 2.0, 3.0]
    laws = {law["name"]: law for law in content["segments"][0]["laws"]}
    assert all(laws[name]["worst"] <= laws[name]["limit"] for name in ("attitude", "body rate"))
    assert laws["kinetic energy"]["limit"] is None
    for name in ("kinetic energy", "world momentum", "body rate", "attitude"):
        law = laws[name]
        assert law["holds"]
        assert law["stamp_ns"] == law["sample"] * 10_000_000
        assert law["time_s"] == law["sample"] / 100
    worst = laws["attitude"]
    assert content["certified"]["attitude_worst"] == {
        "segment": 1,
        "sample": worst["sample"],
        "stamp_ns": worst["stamp_ns"],
        "time_s": worst["time_s"],
    }
    assert main([str(bag)]) == 0
    out = capsys.readouterr().out
    row = next(line.split() for line in out.splitlines() if line.startswith("attitude "))
    assert row[-3:] == [str(worst["sample"]), f"{worst['time_s']:.7g}", "holds"]


@pytest.mark.parametrize(("worst", "said"), [(300.0, "300"), (99.5, "1e+02"), (2.51e-16, "2.5e-16"), (1e7, "1e+07")])
def test_a_count_has_all_its_digits(worst, said):
    assert law_cells(LawResult("stamps", "gap", worst, 0.0, 1, 1, 1, 1), 1.0)[1] == said


def test_a_bag_that_breaks_a_law(tmp_path, capsys):
    bag = write_bag(tmp_path / "poor.mcap", method="rkmk1")
    assert main([str(bag)]) == 1
    capsys.readouterr()
    assert main([str(bag), "--json"]) == 1
    content = json.loads(capsys.readouterr().out)
    assert content["passed"] is False
    assert content["certified"] is None
    broken = [law for law in content["segments"][0]["laws"] if not law["holds"]]
    assert content["messages"] == [law["message"] for law in broken]
    [motion] = [law for law in broken if law["name"] == "attitude"]
    assert (motion["sample"], motion["broken"] > 300) == (399, True)


def test_a_wider_limit_may_be_given(tmp_path, capsys):
    bag = write_bag(tmp_path / "poor.mcap", method="rkmk1")
    assert main([str(bag)]) == 1
    assert main([str(bag), "--max-attitude", "1deg"]) == 0
    assert main([str(bag), str(bag), "--max-attitude", "1e-9rad"]) == 1
    capsys.readouterr()
    assert main([str(bag), "--max-attitude", "0deg"]) == 2
    assert main([str(bag), "--max-attitude", "1"]) == 2
    assert "--max-attitude" in capsys.readouterr().err


SENSORS: dict[str, Any] = {"imu_rate": 200.0, "magnetometer_rate": 30.0, "sensor_grade": "mems"}


def test_sensors_are_certified_and_what_no_scenario_determines_is_listed(tmp_path, capsys):
    from lie_rigid_body import simulate

    bag = tmp_path / "sensors.mcap"
    simulate(duration=1.0, **SENSORS).to_bag(bag)
    assert main([str(bag)]) == 0
    out = capsys.readouterr().out
    rows = [line for line in out.splitlines() if line.endswith(" holds")]
    for name, unit in (("gyro ", "rad/s"), ("accelerometer bias ", "m/s²"), ("magnetometer ", "T")):
        assert any(row.startswith(name) and f" {unit} " in row for row in rows)
    assert main([str(bag), "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["certified_sensors"] == ["/imu/data_raw", "/imu/bias", "/imu/mag"]
    laws = {law["name"]: law for law in content["segments"][0]["laws"]}
    assert (laws["gyro"]["unit"], laws["gyro"]["checked"], laws["gyro"]["holds"]) == ("rad/s", 200, True)


needs_flint = pytest.mark.skipif(find_spec("flint") is None, reason="python-flint is not installed")


def proved(capsys, bag: Path, *options: str) -> tuple[int, dict]:
    status = main([str(bag), *options, "--json"])
    return status, json.loads(capsys.readouterr().out)


@needs_flint
@pytest.mark.parametrize("motion", ["moving_chart", "closed_form"])
def test_a_good_bag_is_proved(tmp_path, capsys, motion):
    good = write_bag(tmp_path / "good.mcap", 300, motion=motion, inertia=[1.0, 0.1, 0.2, 2.0, 0.3, 2.5])
    status, content = proved(capsys, good, "--prove", "20")
    assert (status, content["proved"]["passed"]) == (0, True)
    assert 0.0 < content["proved"]["attitude_rad"] < 5e-15
    numbers = [sample["sample"] for sample in content["proved"]["samples"]]
    assert {content["certified"]["attitude_worst"]["sample"], *np.rint(np.linspace(0, 299, 20))} <= set(numbers)
    assert numbers == sorted(set(numbers))


@needs_flint
def test_a_bag_beyond_its_limit_is_proved_to_be(tmp_path, capsys):
    status, content = proved(capsys, write_bag(tmp_path / "poor.mcap", 300, method="rkmk1"), "--prove", "3")
    assert (status, content["proved"]["passed"]) == (1, False)
    last = content["proved"]["samples"][-1]
    assert last["attitude_limit_rad"] < last["attitude_at_least_rad"] <= last["attitude_at_most_rad"]


@needs_flint
def test_the_inertia_given_is_the_one_proved(bag, capsys):
    status, content = proved(capsys, bag, "--prove", "3", "--inertia", "1.0000001,2,3")
    assert (status, content["proved"]["passed"]) == (1, False)


@pytest.mark.slow
@needs_flint
def test_more_samples_than_there_are_prove_all(bag, capsys):
    assert len(proved(capsys, bag, "--prove", "10000")[1]["proved"]["samples"]) == 400


def test_without_python_flint_one_line_says_what_to_install(bag):
    call = f"from lie_rigid_body.cli.check import main; sys.exit(main({[str(bag), '--prove', '3']}))"
    code = f"import sys; sys.modules['flint'] = None; {call}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "pip install 'python-flint>=0.9'" in done.stderr
