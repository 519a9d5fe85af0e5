"""``evaluate`` of several estimates: a row each, the difference of each pair, a picture, a page."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from estimate_messages import beside
from evaluating import HOW, IMU, POSE, scored
from scipy.spatial.transform import Rotation

from lie_rigid_body import Estimate, attitude_error, simulate
from lie_rigid_body.cli.evaluate import main

pytestmark = pytest.mark.usefixtures("undiagnosed")

WORSE = 3.0


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    """A bag with three estimates: one with white noise, one with three times as much, and one like the first."""
    folder = tmp_path_factory.mktemp("several")
    run = simulate("tumbling_cubesat", duration=20.0)
    run.to_bag(folder / "run.mcap")
    t = np.arange(0, 20 * 10**9, 20_000_000)
    truth, draws = Rotation.from_quat(run.attitude().at(t)), np.random.default_rng(3)
    made = {
        name: (Rotation.from_rotvec(np.radians(size) * draws.normal(size=(len(t), 3))) * truth).as_quat()
        for name, size in (("/good", 0.5), ("/poor", WORSE * 0.5), ("/alike", 0.5))
    }
    topics = [(POSE, HOW[POSE], name, t, attitude) for name, attitude in made.items()]
    late = (IMU, HOW[IMU], "/elsewhere", t[:-1] + 7, made["/good"][:-1])
    bag = beside(folder / "run.mcap", folder / "several.mcap", *topics, late)
    errors = {name: np.degrees(attitude_error(attitude, truth.as_quat()).total) for name, attitude in made.items()}
    return bag, errors


def rms(errors):
    return float(np.sqrt(np.mean(errors**2)))


def test_each_has_its_score_and_one_run_has_no_difference(several, capsys):
    bag, errors = several
    content = scored(capsys, bag, *(word for name in errors for word in ("--estimate", name)))
    assert [each["topic"] for each in content["estimates"]] == list(errors)
    assert [each["total_deg"]["rms"] for each in content["estimates"]] == pytest.approx([*map(rms, errors.values())])
    assert {*content} == {"estimates", "passed"}
    assert content["passed"] is True


def test_a_limit_is_held_by_each(several, capsys):
    bag, errors = several
    both = ["--estimate", "/good", "--estimate", "/poor"]
    content = scored(capsys, bag, *both, "--max-rms", "1.5deg", status=1)
    assert [each["passed"] for each in content["estimates"]] == [True, False]
    assert content["passed"] is False
    assert main([str(bag), *both, "--max-rms", "1.5deg"]) == 1
    assert f"{rms(errors['/poor']):.4g}°" in capsys.readouterr().out


@pytest.mark.slow
def test_they_share_a_picture_and_a_page(several, tmp_path, capsys):
    picture, page = tmp_path / "a.png", tmp_path / "a.html"
    given = f"--estimate /good --estimate /poor --plot {picture} --report {page}"
    assert main([str(several[0]), *given.split()]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    content = page.read_text(encoding="utf-8")
    assert content.count("<svg") == 1
    assert re.findall(r"<td>(/good|/poor)</td>", content) == ["/good", "/poor"]
    assert "</html>" in content


def test_a_bias_of_the_gyro_has_its_column(tmp_path, capsys):
    run: Any = simulate("tumbling_cubesat", duration=2.0, imu_rate=50.0)
    attitude, bias = run.attitude().at(run.imu.t_ns), np.full((len(run.imu.t_ns), 3), [3e-3, 0.0, 4e-3])
    given = {"/with": Estimate(attitude, gyro_bias=bias), "/without": Estimate(attitude)}
    run.to_bag(tmp_path / "both.mcap", estimates=given)
    assert main([str(tmp_path / "both.mcap"), "--estimate", "/with", "--estimate", "/without"]) == 0
    head, *rows = capsys.readouterr().out.splitlines()[2:5]
    assert "gyro bias" in head
    assert ["0.005 rad/s" in row for row in rows] == [True, False]
