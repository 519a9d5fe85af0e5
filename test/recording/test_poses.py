"""Trajectories of others in text files and bags, and the knots of a path that follow from them."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body import simulate
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.path import MAX_KNOTS
from lie_rigid_body.recording.poses import read_poses, with_path

STAMPS = [1305031102175304123, 1305031102211214567, 1305031102243100000, 1305031102275000001]
POSITIONS = np.arange(12.0).reshape(4, 3) / 7.0
ATTITUDES = quaternion.exp(np.arange(12.0).reshape(4, 3) / 20.0)


def tum(path: Path) -> Path:
    rows = zip(STAMPS, POSITIONS.tolist(), ATTITUDES.tolist(), strict=True)
    lines = [" ".join([f"{Decimal(t) / 10**9}", *map(repr, [*p, *q])]) for t, p, q in rows]
    path.write_text("# timestamp tx ty tz qx qy qz qw\n" + "\n".join(lines) + "\n")
    return path


def euroc(path: Path, *more: str) -> Path:
    rows = zip(STAMPS, POSITIONS.tolist(), ATTITUDES.tolist(), strict=True)
    lines = [", ".join([f"{t}", *map(repr, [*p, q[3], *q[:3]]), *more]) for t, p, q in rows]
    path.write_text("#timestamp, p_RS_R_x [m], ...\r\n" + "\r\n".join(lines))
    return path


def attitudes(path: Path) -> Path:
    lines = [",".join([f"{t}", *map(repr, q)]) for t, q in zip(STAMPS, ATTITUDES.tolist(), strict=True)]
    path.write_text("t_ns,x,y,z,w\n" + "\n".join(lines))
    return path


@pytest.mark.parametrize("make", [tum, euroc, lambda path: euroc(path, *["0.0"] * 9), attitudes])
def test_poses_of_each_layout_are_read_exactly(make: Callable[[Path], Path], tmp_path: Path) -> None:
    poses = read_poses(make(tmp_path / "poses.txt"))
    assert poses.t_ns.tolist() == [stamp - STAMPS[0] for stamp in STAMPS]
    assert (poses.position == (0.0 if make is attitudes else POSITIONS)).all()
    assert np.abs(poses.attitude_xyzw - ATTITUDES).max() < 2e-16


def test_poses_of_a_bag_are_those_of_its_topic(tmp_path: Path) -> None:
    run = simulate(duration=0.5, translation="thrown", initial_velocity=[1.0, 2.0, 3.0], epoch_ns=10**9)
    run.to_bag(tmp_path / "own.mcap", estimates={"/mine": Estimate(run.truth.attitude_xyzw, run.t_ns)})
    poses = read_poses(tmp_path / "own.mcap")
    assert poses.t_ns.tolist() == (run.t_ns - run.t_ns[0]).tolist()
    assert (poses.position == run.position).all()
    assert np.abs(poses.attitude_xyzw - run.truth.attitude_xyzw).max() < 2e-16


def test_quaternions_that_a_file_rounds_are_normalised(tmp_path: Path) -> None:
    file = tmp_path / "p.tum"
    file.write_text("0.0 0 0 0 0.5 0.5 0.5 0.501\n")
    assert np.linalg.norm(read_poses(file).attitude_xyzw) == pytest.approx(1.0, abs=2e-16)


def test_too_many_knots_are_refused_and_averaged_to_fewer(tmp_path: Path) -> None:
    file = tmp_path / "p.tum"
    file.write_text("\n".join(f"{k / 1000} 0 0 0 0 0 0 1" for k in range(2 * MAX_KNOTS)))
    given = {"motion": "path", "path_file": str(file), "path_interval": 0.0}
    with pytest.raises(ParameterError) as refused:
        with_path(given)
    assert "longer path_interval" in str(refused.value)
    knots = np.array(with_path({**given, "path_interval": 0.002})["path_knots"])
    assert len(knots) == MAX_KNOTS * 8


def test_the_file_is_read_for_a_path_alone_and_once(tmp_path: Path) -> None:
    missing = str(tmp_path / "missing.tum")
    assert with_path({"path_file": missing}) == {"path_file": missing}
    carried = {"motion": "path", "path_file": missing, "path_knots": [0.0] * 8}
    assert with_path(carried) == carried
    with pytest.raises(ParameterError, match="exist"):
        with_path({"motion": "path", "path_file": missing})
