"""Repairs of the estimate: the causes of `lie_rigid_body.evaluation.causes`, and two of a filter's own code."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import product
from typing import Final, Literal, get_args

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.diagnosis.repairs import HALVED, Repair, Repairs, text_of
from lie_rigid_body.evaluation.attitudes import SIGNED_PERMUTATIONS
from lie_rigid_body.evaluation.causes import CAUSES, Cause, by_maps
from lie_rigid_body.evaluation.matched import Matched, MatchedRuns, error_of
from lie_rigid_body.foundation.arrays import Array

CONSTANT: Final = 0.95
"""Least ratio of a constant in the last third of a run to that in the first, of a filter that does not converge."""
OF_VECTOR: Final = [P for P in SIGNED_PERMUTATIONS[1:] if np.trace(P) > -3.0]
"""Permutations with signs of the vector part of a quaternion, but the inverse."""
Order = Literal["ZYX", "XYZ", "YXZ", "ZXY", "XZY", "YZX"]
ORDERS: Final = get_args(Order)
"""Orders of rotations about axes of the body, the usual one first."""
COMPOSED: Final = [
    each for each in product(ORDERS, ORDERS, product((1.0, -1.0), repeat=3)) if each[0] != each[1] or min(each[2]) < 0.0
]
"""Order in which a filter composes Euler angles, the right order, and the right sign of each angle in that."""


def _angles(track: Matched, order: Order) -> Array:
    """Angles of rotations about axes of the body, in an order, shape (N, 3), rad."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # where two axes are one, any of the angles will do
        return scipy.spatial.transform.Rotation.from_quat(track.attitude_xyzw).as_euler(order)


def _recomposed(angles: Array, chosen: float) -> Array:
    """Attitudes, (N, 4), of angles in a wrong order, (N, 3), by a row of `COMPOSED`."""
    wrong, right, signs = COMPOSED[int(chosen)]
    sorted_angles = angles[:, [wrong.index(axis) for axis in right]]
    return scipy.spatial.transform.Rotation.from_euler(right, sorted_angles * signs).as_quat()


def _best_composed(tracks: MatchedRuns) -> list[Array]:
    """The row of `COMPOSED` that leaves the least error."""
    few = [track.thinned() for track in tracks]
    truth = np.concatenate([track.truth_xyzw for track in few])
    angles = {order: np.concatenate([_angles(track, order) for track in few]) for order in ORDERS}
    cosines = [np.sum(_recomposed(angles[each[0]], row) * truth, axis=1) for row, each in enumerate(COMPOSED)]
    return [np.array([float(np.argmax(np.sum(np.square(cosines), axis=1)))])]


def _composition(c: Array) -> str:
    wrong, right, signs = COMPOSED[int(c[0])]
    signed = " ".join("-" * (sign < 0.0) + axis for axis, sign in zip(right, signs, strict=True))
    return f"are put together as {' '.join(wrong)} instead of {signed}".lower()


EULER: Final = Cause(
    "euler_order",
    0,
    lambda track, c: replace(track, attitude_xyzw=_recomposed(_angles(track, COMPOSED[int(c[0])][0]), c[0])),
    _best_composed,
    lambda c: f"The three Euler angles {_composition(c)}",
    lambda c: "Put together in the right way they leave",
)
OUTPUT_AXES: Final = by_maps(
    "output_axes",
    [np.pad(P, (0, 1)) + np.diag([0.0, 0.0, 0.0, 1.0]) for P in OF_VECTOR],
    lambda c: "The vector part of the quaternion has its numbers in another order or with other signs",
    lambda c: f"Given as {text_of(OF_VECTOR[int(c[0])])} they leave",
)
OUTPUTS: Final = (*CAUSES, EULER, OUTPUT_AXES)
"""Causes in the output that are undone."""
CODED: Final = {cause.code: cause for cause in OUTPUTS}


def of_output(cause: Cause, constants: Array) -> Repair:
    """A repair of the estimate by undoing a cause."""
    text = " ".join([*(f"{constant:.5g}" for constant in constants), cause.unit]) if cause.price else "undone"
    if cause is OUTPUT_AXES:
        text = text_of(OF_VECTOR[int(constants[0])])
    return Repair(
        cause.code, text, cause.fact(constants), cause.deed(constants), price=cause.price, constants=constants
    )


def _is_converging(cause: Cause, tracks: MatchedRuns) -> bool:
    """Whether the constant of a cause is smaller at the end than at the beginning: then the filter still converges."""
    none = 1.0 if cause.code == "clock_rate" else 0.0
    thirds = ([track.fraction(begin, begin + 1.0 / 3.0) for track in tracks] for begin in (0.0, 2.0 / 3.0))
    first, last = (float(np.linalg.norm(cause.fitted(third)[0] - none)) for third in thirds)
    return last < CONSTANT * first


def without(tracks: MatchedRuns, causes: Iterable[Cause], *, pairs: bool) -> Iterator[tuple[Repairs, float]]:
    """Undo each cause, or each pair whose first has no constant; yield the repairs and the error left."""
    before = error_of(tracks)
    for cause in causes:
        constants, error = cause.fitted(tracks)
        if cause.price and error < HALVED * before and _is_converging(cause, tracks):
            continue
        repair = of_output(cause, constants)
        yield (repair,), error
        if pairs and not cause.price:
            mended = [cause.undo(track, constants) for track in tracks]
            for second, left in without(mended, [other for other in OUTPUTS if other is not cause], pairs=False):
                yield (repair, *second), left
