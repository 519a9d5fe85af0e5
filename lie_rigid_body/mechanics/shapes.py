"""Homogeneous bodies with moments in closed form, each about its own centre and in its own principal axes.

The second moment of a homogeneous body is its mass times the mean of x xᵀ over it. Move, turn, add and subtract the
results with `MassMoments` to build other bodies of them. Equation numbers are those of A. Lucas, arXiv 1111.1275.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, whole_number
from lie_rigid_body.mechanics.array_input import positive
from lie_rigid_body.mechanics.mass_moments import MassMoments

MIN_THICKNESS: Final = 0.02
"""Shortest side of a box that is to be seen, as a share of the longest."""


def ball(mass: float, radius: float, dimension: int = 3) -> MassMoments:
    """A ball in n dimensions: K = m r²/(n + 2) 1, eq. (10).

    Parameters
    ----------
    mass : float
        m, kg.
    radius : float
        r, m.
    dimension : int
        n, at least 1.

    Returns
    -------
    MassMoments

    Raises
    ------
    ParameterError
        If a mass, a length or the dimension is not positive, or the dimension no whole number.
    """
    return ellipsoid(mass, np.full(whole_number("dimension", dimension, 1), positive("radius", radius, "m")))


def ellipsoid(mass: float, semi_axes: ArrayLike) -> MassMoments:
    """A solid ellipsoid in n dimensions: K = m diag(aᵢ²)/(n + 2), eq. (10).

    Parameters
    ----------
    mass : float
        m, kg.
    semi_axes : array_like, shape (n,)
        aᵢ along the coordinate axes, m.

    Returns
    -------
    MassMoments

    Raises
    ------
    ParameterError
        If the mass or a length is not positive.
    """
    a = positive("semi-axes", semi_axes, "m", ("n",))
    return _centred(mass, a, len(a) + 2)


def box(mass: float, edges: ArrayLike) -> MassMoments:
    """A rectangular box in n dimensions: K = m diag(lᵢ²)/12, eq. (10).

    Parameters
    ----------
    mass : float
        m, kg.
    edges : array_like, shape (n,)
        Whole lengths lᵢ along the coordinate axes, m.

    Returns
    -------
    MassMoments

    Raises
    ------
    ParameterError
        If the mass or a length is not positive.
    """
    return _centred(mass, positive("edges", edges, "m", ("n",)), 12)


def box_sides(principal_moments: ArrayLike) -> Array:
    """The sides of a box with these ratios of principal moments, to draw a body of which nothing but those is known.

    Parameters
    ----------
    principal_moments : array_like, shape (3,)
        kg m².

    Returns
    -------
    ndarray, shape (3,)
        Sides along the principal axes; the longest is 1, and none is below `MIN_THICKNESS`.

    Notes
    -----
    I₁ = m (b² + c²)/12 and its permutations give a² ∝ I₂ + I₃ − I₁.
    """
    moments = np.asarray(principal_moments, dtype=np.float64)
    moments = moments / moments.max()
    sides = np.sqrt(np.maximum(moments.sum() - 2.0 * moments, 0.0))
    return np.asarray(np.maximum(sides / sides.max(), MIN_THICKNESS))


def cylinder(mass: float, radius: float, height: float) -> MassMoments:
    """A solid circular cylinder about the z axis: K = m diag(r²/4, r²/4, h²/12), eq. (10).

    Parameters
    ----------
    mass : float
        m, kg.
    radius : float
        r, m.
    height : float
        h, whole length along z, m.

    Returns
    -------
    MassMoments

    Raises
    ------
    ParameterError
        If the mass or a length is not positive.
    """
    r = positive("radius", radius, "m")
    return _centred(mass, [r, r, positive("height", height, "m")], [4, 4, 12])


def rod(mass: float, length: float) -> MassMoments:
    """A thin rod along the z axis: K = m diag(0, 0, l²/12), eq. (10).

    A rod alone is no `RigidBody`, since nothing resists a turn about its own axis; it is a part of one.

    Parameters
    ----------
    mass : float
        m, kg.
    length : float
        l, m.

    Returns
    -------
    MassMoments

    Raises
    ------
    ParameterError
        If the mass or the length is not positive.
    """
    return _centred(mass, [0.0, 0.0, float(positive("length", length, "m"))], 12)


def disc(mass: float, radius: float) -> MassMoments:
    """A thin circular disc across the z axis: K = m diag(r²/4, r²/4, 0), eq. (10).

    Parameters
    ----------
    mass : float
        m, kg.
    radius : float
        r, m.

    Returns
    -------
    MassMoments

    Raises
    ------
    ParameterError
        If the mass or the radius is not positive.
    """
    r = float(positive("radius", radius, "m"))
    return _centred(mass, [r, r, 0.0], 4)


@np.errstate(over="ignore", invalid="ignore")  # what goes beyond doubles is refused
def _centred(mass: float, lengths: ArrayLike, divisors: ArrayLike) -> MassMoments:
    """The body whose mean squares of the coordinates are the squares of these lengths over these divisors."""
    mean_squares = np.square(lengths) / divisors
    return MassMoments(mass, np.zeros(len(mean_squares)), np.diag(positive("mass", mass, "kg") * mean_squares))
