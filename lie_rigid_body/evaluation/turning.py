"""How an estimate turns beside the body: not at all, too fast, or about other axes, whatever its attitude is.

The turn of the estimate from one sample to the next, on its own body axes, is held against that of the truth times a
scale and with axes that change places and signs. A gyro in deg/s, one axis of wrong sign or a left-handed frame leave
attitudes that no constant rotation explains, and turns that this explains to a few percent.
"""

from __future__ import annotations

from itertools import permutations, product
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation.estimate import GAP, Remark, period_ns
from lie_rigid_body.evaluation.search import spread
from lie_rigid_body.lie import quaternion

STEPS: Final = 400
"""Largest number of steps that are compared."""
FEWEST_STEPS: Final = 20
LEAST_TURN: Final = 0.5
"""A body that turns by less in all, rad, tells nothing."""
STUCK: Final = 0.01
"""Share of the body's turn below which an estimate does not turn."""
LARGEST_MISS: Final = 0.2
"""Median by which the turns may be missed, as a share of the median turn: mistakes of this kind leave less."""

DEGREE: Final = 180.0 / np.pi
SCALES: Final = {
    1.0: "",
    DEGREE: "its gyro is in deg/s where the filter wants rad/s",
    1.0 / DEGREE: "its gyro is in rad/s where the filter wants deg/s",
    2.0: "the rate of a quaternion is ½ q ω, or its time step is twice that of the gyro",
    0.5: "the rate of a quaternion is ½ q ω, once, or its time step is half that of the gyro",
}
"""How many times as fast as the body an estimate may turn, and what is the matter then."""
AXES: Final = np.array(
    [np.diag(signs)[list(order)] for order in permutations(range(3)) for signs in product((1.0, -1.0), repeat=3)]
)
"""Axes that change places and signs, the first of which is none: shape (48, 3, 3)."""


def turning(stamps_ns: Integers, estimate_xyzw: Array, true_xyzw: Array) -> tuple[Remark, ...]:
    """What is wrong about the turns of an estimate whose error has no other cause.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    estimate_xyzw, true_xyzw : ndarray, shape (N, 4)

    Returns
    -------
    tuple of Remark
    """
    whole = np.flatnonzero(np.diff(stamps_ns) <= GAP * period_ns(stamps_ns))
    ours, true = (_steps(q, whole) for q in (estimate_xyzw, true_xyzw))
    turned, turn = _angles(ours), _angles(true)
    if len(whole) < FEWEST_STEPS or turn.sum() < LEAST_TURN:
        return ()
    if turned.sum() < STUCK * turn.sum():
        message = (
            f"The estimate turns by {np.degrees(turned.sum()):.3g}° in all, the body by {np.degrees(turn.sum()):.4g}°: "
            "see whether the filter gets its readings, and publishes what it makes of them."
        )
        return (Remark("stuck", message),)
    few = spread(len(whole), STEPS)
    fitting = _fitting(ours[few], quaternion.log(true[few]), LARGEST_MISS * float(np.median(turned[few])))
    if len({scale for scale, _ in fitting}) != 1:
        return ()
    scale, axes = fitting[0]
    times = f"{max(scale, 1.0 / scale):.3g} times as {'fast' if scale > 1.0 else 'slow'} as the body"
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


def _steps(attitude_xyzw: Array, first: Integers) -> Array:
    """Rotations from some samples to the next, on the body's axes, shape (n, 4)."""
    return quaternion.multiply(quaternion.conjugate(attitude_xyzw[first]), attitude_xyzw[first + 1])


def _angles(rotations: Array) -> Array:
    return np.asarray(np.sqrt(np.sum(quaternion.log(rotations) ** 2, axis=-1)))


def _fitting(ours: Array, true: Array, most: float) -> list[tuple[float, int]]:
    """Scales and axes that miss the estimate's turns by no more than a median, rad; those of no change come first."""
    found = []
    for scale in SCALES:
        predicted = quaternion.exp(scale * np.einsum("aij,nj->ani", AXES, true))
        missed = np.median(_angles(quaternion.multiply(quaternion.conjugate(predicted), ours)), axis=-1)
        found += [(scale, int(axes)) for axes in np.flatnonzero(missed <= most)]
    return found
