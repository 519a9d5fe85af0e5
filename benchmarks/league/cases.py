"""The cases: motions, grades of sensors, and faults, each a parameter file that the package ships."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np

from league.readings import Readings
from lie_rigid_body import Run, simulate
from lie_rigid_body.evaluation import BiasNoise, UnavoidableError, VectorReadings, unavoidable_error
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
TUNING_SEED: Final = 1001
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
    parameters = {**gather(None, files, []), "sensor_grade": case.grade, "sensor_seed": seed}
    run = simulate(duration=DURATION, **parameters)
    return run, Readings.of(run)


def best_possible(case: Case) -> UnavoidableError | None:
    """What the declared noise leaves to any filter at best, if scale, mounting and iron had no errors; None if perfect.

    A filter that knows the hard iron's size is granted that: it bounds the magnetometer's constant error.
    """
    run, given = run_of(case, SEED)
    value = run.scenario.parameters()
    number = {name: float(entry) for name, entry in value.items() if isinstance(entry, int | float)}
    if case.grade == "perfect" or number["gyro_noise_density"] == 0.0:
        return None
    root = np.sqrt(given.rate)

    def walk(sensor: str) -> BiasNoise:
        return BiasNoise(number[f"{sensor}_turn_on_bias"], number[f"{sensor}_bias_random_walk"] / root)

    iron = float(np.max(np.abs(np.asarray(value["magnetometer_hard_iron"], dtype=float))))
    up = np.array([0.0, 0.0, 9.80665])
    gravity = VectorReadings(given.t_ns, up, number["accelerometer_noise_density"] * root, walk("accelerometer"))
    field = VectorReadings(given.t_ns, given.field, number["magnetometer_noise_density"] * root, BiasNoise(iron))
    return unavoidable_error(
        given.t_ns,
        run.attitude().at(given.t_ns),
        gyro_noise=number["gyro_noise_density"] * root,
        gyro_bias=walk("gyro"),
        vectors=[gravity, field],
    )
