"""The enclosure of a true state, as thin as asked for, and what it proves of a recorded one."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import Final, TypeAlias

from flint import arb, ctx
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import as_double, shaped, whole_number
from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.proof.balls import (
    Balls,
    Integers,
    UndecidedError,
    at_least,
    at_most,
    conjugate,
    integers,
    norm,
    product,
    widest,
)
from lie_rigid_body.proof.exact_solution import exact_state
from lie_rigid_body.proof.start import Start

WIDTH: Final = 2.0**-80
"""Default of the largest width of an `Enclosure`, 8e-25."""

Bounds: TypeAlias = tuple[float, float]
"""The least and the largest that a distance may be, rounded outward."""

_MIN_BITS: Final = 128
_MAX_BITS: Final = 1 << 16


@short_dataclass
class Enclosure:
    """Balls that hold the true state at one time.

    Parameters
    ----------
    attitude_xyzw : tuple of 4 flint.arb
        Rotation taking body vectors to world vectors, of unit norm and continuous from the start.
    body_rate : tuple of 3 flint.arb
        rad/s, body frame.
    bits : int
        The precision it took.
    """

    attitude_xyzw: Balls
    body_rate: Balls
    bits: int

    def __reduce__(self) -> tuple[Callable[..., Enclosure], tuple[object, ...]]:
        """The balls as integers: python-flint does not pickle them, and rounds a radius up when it is made anew."""
        return _from_integers, (
            *(tuple(map(integers, balls)) for balls in (self.attitude_xyzw, self.body_rate)),
            self.bits,
        )

    @property
    def width(self) -> float:
        """The largest width of a component of the attitude, and of the rate relative to its norm, rounded up."""
        width = widest(self.body_rate)
        relative = 0.0 if width == 0 else at_most(width / norm(self.body_rate))
        return max(at_most(widest(self.attitude_xyzw)), relative)

    def attitude_error(self, attitude_xyzw: ArrayLike) -> Bounds:
        """Bounds of the angle between a given attitude and the true one.

        Parameters
        ----------
        attitude_xyzw : array_like, shape (4,)
            Taken as exact; its norm and sign do not matter.

        Returns
        -------
        at_least, at_most : float
            rad, rounded outward; infinite where the quaternion is zero or not finite.
        """
        with ctx.workprec(self.bits):
            given = _balls("attitude_xyzw", attitude_xyzw, 4)
            between = product(conjugate(self.attitude_xyzw), given)
            # one of the half angle's sine and cosine may be 0; of a zero quaternion both are
            sine = norm(between[:3])
            cosine = abs(between[3])
            angle = 2 * (sine / cosine).atan() if cosine > sine else arb.pi() - 2 * (cosine / sine).atan()
            return _bounds(angle)

    def rate_error(self, body_rate: ArrayLike) -> Bounds:
        """Bounds of the distance of a given body rate from the true one.

        Parameters
        ----------
        body_rate : array_like, shape (3,)
            Taken as exact.

        Returns
        -------
        at_least, at_most : float
            rad/s, rounded outward; infinite where the rate is not finite.
        """
        with ctx.workprec(self.bits):
            given = _balls("body_rate", body_rate, 3)
            return _bounds(norm(tuple(x - y for x, y in zip(given, self.body_rate, strict=True))))

    def overlaps(self, other: Enclosure) -> bool:
        """Whether the two may hold the same state: enclosures of one state always do."""
        mine = (*self.attitude_xyzw, *self.body_rate)
        theirs = (*other.attitude_xyzw, *other.body_rate)
        return all(x.overlaps(y) for x, y in zip(mine, theirs, strict=True))


def _from_integers(attitude: tuple[Integers, ...], rate: tuple[Integers, ...], bits: int) -> Enclosure:
    return Enclosure(tuple(arb(*parts) for parts in attitude), tuple(arb(*parts) for parts in rate), bits)


def enclose(
    inertia: ArrayLike, attitude_xyzw: ArrayLike, body_rate: ArrayLike, t_ns: int, *, width: float = WIDTH
) -> Enclosure:
    """The true state at a time, by the exact solution.

    Parameters
    ----------
    inertia : array_like, shape (3,), (6,) or (3, 3)
        Principal moments, ``ixx ixy ixz iyy iyz izz`` or the tensor in the body frame, kg m². Taken as exact.
    attitude_xyzw : array_like, shape (4,)
        At the start, world from body. Taken as exact, and normalised exactly.
    body_rate : array_like, shape (3,)
        At the start, rad/s, body frame. Taken as exact.
    t_ns : int
        Nanoseconds since the start.
    width : float
        See `Enclosure.width`.

    Returns
    -------
    Enclosure

    Raises
    ------
    InputError
        If the start is not that of a rigid body, or the time or the width is no such number.
    LieRigidBodyError
        If 65 536 bits are too few.
    """
    start = Start.of(inertia, attitude_xyzw, body_rate)
    t_ns = whole_number("t_ns", t_ns, -(2**63), 2**63 - 1)
    if not 0.0 < as_double(width) < 1.0:
        raise InputError(f"width: {shown(width)} is not between 0 and 1: give for example 1e-20")
    bits = _MIN_BITS
    while bits <= _MAX_BITS:
        with suppress(UndecidedError):
            found = Enclosure(*exact_state(start, t_ns, bits), bits)
            if found.width <= width:
                return found
        bits *= 2
    raise LieRigidBodyError(f"{_MAX_BITS} bits are too few to enclose this motion: ask for a shorter time")


def _balls(name: str, values: ArrayLike, size: int) -> Balls:
    return tuple(arb(x) for x in shaped(name, values, (size,)).tolist())


def _bounds(distance: arb) -> Bounds:
    if not distance.is_finite():
        return math.inf, math.inf
    return max(0.0, at_least(distance)), at_most(distance)
