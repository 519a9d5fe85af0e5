"""Mass, centre of mass and second moment of a body in n dimensions: all that its free motion depends on.

Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics.array_input import orthogonal_matrix, positive, symmetrised
from lie_rigid_body.mechanics.second_moment import second_moment_matrix


@short_dataclass(eq=False)
class MassMoments:
    """The moments of a mass distribution of orders 0, 1 and 2, the last of them K of eq. (10).

    They are stored about the centre of mass, so that a body far from its origin loses no digits. The moments of a
    body are the sum of those of its parts; a hole is subtracted.

    Parameters
    ----------
    mass : float
        m = ∫ρ, kg. Positive.
    centre : array_like, shape (n,)
        c = ∫ρ x / m, m.
    central_second_moment : array_like, shape (n, n)
        ∫ρ (x − c)(x − c)ᵀ, kg m².

    Attributes
    ----------
    centre : ndarray, shape (n,)
        Read only.
    central_second_moment : ndarray, shape (n, n)
        Read only, exactly symmetric.

    Raises
    ------
    ParameterError
        If no mass distribution has these moments: the mass is not positive, the second moment not symmetric or not
        positive semidefinite within round-off; or if sizes differ.
    """

    mass: float
    centre: Array
    central_second_moment: Array

    def __post_init__(self) -> None:
        mass = float(positive("mass", self.mass, "kg"))
        central = second_moment_matrix(self.central_second_moment)
        centre = real_array("centre", self.centre, (len(central),))
        centre.setflags(write=False)
        central.setflags(write=False)
        vars(self).update(mass=mass, centre=centre, central_second_moment=central)

    @property
    def dimension(self) -> int:
        """The number n of dimensions."""
        return len(self.centre)

    @property
    def first_moment(self) -> Array:
        """The first moment ∫ρ x about the origin, shape (n,), kg m."""
        return self.mass * self.centre

    @property
    def second_moment(self) -> Array:
        """The second moment K = ∫ρ x xᵀ about the origin, shape (n, n), kg m²: eq. (10).

        K is the central second moment plus m c cᵀ (parallel axes).
        """
        return self.central_second_moment + self.mass * np.outer(self.centre, self.centre)

    def moved(self, rotation: ArrayLike, translation: ArrayLike) -> MassMoments:
        """The moments of the displaced body, x ↦ A x + t, about the same origin: the A₀ K A₀ᵀ of eq. (13), displaced.

        Parameters
        ----------
        rotation : array_like, shape (n, n)
            A, orthogonal; a reflection gives the mirror image of the body.
        translation : array_like, shape (n,)
            t, m.

        Returns
        -------
        MassMoments

        Raises
        ------
        ParameterError
            If A is not an orthogonal n×n matrix or t has another size.
        """
        A = orthogonal_matrix("rotation", real_array("rotation", rotation, ("n", "n")), self.dimension)
        t = real_array("translation", translation, (self.dimension,))
        return MassMoments(self.mass, A @ self.centre + t, symmetrised(A @ self.central_second_moment @ A.T))

    def rotated(self, rotation: ArrayLike) -> MassMoments:
        """The moments of the body turned about the origin: K becomes A K Aᵀ, as in eq. (13); see `moved`."""
        return self.moved(rotation, np.zeros(self.dimension))

    def about(self, origin: ArrayLike) -> MassMoments:
        """The moments about another origin, eq. (10), by the parallel axis theorem.

        Parameters
        ----------
        origin : array_like, shape (n,)
            The new origin o in the present frame, m.

        Returns
        -------
        MassMoments
            In coordinates from the new origin: the centre is c − o, and K is the central second moment plus
            m (c − o)(c − o)ᵀ.

        Raises
        ------
        ParameterError
            If the origin has another size.
        """
        o = real_array("origin", origin, (self.dimension,))
        return MassMoments(self.mass, self.centre - o, self.central_second_moment)

    def __add__(self, other: MassMoments) -> MassMoments:
        """The moments of both bodies together, in a common frame: eq. (10) is a sum over the parts of a body."""
        return self._joined(other, 1.0)

    def __sub__(self, other: MassMoments) -> MassMoments:
        """The moments of this body without a part of it, as a hole, in a common frame."""
        return self._joined(other, -1.0)

    def _joined(self, other: MassMoments, sign: float) -> MassMoments:
        if other.dimension != self.dimension:
            raise ParameterError(
                "body", f"{other.dimension} dimensions where the first has {self.dimension}: give both in one space"
            )
        mass = self.mass + sign * other.mass
        if not mass > 0.0:
            raise ParameterError(
                "mass", f"{mass:.9g} kg would be left, not above 0 kg: subtract only a part of the body"
            )
        fraction = sign * other.mass / mass
        apart = other.centre - self.centre
        central = self.central_second_moment + sign * other.central_second_moment
        return MassMoments(
            mass, self.centre + fraction * apart, central + self.mass * fraction * np.outer(apart, apart)
        )
