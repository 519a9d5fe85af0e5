"""Remarks on an estimate that hold whatever convention its attitudes are in: on its series, and on its turns.

The turns of an estimate are wrong if they vanish, go to and fro, are too fast, or are about other axes. The turn from
one sample to the next, on the estimate's own body axes, is compared with that of the truth. The latter is multiplied by
a scale, and its axes are permuted and reversed. A gyro in deg/s, one axis of wrong sign or a left-handed frame leave
attitudes that no constant rotation explains. Such a map explains their turns to a few percent.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.evaluation.attitudes import (
    GAP_PERIODS,
    SIGNED_PERMUTATIONS,
    Truth,
    angles_between,
    named,
    period_ns,
    relative_rotations,
    times,
)
from lie_rigid_body.evaluation.causes import FEIGNED
from lie_rigid_body.evaluation.clock import CLOCK_RATIO
from lie_rigid_body.evaluation.matched import MIN_SAMPLES, SAMPLES, Matched, spread
from lie_rigid_body.evaluation.statistics import MIN_LIMIT
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers, runs_of
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm

GAP_OF_EVEN: Final = 1.5
"""Least distance of two stamps that is a gap, in median periods, where stamps are even: one missing sample stands
out."""
UNEVEN: Final = 0.1
"""Limit of even stamps: of the relative difference of a period from the median, and of the share of periods beyond
that."""
NOT_UNIT: Final = 0.002
"""Largest | |q|² − 1 | that counts as unit norm, as of a quaternion written with three decimals. tf2 takes 0.01."""
ABSENT: Final = 0.05
"""Largest share of the truth's times by which a filter may begin late or end early without a remark."""
MIN_TURN: Final = 0.5
"""Least turn of the body in the whole run, rad, at which turns are compared."""
STUCK: Final = 0.01
"""Share of the body's turn below which an estimate counts as not turning."""
LONG: Final = 0.1
"""Least share of the run in which an estimate must be stuck for a finding, if it turns in other parts."""
JUMP: Final = 3.0
"""Least ratio of a jump to the body's turn in the same step, and to what a jump and the next one leave."""
MIN_MIXED: Final = 0.02
"""Least share of steps that are jumps from one of two attitudes to the other."""
MAX_MISS: Final = 0.2
"""Largest RMS difference, in median turns, between the turns of an estimate and those that a mistake predicts. Real
mistakes leave less."""
MIN_MISS: Final = 1e-3
"""Floor of the RMS difference between turns and a prediction, in median turns."""
CLEARLY: Final = 2.0
"""Ratio of the RMS differences of two predictions above which the larger one is not the mistake."""

DEGREE: Final = 180.0 / np.pi
SCALES: Final = {
    1.0: "",
    DEGREE: "its gyro is in deg/s where the filter wants rad/s",
    1.0 / DEGREE: "its gyro is in rad/s where the filter wants deg/s",
    2.0: "the rate of a quaternion is ½ q ω, or its time step is twice that of the gyro",
    0.5: "the rate of a quaternion is ½ q ω, once, or its time step is half that of the gyro",
}
"""Ratios of the turns of an estimate to those of the body, each with its cause."""


class Remark(NamedTuple):
    """Code and message of a mistake that has no repair by attitudes: undone, nothing would be left to compare."""

    code: str
    message: str


