"""Bags along a path are certified as prescribed, to 1e-9, and by no law of mechanics."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from tampering import at, declared, on, rotated, tamper, with_numbers

from foreign_bags import Message
from lie_rigid_body import certify, simulate
from lie_rigid_body.__main__ import main
from lie_rigid_body.certificate.proved import prove
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.path import Knots
from lie_rigid_body.recording.bag_reader import read_bag

STEP_NS = 100_000_000


def knots(count: int) -> list[float]:
    """Knots of a steady rotation and of a cubic, to which a spline through any of them is equal."""
    t_ns = STEP_NS * np.arange(count)
    t_s = t_ns[:, np.newaxis] / 1e9
    return Knots(t_ns, t_s**3 * [1.0, -2.0, 0.5] + [0.0, 2.0, 1.0], quaternion.exp(t_s * [1.0, 2.0, 0.5])).numbers()


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "path.mcap"
    simulate(motion="path", path_knots=knots(11), imu_rate=50.0, duration=1.0).to_bag(path)
    return path


def test_the_certificate_says_that_the_motion_is_prescribed(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    certificate = certify(bag)
    assert certificate.passed
    assert certificate.is_prescribed
    assert {law.name for law in certificate.laws}.isdisjoint({"kinetic energy", "world momentum"})
    assert certificate.segments[0].law("attitude").limit == 1e-9
    assert main(["check", str(bag), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["certified"]["kinetic_energy_relative"] is None
    assert any("prescribed" in sentence for sentence in told["not_certified"])


@pytest.mark.parametrize("option", [["--prove", "3"], ["--inertia", "1,2,3"]])
def test_there_is_nothing_of_mechanics_to_ask(
    option: Sequence[str], bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(bag), *option]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_proof_from_python_is_refused(bag: Path) -> None:
    with pytest.raises(InputError):
        list(prove(read_bag(bag), certify(bag), 3))


def moved(first: int, place: int) -> Callable[[float], Callable[[Message], Message]]:
    """Changes of one of the last numbers of a message by so much."""
    return lambda by: lambda message: with_numbers(message, first, lambda x: x + by * np.eye(first)[place])


CHANGES = {
    "attitude": ("/pose", lambda by: rotated(by, np.ones(3))),
    "position": ("/pose", moved(7, 1)),
    "velocity": ("/twist", moved(6, 2)),
    "body rate": ("/twist", moved(3, 0)),
    "gyro": ("/imu/data_raw", moved(24, 0)),
    "accelerometer": ("/imu/data_raw", moved(12, 0)),
}


@pytest.mark.parametrize(("law", "by"), zip(CHANGES, [1e-8, 1e-8, 1e-7, 1e-7, 1e-7, 1e-7], strict=True))
def test_what_is_moved_is_caught(law: str, by: float, bag: Path, tmp_path: Path) -> None:
    topic, change = CHANGES[law]
    for size, broken in ((by, [law]), (1e-11, [])):
        certificate = certify(tamper(bag, tmp_path / f"{size}.mcap", on(topic, at(7, change(size)))))
        assert [each.name for each in certificate.laws if not each.holds] == broken


def test_samples_behind_the_last_pose_are_none_of_the_path(bag: Path, tmp_path: Path) -> None:
    shorter = certify(tamper(bag, tmp_path / "a.mcap", declared(path_knots=knots(9))))
    assert shorter.segments[0].law("body rate").holds
    assert shorter.segments[0].law("attitude").broken == 19  # 0.81 to 0.99 s


def test_a_path_that_is_none_is_an_impossible_declaration(bag: Path, tmp_path: Path) -> None:
    for path_knots in ([], knots(3), knots(11)[8:] + knots(1)):
        certificate = certify(tamper(bag, tmp_path / "a.mcap", declared(path_knots=path_knots)))
        assert [law.name for law in certificate.whole] == ["declaration"]
        assert not certificate.passed
