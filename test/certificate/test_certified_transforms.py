"""Transforms from the world to the body are judged as its poses are; those of other frames are told, and not judged."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from estimate_messages import beside, header, make, vector
from estimate_messages import quaternion as rotation

from lie_rigid_body import Run, simulate
from lie_rigid_body.certificate import certify
from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages.definitions import TF_MESSAGE, TRANSFORM_STAMPED

MOTION: dict[str, Any] = {"motion": "closed_form", "rate": 50.0, "initial_body_rate": [0.4, 0.6, -0.3]}


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Run]:
    path = tmp_path_factory.mktemp("transforms") / "run.mcap"
    made = simulate(duration=4.0, **MOTION)
    made.to_bag(path)
    return path, made


def transform(t: int, xyzw: np.ndarray, frame: str = "world") -> Any:
    moved = make("geometry_msgs/msg/Transform", vector(), rotation(xyzw))
    return make(TRANSFORM_STAMPED, header(t, frame), "base_link", moved)


def with_transforms(run: tuple[Path, Run], tmp_path: Path, name: str, turned: float = 0.0, late_ns: int = 0) -> Path:
    """The bag with the poses as transforms, one of which is turned, and all of which are late by so much."""
    path, made = run
    attitude = made.truth.attitude_xyzw.copy()
    attitude[77] = quaternion.multiply(attitude[77], quaternion.exp(np.array([turned, 0.0, 0.0])))
    how = {
        "own": lambda t, q: make(TF_MESSAGE, [transform(t, q)]),
        "with another": lambda t, q: make(TF_MESSAGE, [transform(t, q, "map"), transform(t, q)]),
    }[name]
    return beside(path, tmp_path / f"{name}.mcap", (TF_MESSAGE, how, "/tf", made.t_ns + late_ns, attitude))


def test_those_of_the_body_are_certified(run: tuple[Path, Run], tmp_path: Path) -> None:
    certificate = certify(with_transforms(run, tmp_path, "own"))
    assert certificate.passed, certificate.messages
    by_name = {law.name: law for law in certificate.whole}
    assert [by_name[name].checked for name in ("transform", "transform position")] == [len(run[1].t_ns)] * 2
    assert not [text for text in certificate.uncovered if "tf" in text or "transform" in text]


def test_those_of_other_frames_are_told(run: tuple[Path, Run], tmp_path: Path) -> None:
    certificate = certify(with_transforms(run, tmp_path, "with another"))
    assert certificate.passed, certificate.messages
    [told] = [text for text in certificate.uncovered if "transform" in text]
    assert str(len(run[1].t_ns)) in told


@pytest.mark.parametrize(("turned", "late_ns"), [(1e-9, 0), (0.0, 1000)])
def test_one_that_is_off_breaks_a_law(run: tuple[Path, Run], tmp_path: Path, turned: float, late_ns: int) -> None:
    certificate = certify(with_transforms(run, tmp_path, "own", turned, late_ns))
    assert [law.name for law in certificate.laws if not law.holds] == ["transform"]
    [law] = [law for law in certificate.laws if law.name == "transform"]
    assert law.sample == 77 if turned else law.broken > 100


def test_a_bag_without_transforms_has_no_such_law(run: tuple[Path, Run]) -> None:
    assert not [law for law in certify(run[0]).laws if "transform" in law.name]