def of_series(stamps: Integers, first: Booleans, given_xyzw: Array, truth: Truth) -> Iterator[Remark]:
    """Remarks on stamps, shape (N,), of which those count that come first, and on attitudes as they were given.

    Gaps are looked for in each smooth motion of the truth.
    """
    begin = stamps[0]
    doubles = stamps[~first]
    kept = stamps[first]
    if doubles.size:
        yield Remark(
            "gaps",
            f"{doubles.size} of {len(stamps)} samples are doubles, of a stamp that another sample had before, first at "
            f"{(doubles[0] - begin) / 1e9:g} s; only the first of a stamp counts: let one publisher write the topic.",
        )
    steps = np.diff(kept)
    period = truth.periods_ns(kept)
    uneven = np.count_nonzero(np.abs(steps - period) > UNEVEN * period)
    wide = np.flatnonzero(steps > (GAP_OF_EVEN if uneven <= UNEVEN * len(steps) else GAP_PERIODS) * period)
    if wide.size:
        longest = wide[np.argmax(steps[wide])]
        yield Remark(
            "gaps",
            f"{wide.size} {'gap' if wide.size == 1 else 'gaps'} in the estimate, the longest of "
            f"{steps[longest] / 1e9:g} s after {(kept[longest] - begin) / 1e9:g} s, where samples come every "
            f"{period[longest] / 1e9:g} s: what the filter did there is not in the score; look for lost messages.",
        )
    norms = quaternion.norm(given_xyzw)
    off = (norms < np.sqrt(1.0 - NOT_UNIT)) | (norms > np.sqrt(1.0 + NOT_UNIT))  # the square of a large norm overflows
    if off.any():
        yield Remark(
            "not_unit",
            f"{np.count_nonzero(off)} of {len(norms)} quaternions are not of unit norm, the worst has "
            f"{norms[np.argmax(np.abs(norms - 1.0))]:.4g}; they were divided by it here, and tf2 refuses 0.005 more or "
            "less: let the filter normalise what it publishes.",
        )


def of_span(stamps: Integers, known: Booleans, truth: Truth, due_ns: int | None) -> Iterator[Remark]:
    """Remarks on the parts of the truth's times that an estimate leaves out at either end, or exceeds.

    Estimates that are due longer than the truth goes on are absent too: in lock-step both end where a filter dies.
    ``known`` tells of each stamp, shape (N,), whether the truth is known there.
    """
    last_ns = max(truth.last_ns, truth.last_ns if due_ns is None else due_ns)
    inside = stamps[(stamps >= truth.first_ns) & (stamps <= last_ns)]
    most = max(ABSENT * (last_ns - truth.first_ns), GAP_PERIODS * period_ns(inside))
    absent = {
        "begins {:g} s after the truth": inside[0] - truth.first_ns,
        "ends {:g} s before the run does": last_ns - inside[-1],
    }
    for what, missing in absent.items():
        if missing > most:
            yield Remark(
                "gaps", f"The estimate {what.format(missing / 1e9)}: that part of the run is not in the score."
            )
    outside = np.count_nonzero(~known)
    if outside > ABSENT * len(known):
        yield Remark(
            "gaps",
            f"{outside} of {len(known)} estimates lie where the truth is not known and are not in the score: "
            "compare with the truth of the same run, by the same clock and without gaps.",
        )


def of_truth(uncertainty_deg: float, rms_deg: float) -> Iterator[Remark]:
    """Remark that the truth between its samples is uncertain beside an error."""
    if uncertainty_deg > max(0.25 * rms_deg, MIN_LIMIT):
        yield Remark(
            "gaps",
            f"Samples of the truth are so far apart that it is uncertain by {uncertainty_deg:.2g}° between them, "
            f"beside an error of {rms_deg:.2g}° rms: give the truth at a higher rate, or its scenario.",
        )


