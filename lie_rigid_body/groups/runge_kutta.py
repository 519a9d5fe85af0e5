"""Explicit Runge–Kutta steps along a vector field, for lists of coordinates."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from lie_rigid_body.motion.munthe_kaas.tableau import Tableau

Point: TypeAlias = list[float]
Field: TypeAlias = Callable[[Point], Point]
Weights: TypeAlias = tuple[tuple[int, float], ...]


class RungeKuttaStepper:
    """An explicit Runge–Kutta method.

    Parameters
    ----------
    tableau : Tableau
        Coefficients; zeros are skipped.
    """

    __slots__ = ("_stages", "_sum", "name", "order")

    def __init__(self, tableau: Tableau) -> None:
        self.name = tableau.name
        self.order = tableau.order
        self._stages = tuple(_nonzero(row) for row in tableau.a)
        self._sum = _nonzero(tableau.b)

    def step(self, field: Field, start: Point, h: float) -> Point:
        """The point after one step of length h along a vector field.

        Parameters
        ----------
        field : callable
            Takes a point and returns its rate, as lists of equal length.
        start : list of float
        h : float
            Step, s.

        Returns
        -------
        list of float
        """
        slopes: list[Point] = []
        for weights in self._stages:
            slopes.append(field(_advance(start, h, weights, slopes)))
        return _advance(start, h, self._sum, slopes)


def _nonzero(row: tuple[object, ...]) -> Weights:
    return tuple((stage, float(weight)) for stage, weight in enumerate(row) if weight)  # type: ignore[arg-type]


def _advance(start: Point, h: float, weights: Weights, slopes: list[Point]) -> Point:
    if not weights:
        return start
    (stage, weight), *rest = weights
    increment = [weight * k for k in slopes[stage]]
    for stage, weight in rest:
        increment = [d + weight * k for d, k in zip(increment, slopes[stage])]  # noqa: B905
    return [y + h * d for y, d in zip(start, increment)]  # noqa: B905
