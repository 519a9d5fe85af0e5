"""Sizes of matrix groups from outside."""

from __future__ import annotations

import operator

from lie_rigid_body.errors import InputError


def as_size(family: str, n: int) -> int:
    """The size n of a family of groups that starts at 2, or an error."""
    try:
        size = operator.index(n)
    except TypeError:
        raise InputError(f"{family}(n) needs a whole number n, given {n!r}: give the size of the matrices") from None
    if size < 2:
        raise InputError(f"{family}({size}) is too small (limit n ≥ 2): give the size of the matrices")
    return size
