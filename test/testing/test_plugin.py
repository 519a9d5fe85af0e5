"""The plugin for tests of filters, in pytest processes of their own, as its users have it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body import Run, simulate
from lie_rigid_body.scenario.parameter_file import scenario_files
from lie_rigid_body.sensors import GRADES
from lie_rigid_body.testing import assert_attitude
from said import numbers

ROOT = Path(__file__).parents[2]
PLUGIN = "lie_rigid_body.testing"


def run_pytest(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Pytest in a folder of its own; only the plugin is loaded, by name, as this checkout need not be installed."""
    command = [sys.executable, "-m", "pytest", "-p", PLUGIN, "-p", "no:cacheprovider", *arguments]
    alone = {"PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    nothing_left = {"PYTHONDONTWRITEBYTECODE": "1", "HYPOTHESIS_STORAGE_DIRECTORY": os.devnull}
    environment = {**os.environ, **alone, **nothing_left}
    for of_a_server in ("CI", "BUILD_NUMBER"):  # there pytest says each message a second time, in its summary
        environment.pop(of_a_server, None)
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


RUNS = """
import pytest

def test_only_collected(attitude_run):
    raise AssertionError("only collected")

@pytest.mark.attitude_run(scenarios=["dzhanibekov"], grades=["mems", "perfect"], duration=0.5, imu_rate=40.0)
def test_marked(attitude_run):
    assert len(attitude_run.imu.t_ns) == 20
    assert attitude_run.scenario.inertia == (1.0, 2.0, 3.0)
    assert attitude_run.scenario.sensors.imu.gyro.noise_density == 0.0 or attitude_run.scenario.sensor_grade == "mems"

first = []

@pytest.mark.attitude_run(duration=0.5)
@pytest.mark.parametrize("attitude_run", [("flat_plate", "tactical")] * 2, indirect=True)
def test_parametrised(attitude_run):
    first.append(attitude_run)
    assert attitude_run is first[0]
    assert attitude_run.scenario.sensor_grade == "tactical"

@pytest.mark.attitude_run(duration=0.5)
@pytest.mark.parametrize("attitude_run", ["flat_plate"], indirect=True)
def test_of_perfect_sensors(attitude_run):
    assert attitude_run.scenario.sensor_grade == "perfect"
"""
ALONE = """
import numpy as np
import pytest
from lie_rigid_body import Scenario

BODY = {
    **{"inertia": [1.23456789, 2.3456789, 3.0123456789], "initial_attitude_xyzw": [0.1, 0.2, 0.3, 0.9273618495495704]},
    **{"rate": 20.0, "imu_rate": 100.0, "magnetometer_rate": 50.0, "sensor_grade": "mems", "world_frame": "inertial"},
}
SPINS = [[0.1, rate, 0.01] for rate in (0.5, 2.0)]

@pytest.mark.attitude_run(
    scenarios=[Scenario.from_parameters({**BODY, "initial_body_rate": spin}) for spin in SPINS],
    grades="perfect", duration=0.1,
)
def test_scenarios(attitude_run, request):
    assert attitude_run.scenario.initial_body_rate == request.node.callspec.params["attitude_run"][0].initial_body_rate

class TestArguments:
    @pytest.mark.attitude_run(
        scenarios="flat_plate", grades="mems", duration=0.1, initial_body_rate=np.array([1, 2, 3.0])
    )
    def test_one(self, attitude_run):
        assert attitude_run.scenario.initial_body_rate[2] == 3.0

    @pytest.mark.attitude_run(
        scenarios="flat_plate", grades="mems", duration=0.1, initial_body_rate=np.array([1, 2, 3.0 + 1e-12])
    )
    def test_other(self, attitude_run):
        assert attitude_run.scenario.initial_body_rate[2] == 3.0 + 1e-12

@pytest.mark.attitude_run(scenarios="flat_plate", grades="mems", duration=0.1)
def test_arrays(attitude_run):
    imu, field = attitude_run.imu, attitude_run.magnetometer
    for array in (attitude_run.t_ns, imu.t_ns, imu.gyro, imu.gyro_bias, field.field, field.arrival_ns):
        with pytest.raises(ValueError, match="read-only"):
            array[:] -= 1
"""
JUDGED = """
import numpy as np
import pytest
from lie_rigid_body.testing import assert_attitude

WRONG = {"not finite": {"max_rms_deg": 1.0}, "from 0 on": {"max_rms_deg": 1.0, "after_s": -1}, "a limit": {},
         "no Run": {"run": None, "max_rms_deg": 1.0}, "degrees above 0": {"max_rms_deg": -1}}

@pytest.mark.attitude_run(scenarios="flat_plate", grades="mems", duration=0.1)
@pytest.mark.parametrize("what", WRONG)
def test_one(attitude_run, what):
    assert_attitude(**{"estimate": np.full((10, 4), np.nan), "run": attitude_run, **WRONG[what]})
"""
ORDERED = f"""
import pytest

@pytest.mark.attitude_run(scenarios={{*{list(scenario_files())}}}, grades={{"mems"}}, duration=0.1)
def test_of_a_set(attitude_run): pass

@pytest.mark.attitude_run(scenarios="tumbling_cubesat", grades="mems", duration=0.1)
def test_of_a_text(attitude_run): pass
"""
PARAMETRISED = """
import pytest

@pytest.mark.parametrize('attitude_run', [('flat_plat', 'mems'), (), ['a', 'b', 'c']], indirect=True)
def test_it(attitude_run): pass
def test_that_asks_late(request): request.getfixturevalue('attitude_run')
"""
OWN_FIXTURE = """
import pytest

@pytest.fixture(params=[1, 2])
def attitude_run(request): return request.param
"""
WRONG_MARKERS = {
    'scenarios="tumbling_cubsat"': "scenario 'tumbling_cubsat' ",
    'scenarios="flat_plate", grades=["mems", "memz"]': "sensor_grade: 'memz' ",
    'scenarios="flat_plate", imu_rat=5.0': "imu_rat: ",
    'scenario="flat_plate"': "scenario='flat_plate' is no argument: did you mean scenarios=?",
    "grades=__import__('numpy').array(['mems', 'memz'])": "sensor_grade: 'memz' ",
    "scenarios=[]": "scenarios=[] makes no run: leave it out for all",
    "grades=()": "grades=() makes no run: leave it out for all",
    "seeds=iter((1, 2))": "seeds= can be read once: give a list",
    "scenarios=5": "scenarios=5 is no list of names: give such as ['",
    "grades=[['mems']]": "grades=[['mems']] is no list of names: give such as ['",
    'grades=["mems"], sensor_grade="mems"': "sensor_grade= is given beside grades=: give one of them",
    'grade="mems"': "grade='mems' is no argument: did you mean grades=?",
    '"flat_plate"': "'flat_plate' has no name: give scenarios=, grades= or arguments of simulate by name",
}
FILES = {
    "test_runs.py": RUNS,
    "test_alone.py": ALONE,
    "test_judged.py": JUDGED,
    "test_ordered.py": ORDERED,
    "test_parametrised.py": PARAMETRISED,
    "other/conftest.py": OWN_FIXTURE,
    "other/test_other.py": "def test_it(attitude_run): assert attitude_run in (1, 2)\n",
    **{
        f"test_wrong_{i}.py": f"import pytest\n@pytest.mark.attitude_run({marker})\ndef test_it(attitude_run): pass\n"
        for i, marker in enumerate(WRONG_MARKERS)
    },
}
"""Tests of a user of the plugin. One process runs all of them, as each takes a second to begin."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("user")
    (folder / "other").mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return folder


@pytest.fixture(scope="module")
def listed(folder: Path) -> str:
    chosen = ("-k", "not only_collected", "--strict-markers", "--continue-on-collection-errors")
    return run_pytest(folder, "-v", *chosen).stdout


@pytest.fixture(scope="module")
def names(folder: Path) -> list[str]:
    """Names of all tests, of another process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONHASHSEED", "1")
        return [line for line in run_pytest(folder, "-q", "--collect-only").stdout.splitlines() if "::" in line]


def outcomes(listed: str, file: str) -> dict[str, str]:
    """What became of each test of a file, in order."""
    return dict(re.findall(rf"^{file}::(.*) (PASSED|FAILED|ERROR) +\[", listed, re.MULTILINE))


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate("prolate_top", duration=5.0, imu_rate=50.0, motion="closed_form", sensor_grade="mems")


def stamps(run: Run) -> np.ndarray:
    return run.imu.t_ns


def test_loading_it_loads_nothing_heavy():
    code = f"import sys, {PLUGIN}; print(sorted({{'numpy', 'scipy', 'yaml', 'hypothesis', 'mcap'}} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.slow
def test_the_worked_example_passes():
    done = run_pytest(ROOT / "examples" / "complementary_filter", "-q")
    assert f"{2 * len(GRADES) + 2} passed" in done.stdout.splitlines()[-1], done.stdout


@pytest.mark.slow
def test_runs_by_marker_by_parametrize_and_all_of_them(listed, names):
    found = outcomes(listed, "test_runs.py")
    assert list(found.values()) == ["PASSED"] * 5, listed
    assert "test_marked[dzhanibekov-mems]" in found
    assert sum("only_collected" in name for name in names) == (len(scenario_files()) - 1) * len(GRADES)


def test_each_test_has_the_run_it_asks_for_and_changes_none_for_others(listed):
    """Scenarios and arguments that look alike where they are shortened are others."""
    assert list(outcomes(listed, "test_alone.py").values()) == ["PASSED"] * 5, listed


def test_a_failure_tells_the_error_and_its_cause(run):
    late = run.attitude().at(np.maximum(stamps(run) - 20_000_000, 0))
    with pytest.raises(AssertionError) as failure:
        assert_attitude(late, run, max_rms_deg=0.01, max_after="1s:2deg")
    message = str(failure.value)
    assert 0.01 in numbers(message.splitlines()[0])
    words = {line.removeprefix("- ").split(" ")[0] for line in message.splitlines()}
    assert {"total", "heading", "inclination", "lagging:"} <= words


def test_a_score_is_returned_and_the_beginning_can_be_left_out(run):
    wrong = run.attitude().at(stamps(run)).copy()
    wrong[:50] = [0.0, 0.0, 0.0, 1.0]
    with pytest.raises(AssertionError):
        assert_attitude(wrong, run, max_rms_deg=0.1)
    score = assert_attitude(wrong, run, max_rms_deg=0.1, after_s=1.0, gyro_bias=run.gyro_bias_at(stamps(run)))
    assert score.samples == 200
    assert score.findings == ()
    assert score.gyro_bias_rad_s is not None
    assert score.gyro_bias_rad_s.max == 0.0
    covariance = np.tile(np.eye(3) * 1e-6, (250, 1, 1))
    assert assert_attitude(wrong, run, max_rms_deg=0.1, after_s=1.0, covariance=covariance).consistency is not None
    few = assert_attitude(wrong[60:80], run, t_ns=stamps(run)[60:80], max_after="0s:0.1deg")
    assert few.samples == 20


def test_names_of_a_set_have_one_order_in_every_process_and_a_text_is_one_name(listed, names):
    found = [name.partition("::")[2] for name in names if name.startswith("test_ordered.py::")]
    assert found == list(outcomes(listed, "test_ordered.py"))
    assert found[0] == "test_of_a_set[asymmetric_top-mems]"
    assert found[len(scenario_files()) :] == ["test_of_a_text[tumbling_cubesat-mems]"]


def test_a_marker_that_makes_no_run_is_one_line_at_collection(listed):
    """At a wrong name in ``parametrize`` it is one at set-up."""
    assert list(outcomes(listed, "test_parametrised.py").values()) == ["ERROR"] * 3 + ["FAILED"]
    assert listed.count("ERROR collecting test_wrong_") == len(WRONG_MARKERS)
    said = {
        **WRONG_MARKERS,
        "a name": "scenario 'flat_plat' ",
        "three": "('a', 'b', 'c') is no scenario and grade: ask for ",
    }
    assert listed.count("\nattitude_run: () ") == 2
    for message in said.values():
        assert f"\nattitude_run: {message}" in listed
        assert listed.count(f"\n{message}") == 0
    assert "During handling of the above exception" not in listed
    assert "ensemble.py" not in listed


def test_a_fixture_of_that_name_in_another_project_is_left_alone(listed):
    assert list(outcomes(listed, "other/test_other.py").values()) == ["PASSED"] * 2


def test_of_what_cannot_be_judged_only_the_line_of_the_test_is_shown(listed):
    assert list(outcomes(listed, "test_judged.py").values()) == ["FAILED"] * 5
    assert listed.count("lie_rigid_body.foundation.errors.InputError: ") >= 5
    assert str(ROOT / "lie_rigid_body") not in listed
    assert "../lie_rigid_body" not in listed


def test_a_broken_limit_is_drawn_where_it_is_wanted(run, tmp_path):
    late = run.attitude().at(np.maximum(stamps(run) - 20_000_000, 0))
    picture = tmp_path / "errors.png"
    assert_attitude(late, run, max_rms_deg=90.0, plot=picture)
    assert not picture.exists()
    with pytest.raises(AssertionError, match=picture.name):
        assert_attitude(late, run, max_rms_deg=0.01, plot=picture)
    assert picture.read_bytes().startswith(b"\x89PNG")


NOT_DRAWN = "\nThe errors over time are not drawn: "


@pytest.mark.parametrize(
    ("plot", "why"), [("no/such/folder/errors.png", "no/such/folder"), ("errors.svg", r"\.png"), (5, "")]
)
def test_a_picture_that_cannot_be_drawn_hides_no_broken_limit(run, tmp_path, plot, why):
    late = run.attitude().at(np.maximum(stamps(run) - 20_000_000, 0))
    with pytest.raises(AssertionError, match=f"{NOT_DRAWN}.*{why}") as failure:
        assert_attitude(late, run, max_rms_deg=0.01, plot=tmp_path / plot if isinstance(plot, str) else plot)
    assert 0.01 in numbers(str(failure.value).splitlines()[0])
