"""Turns of an estimate beside those of the body: not at all, to and fro, too fast, or about other axes.

The turn of the estimate from one sample to the next, on its own body axes, is held against that of the truth. The
latter is taken times a scale, and with axes that change places and signs. A gyro in deg/s, one axis of wrong sign or a
left-handed frame leave attitudes that no constant rotation explains, and turns that this explains to a few percent.
"""

from __future__ import annotations

from itertools import permutations, product
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers, runs_of
from lie_rigid_body.evaluation.attitudes import angles_between, named, sizes, times, turns
from lie_rigid_body.evaluation.causes import FEIGNED
from lie_rigid_body.evaluation.clock import FAR
from lie_rigid_body.evaluation.estimate import GAP, Remark, period_ns
from lie_rigid_body.evaluation.explanations import FORMS, spread
from lie_rigid_body.lie import quaternion

STEPS: Final = 400
"""Largest number of steps that are compared."""
FEWEST_STEPS: Final = 20
LEAST_TURN: Final = 0.5
"""Least turn of the body in the whole run that tells anything, rad."""
STUCK: Final = 0.01
"""Share of the body's turn below which an estimate does not turn."""
LONG: Final = 0.1
"""Least share of the run in which an estimate is stuck to be told so, where it turns in others."""
JUMP: Final = 3.0
"""Least ratio of a step to that of the body, and to those within each of two attitudes, that is a jump."""
LEAST_MIXED: Final = 0.02
"""Least share of the steps that are jumps from one attitude to another."""
MOST_SORTED: Final = 4000
"""Largest number of samples that are sorted by the attitude that they belong to."""
LARGEST_MISS: Final = 0.2
"""Root mean square by which the turns may be missed, in median turns: mistakes of this kind leave less."""
SMALLEST_MISS: Final = 1e-3
"""Least root mean square by which the turns count as missed, in median turns."""
CLEARLY: Final = 2.0
"""Ratio of two misses above which the larger one is not the mistake."""

DEGREE: Final = 180.0 / np.pi
SCALES: Final = {
    1.0: "",
    DEGREE: "its gyro is in deg/s where the filter wants rad/s",
    1.0 / DEGREE: "its gyro is in rad/s where the filter wants deg/s",
    2.0: "the rate of a quaternion is ½ q ω, or its time step is twice that of the gyro",
    0.5: "the rate of a quaternion is ½ q ω, once, or its time step is half that of the gyro",
}
"""Ratios of the turns of an estimate to those of the body, each with its cause."""
OTHERWISE_WRITTEN: Final = tuple(form for form in FORMS if {"scalar_first", "inverted"} & set(form.codes))
"""Conventions that may feign other turns."""
AXES: Final = np.array(
    [np.diag(signs)[list(order)] for order in permutations(range(3)) for signs in product((1.0, -1.0), repeat=3)]
)
"""Matrices that change places and signs of axes, the first of which changes none: shape (48, 3, 3)."""


