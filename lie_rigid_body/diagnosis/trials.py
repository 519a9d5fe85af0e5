"""Trials of repairs, and the rule that chooses from all of them those that name the mistakes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Final

import numpy as np

from lie_rigid_body.diagnosis.answers import Answer
from lie_rigid_body.diagnosis.repairs import HALVED, JOINT, ORDER, Repair, Repairs
from lie_rigid_body.evaluation.matched import Matched
from lie_rigid_body.foundation.short_dataclass import short_dataclass

MENDED: Final = 0.1
"""Largest share of the error that a repair may leave if the error stays above the floor."""
NEAR: Final = 2.0
"""Factor within which errors above the floor count as equal."""
UNCHANGED: Final = 1e-6
"""Change of the estimate, rad, below which a repair has no effect."""
ONE_ROTATION: Final = {"body_axes", "body_mounting"}
"""Codes of two rotations of the body, of the readings and of the estimate: together they are one, or none."""


@short_dataclass(eq=False)
class Trial:
    """Runs with one kind of gyro and with repairs, and the error that they leave.

    Attributes
    ----------
    repairs : tuple of Repair
    kind : str
        The kind of gyro.
    error : float
        RMS of the total error over the last two thirds of all runs, rad.
    parts : tuple of float
        RMS of the error of the vertical, and of that of the rotations, rad, where it is known. In the choice of pairs
        after the least that it leaves with one repair of the output. One repair of two may take away one of these.
    track : Matched or None
        The estimate on the first course, at those samples that are compared; none where the filter failed.
    unrepaired : sequence of Answer
        What the filter answers on each course where no reading is repaired; else none.
    """

    repairs: Repairs
    kind: str
    error: float
    parts: tuple[float, ...] = ()
    track: Matched | None = None
    unrepaired: Sequence[Answer] = ()

    def changes(self, other: Trial) -> bool:
        """Whether its estimate differs from that of another trial, or the filter failed in one of them."""
        return self.track is None or other.track is None or self.track.max_difference(other.track) > UNCHANGED

    @property
    def error_deg(self) -> float:
        """The error, degrees."""
        return math.degrees(self.error)

    @cached_property
    def mistakes(self) -> Repairs:
        """Repairs that name mistakes: all but `JOINT`."""
        return tuple(repair for repair in self.repairs if repair != JOINT)

    @cached_property
    def codes(self) -> tuple[str, ...]:
        """Codes of the mistakes."""
        return tuple(repair.code for repair in self.mistakes)

    @cached_property
    def rank(self) -> tuple[int, int, list[int]]:
        """Rank of the trial: number of repairs, price, places in the table. The least rank is named.

        A rotated world counts twice: half a turn about a level axis is a world with z down and a heading.
        """
        count = len(self.codes) + self.codes.count("world_turned")
        return count, sum(repair.price for repair in self.mistakes), sorted(map(ORDER.index, self.codes))


def plain(trials: Iterable[Trial]) -> Trial:
    """Trial without a repair, with the kind of gyro that the filter expects; `JOINT` does not count as a repair."""
    return min((t for t in trials if not t.codes), key=lambda t: t.error)


def choose(trials: Sequence[Trial], floor: float, mended: float = MENDED) -> list[Trial]:
    """Trials that mend the error: first the one that is named, then others of as many repairs that do as well.

    Parameters
    ----------
    trials : sequence of Trial
        Trials that include those without a repair, and each repair of a pair alone.
    floor : float
        The error below which all count as equal, rad.
    mended : float, optional
        Share of the error that a repair may leave above the floor.
    """
    before = plain(trials).error

    def is_enough(error: float, before: float) -> bool:
        return error <= max(mended * before, min(floor, HALVED * before))

    def earns(trial: Trial) -> bool:
        """Whether each repair of a trial halves the error at least, unless both leave less than the floor."""
        if len(trial.mistakes) < 2:
            return True
        first = min(alone(trials, repair) for repair in trial.mistakes)
        is_halved = first <= HALVED * before or trial.error <= floor
        return is_halved and is_enough(trial.error, first) and not ONE_ROTATION.issubset(trial.codes)

    mending = [t for t in trials if before > floor and t.codes and is_enough(t.error, before) and earns(t)]
    best = min((t.error for t in mending), default=0.0)
    as_good = [t for t in mending if t.error <= (floor if best <= floor else NEAR * best)]
    as_good.sort(key=lambda t: (t.rank, t.error))
    return as_good[:1] + [
        t for t in as_good[1:] if len(t.codes) == len(as_good[0].codes) and t.codes != as_good[0].codes
    ]


def alone(trials: Iterable[Trial], repair: Repair) -> float:
    """Least error that a repair leaves by itself; its constants may differ, as they are fitted."""
    same = [t for t in trials if t.codes == (repair.code,) and (repair.price or t.mistakes[0].text == repair.text)]
    return min((t.error for t in same), default=np.pi)


def most_promising(trials: Sequence[Trial]) -> list[Trial]:
    """Order trials by their best rank in any error: with a repair of the output, of the vertical, of the rotations."""
    errors = np.array([trial.parts for trial in trials])
    places = np.argsort(np.argsort(errors, axis=0, kind="stable"), axis=0).min(axis=1)
    return [trials[number] for number in np.argsort(places, kind="stable")]
