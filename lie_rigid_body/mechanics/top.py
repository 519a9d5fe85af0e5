"""Which kind of top a body is, and what its symmetry keeps constant in the body."""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.mechanics.rigid_body import RigidBody

Kind: TypeAlias = Literal["asymmetric", "oblate", "prolate", "spherical"]

_ROUND_OFF: Final = 8.0 * float(np.finfo(np.float64).eps)


def equal_moments(one: float, other: float) -> bool:
    """Whether two principal moments are the same number, or differ by no more than their decomposition's round-off.

    A symmetric body whose axis is tilted in its frame has no exactly equal moments once its tensor is rounded.
    """
    return abs(one - other) <= _ROUND_OFF * max(abs(one), abs(other))


def kind_of_top(body: RigidBody) -> Kind:
    """Asymmetric, oblate (two equal moments below the third), prolate (two above it) or spherical."""
    small, middle, large = (float(moment) for moment in body.principal_moments)
    if equal_moments(small, large):
        return "spherical"
    if equal_moments(small, middle):
        return "oblate"
    return "prolate" if equal_moments(middle, large) else "asymmetric"


def is_flat(body: RigidBody) -> bool:
    """Whether the largest moment is the sum of the others: all mass in one plane, across the largest axis."""
    small, middle, large = (float(moment) for moment in body.principal_moments)
    return equal_moments(small + middle, large)


def symmetry_axis(body: RigidBody) -> int | None:
    """The index, among the principal axes, of an oblate or prolate body's axis of symmetry."""
    return {"oblate": 2, "prolate": 0}.get(kind_of_top(body))


def conserved_body_axes(body: RigidBody) -> Array:
    """Directions in the body along which the body momentum Mω stays constant in every motion.

    They are the axes about which rotations leave M as it is: by Noether's theorem for the motion's symmetry under
    rotations of the body within itself.

    Parameters
    ----------
    body : RigidBody

    Returns
    -------
    ndarray, shape (k, 3)
        Orthonormal rows, body frame: none for an asymmetric top, its axis for a symmetric one, three for a sphere.
    """
    kind, axis = kind_of_top(body), symmetry_axis(body)
    if kind == "spherical":
        return np.eye(3)
    return np.empty((0, 3)) if axis is None else body.principal_axes[:, [axis]].T.copy()
