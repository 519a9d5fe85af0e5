"""How sharp ``diagnose`` is, in the environment of the league (``scripts/environment.sh league``).

    python benchmarks/diagnosis.py separation   for every pair of repairs, what taking one for the other leaves
    python benchmarks/diagnosis.py healthy      what is said of the filters of the league as they are
    python benchmarks/diagnosis.py mistakes     each mistake put into each filter that is right with perfect sensors
    python benchmarks/diagnosis.py cases --folder FOLDER    filters of a folder, beside what is wrong with them

``--filters NAME...`` chooses filters whose names contain one of them, ``--mistakes NAME...`` mistakes.

The mode ``cases`` needs no environment of its own. It diagnoses each public function of FOLDER's modules that can be
called with one argument, ``run``. A file ``expected.yaml`` in FOLDER says what is wrong with each, by the function's
name: the codes of its mistakes, or of probes and notes that show it, or an empty list where nothing may be named.
Without that file what is said is printed, and not judged::

    fusion: []
    fusion_radians: [gyro_units]
    slow_bias: [gyro_bias]

- right: each mistake that is named is in the list, and the list is empty or one is named; or a failed probe or a note;
- or_else: each is, or may be replaced by one that is;
- wrong: one that is named is neither;
- symptom: nothing is named, but a probe fails, or a sentence says where the filter is right;
- nothing: nothing is said.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from importlib import import_module
from inspect import Parameter, isfunction, signature
from pathlib import Path
from time import perf_counter
from types import SimpleNamespace
from typing import Any, Final

import numpy as np
import yaml
from scipy.spatial.transform import Rotation
from tqdm import tqdm

from league.contender import Filter, filters
from league.readings import Readings
from lie_rigid_body.diagnosis import FilterDiagnosis, diagnose
from lie_rigid_body.diagnosis.answers import Answer, Job
from lie_rigid_body.diagnosis.course import courses_of
from lie_rigid_body.diagnosis.examination import MAX_RUNS
from lie_rigid_body.diagnosis.repairs import SENSOR_READINGS, Repair, exact_repairs, factor, late
from lie_rigid_body.diagnosis.search import Search
from lie_rigid_body.diagnosis.trials import plain
from lie_rigid_body.estimates.estimators import each_alone
from lie_rigid_body.evaluation.causes import CAUSES
from lie_rigid_body.foundation.errors import FilterError, LieRigidBodyError
from lie_rigid_body.lie import quaternion

sys.path.append(str(Path(__file__).parents[1] / "test" / "diagnosis"))
import textbook

Array = np.ndarray[Any, Any]
Estimate = Callable[[Any], tuple[Array, Array]]


@dataclass(frozen=True)
class Put:
    """A mistake put into a filter: what is done to its readings, by name, and to its stamps and estimate.

    Attributes
    ----------
    name : str
    codes : tuple of str
        The codes that tell it, one for each mistake in it.
    readings : mapping of str to callable
    output : callable
    on_body_axes : bool
        Whether the gyro is turned from the world's axes to the body's by the truth, for a filter that turns about the
        world's.
    """

    name: str
    codes: tuple[str, ...]
    readings: Mapping[str, Callable[[Array], Array]] = field(default_factory=dict)
    output: Callable[[Array, Array], tuple[Array, Array]] = lambda t_ns, q: (t_ns, q)
    on_body_axes: bool = False

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
            sensors = {"imu": imu, "magnetometer": field}
            return self.output(*estimate(SimpleNamespace(**sensors, sensors=sensors, scenario=run.scenario)))

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


def _of_attitude(change: Callable[[Array], Array]) -> Callable[[Array, Array], tuple[Array, Array]]:
    return lambda t_ns, q: (t_ns, change(q))


def _euler(q: Array) -> Array:
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
    yield Put("turn on the wrong side", ("gyro_world_axes",), on_body_axes=True)
    yield Put("accelerometer in g", ("accelerometer_units",), {"specific_force": _times(1.0 / 9.80665)})
    yield Put("magnetometer in µT", ("magnetometer_units",), {"field": _times(1e6)})
    frd = _axes(0, 1, 2, signs=(1, -1, -1))
    yield Put("all axes x -y -z", ("body_axes",), dict.fromkeys(sensors.values(), frd))
    first = _of_attitude(lambda q: np.roll(q, 1, axis=1))
    ned = np.pi * np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    for name, code, output in (
        ("inverted", "inverted", _of_attitude(lambda q: q * [-1, -1, -1, 1])),
        ("scalar first", "scalar_first", first),
        ("NED world", "ned_world", _of_attitude(_turned(left=ned))),
        ("Euler order", "euler_order", _of_attitude(_euler)),
        ("declination", "heading_offset", _of_attitude(_turned(left=(0.0, 0.0, 0.07)))),
        ("world turned", "world_turned", _of_attitude(_turned(left=(0.3, -0.2, 0.5)))),
        ("mounting", "body_mounting", _of_attitude(_turned(right=(0.2, 0.1, -0.3)))),
        ("output 5 samples late", "lagging", _of_attitude(_late(5))),
        ("output 5 samples early", "leading", lambda t_ns, q: (t_ns[:-5], q[5:])),
        ("clock 3 % fast", "clock_rate", lambda t_ns, q: (np.round(1.03 * t_ns).astype(np.int64), q)),
    ):
        yield Put(name, (code,), {}, output)
    z = _axes(0, 1, 2, signs=(1, 1, -1))
    yield Put(
        "gyro in degrees, magnetometer z negated",
        ("gyro_units", "magnetometer_axes"),
        {"gyro": np.degrees, "field": z},
    )
    two = {"specific_force": _times(-1.0), "field": _axes(1, 0, 2)}
    yield Put("accelerometer negated, magnetometer swapped", ("accelerometer_axes", "magnetometer_axes"), two)
    yield Put("gyro swapped, scalar first", ("gyro_axes", "scalar_first"), {"gyro": _axes(1, 0, 2)}, first)


MISTAKES: Final = tuple(_mistakes())


def of_textbook(given: Readings) -> Rotation:
    """Mahony's filter with the gyro's step first, as the tests have it."""
    imu = SimpleNamespace(t_ns=given.t_ns, gyro=given.gyro, specific_force=given.acc)
    scenario = SimpleNamespace(parameters=lambda: {"magnetic_field": given.field})
    run = SimpleNamespace(imu=imu, magnetometer=SimpleNamespace(field=given.mag), scenario=scenario)
    return Rotation.from_quat(textbook.mahony(run))


def contenders() -> tuple[Filter, ...]:
    """The filters of the league, and one of a textbook."""
    return (*filters(), Filter("textbook", "Mahony", of_textbook))


def estimator(number: int) -> Estimate:
    """A filter at its defaults, as a function of a run."""
    each = contenders()[number]

    def estimate(run: Any) -> tuple[Array, Array]:
        np.random.seed(1)  # noqa: NPY002 - what filters draw from
        given = Readings.of(run)
        return given.t_ns, np.asarray(each.estimate(given).as_quat())

    return estimate


class Watched:
    """A search in this process, for a filter that may have a mistake put into it."""

    def __init__(self, estimate: Estimate, put: Put | None = None) -> None:
        self._estimate, self._put = put.into(estimate) if put else estimate, put
        self.search = Search(self._each, courses_of({}), MAX_RUNS)

    def _each(self, jobs: Sequence[Job]) -> Iterator[Answer | FilterError]:
        last = (BODY_AXES,) if self._put and self._put.on_body_axes else ()
        return each_alone(self._estimate, [replace(job, repairs=(*job.repairs, *last)) for job in jobs])

    def is_right(self) -> bool:
        """Whether the filter errs by less than the floor without a repair."""
        return plain(list(self.search.fully([()]))).error <= self.search.floor


def _on_body_axes(readings: Any) -> Any:
    back = quaternion.conjugate(readings.course.at(readings.t_ns))
    return readings.changed(lambda gyro: quaternion.rotate(back, gyro), "gyro")


BODY_AXES: Final = Repair("put", "gyro on the body's axes", change=_on_body_axes)


def named(number: int, mistake: int) -> tuple[int, int, str, str]:
    """What is named of a mistake in a filter, without probes: ``named``, ``other`` or ``nothing``, and what.

    A mistake of a sensor that only the first answer hears is ``first answer``: a repair that changes that is not named.

    Of two mistakes one may have no effect, as one of the gyro in a filter that does not use it. Then the other alone,
    whose repair leaves less than the floor, is all that there is to name.
    """
    put = MISTAKES[mistake]
    watched = Watched(estimator(number), put)
    if watched.is_right():
        return number, mistake, "no effect", ""
    watched.search.run()
    found = watched.search.choice()
    told = any(
        sorted(set(trial.codes) - {"gyro_scale"}) == sorted(put.codes)
        or (set(trial.codes) < set(put.codes) and trial.error <= watched.search.floor)
        for trial in found
    )
    deaf = {SENSOR_READINGS[sensor] for sensor in watched.search.deaf}
    if put.readings and {*put.readings} <= deaf and not told:  # what is left is a constant turn of the world
        return number, mistake, "first answer", f"{watched.search.runs} runs"
    if not found:
        return number, mistake, "nothing", f"{watched.search.runs} runs"
    what = f"{' + '.join(found[0].codes)}, {np.degrees(found[0].error):.2g}°, {watched.search.runs} runs"
    return number, mistake, "named" if told else "other", what


def is_right(number: int) -> bool:
    """Whether a filter errs by less than the floor with perfect sensors, perhaps ahead by a sample."""
    try:
        return Watched(estimator(number)).is_right()
    except LieRigidBodyError:
        return False


def healthy(number: int) -> tuple[int, str]:
    """What is said of a filter as it is."""
    try:
        found = diagnose(estimator(number))
    except Exception as error:
        return number, f"failed: {error}"
    mistakes = [m.code for m in found.mistakes]
    failed = [f"{p.code} ({p.message})" for p in found.failed]
    return number, f"{found.rms_deg:.2g}° mistakes {mistakes} failed {failed} notes {[n.code for n in found.notes]}"


def separation() -> None:
    """Print, for every pair of repairs of which at least one is of the input, what taking one for the other leaves.

    The filter is TRIAD beside a gyro (BasicVQF). One repair is put into it, undone by its inverse where the other is
    not tried; the other, and each of the output's, is then the repair. Of each pair of codes the least is printed.
    """
    number = next(i for i, each in enumerate(contenders()) if each.name == "BasicVQF")
    watched = Watched(estimator(number))
    course = replace(courses_of({})[0], moving_s=4.0)
    repairs = [repair for repair in exact_repairs() if not repair.code.endswith("_units")]
    repairs += [repair for repair in exact_repairs() if repair.code == "gyro_units" and "degrees a" in repair.fact]
    repairs += [late(sensor, count) for sensor in SENSOR_READINGS for count in (-4, -1, 1, 4)]
    repairs += [factor(value) for value in (0.9, 1.1)]
    least: dict[tuple[str, str], float] = {}
    codes = list(dict.fromkeys(repair.code for repair in repairs))
    puts = [next(r for r in repairs if r.code == code and r.text in TYPICAL.get(code, (r.text,))) for code in codes]
    for put in puts:
        asked = [((repair, put), (course,)) for repair in repairs if repair.code != put.code]
        for trials in watched.search.tried(asked):
            key = put.code, trials[0].repairs[0].code
            least[key] = min(least.get(key, np.pi), trials[0].error)
        ((alone, *undone),) = watched.search.tried([((put,), (course,))], CAUSES)
        for trial in undone:
            least[put.code, trial.codes[-1]] = trial.error
        least[put.code, "nothing"] = alone.error
    columns = [*codes, *(cause.code for cause in CAUSES), "nothing"]
    print("| put in | " + " | ".join(columns) + " |\n|" + " --- |" * (len(columns) + 1))
    for row in codes:
        cells = [f"{np.degrees(least[row, column]):.2f}" if (row, column) in least else "" for column in columns]
        print(f"| {row} | " + " | ".join(cells) + " |")


def functions_of(folder: Path) -> list[str]:
    """Public functions of the modules of a folder that can be called with a run alone, as ``module:function``."""
    sys.path.insert(0, str(folder))
    os.environ["PYTHONPATH"] = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    return [
        f"{path.stem}:{name}"
        for path in sorted(folder.glob("*.py"))
        for name, each in vars(import_module(path.stem)).items()
        if isfunction(each) and each.__module__ == path.stem and not name.startswith("_") and _takes_a_run(each)
    ]


def _takes_a_run(function: Callable[..., Any]) -> bool:
    """Whether a function can be called with one argument, ``run``."""
    parameters = list(signature(function).parameters.values())
    return [each.name for each in parameters if each.default is Parameter.empty] == ["run"]


def verdict(found: FilterDiagnosis, expected: Collection[str]) -> str:
    """Verdict of a case: right, or_else, wrong, symptom or nothing."""
    named = [mistake for mistake in found.mistakes if mistake.code not in expected]
    if named:
        return "or_else" if all({*mistake.or_else} & {*expected} for mistake in named) else "wrong"
    shown = {probe.code for probe in found.failed} | {note.code for note in found.notes}
    if found.mistakes or not expected or shown & {*expected}:
        return "right"
    return "symptom" if found.failed or found.first else "nothing"


def cases(folder: Path, words: Sequence[str]) -> None:
    """Print a row for each function of a folder, and how many of each verdict there are."""
    table = folder / "expected.yaml"
    expected = yaml.safe_load(table.read_text(encoding="utf-8")) if table.is_file() else {}
    names = functions_of(folder)
    counts: Counter[str] = Counter()
    print("| function | verdict | expected | named, or else | failed probes | notes | error | runs | updates | s |")
    print("|" + " --- |" * 10)
    for number in _chosen(names, words):
        name = names[number]
        function = name.partition(":")[2]
        if expected and function not in expected:
            continue
        begun = perf_counter()
        try:
            found = diagnose(name)
        except LieRigidBodyError as error:
            print(f"| {function} | not run: {error} |" + " |" * 8, flush=True)
            continue
        told = verdict(found, expected[function]) if expected else ""
        counts[told] += 1
        named = (
            f"{each.code} {each.repair}" + f" ({', '.join(each.or_else)})" * bool(each.or_else)
            for each in found.mistakes
        )
        row = (
            told,
            ", ".join(expected.get(function, ())),
            "; ".join(named),
            ", ".join(each.code for each in found.failed),
            ", ".join(each.code for each in found.notes),
            f"{found.rms_deg:.2g}°",
            str(found.filter_runs),
            str(found.updates),
            f"{perf_counter() - begun:.0f}",
        )
        print(f"| {function} | " + " | ".join(row) + " |", flush=True)
    if expected:
        print(
            "\n" + ", ".join(f"{counts[each]} {each}" for each in ("right", "or_else", "wrong", "symptom", "nothing"))
        )


TYPICAL: Final = {
    **{f"{sensor}_axes": ("y x z",) for sensor in SENSOR_READINGS},
    "body_axes": ("y z x",),
    **{f"{sensor}_late": ("4 samples later",) for sensor in SENSOR_READINGS},
}
"""The repair of each code that is put in, where it has several."""


def _chosen(names: Iterable[str], words: Sequence[str]) -> list[int]:
    """The numbers of the names in which one of some words is."""
    return [i for i, name in enumerate(names) if any(word.lower() in name.lower() for word in words)]


def main() -> None:
    """Print the tables that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("separation", "healthy", "mistakes", "cases"))
    parser.add_argument("--folder", type=Path, help="of the mode cases")
    parser.add_argument("--filters", nargs="+", default=[""])
    parser.add_argument("--mistakes", nargs="+", default=[""])
    given = parser.parse_args()
    if given.what == "cases":
        if given.folder is None:
            parser.error("cases needs --folder")
        cases(given.folder.resolve(), given.filters)
        return
    numbers = _chosen((each.full_name for each in contenders()), given.filters)
    if given.what == "separation":
        separation()
        return
    with ProcessPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        if given.what == "healthy":
            for number, said in pool.map(healthy, numbers):
                print(f"{contenders()[number].full_name}: {said}", flush=True)
            return
        right = [number for number, good in zip(numbers, pool.map(is_right, numbers), strict=True) if good]
        chosen = _chosen((put.name for put in MISTAKES), given.mistakes)
        jobs = [(number, mistake) for number in right for mistake in chosen]
        found = []
        for number, mistake, outcome, what in tqdm(
            pool.map(named, *zip(*jobs, strict=True)), total=len(jobs), disable=None
        ):
            found.append((number, mistake, outcome, what))
            print(f"{contenders()[number].full_name}: {MISTAKES[mistake].name}: {outcome} {what}", flush=True)
    print("\nright with perfect sensors: " + ", ".join(contenders()[number].full_name for number in right))
    print(
        "\n| filter | named | something else | nothing | first answer alone | no effect |\n"
        "| --- | --- | --- | --- | --- | --- |"
    )
    for number in right:
        count = Counter(outcome for n, _, outcome, _ in found if n == number)
        print(
            f"| {contenders()[number].full_name} | {count['named']} | {count['other']} | {count['nothing']} | "
            f"{count['first answer']} | {count['no effect']} |"
        )


if __name__ == "__main__":
    main()
