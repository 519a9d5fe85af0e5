"""The cases: motions, grades of sensors, and faults, each a parameter file that the package ships."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from league.readings import Readings
from lie_rigid_body import Run, simulate
from lie_rigid_body.scenario.parameter_file import CONFIG, gather

FOLDER: Final[Path] = CONFIG / "league"
MOTIONS: Final = ("slow_tumble", "fast_tumble", "spin_x", "spin_y", "spin_z", "flips", "precession")
GRADES: Final = ("perfect", "navigation", "tactical", "mems")
FAULTS: Final = tuple(sorted(path.stem.removeprefix("fault_") for path in FOLDER.glob("fault_*.yaml")))
DURATION: Final = 60.0
"""Length of a run, s."""
SETTLED: Final = 30.0
"""Errors count from here on, s: filters begin without knowing the attitude."""
SEED: Final = 1
TUNING_SEEDS: Final = (1001, 1002)
"""Noise of the runs on which settings are chosen: others than those that are scored."""


@dataclass(frozen=True)
class Case:
    """A motion read by sensors of a grade, perhaps with a fault.

    Attributes
    ----------
    motion, grade, fault : str
        No fault is ''.
    """

    motion: str
    grade: str
    fault: str = ""

    @property
    def name(self) -> str:
        """For tables."""
        return f"{self.motion} {self.grade}" + f" {self.fault}" * bool(self.fault)


def cases() -> tuple[Case, ...]:
    """Every motion with every grade, and a slow tumble of MEMS sensors with each fault."""
    clean = [Case(motion, grade) for grade in GRADES for motion in MOTIONS]
    return (*clean, *(Case("slow_tumble", "mems", fault) for fault in FAULTS))


@lru_cache(maxsize=4)
def run_of(case: Case, seed: int) -> tuple[Run, Readings]:
    """The run of a case, and what filters are given of it."""
    files = [FOLDER / "sensors.yaml", FOLDER / f"{case.motion}.yaml"]
    if case.fault:
        files.append(FOLDER / f"fault_{case.fault}.yaml")
    parameters: dict[str, Any] = {**gather(None, files, []), "sensor_grade": case.grade, "sensor_seed": seed}
    run = simulate(duration=DURATION, **parameters)
    return run, Readings.of(run)
