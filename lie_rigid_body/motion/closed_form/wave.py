"""The elliptic functions along a motion, as sampled from a clock's phase."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from lie_rigid_body.motion.closed_form.double_double import Array, Number


class Crest(NamedTuple):
    """Values at the samples, each of shape (..., N), for u in [−K, K].

    Attributes
    ----------
    sn, cn, dn : ndarray
        Jacobi's elliptic functions of u.
    sine, cosine : ndarray
        Proportional, with a positive factor, to the sine and cosine of the precession's libration about its mean.
    drift : ndarray
        An angle to be added to that libration, rad.
    """

    sn: Array
    cn: Array
    dn: Array
    sine: Array
    cosine: Array
    drift: Array


class Wave(Protocol):
    """Elliptic functions of one parameter and one characteristic."""

    def begin(self, phase: Number) -> tuple[Number, Number, Number]:
        """The last three members of `Crest` at the phase of one start, or of each motion's start."""
        ...

    def at(self, phase: Array) -> Crest:
        """The functions at these phases, shape (..., N), each within a quarter period of 0."""
        ...
