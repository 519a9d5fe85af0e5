"""Turns of an estimate beside those of the body: not at all, to and fro, too fast, or about other axes.

The turn of the estimate from one sample to the next, on its own body axes, is held against that of the truth times a
scale and with axes that change places and signs. A gyro in deg/s, one axis of wrong sign or a left-handed frame leave
attitudes that no constant rotation explains, and turns that this explains to a few percent.
"""

from __future__ import annotations

from itertools import permutations, product
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers, runs_of
from lie_rigid_body.evaluation.attitudes import angles_between, sizes, turns
from lie_rigid_body.evaluation.clock import FAR
from lie_rigid_body.evaluation.estimate import GAP, Remark, period_ns
from lie_rigid_body.evaluation.naming import FORMS, spread
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
BY_A_CLOCK: Final = (2.0, 0.5)
"""Ratios of turns that another clock of an evenly turning body makes as well."""
WRITTEN: Final = tuple(form for form in FORMS if "ned_world" not in form.codes)
"""Conventions that change the turns; another world changes none, other body axes are a mounting."""
OTHERWISE_WRITTEN: Final = tuple(form for form in FORMS if {"scalar_first", "inverted"} & set(form.codes))
"""Conventions that may feign other turns without a mounting."""
AXES: Final = np.array(
    [np.diag(signs)[list(order)] for order in permutations(range(3)) for signs in product((1.0, -1.0), repeat=3)]
)
"""Matrices that change places and signs of axes, the first of which changes none: shape (48, 3, 3)."""


def stuck(stamps_ns: Integers, estimate_xyzw: Array, true_xyzw: Array) -> tuple[Remark, ...]:
    """Remark that an estimate does not turn, in all or for long, while the body does; arguments as in `turning`."""
    whole = _whole(stamps_ns)
    ours, true = (sizes(_steps(q, whole)) for q in (estimate_xyzw, true_xyzw))
    turned, turn, when = float(ours.sum()), float(true.sum()), "in all"
    if turned >= STUCK * turn:
        begins, ends = runs_of(0, ours < STUCK * true)
        if not len(begins):
            return ()
        k = int(np.argmax(ends - begins))
        longest = slice(begins[k], ends[k] + 1)
        whole, turned, turn = whole[longest], float(ours[longest].sum()), float(true[longest].sum())
        since, until = ((stamps_ns[k] - stamps_ns[0]) / 1e9 for k in (whole[0], whole[-1] + 1))
        when = f"from {since:.4g} s to {until:.4g} s after its first stamp"
        duration = (stamps_ns[-1] - stamps_ns[0]) / 1e9
        if until - since < LONG * duration or until < duration / 4.0:  # in which a filter may begin
            return ()
    if len(whole) < FEWEST_STEPS or turn < LEAST_TURN:
        return ()
    turned, turn = (round(float(np.degrees(angle)), 6) for angle in (turned, turn))
    message = (
        f"The estimate turns by {turned:.3g}° {when}, the body by {turn:.4g}°: "
        "see whether the filter gets its readings, and publishes what it makes of them."
    )
    return (Remark("stuck", message),)


def mixed(stamps_ns: Integers, estimate_xyzw: Array, true_xyzw: Array) -> tuple[Remark, ...]:
    """Remark that the samples of an estimate belong to two attitudes in turns; arguments as in `turning`.

    Each sample is of that attitude, of the two that came last, which is nearer.
    """
    whole = _whole(stamps_ns)
    ours, true = (sizes(_steps(q, whole)) for q in (estimate_xyzw, true_xyzw))
    jumps = ours > np.maximum(LEAST_TURN, JUMP * true)
    if np.count_nonzero(jumps) < max(FEWEST_STEPS, LEAST_MIXED * len(whole)):
        return ()
    first = int(whole[np.argmax(jumps)])
    tracks = [first], [first + 1]
    for k in range(first + 2, min(first + MOST_SORTED, len(stamps_ns))):
        near = [abs(float(estimate_xyzw[k] @ estimate_xyzw[track[-1]])) for track in tracks]
        tracks[near[1] > near[0]].append(k)
    switches = int(np.count_nonzero(np.diff(np.sort(tracks[0])) > 1))
    jump = float(np.median(ours[jumps]))
    if min(switches, *map(len, tracks)) < FEWEST_STEPS:
        return ()
    if any(JUMP * np.percentile(angles_between(q[:-1], q[1:]), 90) > jump for q in (estimate_xyzw[t] for t in tracks)):
        return ()
    message = (
        f"The estimate jumps by {np.degrees(jump):.3g}° and back, {np.count_nonzero(jumps)} times: its samples are of "
        "two attitudes in turns, as of two bodies, or of two filters, on one topic: give those of one."
    )
    return (Remark("mixed", message),)


