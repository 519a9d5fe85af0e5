"""When stamps are due: simulated time laid along a steady clock, in integer nanoseconds."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Final, Protocol

FOREVER: Final = 2**63
"""ns; longer than any wait, and later than any stamp."""


class Pace(Protocol):
    """A relation between stamps and a steady clock."""

    def due_ns(self, steady_ns: int) -> int:
        """The last stamp that is due at a steady time, ns."""
        ...

    def wait_ns(self, stamp_ns: int, steady_ns: int) -> int:
        """How long after a steady time a stamp is due, ns; negative when it has been due for as long."""
        ...


@dataclass(frozen=True)
class Steady:
    """Simulated time passes in proportion to the steady clock.

    The relation never changes: nothing drifts, no sample is skipped, and what a stall delayed is simply due at once.

    Parameters
    ----------
    stamp_ns, steady_ns : int
        A stamp, and the steady time at which it is due, ns.
    factor : Fraction
        Simulated time by steady time, above 0.
    """

    stamp_ns: int
    steady_ns: int
    factor: Fraction

    def due_ns(self, steady_ns: int) -> int:
        """See `Pace`."""
        n, d = self.factor.numerator, self.factor.denominator
        return self.stamp_ns + (steady_ns - self.steady_ns) * n // d

    def wait_ns(self, stamp_ns: int, steady_ns: int) -> int:
        """See `Pace`."""
        n, d = self.factor.numerator, self.factor.denominator
        return self.steady_ns - (self.stamp_ns - stamp_ns) * d // n - steady_ns


@dataclass(frozen=True)
class Unlimited:
    """Every stamp is due at once."""

    def due_ns(self, steady_ns: int) -> int:
        """See `Pace`."""
        return FOREVER

    def wait_ns(self, stamp_ns: int, steady_ns: int) -> int:
        """See `Pace`."""
        return 0


@dataclass(frozen=True)
class Halted:
    """Simulated time has stopped.

    Parameters
    ----------
    stamp_ns : int
        The last stamp that is due, ns.
    """

    stamp_ns: int

    def due_ns(self, steady_ns: int) -> int:
        """See `Pace`."""
        return self.stamp_ns

    def wait_ns(self, stamp_ns: int, steady_ns: int) -> int:
        """See `Pace`."""
        return 0 if stamp_ns <= self.stamp_ns else FOREVER


def pace(factor: float, stamp_ns: int, steady_ns: int) -> Steady | Unlimited:
    """The pace of a real-time factor.

    Parameters
    ----------
    factor : float
        Simulated time by steady time; 0: without a limit.
    stamp_ns, steady_ns : int
        A stamp, and the steady time at which it is due, ns.
    """
    return Steady(stamp_ns, steady_ns, Fraction(repr(factor))) if factor > 0.0 else Unlimited()
