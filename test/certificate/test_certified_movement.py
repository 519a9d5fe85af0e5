"""Certificates of bodies that are kicked and carried: what they accept, and the least change that they refuse."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sensor_bags import MOTIONS, broken
from tampering import Change, at, declared, on, tamper, with_numbers

from foreign_bags import Message
from lie_rigid_body import Run, simulate
from lie_rigid_body.certificate import certify
from lie_rigid_body.certificate.proved import prove
from lie_rigid_body.recording.bag_reader import Bag

KICKS = [0.5, 1.0, -0.5, 0.2, 1.0, 0.0, 0.0, 0.0, 1.6, 0.1, 2.0, 0.05]
GIVEN: dict[str, Any] = {
    "inertia": [1.0, 0.1, -0.05, 1.4, 0.2, 1.9],
    "initial_position": [1.0, -2.0, 0.5],
    "translation": "carried",
    "sway_acceleration": [1.0, 0.5, 2.0],
    "sway_band": [0.5, 3.0],
    "vibration_acceleration": [0.1, 0.0, 0.2],
    "accelerometer_lever_arm": [0.1, 0.0, -0.2],
    "kicks": KICKS,
    "kick_period": 2.0,
    "rate": 97.0,
    "imu_rate": 150.0,
    "magnetometer_rate": 40.0,
    "gyro_rate": "integrated",
    "sensor_grade": "mems",
}
RESTING = 130
"""Index of a sample at rest, after the sway has come to a stop."""


def bag_of(path: Path, **given: object) -> Path:
    simulate(duration=3.1, **{**GIVEN, **given}).to_bag(path)
    return path


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return bag_of(tmp_path_factory.mktemp("bags") / "honest.mcap", motion="closed_form")


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("translation", ["none", "thrown", "carried"])
def test_bodies_that_move_are_certified(motion: str, translation: str, tmp_path: Path) -> None:
    sway = {} if translation == "carried" else {"sway_acceleration": [0.0] * 3, "sway_band": [0.2, 2.0]}
    path = bag_of(tmp_path / "moved.mcap", **MOTIONS[motion], translation=translation, **sway)
    certificate = certify(path)
    assert certificate.messages == ()
    assert certificate.to_the_bit is (True if motion == "closed form" else None)
    assert certificate.accuracy("kinetic energy") < 1e-7
    assert certificate.accuracy("position") == 0.0


def test_what_is_read_is_what_was_simulated(honest: Path) -> None:
    simulated: Any = simulate(duration=3.1, **{**GIVEN, "motion": "closed_form"})
    read = Run.from_bag(honest)
    for name in ("position", "velocity", "acceleration"):
        assert (getattr(read, name) == getattr(simulated, name)).all()
    assert (read.imu.specific_force == simulated.imu.specific_force).all()
    assert (read.kicks.t_ns == [500_000_000, 1_000_000_000, 1_600_000_000, 2_500_000_000, 3_000_000_000]).all()


def test_a_kicked_motion_is_proved(honest: Path) -> None:
    pytest.importorskip("flint", reason="python-flint is not installed")
    bag = Bag(honest)
    proved = list(prove(bag, certify(bag), 12))
    assert max(sample.attitude_at_most_rad for sample in proved) < 2e-15
    assert all(sample.body_rate_at_most_rad_s < 1e-14 for sample in proved)


def test_the_energy_of_an_arc_is_judged_by_the_largest(tmp_path: Path) -> None:
    path = bag_of(tmp_path / "slow.mcap", kicks=[0.5, 1e-9, 0.0, 0.0, 1.0, 0.0, 0.0, 3.0])
    certificate = certify(path)
    assert certificate.passed
    assert certificate.accuracy("world momentum") < 1e-14


def moved(first: int, by: float) -> Callable[[Message], Message]:
    """Add to a number of a message, counted from its end."""
    return lambda message: with_numbers(message, first, lambda numbers: np.append(numbers[0] + by, numbers[1:]))


@pytest.mark.parametrize(
    ("change", "laws"),
    [
        (on("/pose", at(40, moved(7, 1e-9))), {"position"}),
        (on("/pose", at(RESTING, moved(5, 1e-9))), {"position"}),
        (on("/twist", at(40, moved(6, 1e-9))), {"velocity"}),
        (on("/twist", at(RESTING, moved(4, 1e-12))), {"velocity"}),
        (on("/twist", at(RESTING, moved(1, 1e-12))), {"body rate"}),
        (declared(kicks=[0.501, *KICKS[1:]]), {"attitude"}),
        (declared(kicks=KICKS[:8]), {"attitude"}),
        (declared(kicks=[*KICKS, 1.9, 0.1, 2.0, 0.06]), {"attitude"}),
        (declared(kick_period=0.0), {"attitude"}),
        (declared(sway_seed=1), {"position", "velocity"}),
        (declared(translation="none"), {"position", "velocity"}),
        (declared(vibration_acceleration=[0.1, 0.0, 0.21]), {"accelerometer"}),
    ],
)
def test_the_least_change_is_refused(honest: Path, change: Change, laws: set[str], tmp_path: Path) -> None:
    assert laws <= broken(certify(tamper(honest, tmp_path / "changed.mcap", change)))


def test_a_rest_that_moves_is_refused_of_every_method(tmp_path: Path) -> None:
    path = bag_of(tmp_path / "stepped.mcap", **MOTIONS["rkmk4"])
    assert certify(path).passed
    assert broken(certify(tamper(path, tmp_path / "moved.mcap", on("/twist", at(RESTING, moved(1, 1e-15)))))) == {
        "body rate"
    }


def test_a_far_position_is_held_to_its_last_digits(tmp_path: Path) -> None:
    path = bag_of(tmp_path / "far.mcap", initial_position=[1e6, 0.0, 0.0], motion="closed_form")
    assert certify(path).passed
    assert broken(certify(tamper(path, tmp_path / "moved.mcap", on("/pose", at(40, moved(7, 2e-9)))))) == {"position"}