def turning(stamps_ns: Integers, estimate_xyzw: Array, true_xyzw: Array, *, surely: bool = False) -> tuple[Remark, ...]:
    """Remark on turns of an estimate that are not those of the body.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    estimate_xyzw, true_xyzw : ndarray, shape (N, 4)
    surely : bool
        Only what neither a convention nor a constant rotation nor another clock may feign.

    Returns
    -------
    tuple of Remark
    """
    whole = _whole(stamps_ns)
    few = whole[spread(len(whole), STEPS)]
    ours, true = (_steps(q, few) for q in (estimate_xyzw, true_xyzw))
    if len(whole) < FEWEST_STEPS or sizes(_steps(true_xyzw, whole)).sum() < LEAST_TURN:
        return ()
    missed = _missed(ours, np.stack([scale * np.einsum("aij,nj->ani", AXES, true) for scale in SCALES]))
    most = CLEARLY * max(float(missed.min()), SMALLEST_MISS)
    if missed.min() > LARGEST_MISS:
        return () if surely else _other_rate(ours, true)
    fitting = [(list(SCALES)[i], int(axes)) for i, axes in np.argwhere(missed <= most)]
    if len({scale for scale, _ in fitting}) != 1 or (surely and fitting[0][0] in BY_A_CLOCK):
        return ()
    if _missed_by_conventions(estimate_xyzw, true_xyzw, few, mounted=surely) <= most:
        return ()
    scale, axes = fitting[0]
    times = _times(scale)
    if axes == 0:  # also where the motion does not tell it from others
        return () if scale == 1.0 else (Remark("turn_rate", f"The estimate turns {times}: {SCALES[scale]}."),)
    if len(fitting) > 1:
        return ()
    mirrored = np.linalg.det(AXES[axes]) < 0.0
    message = (
        f"The estimate turns about x, y, z as the body does about {named(AXES[axes])}"
        f"{f', {times}' if scale != 1.0 else ''}: give the filter its gyro on the axes of the body"
        f"{', which are right-handed; these are not' if mirrored else ''}."
    )
    return (Remark("turn_axes", message),)


def named(axes: Array) -> str:
    """Rows of a matrix of axes that change places and signs, as ``y, -x, z``."""
    return ", ".join(f"{'-' if row.sum() < 0.0 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}" for row in axes)


def _other_rate(ours: Array, true: Array) -> tuple[Remark, ...]:
    """Remark that an estimate turns about the body's axes at any other rate, by turns of shape (n, 3)."""
    scale = float(np.sum(ours * true) / np.sum(true**2))
    if not max(scale, 1.0 / max(scale, 1e-300)) > FAR or _missed(ours, scale * true) > LARGEST_MISS:
        return ()
    message = f"The estimate turns {_times(scale)}: see the time step of the filter, and the unit of its gyro."
    return (Remark("turn_rate", message),)


def _times(scale: float) -> str:
    return f"{max(scale, 1.0 / scale):.3g} times as {'fast' if scale > 1.0 else 'slow'} as the body"


def _steps(attitude_xyzw: Array, first: Integers) -> Array:
    """Turns from some samples to the next, on the body's axes, shape (n, 3), rad."""
    return turns(attitude_xyzw[first], attitude_xyzw[first + 1])


def _whole(stamps_ns: Integers) -> Integers:
    """Indices of the first samples of the steps that are no gaps."""
    return np.flatnonzero(np.diff(stamps_ns) <= GAP * period_ns(stamps_ns))


def _missed_by_conventions(estimate_xyzw: Array, true_xyzw: Array, few: Integers, *, mounted: bool) -> float:
    """Least miss of the turns by a convention, alone or with the mounting that suits it best."""
    true, least = _steps(true_xyzw, few), np.inf
    for form in WRITTEN if mounted else OTHERWISE_WRITTEN:
        ours = _steps(estimate_xyzw @ form.matrix.T, few)
        if not mounted:
            least = min(least, float(_missed(ours, true)))
            continue
        # W. Kabsch, A solution for the best rotation to relate two sets of vectors, Acta Cryst. A 32 (1976) 922
        U, _, V = np.linalg.svd(ours.T @ true)
        mounting = U @ np.diag([1.0, 1.0, np.linalg.det(U @ V)]) @ V
        least = min(least, float(_missed(ours, true @ mounting.T)))
    return least


def _missed(ours: Array, predicted: Array) -> Array:
    """Root mean square by which turns (n, 3) are missed by predictions (..., n, 3), in median turns, two at most.

    Axes about which the body turns for a short time only, as that of a flip, count by this, and not by a median.
    """
    missed = angles_between(quaternion.exp(predicted), quaternion.exp(ours))
    turned = max(float(np.median(sizes(ours))), 1e-300)
    return np.asarray(np.sqrt(np.mean(np.minimum(missed / turned, 2.0) ** 2, axis=-1)))