class Turns:
    """Turns of an estimate and of the body from each sample to the next, those across gaps left out.

    Parameters
    ----------
    track : Matched
        Samples within the truth's times.
    """

    def __init__(self, track: Matched) -> None:
        stamps = track.stamps_ns
        q = track.attitude_xyzw
        self.stamps_ns = stamps
        self.estimate_xyzw = q
        self.truth_xyzw = track.truth_xyzw
        self.first = np.flatnonzero(np.diff(stamps) <= GAP_PERIODS * period_ns(stamps))
        self.ours, self.true = (
            relative_rotations(each[self.first], each[self.first + 1]) for each in (q, track.truth_xyzw)
        )
        self.ours_rad = norm(self.ours)
        self.true_rad = norm(self.true)

    def stuck(self) -> Remark | None:
        """Finding that the estimate does not turn, in all or for long, while the body does."""
        still = (self.ours_rad < STUCK * self.true_rad) | (self.ours_rad.sum() < STUCK * self.true_rad.sum())
        begins, ends = runs_of(0, still)
        if not len(begins):
            return None
        k = np.argmax(ends - begins)
        every = slice(begins[k], ends[k] + 1)
        t_s = (self.stamps_ns - self.stamps_ns[0]) / 1e9
        since = t_s[self.first[begins[k]]]
        until = t_s[self.first[ends[k]] + 1]
        turned, turn = (round(math.degrees(one[every].sum()), 6) for one in (self.ours_rad, self.true_rad))
        is_long = until - since >= LONG * t_s[-1] and until >= t_s[-1] / 4.0  # in a quarter of a run a filter may begin
        if not is_long or len(self.first[every]) < MIN_SAMPLES or turn < np.degrees(MIN_TURN):
            return None
        return Remark(
            "stuck",
            f"The estimate turns by {turned:.3g}° from {since:.4g} s to {until:.4g} s after its first stamp, the body "
            f"by {turn:.4g}°: see whether the filter gets its readings, and publishes what it makes of them.",
        )

    def mixed(self) -> Remark | None:
        """Finding that the samples of the estimate belong to two attitudes in turns.

        A jump leads from one of them to the other, and the next one leads back. So from the sample before a jump to
        the one after the next jump the estimate rotates as far as the body.
        """
        jumps = self.ours_rad > np.maximum(MIN_TURN, JUMP * self.true_rad)
        if np.count_nonzero(jumps) <= max(MIN_SAMPLES, MIN_MIXED * len(jumps)):
            return None
        jump = np.median(self.ours_rad[jumps])
        at = self.first[jumps]
        ours, true = (angles_between(q[at[:-1]], q[at[1:] + 1]) for q in (self.estimate_xyzw, self.truth_xyzw))
        if np.percentile(np.abs(ours - true), 90) * JUMP > jump:
            return None
        return Remark(
            "mixed",
            f"The estimate jumps by {np.degrees(jump):.3g}° and back, {np.count_nonzero(jumps)} times: its samples are "
            "of two attitudes in turns, as of two bodies, or of two filters, on one topic: give those of one.",
        )

    def other(self) -> Remark | None:
        """Finding that the estimate turns as the body would at another rate, or about other axes."""
        few = spread(len(self.first), SAMPLES)
        ours = self.ours[few]
        true = self.true[few]
        if len(self.first) < MIN_SAMPLES or self.true_rad.sum() < MIN_TURN:
            return None
        missed = _missed(
            ours, np.stack([scale * np.einsum("aij,nj->ani", SIGNED_PERMUTATIONS, true) for scale in SCALES])
        )
        most = CLEARLY * max(missed.min(), MIN_MISS)
        if missed.min() > MAX_MISS:  # about the axes of the body perhaps, at any other rate
            scale = float(np.sum(ours * true) / np.sum(true**2))
            is_rate = max(scale, 1.0 / max(scale, 1e-300)) > CLOCK_RATIO and _missed(ours, scale * true) <= MAX_MISS
            return _turn_rate(scale) if is_rate else None
        fitting = [(list(SCALES)[i], int(axes)) for i, axes in np.argwhere(missed <= most)]
        if len({scale for scale, _ in fitting}) != 1:
            return None
        scale, axes = fitting[0]
        if axes == 0:  # also where the motion does not tell it from others
            return None if scale == 1.0 else _turn_rate(scale)
        if len(fitting) > 1:
            return None
        mirrored = ", which are right-handed; these are not" if np.linalg.det(SIGNED_PERMUTATIONS[axes]) < 0.0 else ""
        return Remark(
            "turn_axes",
            f"The estimate turns about x, y, z as the body does about {named(SIGNED_PERMUTATIONS[axes])}"
            f"{f', {times(scale)} the body' if scale != 1.0 else ''}: give the filter its gyro on the "
            f"axes of the body{mirrored}; {FEIGNED}.",
        )


def _turn_rate(scale: float) -> Remark:
    remedy = SCALES.get(scale, "see the time step of the filter, and the unit of its gyro")
    return Remark("turn_rate", f"The estimate turns {times(scale)} the body: {remedy}; {FEIGNED}.")


def _missed(ours: Array, predicted: Array) -> Array:
    """RMS difference between turns (n, 3) and predictions (..., n, 3), in median turns, at most two.

    An RMS, unlike a median, also counts axes about which the body turns for a short time only, as in a flip.
    """
    missed = angles_between(quaternion.exp(predicted), quaternion.exp(ours))
    turned = max(np.median(norm(ours)), 1e-300)
    return np.sqrt(np.mean(np.minimum(missed / turned, 2.0) ** 2, axis=-1))
