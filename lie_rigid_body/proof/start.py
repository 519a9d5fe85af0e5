"""The start of a motion as rational numbers, in which every question of its kind has an exact answer.

With momentum p = M ω, twice the kinetic energy 2H = ω·p and the principal moments I₁ ≤ I₂ ≤ I₃ a motion is, in this
order,

- steady where p × ω = 0: the body rate stays as it is;
- that of a symmetric top where two moments are equal, which the discriminant of the characteristic polynomial of M
  tells;
- on the separatrix where 2H M − p² 1 is singular. Of its eigenvalues 2H Iⱼ − p² only the middle one can then vanish,
  since the others are −Σ Iⱼ(Iⱼ−I₁)ωⱼ² and Σ Iⱼ(I₃−Iⱼ)ωⱼ²;
- else it circulates about the axis of the smallest moment where det(2H M − p² 1) < 0, and of the largest where it is
  > 0.

L. D. Landau, E. M. Lifshitz, Mechanics, 3rd ed., §37.
"""

from __future__ import annotations

import enum

from flint import fmpq, fmpq_mat
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics import RigidBody

Rationals = tuple[fmpq, ...]


class Kind(enum.Enum):
    """Kinds of motion, each with a formula of its own for the solution."""

    STEADY = "steady"
    SYMMETRIC = "symmetric top"
    SEPARATRIX = "on the separatrix"
    ABOUT_SMALLEST = "circulates about the axis of the smallest moment"
    ABOUT_LARGEST = "circulates about the axis of the largest moment"


@short_dataclass
class Start:
    """Inertia and initial state of a motion, exactly.

    Parameters
    ----------
    inertia : fmpq_mat, shape (3, 3)
        M, kg m², body frame.
    attitude_xyzw : tuple of 4 fmpq
        Of any norm but 0: its direction is the attitude.
    rate : tuple of 3 fmpq
        ω, rad/s, body frame.
    """

    inertia: fmpq_mat
    attitude_xyzw: Rationals
    rate: Rationals

    @classmethod
    def of(cls, inertia: ArrayLike, attitude_xyzw: ArrayLike, body_rate: ArrayLike) -> Start:
        """The start that arrays of doubles say.

        Parameters
        ----------
        inertia : array_like, shape (3,), (6,) or (3, 3)
            Principal moments, ``ixx ixy ixz iyy iyz izz`` or the tensor, kg m².
        attitude_xyzw : array_like, shape (4,)
        body_rate : array_like, shape (3,)
            rad/s, body frame.

        Raises
        ------
        InputError
            If a shape is another, a number is not finite, no body has the inertia, or the quaternion is zero.
        """
        attitude = _exact(real_array("attitude_xyzw", attitude_xyzw, (4,)))
        if not any(attitude):
            raise InputError("attitude_xyzw: a zero quaternion is no attitude: give one of unit norm")
        tensor = fmpq_mat(3, 3, list(_exact(RigidBody(inertia).inertia)))
        return cls(tensor, attitude, _exact(real_array("body_rate", body_rate, (3,))))

    @property
    def momentum(self) -> Rationals:
        """Angular momentum p = M ω, body frame, kg m²/s."""
        return tuple((self.inertia * fmpq_mat(3, 1, list(self.rate))).entries())

    @property
    def momentum_squared(self) -> fmpq:
        """Its square p·p."""
        return _dot(self.momentum, self.momentum)

    @property
    def twice_energy(self) -> fmpq:
        """Twice the kinetic energy, 2H = ω·p, J."""
        return _dot(self.rate, self.momentum)

    @property
    def repeated_moment(self) -> fmpq | None:
        """The principal moment that two axes share, if any: rational, as a double root of a rational cubic."""
        trace, minors, determinant = self.invariants
        if 18 * trace * minors * determinant + (trace * minors) ** 2 != (
            4 * trace**3 * determinant + 4 * minors**3 + 27 * determinant**2
        ):
            return None
        if trace**2 == 3 * minors:
            return trace / 3
        return (trace * minors - 9 * determinant) / (2 * (trace**2 - 3 * minors))

    @property
    def invariants(self) -> tuple[fmpq, fmpq, fmpq]:
        """Coefficients T, S, D of det(x 1 − M) = x³ − T x² + S x − D."""
        M = self.inertia
        minors = sum((M[i, i] * M[j, j] - M[i, j] ** 2 for i, j in ((0, 1), (0, 2), (1, 2))), fmpq(0))
        return M[0, 0] + M[1, 1] + M[2, 2], minors, M.det()

    @property
    def kind(self) -> Kind:
        """Which formulas solve this motion."""
        p = self.momentum
        w = self.rate
        if all(p[i] * w[j] == p[j] * w[i] for i, j in ((0, 1), (0, 2), (1, 2))):
            return Kind.STEADY
        if self.repeated_moment is not None:
            return Kind.SYMMETRIC
        squared = self.momentum_squared
        none = fmpq(0)
        shift = fmpq_mat(3, 3, [squared, none, none, none, squared, none, none, none, squared])
        side = (self.inertia * self.twice_energy - shift).det()
        if side == 0:
            return Kind.SEPARATRIX
        return Kind.ABOUT_SMALLEST if side < 0 else Kind.ABOUT_LARGEST


def _dot(a: Rationals, b: Rationals) -> fmpq:
    return sum((x * y for x, y in zip(a, b, strict=True)), fmpq(0))


def _exact(array: Array) -> Rationals:
    return tuple(fmpq(*number.as_integer_ratio()) for number in array.ravel().tolist())
