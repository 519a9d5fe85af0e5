"""Whether units that mend a filter make it hear a sensor or silence it, as `diagnose` tells by a drift of the gyro.

    python benchmarks/silence.py            filters with a wrong sign or a gain too high, and right ones in other units
    python benchmarks/silence.py --league   other units put into the filters of the league (``environment.sh league``)

For each filter every repair of units is tried that leaves less than the floor in a course of 5 s. Its margin is by how
much a drift makes more without the sensor, in floors: above 1 the sensor is heard. Whether those that are heard mend
all courses is told beside.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from lie_rigid_body.diagnosis.course import courses_of
from lie_rigid_body.diagnosis.examination import MAX_RUNS
from lie_rigid_body.diagnosis.repairs import Repair, exact_repairs
from lie_rigid_body.diagnosis.search import Search
from lie_rigid_body.estimates.estimators import each_alone
from lie_rigid_body.foundation.errors import LieRigidBodyError

sys.path.append(str(Path(__file__).parents[1] / "test" / "diagnosis"))
import textbook

G: Final = 9.80665
FILTERS: Final[dict[str, Callable[..., Any]]] = {
    "proportional, gain 0.2": partial(textbook.proportional, gain=0.2),
    "proportional, gain 2": textbook.proportional,
    "proportional, gain 10": partial(textbook.proportional, gain=10.0),
    "Kalman": textbook.kalman,
    "Kalman, predicted Jacobian": partial(textbook.kalman, predicted=True),
}
WRONG: Final[dict[str, Callable[..., Any]]] = {
    "accelerometer's sign": lambda f: partial(f, signs=(-1.0, 1.0)),
    "magnetometer's sign": lambda f: partial(f, signs=(1.0, -1.0)),
    "both signs": lambda f: partial(f, signs=(-1.0, -1.0)),
    "signs of its corrections": lambda f: partial(f, step=-1.0),
    "corrections three times": lambda f: partial(f, step=3.0),
    "corrections forty times": lambda f: partial(f, step=40.0),
}
"""Mistakes that no unit explains."""
UNITS: Final = {
    "accelerometer in g": ("accelerometer_units", (1.0 / G, 1.0)),
    "accelerometer in m/s²": ("accelerometer_units", (G, 1.0)),
    "accelerometer in mg": ("accelerometer_units", (1e3 / G, 1.0)),
    "magnetometer in gauss": ("magnetometer_units", (1.0, 1e4)),
    "magnetometer in µT": ("magnetometer_units", (1.0, 1e6)),
    "magnetometer taken for µT": ("magnetometer_units", (1.0, 1e-6)),
}


def own() -> Iterator[tuple[str, str, Callable[[Any], Any]]]:
    """Filters by name, with the code of the units that are wrong in them, if any."""
    for kind, estimate in FILTERS.items():
        for name, put in WRONG.items():
            yield f"{kind}; {name}", "", put(estimate)
        for name, (code, units) in UNITS.items():
            yield f"{kind}; {name}", code, partial(estimate, units=units)


def of_the_league() -> Iterator[tuple[str, str, Callable[[Any], Any]]]:
    """The filters of the league with units put into them that they do not normalise."""
    from diagnosis import MISTAKES, contenders, estimator

    puts = [put for put in MISTAKES if len(put.codes) == 1 and put.codes[0].endswith("_units")]
    for number, each in enumerate(contenders()):
        for put in puts:
            yield f"{each.full_name}; {put.name}", put.codes[0], put.into(estimator(number))


def margins(estimate: Callable[[Any], Any]) -> tuple[float, dict[Repair, tuple[float, bool]]]:
    """Error in a short course, rad, and of each repair the margin and whether it mends all courses."""
    search = Search(partial(each_alone, estimate), courses_of({}), MAX_RUNS)
    ((plain,),) = search.tried([((), search.short)])
    found = {}
    for repair in exact_repairs() if plain.error > search.floor else ():
        sensor, _, what = repair.code.partition("_")
        if what != "units":
            continue
        ((trial,),) = search.tried([((repair,), search.short)])
        if trial.error <= search.floor:
            margin = search.drift_costs(sensor, (repair,))[0] / search.floor
            left = min(each.error for each in search.fully([(repair,)])) if margin > 1.0 else np.inf
            found[repair] = margin, left <= search.floor
    return plain.error, found


def main() -> None:
    """Print a row for each filter, and the margins of repairs where units are wrong, and where another thing is."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--league", action="store_true")
    all_found: dict[bool, list[tuple[float, bool]]] = {True: [], False: []}
    print("| filter | error | margins; * mends all courses |\n| --- | --- | --- |")
    for name, code, estimate in of_the_league() if parser.parse_args().league else own():
        try:
            error, found = margins(estimate)
        except LieRigidBodyError as raised:
            print(f"| {name} | {raised} | |", flush=True)
            continue
        for repair, margin in found.items():
            all_found[repair.code == code].append(margin)
        told = ", ".join(f"{r.code} {r.text}: {margin:.3g}{'*' * mends}" for r, (margin, mends) in found.items())
        print(f"| {name} | {np.degrees(error):.2g}° | {told} |", flush=True)
    for is_right, each in all_found.items():
        of_named = [margin for margin, mends in each if mends]
        print(f"{'units' if is_right else 'something else'} wrong: {len(each)} repairs, {len(of_named)} named", end="")
        print(f", least margin {min(of_named):.3g}" if of_named else "")


if __name__ == "__main__":
    main()
