"""An engine judged: its order, errors and drifts in each case, and the mistakes that they show."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from math import inf
from typing import Any, Final, Literal, TypeAlias

import numpy as np

from lie_rigid_body.conformance.cases import CASES
from lie_rigid_body.conformance.mistakes import suspects
from lie_rigid_body.conformance.results import MAX_DIFFERENCE, MAX_REMAINS, STEPS, CaseResults, Simulate, difference
from lie_rigid_body.foundation.arrays import Array, shaped
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import counted, shown
from lie_rigid_body.lie import quaternion

Judged: TypeAlias = "float | Literal['not judged']"
NOT_JUDGED: Final = "not judged"
"""Word for a number below the precision of the results."""
MAX_ORDER: Final = 1.5
"""Orders below this one are the first."""
MIN_DRIFT: Final = 0.01
"""Smallest change of the energy at the smallest step that is told, though it vanishes with the step."""
MIN_GROWTH: Final = 1.5
"""Smallest quotient of the logarithms of energy in the last and second quarter: 2.3 of damping, 1 of wrong units."""
MAX_SHARE_OFF: Final = 0.25
"""Largest distance of the rate of a step's rotation from that at an end, as a share of the rate's change in the step.
It is then nearer to the end than to the middle."""
_UNEXPLAINED: Final = "results do not converge, or to a motion neither exact nor of a known mistake"
_HEADER: Final = ("case", "order", "error, rad", "energy drift", "momentum drift", "precision")


@short_dataclass
class EngineRow:
    """An engine in a case. What is below the precision of its results is ``"not judged"``.

    Attributes
    ----------
    case : str
    order : float or str
        Order of attitude and rate.
    error_rad : float or str
        Largest error of the attitude at the smallest step, rad; infinite where the engine diverges.
    energy_drift, momentum_drift : float or str
        Change from start to end at the smallest step: of the energy, with its sign, and of the momentum in the world's
        axes, each as a share.
    precision : float
        Of the results: 1e-16 of doubles, 1e-8 to 1e-7 of single precision.
    """

    case: str
    order: Judged
    error_rad: Judged
    energy_drift: Judged
    momentum_drift: Judged
    precision: float


@short_dataclass
class EngineMistake:
    """A mistake of an engine, or a note.

    Attributes
    ----------
    code, message : str
    cases : tuple of str
        Names of the cases that show it.
    """

    code: str
    message: str
    cases: tuple[str, ...]


@short_dataclass
class Conformance:
    """Result of `judge`.

    Attributes
    ----------
    rows : tuple of EngineRow
    mistakes : tuple of EngineMistake
    notes : tuple of EngineMistake
        No mistakes: a low order, and drifts that vanish with the step.
    """

    rows: tuple[EngineRow, ...]
    mistakes: tuple[EngineMistake, ...]
    notes: tuple[EngineMistake, ...]

    def to_dict(self) -> dict[str, Any]:
        """Everything as numbers, text and lists."""
        return asdict(self)

    def __str__(self) -> str:
        """A table of the rows, and a line for each mistake and note."""
        rows = [_HEADER, *(asdict(row).values() for row in self.rows)]
        table = ["".join(f"{_cell(value):18}" for value in row).rstrip() for row in rows]
        for kind, found in (("mistake", self.mistakes), ("note", self.notes)):
            table += [f"{kind}: {each.code}: {each.message} ({counted(len(each.cases), 'case')})" for each in found]
        return "\n".join(table + ["no mistake found"] * (not self.mistakes))


def _cell(value: object) -> str:
    return f"{value:.2g}" if isinstance(value, float) else str(value)


def judge(simulate: Simulate, steps: Sequence[int] | None = None) -> Conformance:
    """Judge an engine by the free motions of `CASES`.

    Parameters
    ----------
    simulate : callable
        ``simulate(case, step)`` returns times, s, shape (N,), attitudes, shape (N, 4), and body rates, rad/s, shape (N,
        3), after every step until ``case.duration``. The start may be returned as well.
    steps : sequence of 3 int, optional
        Numbers of steps in a period, each the same whole multiple of the one before; 20, 40, 80 if not given.

    Returns
    -------
    Conformance

    Raises
    ------
    InputError
        If the steps are no such numbers, or the engine does not return a state for every step.
    """
    given = shaped("steps", STEPS if steps is None else steps, (3,)).tolist()
    first = max(1.0, given[0] // 1)
    ratio = max(2.0, given[1] // first)
    if given != [first, first * ratio, first * ratio * ratio]:
        raise ParameterError("steps", f"{shown(steps)} are no three such numbers: give for example (20, 40, 80)")
    found = [CaseResults(simulate, case, int(first), int(ratio)) for case in CASES]
    grows = 2 * sum(each.order < 0.0 for each in found) > len(found)  # as the step falls
    wrong = [each for each in found if each.remains(each.truth) > MAX_REMAINS]
    stray = found if grows else wrong
    energies = [_Energy(each) for each in found if each.judged]
    stay = [each for each in energies if each.stays]
    mistakes = (
        tuple(_wrong_motions(wrong))
        or (*_drifts(stay, ", and not less with a smaller step"), *_clamped(energies))
        or tuple(_low_order(found, "attitude_order"))
        or (EngineMistake("unexplained", _UNEXPLAINED, tuple(each.case.name for each in stray)),) * bool(stray)
    )
    drifting = [each for each in energies if abs(each.fine) > max(MIN_DRIFT, each.floor) and not mistakes]
    notes = (*_drifts(drifting, ""), *_low_order(found, "first_order"))
    return Conformance(tuple(map(_row, found)), mistakes, notes)


def _row(found: CaseResults) -> EngineRow:
    here = slice(1, max(2, int(np.sum(found.floor < MAX_DIFFERENCE))))
    errors = np.linalg.norm(difference(found.truth, found.common[-1], found.speed)[:, :3], axis=1)
    momenta = np.linalg.norm(found.momentum - found.momentum[0], axis=1)
    error, energy, momentum = (
        _above(values[here], found.floor[here]) for values in (errors, found.energy[-1], momenta)
    )
    return EngineRow(
        found.case.name, found.order if found.order < inf else NOT_JUDGED, error, energy, momentum, found.precision
    )


def _above(values: Array, floor: Array) -> Judged:
    """The largest of values that are above a floor, with its sign; infinite where one is not finite."""
    if not np.isfinite(values).all():
        return inf
    clear = values[np.abs(values) > floor]
    return float(clear[np.argmax(np.abs(clear))]) if clear.size else NOT_JUDGED


def _wrong_motions(wrong: Sequence[CaseResults]) -> Iterator[EngineMistake]:
    """The mistake to whose motion an engine converges in most cases in which it is wrong, and in two at least."""
    fitting: defaultdict[tuple[str, str], dict[str, None]] = defaultdict(dict)
    for each in wrong:
        for told, motion in suspects(each.case, each.t_s):
            if each.remains(motion) <= MAX_REMAINS:
                fitting[told][each.case.name] = None
    named, names = max(fitting.items(), key=lambda item: len(item[1]), default=(("", ""), {}))
    if 2 * len(names) > max(2, sum(each.judged > 0 for each in wrong)):
        yield EngineMistake(*named, tuple(names))


class _Energy:
    """Energy of an engine in the last quarter of the instants that are judged, as a change since the start."""

    def __init__(self, found: CaseResults) -> None:
        self.found = found
        _, second, _, last = np.array_split(found.energy[:, : found.judged], 4, axis=1)
        coarse, middle, fine = last.mean(axis=1)
        added, unknown = found.at_step_0(coarse - middle, middle - fine)
        self.floor = 2.0 * found.floor[found.judged - 1]
        self.fine = fine
        """Change at the smallest step."""
        self.a_period = fine * found.case.period / found.t_s[7 * found.judged // 8]
        limit = abs(fine + added)
        falls = limit <= MAX_REMAINS * (abs(unknown) + self.floor) and abs(fine) < abs(middle)
        grows = fine * (fine + 1.0 - (second[2].mean() + 1.0) ** MIN_GROWTH) > 0.0
        self.stays = min(limit, abs(middle)) > MIN_DRIFT and grows and not falls
        """Whether it grows with time, and does not vanish with the step."""


def _drifts(energies: Sequence[_Energy], how: str) -> Iterator[EngineMistake]:
    """Damping or growth: what energies tell that change alike in all cases."""
    changes = np.array([each.a_period for each in energies])
    if len(changes) > 1 and len(set(np.sign(changes))) == 1:
        code, what = ("energy_grows", "added") if changes[0] > 0.0 else ("damped", "lost")
        message = f"at the smallest step {np.median(np.abs(changes)):.1%} of the energy is {what} in a period{how}"
        yield EngineMistake(code, message, tuple(each.found.case.name for each in energies))


def _clamped(energies: Sequence[_Energy]) -> Iterator[EngineMistake]:
    """A norm of the momentum that is held while its direction drifts, and an energy that runs to L²/2I₂."""
    sides = {each.found.case.name: _side(each) for each in energies}
    names = tuple(name for name, side in sides.items() if side)
    if {-1.0, 1.0} <= {*sides.values()} and 2 * len(names) > len(energies):
        what = "the norm of the momentum is held, and the energy runs to that of a spin about the intermediate axis"
        yield EngineMistake("toward_intermediate", what, names)


def _side(energy: _Energy) -> float:
    """Sign of the change of an energy that runs to L²/2I₂, while the norm of the momentum alone is held; else 0."""
    found = energy.found
    here = slice(1, found.judged)
    floor = MAX_REMAINS * found.floor[here]
    is_held = np.all(np.abs(np.linalg.norm(found.momentum[here], axis=1) - 1.0) < floor)
    is_drifting = np.any(np.linalg.norm(found.momentum[here] - found.momentum[0], axis=1) > floor)
    p = found.case.inertia @ found.case.body_rate
    way = p @ p / (found.case.principal_moments[1] * (found.case.body_rate @ p)) - 1.0
    is_running = way * energy.fine > 0.0 and abs(energy.fine) > MAX_REMAINS * energy.floor
    return float(np.sign(way)) if is_held and is_drifting and is_running else 0.0


def _low_order(found: Iterable[CaseResults], code: str) -> Iterator[EngineMistake]:
    """Errors of first order in most cases, and which rate of a step the attitude takes.

    As ``attitude_order`` it is told where the attitude takes the rate of one end, and rates are of a higher order.
    """
    known = [each for each in found if each.order < inf]
    low = [each for each in known if 0.0 < each.order < MAX_ORDER]
    if code == "attitude_order":
        low = [each for each in known if _end(each) and each.orders[1] > MAX_ORDER]
    if 2 * len(low) > len(known):
        end = statistics.mode(map(_end, low))
        how = f"the attitude is advanced with the rate that is returned {end} the step: " * bool(end)
        yield EngineMistake(code, f"{how}errors fall no faster than the step", tuple(each.case.name for each in low))


def _end(found: CaseResults) -> str:
    """The end of a step whose rate the attitude takes: before or after it; empty where it is neither.

    The rate of the rotation of a step, log(qₙ⁻¹ qₙ₊₁)/h, is then nearer to it than by a share of the rate's change.
    """
    step, q, rate = found.tracks[-1]
    here = slice((found.judged - 1) * found.ratio**2)
    turned = quaternion.log(quaternion.multiply(quaternion.conjugate(q[:-1]), q[1:])) / step
    ends = {"before": rate[:-1], "after": rate[1:]}
    near = MAX_SHARE_OFF * np.linalg.norm((ends["after"] - ends["before"])[here])
    return next((end for end, taken in ends.items() if np.linalg.norm((turned - taken)[here]) < near), "")
