"""Estimators that were written elsewhere find the attitude again, from what the sensors in a bag read."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from lie_rigid_body.__main__ import main

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "estimators.py"
PAGE = ROOT / "docs" / "explanation" / "three_estimators.md"

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning:mcap_ros2.reader")
Table = dict[str, list[float]]
FIRST, RMS, LARGEST, FINAL, LATER, INVERSE = range(6)
FILTERS = ("madgwick", "mahony", "ekf")


def rows(text: str) -> Table:
    """Lines of a name and six numbers."""
    found = re.findall(rf"^[ |]*([a-z]+(?: alone)?) *{6 * r'[ |]+([-+.e0-9]+)'}[ |]*$", text, flags=re.MULTILINE)
    return {name: [float(number) for number in numbers] for name, *numbers in found}


@pytest.fixture(scope="module")
def tables() -> tuple[Table, Table]:
    """Of the bag without errors of the sensors, and of the one with: both are recorded in this process."""
    pytest.importorskip("ahrs")
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(StringIO()) as printed:
        patch.setattr(sys, "argv", [str(EXAMPLE)])
        patch.setattr(subprocess, "run", lambda words, check: subprocess.CompletedProcess(words, main(words[3:])))
        runpy.run_path(str(EXAMPLE), run_name="__main__")
    perfect, mems = printed.getvalue().split("consumer MEMS")
    assert set(rows(perfect)) == set(rows(mems)) == {"gyro alone", *FILTERS}
    return rows(perfect), rows(mems)


def test_the_integrated_gyro_alone_is_the_truth(tables: tuple[Table, Table]) -> None:
    radian = 57.3
    assert tables[0]["gyro alone"][LARGEST] < 1e-12 * radian


def test_a_noisy_gyro_alone_is_not(tables: tuple[Table, Table]) -> None:
    assert tables[1]["gyro alone"][FINAL] > 5.0


@pytest.mark.parametrize("name", FILTERS)
def test_a_first_guess_20_degrees_off_converges_to_the_truth(tables: tuple[Table, Table], name: str) -> None:
    perfect, mems = tables
    assert perfect[name][FIRST] == mems[name][FIRST] == pytest.approx(20.0)
    assert perfect[name][LARGEST] < 0.7
    assert mems[name][RMS] < 2.0
    assert mems[name][LARGEST] < 3.0


@pytest.mark.parametrize("name", FILTERS)
def test_a_quaternion_read_the_wrong_way_round_is_far_off(tables: tuple[Table, Table], name: str) -> None:
    for table in tables:
        assert table[name][INVERSE] > 40.0


@pytest.mark.parametrize("name", ["madgwick", "mahony"])
def test_perfect_readings_leave_a_lead_of_one_sample(tables: tuple[Table, Table], name: str) -> None:
    perfect = tables[0][name]
    one_sample_deg = 0.39 * 0.02 * 57.3
    assert perfect[RMS] == pytest.approx(one_sample_deg, rel=0.2)
    assert perfect[LATER] < 0.4 * one_sample_deg


def test_the_page_shows_what_comes_out(tables: tuple[Table, Table]) -> None:
    shown = PAGE.read_text(encoding="utf-8").split("Consumer MEMS")
    for page, run in zip(map(rows, shown), tables, strict=True):
        assert set(page) == set(run)
        for name, numbers in run.items():
            # the noise is the same everywhere, but not the last bits, and some filters take them up
            assert page[name] == pytest.approx(numbers, rel=0.25, abs=1e-11), name


@pytest.mark.parametrize("name", ["missing.mcap", "test_estimators.py"])
def test_what_is_no_bag_is_told_in_one_line(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("ahrs")
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE), str(Path(__file__).with_name(name))])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(EXAMPLE), run_name="__main__")
    assert ended.value.code == 2
    [line] = capsys.readouterr().err.splitlines()
    assert f"{name} " in line
