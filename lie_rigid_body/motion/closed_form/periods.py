"""Periods of a polhode's elliptic functions, and the place on them where the momentum would meet the third axis."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal

from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.motion.closed_form.elliptic_integrals import complete_first, symmetric_first
from lie_rigid_body.motion.closed_form.polhode import Polhode
from lie_rigid_body.motion.closed_form.principal_axes import PHASE_DIGITS

_INFINITY = Decimal("Infinity")


@dataclass(frozen=True)
class Periods:
    """Quarter periods, in the unit of u.

    Attributes
    ----------
    real : Decimal
        K; infinite on the separatrix.
    pole : Decimal
        a in (0, K′] with sc(a|m1) = 1/√−ν. At u = ±ia, 1 − ν sn²u has its zeros, where the unit momentum n has n₃ = ±1.
        Infinite for a symmetric top. To ``PHASE_DIGITS``.
    copole : Decimal
        K′ − a, formed without the difference; sc(K′ − a|m1) = √(−ν/m). To ``PHASE_DIGITS``.
    """

    real: Decimal
    pole: Decimal
    copole: Decimal

    @classmethod
    def of(cls, polhode: Polhode) -> Periods:
        """The periods of a polhode."""
        return cls(
            real=complete_first(polhode.m1) if polhode.m1 else _INFINITY,
            pole=_inverse_sc(polhode.characteristic, polhode.m),
            copole=_inverse_sc(1 / polhode.ratio, polhode.m),
        )

    @property
    def imaginary(self) -> Decimal:
        """K′ to ``PHASE_DIGITS``."""
        return self.pole + self.copole


def _inverse_sc(inverse_square: Decimal, m: Decimal) -> Decimal:
    """The u > 0 with 1/sc²(u|1 − m) as given, from R_F(cs², ds², ns²) (DLMF 19.25.31)."""
    if inverse_square == 0 and m == 0:
        return _INFINITY
    with working_precision(PHASE_DIGITS):
        return symmetric_first(inverse_square, inverse_square + m, inverse_square + 1)
