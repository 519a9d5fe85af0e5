"""The motions among many that are ordinary, together where they go together, and the same bits as one by one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arrays import Array
from lie_rigid_body.motion.closed_form.coupled_frame import Coupled, coupled, one_coupled
from lie_rigid_body.motion.closed_form.diagonal_frame import diagonal_frames, judged_diagonal, one_diagonal
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.ordinary import Shape
from lie_rigid_body.motion.closed_form.ordinary_motion import OrdinaryFrame, ordinary_motion

FEW: Final = 24
"""So many motions are sooner computed one by one, in floats."""

AT_ONCE: Final = 4096
"""Motions: their numbers then stay in a processor's cache."""


class Starts(NamedTuple):
    """Bodies and their starts.

    Attributes
    ----------
    inertia : ndarray, shape (B, 3, 3)
    moments : ndarray, shape (B, 3)
        Ascending, in doubles.
    axes : ndarray, shape (B, 3, 3)
        Columns are the principal axes, in doubles.
    attitude_xyzw : ndarray, shape (B, 4)
    body_rate : ndarray, shape (B, 3)
    """

    inertia: Array
    moments: Array
    axes: Array
    attitude_xyzw: Array
    body_rate: Array

    def some(self, members: NDArray[np.intp]) -> Starts:
        """Those of these numbers."""
        return Starts(*(column[members] for column in self))


def ordinary_motions(starts: Starts) -> Iterator[tuple[GeneralMotion, NDArray[np.intp]]]:
    """The ordinary motions among these: as one those that go together, and which they are."""
    count = len(starts.inertia)
    kinds = _kinds(starts) if count >= FEW else np.zeros(count, dtype=np.intp)
    for kind in np.unique(kinds[kinds >= 0]).tolist():
        members = np.flatnonzero(kinds == kind)
        if len(members) < FEW:
            yield from _one_by_one(starts, members)
            continue
        for begin in range(0, len(members), AT_ONCE):
            some = members[begin : begin + AT_ONCE]
            part = starts.some(some)
            x, y, z, w = part.attitude_xyzw.T
            yield (
                ordinary_motion(_frames(part, kind % 2 == 1), (x, y, z, w), Shape(kind // 2 % 2 == 1, kind // 4)),
                some,
            )


def _one_by_one(starts: Starts, members: NDArray[np.intp]) -> Iterator[tuple[GeneralMotion, NDArray[np.intp]]]:
    for i in members:
        motion = ordinary_one(*(column[i].tolist() for column in starts))
        if motion is not None:
            yield motion, np.array([i])


def ordinary_one(
    inertia: list[list[float]],
    moments: list[float],
    axes: list[list[float]],
    attitude_xyzw: list[float],
    body_rate: list[float],
) -> GeneralMotion | None:
    """The motion of one body, or None if it is not ordinary."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    straight = xy == 0.0 and xz == 0.0 and yz == 0.0
    found = one_diagonal([xx, yy, zz], body_rate) if straight else one_coupled(inertia, moments, axes, body_rate)
    if found is None:
        return None
    frame, shape = found
    x, y, z, w = attitude_xyzw
    return ordinary_motion(frame, (x, y, z, w), shape)


def _kinds(starts: Starts) -> NDArray[np.intp]:
    """What tells groups apart: 1 for products of inertia, 2 where m > ½, 4 for each step; negative: not ordinary."""
    straight = (starts.inertia[:, [0, 0, 1], [1, 2, 2]] == 0.0).all(axis=1)
    kinds = np.full(len(straight), -1)
    with np.errstate(all="ignore"):
        for members, products in ((np.flatnonzero(straight), False), (np.flatnonzero(~straight), True)):
            part = starts.some(members)
            fits, hyperbolic, steps = (
                _coupled(part).judged() if products else judged_diagonal(_diagonal(part), part.body_rate)
            )
            kinds[members] = np.where(fits, products + 2 * hyperbolic + 4 * steps, -1)
    return kinds


def _frames(starts: Starts, products: bool) -> OrdinaryFrame:
    return _coupled(starts).frame() if products else diagonal_frames(_diagonal(starts), starts.body_rate)


def _diagonal(starts: Starts) -> Array:
    return np.diagonal(starts.inertia, axis1=1, axis2=2)


def _coupled(starts: Starts) -> Coupled:
    inertia, axes = (np.ascontiguousarray(np.moveaxis(tensor, 0, -1)) for tensor in (starts.inertia, starts.axes))
    return coupled(inertia, starts.moments.T.copy(), axes, starts.body_rate.T.copy())
