"""What ``evaluate`` remarks of estimates beside their score: findings, and notes of stamps, frames, covariances."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
from estimate_messages import beside, messages
from evaluating import HOW, IMU, ODOMETRY, POSE, P, scored

from lie_rigid_body.cli.evaluate import main
from lie_rigid_body.lie import quaternion
from said import numbers

NAMED: dict[str, Any] = {
    "inverted": (lambda t, q: (t, quaternion.conjugate(q)), ["inverted"]),
    "not of unit norm": (lambda t, q: (t, 1.1 * q), ["not_unit"]),
    "with gaps": (lambda t, q: (np.delete(t, slice(50, 75)), np.delete(q, slice(50, 75), axis=0)), ["gaps"]),
    "with doubles": (lambda t, q: (np.repeat(t, 2), np.repeat(q, 2, axis=0)), ["gaps"]),
}


@pytest.mark.parametrize("case", NAMED)
def test_flawed_estimates_are_scored_and_named(case, own, stamps, noisy, tmp_path, capsys):
    change, codes = NAMED[case]
    bag = beside(own, tmp_path / "flawed.mcap", (POSE, HOW[POSE], "/estimate", *change(stamps, noisy)))
    assert [f["code"] for f in scored(capsys, bag, "--estimate", "/estimate")["findings"]] == codes


FAR = 2**31 * 10**9 - 10**9
"""A stamp of the year 2038, ns."""


@pytest.mark.usefixtures("undiagnosed")
def test_one_stamp_far_ahead_does_not_hide_what_follows(own, run, stamps, tmp_path, capsys):
    t, q = stamps.copy(), run.attitude().at(stamps)
    t[3] = FAR
    bag = beside(own, tmp_path / "far.mcap", (POSE, HOW[POSE], "/estimate", t, q))
    content = scored(capsys, bag, "--estimate", "/estimate", "--max-rms", "1deg")
    assert content["samples"] == 249
    [note] = content["notes"]
    assert numbers(note) == [1, 250, FAR / 1e9]


@pytest.mark.usefixtures("undiagnosed")
def test_what_is_out_of_order_is_left_out_and_counted(own, run, stamps, noisy, tmp_path, capsys):
    order = np.r_[100:125, :125, 125:250]
    bag = beside(own, tmp_path / "back.mcap", (IMU, HOW[IMU], "/estimate", stamps[order], noisy[order]))
    content = scored(capsys, bag, "--estimate", "/estimate")
    [note] = content["notes"]
    assert numbers(note) == [25, 275, 4]
    expected = run.score(noisy[:250], stamps[:250], covariance=P).to_dict()
    assert content["total_deg"] == pytest.approx(expected["total_deg"])
    assert content["nees"]["mean"] == pytest.approx(expected["nees"]["mean"])


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize(
    ("kind", "names", "told"),
    [
        (POSE, {"world": "odom"}, ["odom", "world"]),
        (POSE, {"world": "o" * 300}, [f"{23 * 'o'}...{24 * 'o'}", "world"]),
        (IMU, {"sensor": "odom"}, ["odom", "world"]),
        (ODOMETRY, {"body": "lidar"}, ["lidar", "base_link"]),
    ],
)
def test_other_frames_are_named(kind, names, told, own, stamps, noisy, tmp_path, capsys):
    bag = beside(own, tmp_path / "named.mcap", (kind, messages(P, **names)[kind], "/estimate", stamps, noisy))
    [note] = scored(capsys, bag, "--estimate", "/estimate")["notes"]
    assert re.findall("'([^']+)'", note) == told


ASYMMETRIC = np.array([[2.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]])


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize(
    ("covariance", "faults"),
    [
        (np.diag([0.0, 0.0, 0.0]), 0),
        (np.diag([-1.0, 0.0, 0.0]), 0),
        (np.diag([0.0, 0.0, 1e-4]), 1),
        (np.diag([1e-4, 1e-4, -1e-4]), 1),
        (np.diag([1e-4, 1e-4, np.nan]), 1),
        (ASYMMETRIC, 1),
    ],
)
def test_covariances_that_cannot_be_used(covariance, faults, own, stamps, noisy, tmp_path, capsys):
    """Unknown ones are none; of others the attitudes have their score, beside one line and status 2."""
    kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
    bag = beside(own, tmp_path / "c.mcap", (kind, messages(covariance)[kind], "/estimate", stamps, noisy))
    assert main([str(bag), "--estimate", "/estimate", "--max-rms", "1deg", "--json"]) == 2 * faults
    out, err = capsys.readouterr()
    content = json.loads(out)
    assert (content["nees"], content["samples"], len(content["notes"])) == (None, len(stamps), faults)
    assert err.count("\n") == faults == err.count("/estimate: covariance: ")


def test_a_covariance_about_the_bodys_axes_is_recognised_and_can_be_said(own, run, stamps, tmp_path, capsys):
    deviations = np.radians([0.05, 0.5, 2.0])
    noise = np.random.default_rng(4).normal(size=(len(stamps), 3)) * deviations
    estimate = quaternion.multiply(run.attitude().at(stamps), quaternion.exp(noise))
    how = messages(np.diag(deviations**2))[IMU]
    bag = beside(own, tmp_path / "body.mcap", (IMU, how, "/estimate", stamps, estimate))
    found = scored(capsys, bag, "--estimate", "/estimate")["nees"]
    assert found["verdict"] == "overconfident"
    assert 2.0 <= numbers(found["remark"])[0] < 4.0
    assert found["remark"].endswith(" covariance_axes body")
    said = scored(capsys, bag, "--estimate", "/estimate", "--covariance-axes", "body")["nees"]
    assert (said["verdict"], said["remark"]) == ("consistent", "")
