"""Cases of the league: bodies that are kicked, carried and at times at rest, as in real recordings, with fixed seeds.

How fast a body turns, how long it turns alike, and how it is accelerated are those of ten recordings of the data set
BROAD (D. Laidig et al., Data 6(7):72, 2021): docs/reference/league.md has both beside one another. The cases were fixed
before any filter was ranked by them.
"""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Any, Final, NamedTuple

import numpy as np

from lie_rigid_body.runs import Run, simulate
from lie_rigid_body.scenario import random_kicks
from lie_rigid_body.scenario.parameter_file import CONFIG, gather
from lie_rigid_body.sensors import PERFECT


class Movement(NamedTuple):
    """How a body turns and is carried.

    Attributes
    ----------
    rate : float
        Largest body rate after a kick, rad/s.
    interval : float
        Mean time between two kicks, s: twice the time after which the autocorrelation of the rate is a half.
    acceleration : float
        RMS of the acceleration along each axis of the world, m/s².
    band : tuple of float
        Frequencies between which it is, Hz.
    """

    rate: float
    interval: float
    acceleration: float
    band: tuple[float, float]


MOTIONS: Final = {
    ("rotation", "slow"): Movement(2.1, 1.2, 0.7, (2.0, 10.0)),
    ("rotation", "fast"): Movement(5.7, 0.3, 1.8, (1.5, 8.5)),
    ("translation", "slow"): Movement(1.1, 0.25, 1.6, (0.5, 4.5)),
    ("translation", "fast"): Movement(3.3, 0.25, 8.1, (1.0, 2.6)),
    ("combined", "slow"): Movement(2.1, 1.2, 1.6, (0.5, 4.5)),
    ("combined", "fast"): Movement(10.4, 0.4, 6.3, (0.9, 3.0)),
    ("disturbed", "slow"): Movement(3.7, 0.75, 1.5, (0.4, 2.5)),
    ("disturbed", "fast"): Movement(8.5, 0.4, 4.6, (0.6, 3.7)),
}
"""Motions by group and speed. Of slow combined motions there is no recording: the rate is that of slow rotations, the
acceleration that of slow translations."""
MAGNETS: Final = {("disturbed", "slow"): "attached_magnet", ("disturbed", "fast"): "passing_magnet"}
"""Files in ``config/league`` that groups have beside."""
GROUPS: Final = tuple(dict.fromkeys(group for group, _ in MOTIONS))
GRADES: Final = ("mems", "tactical")
"""Grades of the sensors in the cases by which filters are ranked."""
SEEDS: Final = (1, 2, 3)
"""Runs of each kind of case, which differ by what is drawn."""
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
REST_S: Final = 10.0
"""Rest with which a run begins, s, as recordings do."""
BREAKS_S: Final = ((24.0, 32.0), (44.0, 52.0))
"""Rests of a run that has rests, s: a third of the time, as in recordings with breaks."""
SETTLED_S: Final = 20.0
"""Time from which on errors count, s: filters begin without knowing the attitude."""
RESOLUTION: Final = 1e-9
"""Share of the range of readings to which they are rounded before they are hashed: round-off differs by machine."""


@dataclass(frozen=True)
class Case:
    """A motion read by sensors of a grade, perhaps with a fault.

    Attributes
    ----------
    group, speed : str
        A key of `MOTIONS`; no speed is the free tumble.
    rests : bool
        Whether the body rests at times.
    grade : str
        Grade of the sensors.
    seed : int
        Which of the runs of its kind.
    fault : str
        One of `FAULTS`, or ''.
    """

    group: str
    speed: str
    rests: bool
    grade: str
    seed: int = SEEDS[0]
    fault: str = ""

    def __str__(self) -> str:
        return " ".join(
            filter(None, (self.group, self.speed, "rests" * self.rests, self.fault, self.grade, str(self.seed)))
        )

    @property
    def draws(self) -> int:
        """Seed of kicks, sway and sensors: one for each name without its fault, so that no two cases share a bias."""
        return zlib.crc32(str(replace(self, fault="")).encode()) % 2**31

    def parameters(self) -> dict[str, Any]:
        """Parameters of its scenario."""
        names = ["sensors"]
        moving = {}
        if self.speed:
            motion = MOTIONS[self.group, self.speed]
            names += filter(None, [MAGNETS.get((self.group, self.speed))])
            moving = {
                "kicks": kicks_of(motion, self.draws, BREAKS_S if self.rests else ()),
                "translation": "carried",
                "sway_acceleration": [motion.acceleration] * 3,
                "sway_band": [*motion.band],
                "sway_seed": self.draws,
            }
        else:
            names.append(self.group)
        names += [f"fault_{self.fault}"] * bool(self.fault)
        files: Any = gather(None, [CONFIG / "league" / f"{name}.yaml" for name in names], [])
        return {**files, **moving, "sensor_grade": self.grade, "sensor_seed": self.draws}


def kicks_of(motion: Movement, seed: int, breaks_s: Sequence[tuple[float, float]]) -> list[float]:
    """Kicks of a motion that begins with a rest, and has breaks: four numbers a kick."""
    drawn = np.reshape(random_kicks(DURATION_S - REST_S, motion.interval, motion.rate, 0.0, seed), (-1, 4))
    drawn[:, 0] += REST_S
    for begin, end in breaks_s:
        before, after = drawn[:, 0] < begin, drawn[:, 0] >= end
        drawn = np.concatenate([drawn[before], [[begin, 0.0, 0.0, 0.0]], drawn[after]])
    return list(drawn.ravel().tolist())


WIRING: Final = Case("tumble", "", False, PERFECT)
"""A free tumble read by perfect sensors, which proves that a filter is wired as it should be."""
RANKED: Final = tuple(
    Case(group, speed, rests, grade, seed)
    for (group, speed), rests, grade, seed in product(MOTIONS, (False, True), GRADES, SEEDS)
)
"""The cases by which filters are ranked."""
FAULTY: Final = tuple(Case("combined", "slow", False, "mems", fault=fault) for fault in FAULTS)
"""A motion with each fault of the sensors."""
CASES: Final = (WIRING, *RANKED, *FAULTY)


@lru_cache(maxsize=4)
def run_of(case: Case) -> Run:
    """The run of a case, with its truth."""
    run: Run = simulate(duration=DURATION_S, **case.parameters())
    return run


def readings_hash(run: Run) -> str:
    """Hash of the readings of a run, as 16 hexadecimal digits: stamps, and vectors to `RESOLUTION` of their range."""
    assert run.magnetometer is not None
    vectors = (run.imu.gyro, run.imu.specific_force, run.magnetometer.field)
    steps = (np.round(each / (RESOLUTION * np.abs(each).max())) for each in vectors)
    hashed = b"".join(each.astype("<i8").tobytes() for each in (run.imu.t_ns, run.magnetometer.t_ns, *steps))
    return hashlib.sha256(hashed).hexdigest()[:16]
