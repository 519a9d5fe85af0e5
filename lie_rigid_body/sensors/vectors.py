"""Vectors and matrices among parameter values, and their limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias, cast

from lie_rigid_body.errors import ParameterError
from lie_rigid_body.parameters import Value

Vector: TypeAlias = tuple[float, ...]


def vector(values: Mapping[str, Value], name: str) -> Vector:
    """The numbers of an array parameter."""
    return cast(Vector, values[name])


def require_at_most(name: str, numbers: Vector, limit: float, unit: str) -> None:
    """Refuse numbers beyond what any instrument has, with which readings could overflow.

    Raises
    ------
    ParameterError
        If the size of one exceeds the limit.
    """
    worst = max(numbers, key=abs)
    if abs(worst) > limit:
        within = f"{limit:g} {unit}".rstrip()
        raise ParameterError(name, f"{worst:g} is outside ±{within}: give numbers of that size at most")