class Turns:
    """Turns of an estimate and of the body from each sample to the next, those across gaps left out.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    estimate_xyzw, true_xyzw : ndarray, shape (N, 4)
    """

    def __init__(self, stamps_ns: Integers, estimate_xyzw: Array, true_xyzw: Array) -> None:
        self.first = np.flatnonzero(np.diff(stamps_ns) <= GAP * period_ns(stamps_ns))
        self.stamps_ns, self.estimate_xyzw = stamps_ns, estimate_xyzw
        self.ours, self.true = (turns(q[self.first], q[self.first + 1]) for q in (estimate_xyzw, true_xyzw))
        self.ours_rad, self.true_rad = sizes(self.ours), sizes(self.true)

    def stuck(self) -> tuple[Remark, ...]:
        """Remark that the estimate does not turn, in all or for long, while the body does."""
        stamps, every, when = self.stamps_ns, slice(None), "in all"
        if self.ours_rad.sum() >= STUCK * self.true_rad.sum():
            begins, ends = runs_of(0, self.ours_rad < STUCK * self.true_rad)
            if not len(begins):
                return ()
            k = int(np.argmax(ends - begins))
            every = slice(begins[k], ends[k] + 1)
            since, until = ((stamps[j] - stamps[0]) / 1e9 for j in (self.first[begins[k]], self.first[ends[k]] + 1))
            when = f"from {since:.4g} s to {until:.4g} s after its first stamp"
            duration = (stamps[-1] - stamps[0]) / 1e9
            if until - since < LONG * duration or until < duration / 4.0:  # in which a filter may begin
                return ()
        turned, turn = (round(float(np.degrees(one[every].sum())), 6) for one in (self.ours_rad, self.true_rad))
        if len(self.first[every]) < FEWEST_STEPS or turn < np.degrees(LEAST_TURN):
            return ()
        message = (
            f"The estimate turns by {turned:.3g}° {when}, the body by {turn:.4g}°: "
            "see whether the filter gets its readings, and publishes what it makes of them."
        )
        return (Remark("stuck", message),)

    def mixed(self) -> tuple[Remark, ...]:
        """Remark that the samples of the estimate belong to two attitudes in turns.

        Each sample is of that attitude, of the two that came last, which is nearer.
        """
        q, jumps = self.estimate_xyzw, self.ours_rad > np.maximum(LEAST_TURN, JUMP * self.true_rad)
        if np.count_nonzero(jumps) < max(FEWEST_STEPS, LEAST_MIXED * len(jumps)):
            return ()
        first = int(self.first[np.argmax(jumps)])
        tracks = [first], [first + 1]
        for k in range(first + 2, min(first + MOST_SORTED, len(q))):
            near = [abs(float(q[k] @ q[track[-1]])) for track in tracks]
            tracks[near[1] > near[0]].append(k)
        switches = int(np.count_nonzero(np.diff(np.sort(tracks[0])) > 1))
        jump = float(np.median(self.ours_rad[jumps]))
        within = [angles_between(q[track[:-1]], q[track[1:]]) for track in tracks]
        if min(switches, *map(len, tracks)) < FEWEST_STEPS or max(np.percentile(a, 90) for a in within) * JUMP > jump:
            return ()
        message = (
            f"The estimate jumps by {np.degrees(jump):.3g}° and back, {np.count_nonzero(jumps)} times: its samples are "
            "of two attitudes in turns, as of two bodies, or of two filters, on one topic: give those of one."
        )
        return (Remark("mixed", message),)

    def other(self) -> tuple[Remark, ...]:
        """Remark that the turns are those of the body at another rate, or about other axes."""
        few = spread(len(self.first), STEPS)
        ours, true = self.ours[few], self.true[few]
        if len(self.first) < FEWEST_STEPS or self.true_rad.sum() < LEAST_TURN:
            return ()
        missed = _missed(ours, np.stack([scale * np.einsum("aij,nj->ani", AXES, true) for scale in SCALES]))
        most = CLEARLY * max(float(missed.min()), SMALLEST_MISS)
        if missed.min() > LARGEST_MISS:
            return _other_rate(ours, true)
        fitting = [(list(SCALES)[i], int(axes)) for i, axes in np.argwhere(missed <= most)]
        if len({scale for scale, _ in fitting}) != 1 or self._missed_by_conventions(few, true) <= most:
            return ()
        scale, axes = fitting[0]
        if axes == 0:  # also where the motion does not tell it from others
            message = f"The estimate turns {times(scale)} the body: {SCALES[scale]}; {FEIGNED}."
            return () if scale == 1.0 else (Remark("turn_rate", message),)
        if len(fitting) > 1:
            return ()
        mirrored = ", which are right-handed; these are not" if np.linalg.det(AXES[axes]) < 0.0 else ""
        message = (
            f"The estimate turns about x, y, z as the body does about {named(AXES[axes])}"
            f"{f', {times(scale)} the body' if scale != 1.0 else ''}: give the filter its gyro on the "
            f"axes of the body{mirrored}; {FEIGNED}."
        )
        return (Remark("turn_axes", message),)

    def _missed_by_conventions(self, few: Integers, true: Array) -> float:
        """Least miss of the turns by a convention."""
        first, q = self.first[few], self.estimate_xyzw
        written = [q @ form.matrix.T for form in OTHERWISE_WRITTEN]
        return min(float(_missed(turns(p[first], p[first + 1]), true)) for p in written)


def _other_rate(ours: Array, true: Array) -> tuple[Remark, ...]:
    """Remark that an estimate turns about the body's axes at any other rate, by turns of shape (n, 3)."""
    scale = float(np.sum(ours * true) / np.sum(true**2))
    if not max(scale, 1.0 / max(scale, 1e-300)) > FAR or _missed(ours, scale * true) > LARGEST_MISS:
        return ()
    remedy = "see the time step of the filter, and the unit of its gyro"
    return (Remark("turn_rate", f"The estimate turns {times(scale)} the body: {remedy}; {FEIGNED}."),)


def _missed(ours: Array, predicted: Array) -> Array:
    """Root mean square by which turns (n, 3) are missed by predictions (..., n, 3), in median turns, two at most.

    Axes about which the body turns for a short time only, as that of a flip, count by this, and not by a median.
    """
    missed = angles_between(quaternion.exp(predicted), quaternion.exp(ours))
    turned = max(float(np.median(sizes(ours))), 1e-300)
    return np.asarray(np.sqrt(np.mean(np.minimum(missed / turned, 2.0) ** 2, axis=-1)))
