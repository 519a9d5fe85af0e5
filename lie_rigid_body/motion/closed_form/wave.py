"""The elliptic functions along a motion."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from lie_rigid_body.arithmetic.numbers import Number


class Crest(NamedTuple):
    """Values at a sample, or at the samples of an array.

    Attributes
    ----------
    sn, cn, dn : number
        Jacobi's elliptic functions of u.
    sine, cosine : number
        Proportional, with a factor of the signs of sn and cn, to the sine and cosine of the precession's libration
        about its mean, less what `drift` adds to it.
    """

    sn: Number
    cn: Number
    dn: Number
    sine: Number
    cosine: Number


class Wave(Protocol):
    """Elliptic functions of one parameter and one characteristic."""

    def begin(self, phase: Number) -> tuple[Number, Number, Number]:
        """Sine, cosine and an angle to be added, rad, of the libration at one start, or at each motion's."""
        ...
