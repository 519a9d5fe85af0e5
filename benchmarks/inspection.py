"""How often ``inspect`` names what is wrong with a log: its confusion over healthy and wrong ones.

    python benchmarks/inspection.py [--data FOLDER] [--quick] [--only KIND...]
    python benchmarks/inspection.py --round-trip N

Logs are made by ``simulate``, of every shipped scenario and grade, and read from FOLDER, whose ``.npz`` files have the
arrays ``gyro``, rad/s, ``specific_force``, m/s², ``magnetic_field``, µT, ``movement`` and ``sampling_rate``. One
mistake after the other is put into each.

``--round-trip`` estimates the parameters of the sensors of N simulated logs, each with a rest and eight kicks, and
prints the share of the errors that are within two standard errors; of 100 logs 95 % are meant to be.

- right: the mistake is named, with its repair, and nothing else;
- or_else: it is, and others do as well;
- within: another one is named, and the mistake is among those that do as well;
- undecided: nothing is named, and the mistake is listed as undecided;
- nothing: nothing is said of it;
- wrong: something else is named.

The last line has the share of right, or_else and within among the cases that the logs decide. A log decides a mistake
unless it lists it as undecided: by the rule another explanation of as few repairs is then not excluded, or what was put
in is less than what the log shows. At least 95 % are meant to be named, and none wrongly.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import product
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from lie_rigid_body import Run, simulate
from lie_rigid_body.evaluation.attitudes import SIGNED_PERMUTATIONS, named
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.inspection import Inspection, LogMistake, inspect
from lie_rigid_body.inspection.rule import MIN_TAKEN_OFF
from lie_rigid_body.runs import SensorArrays
from lie_rigid_body.scenario.parameter_file import scenario_files
from lie_rigid_body.sensors.parameters import GRADES, PERFECT

DURATION_S = 100.0
GRAVITY = 9.80665
DELAY_S = 0.012
"""Largest error of a delay, s; or a tenth of it."""
FACTOR = 0.05
"""Largest relative error of a factor."""
IRON_T = 7e-6
"""Largest error of the hard iron, T; or two standard errors that are told with it."""
CLASSES = ("right", "or_else", "within", "undecided", "nothing", "wrong")


@dataclass(frozen=True)
class Log:
    """Readings of one log."""

    name: str
    seed: int
    t_ns: np.ndarray
    gyro: np.ndarray
    force: np.ndarray
    field_ns: np.ndarray
    field: np.ndarray
    up: np.ndarray

    def run(self) -> Run:
        """The log as a run, whose truth is not its own."""
        template = _template()
        imu = dict.fromkeys(template.imu.arrays)
        imu.update(gyro=self.gyro, specific_force=self.force)
        sensors = {
            "imu": SensorArrays(self.t_ns, self.t_ns, imu),
            "magnetometer": SensorArrays(self.field_ns, self.field_ns, {"field": self.field}),
        }
        return replace(template, sensors=sensors)


@lru_cache
def _template() -> Run:
    return simulate("hand", duration=0.1)


@lru_cache(4)
def _healthy(log_key: int) -> Inspection:
    return inspect(_LOGS[log_key].run())


_LOGS: dict[int, Log] = {}


def healthy(log: Log) -> Inspection:
    _LOGS[id(log)] = log
    return _healthy(id(log))


Judge = Callable[[LogMistake], bool]


@dataclass(frozen=True)
class Case:
    """A log with what is wrong with it."""

    kind: str
    log: Log
    code: str = ""
    is_right: Judge = lambda mistake: True
    iron: np.ndarray | None = None


def axes(log: Log, sensor: str, array: str) -> Case:
    """Axes at random, but for the bare sign of a vector."""
    draw = np.random.default_rng(log.seed)
    matrix = SIGNED_PERMUTATIONS[1 + draw.integers(47)]
    if sensor != "gyro":
        matrix = matrix * np.linalg.det(matrix)
        if np.trace(matrix) == 3.0:
            matrix = SIGNED_PERMUTATIONS[9] * np.linalg.det(SIGNED_PERMUTATIONS[9])
    text = named(matrix).replace(",", "")
    changed = replace(log, **{array: getattr(log, array) @ matrix})
    return Case(
        f"{sensor} axes", changed, f"{sensor}_axes", lambda mistake: mistake.repair == text or text in mistake.message
    )


def late(log: Log, delay_s: float) -> Case:
    own = [float(np.sum(note.value)) for note in healthy(log).notes if note.code == "magnetometer_late"]
    expected = delay_s + (own[0] if own else 0.0)

    def is_right(mistake: LogMistake) -> bool:
        found = -float(mistake.repair.split()[0])
        return abs(found - expected) <= max(DELAY_S, 0.1 * delay_s)

    moved = replace(log, field_ns=log.field_ns + round(delay_s * 1e9))
    return Case(f"magnetometer {delay_s * 1e3:.0f} ms late", moved, "magnetometer_late", is_right)


def without_gravity(log: Log) -> Case:
    return Case("gravity removed", replace(log, force=log.force - GRAVITY * log.up), "gravity_removed")


def mean_removed(log: Log) -> Case:
    """The mean taken off, which is no mistake where the body turned so evenly that there is next to none."""
    mean = log.force.mean(axis=0)
    code = "gravity_removed" if np.linalg.norm(mean) > MIN_TAKEN_OFF * GRAVITY else ""
    return Case("mean removed", replace(log, force=log.force - mean), code)


def iron(log: Log) -> Case:
    direction = np.random.default_rng(log.seed).normal(size=3)
    offset = 30e-6 * direction / np.linalg.norm(direction)
    own = healthy(log).sensors.get("magnetometer_hard_iron")
    expected = offset + (np.array(own.value) if own else 0.0)
    return Case("hard iron of 30 µT", replace(log, field=log.field + offset), "hard_iron", iron=expected)


def zeros(log: Log) -> Case:
    t_ns = log.t_ns.copy()
    t_ns[len(t_ns) // 3 : len(t_ns) // 3 + 200] = 0
    return Case("zeros in the stamps", replace(log, t_ns=t_ns), "stamps")


def factor_near(wanted: float) -> Judge:
    return lambda mistake: abs(float(mistake.repair.split()[1]) / wanted - 1.0) < FACTOR


KINDS: dict[str, Callable[[Log], Case]] = {
    "healthy": lambda log: Case("healthy", log),
    "gyro axes": lambda log: axes(log, "gyro", "gyro"),
    "accelerometer axes": lambda log: axes(log, "accelerometer", "force"),
    "magnetometer axes": lambda log: axes(log, "magnetometer", "field"),
    "gyro in degrees": lambda log: Case("gyro in degrees", replace(log, gyro=np.degrees(log.gyro)), "gyro_units"),
    "gyro halved": lambda log: Case("gyro halved", replace(log, gyro=log.gyro / 2.0), "time_step", factor_near(2.0)),
    "accelerometer in g": lambda log: Case(
        "accelerometer in g", replace(log, force=log.force / GRAVITY), "accelerometer_units", factor_near(GRAVITY)
    ),
    "magnetometer 50 ms late": lambda log: late(log, 0.05),
    "magnetometer 100 ms late": lambda log: late(log, 0.1),
    "magnetometer 200 ms late": lambda log: late(log, 0.2),
    "gravity removed": without_gravity,
    "mean removed": mean_removed,
    "hard iron of 30 µT": iron,
    "zeros in the stamps": zeros,
}


def judged(case: Case, found: Inspection) -> str:
    """Class of what is said of a case."""
    if case.iron is not None:
        return judged_iron(case, found)
    if not case.code:
        return "wrong" if found.mistakes else "right"
    if not found.mistakes:
        return "undecided" if case.code in {each.code for each in found.undecided} else "nothing"
    if len(found.mistakes) > 1:
        return "wrong"
    mistake = found.mistakes[0]
    if mistake.code == case.code:
        return ("or_else" if mistake.or_else else "right") if case.is_right(mistake) else "wrong"
    return "within" if case.code in mistake.or_else else "wrong"


def judged_iron(case: Case, found: Inspection) -> str:
    notes = [np.array(note.value) for note in found.notes if note.code == "hard_iron"]
    is_open = "hard_iron" in {each.code for each in found.undecided}
    if found.mistakes:
        return "wrong"
    if not notes:
        return "undecided" if is_open or "magnetometer_axes" in {each.code for each in found.undecided} else "nothing"
    errors = found.sensors["magnetometer_hard_iron"].standard_error
    if np.linalg.norm(notes[0] - case.iron) <= max(IRON_T, 2.0 * float(np.linalg.norm(errors))):
        return "right"
    return "undecided" if is_open else "wrong"


def upward(attitude_xyzw: np.ndarray) -> np.ndarray:
    """The world's z on the body's axes."""
    return Rotation.from_quat(attitude_xyzw).inv().apply([0.0, 0.0, 1.0])


def recordings(folder: Path) -> Iterator[Log]:
    for seed, path in enumerate(sorted(folder.glob("*.npz"))):
        data = {name: array.astype(np.float64) for name, array in np.load(path).items()}
        rate = float(data["sampling_rate"])
        begin = int(np.flatnonzero(data["movement"])[0])
        rows = slice(begin, begin + int(DURATION_S * rate))
        t_ns = np.round(np.arange(len(data["gyro"]))[rows] / rate * 1e9).astype(np.int64)
        attitude = data["attitude_wxyz"][rows][:, [1, 2, 3, 0]]
        known = np.isfinite(attitude).all(axis=1)
        up = upward(attitude[known])
        up = np.stack([np.interp(t_ns, t_ns[known], axis) for axis in up.T], axis=1)
        field = data["magnetic_field"][rows] * 1e-6
        yield Log(path.stem, seed, t_ns, data["gyro"][rows], data["specific_force"][rows], t_ns, field, up)


def simulated(name: str, grade: str, seed: int) -> Log:
    run = simulate(
        name,
        duration=DURATION_S,
        sensor_grade=grade,
        sensor_seed=seed,
        imu_rate=100.0,
        magnetometer_rate=50.0,
        accelerometer_mode="pivot_gravity",
        gyro_range=0.0,  # a range that is reached is a mistake of the log
        accelerometer_range=0.0,
        magnetometer_range=0.0,
    )
    if run.scenario.translation == "thrown":
        raise LieRigidBodyError(f"{name} is left out: it falls freely, and reads no gravity")
    imu, magnetometer = run.imu, run.sensors["magnetometer"]
    kept = imu.t_ns <= run.t_ns[-1]
    t_ns = imu.t_ns[kept]
    up = upward(run.attitude().at(t_ns))
    readings = imu.gyro[kept], imu.specific_force[kept]
    return Log(f"{name}, {grade}", seed, t_ns, *readings, magnetometer.t_ns, magnetometer.field, up)


def logs(folder: Path | None) -> Iterator[tuple[str, Callable[[], Log]]]:
    """Logs by their sources, each made when it is asked for."""
    if folder is not None:
        for log in recordings(folder):
            yield "recordings", partial(replace, log)
    for seed, (name, grade) in enumerate(
        product(sorted(scenario_files()), [PERFECT, *(g for g in GRADES if g != PERFECT)])
    ):
        yield "simulated", partial(simulated, name, grade, seed)


Table = defaultdict[tuple[str, str], Counter[str]]


def measure(options: argparse.Namespace, table: Table, seconds: list[float]) -> None:
    """Judge each mistake in each log, and count."""
    count = 0
    for index, (source, make) in enumerate(logs(options.data)):
        if options.source not in (None, source) or index % options.part[1] != options.part[0]:
            continue
        log = None
        for kind in options.only:
            count += 1
            if options.quick and count % 10:
                continue
            try:
                log = make() if log is None else log
            except LieRigidBodyError as error:
                print(f"{source} {index}: {error}", file=sys.stderr)
                break
            case = KINDS[kind](log)
            begin = perf_counter()
            found = inspect(case.log.run())
            seconds.append(perf_counter() - begin)
            verdict = judged(case, found)
            table[source, kind][verdict] += 1
            if verdict not in ("right", "or_else"):
                said = "; ".join(f"{each.code} {each.repair} {each.or_else or ''}" for each in found.mistakes)
                asked = ", ".join(each.code for each in found.undecided)
                print(f"{verdict}: {log.name}, {kind}: {said} undecided: {asked}", flush=True)


def errors_in_sigmas(seed: int) -> dict[str, list[float]]:
    """Errors of what is estimated of a simulated log, in standard errors, by the parameters' names."""
    draws = np.random.default_rng(seed)
    directions = draws.normal(size=(8, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rates = directions * draws.uniform(0.6, 1.5, (8, 1))
    soft_iron = np.eye(3) + draws.uniform(-0.05, 0.05, (3, 3))
    true: dict[str, Any] = {
        "gyro_noise_density": 10.0 ** draws.uniform(-4.3, -3.0),
        "gyro_bias_random_walk": 10.0 ** draws.uniform(-6.0, -4.0),
        "gyro_turn_on_bias": 10.0 ** draws.uniform(-4.0, -2.0),
        "gyro_resolution": 10.0 ** draws.uniform(-5.0, -3.5),
        "accelerometer_noise_density": 10.0 ** draws.uniform(-3.3, -2.0),
        "magnetometer_noise_density": 10.0 ** draws.uniform(-8.0, -7.0),
        "magnetometer_hard_iron": draws.uniform(-30e-6, 30e-6, 3),
        "magnetometer_soft_iron": (3.0 / np.trace(soft_iron) * soft_iron).ravel(),
        "magnetometer_clock_offset": float(draws.choice([0.0, 0.06])),
    }
    run = simulate(
        duration=80.0,
        initial_body_rate=[0.0, 0.0, 0.0],
        kicks=np.column_stack([40.0 + 5.0 * np.arange(8), rates]).ravel(),
        translation="carried",
        sway_acceleration=[0.3, 0.3, 0.3],
        imu_rate=100.0,
        magnetometer_rate=50.0,
        sensor_seed=seed,
        **true,
    )
    found = inspect(run).sensors
    assert (found["imu_rate"].value, found["magnetometer_rate"].value) == (100.0, 50.0)
    assert np.isclose(found["gyro_resolution"].value, true["gyro_resolution"], rtol=1e-6)
    true["gyro_bias"] = run.imu.gyro_bias[run.imu.t_s < 40.0].mean(axis=0)
    return {
        name: np.atleast_1d((np.array(each.value) - true[name]) / np.array(each.standard_error)).tolist()
        for name, each in found.items()
        if name in true and np.any(each.standard_error)
    }


def round_trip(count: int) -> None:
    """Print the share of the errors within two standard errors, of each parameter and of all."""
    table: dict[str, list[float]] = defaultdict(list)
    for seed in range(count):
        for name, errors in errors_in_sigmas(seed).items():
            table[name] += errors
    every = [error for errors in table.values() for error in errors]
    for name, errors in {**table, "all": every}.items():
        print(f"{name:32} {len(errors):6} numbers, {np.mean(np.abs(errors) < 2.0):6.1%} within two standard errors")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, metavar="FOLDER", help="recordings")
    parser.add_argument("--round-trip", type=int, metavar="N", help="parameters of N simulated logs, and nothing else")
    parser.add_argument("--quick", action="store_true", help="a tenth of it")
    parser.add_argument(
        "--part", type=int, nargs=2, metavar=("I", "N"), default=(0, 1), help="the Ith of N parts of the logs"
    )
    parser.add_argument("--source", choices=("recordings", "simulated"))
    parser.add_argument("--only", nargs="+", choices=KINDS, default=list(KINDS), metavar="KIND")
    options = parser.parse_args()
    if options.round_trip:
        round_trip(options.round_trip)
        return 0
    table: Table = defaultdict(Counter)
    seconds: list[float] = []
    with suppress(KeyboardInterrupt):  # what was done by then is shown
        measure(options, table, seconds)
    print(f"{'':40}" + "".join(f"{name:>11}" for name in CLASSES))
    for (source, kind), counts in table.items():
        print(f"{source + ', ' + kind:40}" + "".join(f"{counts[name]:>11}" for name in CLASSES))
    every = sum(table.values(), Counter())
    print(f"{'all ' + str(every.total()):40}" + "".join(f"{every[name]:>11}" for name in CLASSES))
    print(f"{np.median(seconds):.2f} s a log, {max(seconds):.2f} s at most")
    decided = every.total() - every["undecided"]
    named = every["right"] + every["or_else"] + every["within"]
    print(f"{decided} cases that the logs decide, {named / max(decided, 1):.1%} of them named; {every['wrong']} wrong")
    return 0


if __name__ == "__main__":
    sys.exit(main())
