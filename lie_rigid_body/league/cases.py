"""Cases of the league: motions, grades of sensors and faults, with fixed seeds, and what filters are given of them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np

from lie_rigid_body.runs import Run, simulate
from lie_rigid_body.scenario.parameter_file import CONFIG, gather
from lie_rigid_body.sensors import PERFECT

MOTIONS: Final = ("slow_tumble", "fast_tumble", "spin_x", "spin_y", "spin_z", "flips", "precession")
REAL: Final = ("navigation", "tactical", "mems")
"""Grades of sensors that have errors."""
GRADES: Final = (PERFECT, *REAL)
FAULTS: Final = (
    "clock_offset",
    "dropouts",
    "magnet",
    "noise_bursts",
    "outages",
    "saturation",
    "spikes",
    "stuck_axis",
    "temperature_ramp",
)
DURATION_S: Final = 60.0
"""Length of a run, s."""
SETTLED_S: Final = 30.0
"""Time from which on errors count, s: filters begin without knowing the attitude."""
SEED: Final = 1
"""Seed of the sensors in every case."""
RESOLUTION: Final = 1e-9
"""Share of the range of readings to which they are rounded before they are hashed: round-off differs by machine."""


@dataclass(frozen=True)
class Case:
    """A motion read by sensors of a grade, perhaps with a fault.

    Attributes
    ----------
    motion, grade, fault : str
        Names of files in ``config/league``, but of the grade; no fault is ''.
    """

    motion: str
    grade: str
    fault: str = ""

    def __str__(self) -> str:
        return " ".join(filter(None, (self.motion, self.grade, self.fault)))


CASES: Final = (
    *(Case(motion, grade) for grade in GRADES for motion in MOTIONS),
    *(Case("slow_tumble", "mems", fault) for fault in FAULTS),
)
"""Every motion with every grade, and a slow tumble of MEMS sensors with each fault."""


@lru_cache(maxsize=4)
def run_of(case: Case, seed: int = SEED) -> Run:
    """The run of a case, with its truth."""
    names = ["sensors", case.motion, *([f"fault_{case.fault}"] if case.fault else [])]
    parameters: dict[str, Any] = dict(gather(None, [CONFIG / "league" / f"{name}.yaml" for name in names], []))
    run: Run = simulate(duration=DURATION_S, **{**parameters, "sensor_grade": case.grade, "sensor_seed": seed})
    return run


def readings_hash(run: Run) -> str:
    """Hash of the readings of a run, as 16 hexadecimal digits: stamps, and vectors to `RESOLUTION` of their range."""
    assert run.magnetometer is not None
    vectors = (run.imu.gyro, run.imu.specific_force, run.magnetometer.field)
    steps = (np.round(each / (RESOLUTION * np.abs(each).max())) for each in vectors)
    hashed = b"".join(each.astype("<i8").tobytes() for each in (run.imu.t_ns, run.magnetometer.t_ns, *steps))
    return hashlib.sha256(hashed).hexdigest()[:16]
