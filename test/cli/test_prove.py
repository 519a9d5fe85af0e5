"""``check --prove``: what it says, what it ends with, and where python-flint is missing."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body.cli.check import main
from lie_rigid_body.cli.record import main as record

needs_flint = pytest.mark.skipif(find_spec("flint") is None, reason="python-flint is not installed")


@pytest.fixture
def bag(tmp_path: Path) -> str:
    return recorded(tmp_path / "bag.mcap")


def recorded(path: Path, *assignments: str) -> str:
    words = [word for assignment in assignments for word in ("-p", assignment)]
    assert record([str(path), "--duration", "3", "--quiet", *words]) == 0
    return str(path)


def proved(capsys, arguments: list[str]) -> tuple[int, dict]:
    status = main([*arguments, "--json"])
    return status, json.loads(capsys.readouterr().out)["proved"]


@needs_flint
@pytest.mark.parametrize("motion", ["moving_chart", "closed_form"])
def test_a_good_bag_is_proved(tmp_path, capsys, motion):
    good = recorded(tmp_path / "good.mcap", f"motion:={motion}", "inertia:=[1.0, 0.1, 0.2, 2.0, 0.3, 2.5]")
    status, content = proved(capsys, [good, "--prove", "20"])
    assert status == 0
    assert content["passed"] is True
    assert 0.0 < content["attitude_rad"] < 5e-15
    numbers = [sample["sample"] for sample in content["samples"]]
    assert set(np.rint(np.linspace(0, 299, 20)).astype(int)) <= set(numbers)
    assert numbers == sorted(set(numbers))


@needs_flint
def test_the_worst_sample_is_among_them(bag, capsys):
    assert main([bag, "--json", "--prove", "1"]) == 0
    content = json.loads(capsys.readouterr().out)
    worst = content["certified"]["attitude_worst"]["sample"]
    assert worst in {sample["sample"] for sample in content["proved"]["samples"]}


@needs_flint
def test_a_bag_beyond_its_limit_is_proved_to_be(tmp_path, capsys):
    poor = recorded(tmp_path / "poor.mcap", "method:=rkmk1")
    status, content = proved(capsys, [poor, "--prove", "3"])
    assert status == 1
    assert content["passed"] is False
    last = content["samples"][-1]
    assert last["attitude_limit_rad"] < last["attitude_at_least_rad"] <= last["attitude_at_most_rad"]


@needs_flint
def test_the_inertia_given_is_the_one_proved(bag, capsys):
    status, content = proved(capsys, [bag, "--prove", "3", "--inertia", "1.0000001,2,3"])
    assert status == 1
    assert content["passed"] is False


@needs_flint
def test_more_samples_than_there_are_prove_all(bag, capsys):
    assert len(proved(capsys, [bag, "--prove", "10000"])[1]["samples"]) == 300


def test_without_the_option_nothing_is_proved(bag, capsys):
    assert main([bag, "--json"]) == 0
    assert "proved" not in json.loads(capsys.readouterr().out)


def test_without_python_flint_one_line_says_what_to_install(bag):
    call = f"from lie_rigid_body.cli.check import main; sys.exit(main({[bag, '--prove', '3']}))"
    code = f"import sys; sys.modules['flint'] = None; {call}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "pip install 'python-flint>=0.9'" in done.stderr
