"""How sharp ``diagnose`` is, in the environment of the league (``scripts/environment.sh league``).

    python benchmarks/diagnosis.py separation   for every pair of repairs, what taking one for the other leaves
    python benchmarks/diagnosis.py healthy      what is said of the filters of the league as they are
    python benchmarks/diagnosis.py mistakes     each mistake put into each filter that is right with perfect sensors

``--filters NAME`` chooses filters whose names contain it, ``--mistakes NAME`` mistakes.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
from tqdm import tqdm

from league.contender import filters
from league.readings import Readings
from lie_rigid_body.diagnosis.choice import FLOOR, plain_error
from lie_rigid_body.diagnosis.examination import MOST_RUNS, diagnose
from lie_rigid_body.diagnosis.filter import Filter
from lie_rigid_body.diagnosis.repairs import Repair, exact_repairs, late
from lie_rigid_body.diagnosis.search import Search, Try
from lie_rigid_body.diagnosis.trial import trials_of
from lie_rigid_body.diagnosis.workers import Alone
from lie_rigid_body.evaluation.causes import CAUSES
from lie_rigid_body.lie import quaternion

Array = np.ndarray[Any, Any]
Estimate = Callable[[Any], tuple[Array, Array]]


@dataclass(frozen=True)
class Put:
    """A mistake put into a filter: what is done to its readings, by name, and to its estimate.

    Attributes
    ----------
    name : str
    codes : tuple of str
        The codes that tell it, one for each mistake in it.
    readings : mapping of str to callable
    output : callable
    """

    name: str
    codes: tuple[str, ...]
    readings: Mapping[str, Callable[[Array], Array]]
    output: Callable[[Array], Array] = lambda q: q

    def into(self, estimate: Estimate) -> Estimate:
        """The filter with the mistake."""

        def wrong(run: Any) -> tuple[Array, Array]:
            changed = {
                "gyro": run.imu.gyro,
                "specific_force": run.imu.specific_force,
                "field": run.magnetometer.field,
            }
            changed = {name: self.readings.get(name, lambda v: v)(vectors) for name, vectors in changed.items()}
            imu = SimpleNamespace(t_ns=run.imu.t_ns, gyro=changed["gyro"], specific_force=changed["specific_force"])
            field = SimpleNamespace(t_ns=run.magnetometer.t_ns, field=changed["field"])
            t_ns, attitude = estimate(SimpleNamespace(imu=imu, magnetometer=field, scenario=run.scenario))
            return t_ns, self.output(attitude)

        return wrong


def _late(count: int) -> Callable[[Array], Array]:
    return lambda vectors: np.concatenate([vectors[:1]] * count + [vectors[:-count]])


def _axes(*columns: int, signs: Sequence[float] = (1.0, 1.0, 1.0)) -> Callable[[Array], Array]:
    return lambda vectors: vectors[:, list(columns)] * np.array(signs)


def _times(factor: float) -> Callable[[Array], Array]:
    return lambda vectors: vectors * factor


def _turned(
    left: Sequence[float] = (0.0, 0.0, 0.0), right: Sequence[float] = (0.0, 0.0, 0.0)
) -> Callable[[Array], Array]:
    L, R = quaternion.exp(np.array(left)), quaternion.exp(np.array(right))
    return lambda q: quaternion.multiply(quaternion.multiply(L, q), R)


def _euler(q: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_euler("XYZ", Rotation.from_quat(q).as_euler("ZYX")[:, ::-1]).as_quat())


def _mistakes() -> Iterator[Put]:
    sensors = {"gyro": "gyro", "accelerometer": "specific_force", "magnetometer": "field"}
    for sensor, name in sensors.items():
        yield Put(f"{sensor} negated", (f"{sensor}_axes",), {name: _times(-1.0)})
        yield Put(f"{sensor} x and y swapped", (f"{sensor}_axes",), {name: _axes(1, 0, 2)})
        yield Put(f"{sensor} z negated", (f"{sensor}_axes",), {name: _axes(0, 1, 2, signs=(1, 1, -1))})
        yield Put(f"{sensor} y z x", (f"{sensor}_axes",), {name: _axes(1, 2, 0)})
        yield Put(f"{sensor} 1 sample late", (f"{sensor}_late",), {name: _late(1)})
        yield Put(f"{sensor} 4 samples late", (f"{sensor}_late",), {name: _late(4)})
    yield Put("gyro in degrees", ("gyro_units",), {"gyro": np.degrees})
    yield Put("gyro taken for degrees", ("gyro_units",), {"gyro": np.radians})
    yield Put("step × 2", ("time_step",), {"gyro": _times(2.0)})
    yield Put("step × ½", ("time_step",), {"gyro": _times(0.5)})
    yield Put("step × 1.05", ("time_step",), {"gyro": _times(1.05)})
    frd = _axes(0, 1, 2, signs=(1, -1, -1))
    yield Put("all axes x -y -z", ("body_axes",), dict.fromkeys(sensors.values(), frd))
    yield Put("inverted", ("inverted",), {}, lambda q: q * [-1, -1, -1, 1])
    yield Put("scalar first", ("scalar_first",), {}, lambda q: np.roll(q, 1, axis=1))
    yield Put("NED world", ("ned_world",), {}, _turned(left=np.pi * np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)))
    yield Put("Euler order", ("euler_order",), {}, _euler)
    yield Put("declination", ("heading_offset",), {}, _turned(left=(0.0, 0.0, 0.07)))
    yield Put("world turned", ("world_turned",), {}, _turned(left=(0.3, -0.2, 0.5)))
    yield Put("mounting", ("body_mounting",), {}, _turned(right=(0.2, 0.1, -0.3)))
    yield Put("output 5 samples late", ("lagging",), {}, _late(5))
    two = {"gyro": np.degrees, "field": _axes(0, 1, 2, signs=(1, 1, -1))}
    yield Put("gyro in degrees, magnetometer z negated", ("gyro_units", "magnetometer_axes"), two)
    two = {"specific_force": _times(-1.0), "field": _axes(1, 0, 2)}
    yield Put("accelerometer negated, magnetometer swapped", ("accelerometer_axes", "magnetometer_axes"), two)
    yield Put(
        "gyro swapped, scalar first",
        ("gyro_axes", "scalar_first"),
        {"gyro": _axes(1, 0, 2)},
        lambda q: np.roll(q, 1, 1),
    )


MISTAKES: Final = tuple(_mistakes())


def estimator(number: int) -> Estimate:
    """A filter of the league at its defaults, as a function of a run."""
    each = filters()[number]

    def estimate(run: Any) -> tuple[Array, Array]:
        np.random.seed(1)  # noqa: NPY002 - what filters draw from
        given = Readings.of(run)
        return given.t_ns, np.asarray(each.estimate(given).as_quat())

    return estimate


def named(number: int, mistake: int) -> tuple[int, int, str, str]:
    """What is named of a mistake in a filter, without probes: ``named``, ``other`` or ``nothing``, and what."""
    trials, runs = trials_of({}), Counter[str]()
    floor = FLOOR * float(np.mean([trial.turn for trial in trials]))
    put = MISTAKES[mistake]
    crew = Alone(put.into(estimator(number)), lambda: runs.update(["all"]))
    search = Search(crew, trials, floor, lambda: runs["all"] < MOST_RUNS)
    search.plain()
    search.run()
    choice = search.choice()
    if choice is None:
        right = plain_error(search.found).error <= floor
        return number, mistake, "below the floor" if right else "nothing", ""
    alike = [choice.named, *choice.others]
    told = any(sorted(c.codes) == sorted(put.codes) for c in alike)
    return number, mistake, "named" if told else "other", " + ".join(choice.named.codes)


def is_right(number: int) -> bool:
    """Whether a filter errs by less than the floor with perfect sensors, perhaps ahead by a sample."""
    trials = trials_of({})
    floor = FLOOR * float(np.mean([trial.turn for trial in trials]))
    search = Search(Alone(estimator(number), lambda: None), trials, floor, lambda: False)
    try:
        search.plain()
    except Exception:
        return False
    return plain_error(search.found).error <= floor


def healthy(number: int) -> tuple[int, str]:
    """What is said of a filter as it is."""
    try:
        found = diagnose(estimator(number), max_runs=1)
    except Exception as error:
        return number, f"failed: {error}"
    mistakes = [m.code for m in found.mistakes]
    failed = [f"{p.code} ({p.message})" for p in found.probes if not p.passed]
    return number, f"{found.rms_deg:.2g}° mistakes {mistakes} failed {failed} notes {[n.code for n in found.notes]}"


def separation() -> None:
    """Print, for every repair, the one that leaves the least where it is taken for another."""
    trials = trials_of({})
    short = replace(trials[0], moving_s=4.0)
    number = next(i for i, each in enumerate(filters()) if each.name == "BasicVQF")
    run = Filter(estimator(number), lambda: None)
    puts = [repair for repair in exact_repairs() if repair.code != "body_axes"]
    puts += [late(sensor, count) for sensor in ("gyro", "accelerometer", "magnetometer") for count in (-1, -4)]
    rows = []
    for put in puts:
        left: list[tuple[float, str]] = []
        (found,) = Try((put,), (short,))(run) or [None]
        if found is None:
            continue
        for cause in CAUSES:
            tracks = [run.answer(short, (put,)).settled()]
            left.append((cause.fitted(tracks)[1], cause.code))
        rows.append((put.code, put.text, *min(left), found.error))
    print(
        "| put in | as | least of the output's repairs leaves | by | nothing leaves |\n| --- | --- | --- | --- | --- |"
    )
    for code in dict.fromkeys(row[0] for row in rows):
        row = min((row for row in rows if row[0] == code), key=lambda row: row[2])
        print(f"| {row[0]} | {row[1]} | {np.degrees(row[2]):.2f}° | {row[3]} | {np.degrees(row[4]):.1f}° |")
    _between_inputs(run, short, puts)


def _between_inputs(run: Filter, short: Any, puts: Sequence[Repair]) -> None:
    """What two repairs of the input leave together, put in as one and repaired as the other: the least of each pair."""
    few = [r for r in puts if r.text in ("y x z", "x y -z", "-x -y -z", "y z x", "gyro on the world's axes")]
    few += [r for r in puts if r.code == "time_step" or r.code.endswith("_late")]
    least: dict[tuple[str, str], float] = {}
    for put in few:
        for repair in few:
            if put is not repair:
                found = Try((put, repair), (short,))(run)
                key = (put.code, repair.code)
                if found and put.code != repair.code:
                    least[key] = min(least.get(key, np.pi), found[0].error)
    codes = list(dict.fromkeys(r.code for r in few))
    print("\n| put in, repaired as | " + " | ".join(codes) + " |\n|" + " --- |" * (len(codes) + 1))
    for a in codes:
        cells = [f"{np.degrees(least[a, b]):.2f}" if (a, b) in least else "" for b in codes]
        print(f"| {a} | " + " | ".join(cells) + " |")


def main() -> None:
    """Print the tables that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("separation", "healthy", "mistakes"))
    parser.add_argument("--filters", default="")
    parser.add_argument("--mistakes", default="")
    given = parser.parse_args()
    numbers = [i for i, each in enumerate(filters()) if given.filters.lower() in each.full_name.lower()]
    if given.what == "separation":
        separation()
        return
    with ProcessPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        if given.what == "healthy":
            for number, said in pool.map(healthy, numbers):
                print(f"{filters()[number].full_name}: {said}", flush=True)
            return
        right = [number for number, good in zip(numbers, pool.map(is_right, numbers), strict=True) if good]
        chosen = [i for i, put in enumerate(MISTAKES) if given.mistakes.lower() in put.name.lower()]
        jobs = [(number, mistake) for number in right for mistake in chosen]
        found = []
        for number, mistake, outcome, what in tqdm(
            pool.map(named, *zip(*jobs, strict=True)), total=len(jobs), disable=None
        ):
            found.append((number, mistake, outcome, what))
            if outcome != "named":
                print(f"{filters()[number].full_name}: {MISTAKES[mistake].name}: {outcome} {what}", flush=True)
    print("right with perfect sensors: " + ", ".join(filters()[number].full_name for number in right))
    print("\n| filter | named | something else | nothing | below the floor |\n| --- | --- | --- | --- | --- |")
    for number in right:
        count = Counter(outcome for n, _, outcome, _ in found if n == number)
        print(
            f"| {filters()[number].full_name} | {count['named']} | {count['other']} | {count['nothing']} | "
            f"{count['below the floor']} |"
        )


if __name__ == "__main__":
    main()
