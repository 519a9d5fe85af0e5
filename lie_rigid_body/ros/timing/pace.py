"""Paces: the stamps that are due at a time of the steady clock, as simulated time passes. Times are integers, ns."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Final, Protocol

from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.ros.timing.sink import FOREVER

CATCH_UP: Final = 1.25
"""Speed of a late run, as a multiple of that of simulated time: a higher one would overrun subscribers."""
BREATH_NS: Final = 500_000
"""Shortest rest of a late run, ns: at high rates a rest after each sample would cost too much."""
MAX_CREDIT_NS: Final = 3_000_000
"""Longest oversleep that a late run makes up for at once, ns: 3 samples at 1 kHz, as many subscribers keep 10."""
STALL_NS: Final = 25_000_000
"""Oversleep from which on it counts as a stall, of which nothing is made up for at once, ns."""


def credit_ns(overslept_ns: int, *, is_far_behind: bool) -> int:
    """Time whose samples may go out at once, in a late run that rested so much longer than it had to, ns.

    In two breaths the run gains on time. In what it overslept beyond, it only keeps up with time: a late waking brings
    no more samples than it brings to a punctual run. One that is far behind gains in all of it. One sample may go out
    in any case.
    """
    if overslept_ns >= STALL_NS:
        return 0
    gaining = min(overslept_ns, 2 * BREATH_NS)  # half of it may be what the breath before left over
    credit = int(CATCH_UP * gaining) + min(overslept_ns, MAX_CREDIT_NS) - gaining
    return max(credit, int(CATCH_UP * overslept_ns)) if is_far_behind else credit


class Pace(Protocol):
    """A relation between stamps and the steady clock."""

    def due_ns(self, steady_ns: int) -> int:
        """The latest stamp that is due at a time of the steady clock, ns."""

    def wait_ns(self, stamp_ns: int, steady_ns: int) -> int:
        """Time from ``steady_ns`` until a stamp is due, ns; negative when it has been due for that long."""

    def last_ns(self, stamp_ns: int, steady_ns: int, credit_ns: int) -> int:
        """The last stamp that may go out, from ``stamp_ns`` on, which is due, with a credit of steady time."""
        return self.due_ns(steady_ns)

    def rest_ns(self, span_ns: int, credit_ns: int) -> int:
        """The rest after stamps with that credit, of which the next comes ``span_ns`` after the first, ns."""
        return 0

    def postponed(self, stamp_ns: int, steady_ns: int) -> Pace:
        """The pace from a time on at which a stamp is due, whatever was due before."""
        return self


@short_dataclass
class Scaled(Pace):
    """Simulated time is the steady clock's, scaled by a constant factor from a common instant.

    The relation never changes: nothing drifts, no sample is skipped, and samples delayed by a stall are due at once.
    They go out by and by, however, in an even stream that is `CATCH_UP` times as fast as simulated time passes.

    Parameters
    ----------
    stamp_ns, steady_ns : int
        A stamp, and the steady time at which it is due, ns.
    factor : Fraction
        Real-time factor: simulated time over steady time, above 0.
    """

    stamp_ns: int
    steady_ns: int
    factor: Fraction

    def due_ns(self, steady_ns: int) -> int:
        """See `Pace`; rounded down."""
        return self.stamp_ns + (steady_ns - self.steady_ns) * self.factor.numerator // self.factor.denominator

    def wait_ns(self, stamp_ns: int, steady_ns: int) -> int:
        """See `Pace`; rounded up, so that the stamp is due after the wait."""
        passed = (self.stamp_ns - stamp_ns) * self.factor.denominator // self.factor.numerator
        return self.steady_ns - passed - steady_ns

    def last_ns(self, stamp_ns: int, steady_ns: int, credit_ns: int) -> int:
        """See `Pace`."""
        allowed = credit_ns * self.factor.numerator // self.factor.denominator
        return min(self.due_ns(steady_ns), stamp_ns + max(0, allowed - 1))

    def rest_ns(self, span_ns: int, credit_ns: int) -> int:
        """See `Pace`; rounded up."""
        return math.ceil((span_ns * self.factor.denominator / self.factor.numerator - credit_ns) / CATCH_UP)

    def postponed(self, stamp_ns: int, steady_ns: int) -> Pace:
        """See `Pace`."""
        return Scaled(stamp_ns, steady_ns, self.factor)


@short_dataclass
class UpTo(Pace):
    """Stamps up to a last one are due at any time, later ones never: simulated time stands still there.

    With `FOREVER` it passes as fast as possible, which is the real-time factor 0.

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


def pace_of(factor: float, stamp_ns: int, steady_ns: int) -> Pace:
    """The pace of a real-time factor.

    Parameters
    ----------
    factor : float
        Simulated time over steady time, taken as its shortest decimal; 0: as fast as possible.
    stamp_ns, steady_ns : int
        A stamp, and the steady time at which it is due, ns.
    """
    return Scaled(stamp_ns, steady_ns, Fraction(repr(factor))) if factor > 0.0 else UpTo(FOREVER)
