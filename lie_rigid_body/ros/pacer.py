"""When samples are due: the sample grid laid along a steady clock, in integer nanoseconds."""

from __future__ import annotations

from dataclasses import dataclass

from lie_rigid_body.simulation import SampleClock


@dataclass(frozen=True)
class Pacer:
    """The fixed relation between stamps and a steady clock.

    A sample is due when the steady clock reaches its stamp plus an offset that never changes. So nothing drifts, no
    sample is skipped, and what a stall delayed is simply due at once.

    Parameters
    ----------
    clock : SampleClock
        Stamps by sample number.
    offset_ns : int
        Steady time minus stamp, ns.
    """

    clock: SampleClock
    offset_ns: int

    def samples_due(self, first: int, steady_ns: int) -> int:
        """How many samples from number ``first`` on are due.

        Parameters
        ----------
        first : int
            Number of the next sample.
        steady_ns : int
            The steady clock now.

        Returns
        -------
        int
            0 or more.
        """
        elapsed = steady_ns - self.offset_ns - self.clock.epoch_ns
        period = self.clock.period_ns
        n, d = period.numerator, period.denominator
        # round(k n/d) <= elapsed, solved for k
        last = (2 * elapsed + 1) * d // (2 * n)
        return max(0, last + 1 - first)

    def lateness_ns(self, number: int, steady_ns: int) -> int:
        """How long ago a sample was due, ns; negative before it is.

        Parameters
        ----------
        number : int
            Of the sample.
        steady_ns : int
            The steady clock now.
        """
        period = self.clock.period_ns
        n, d = period.numerator, period.denominator
        due = self.clock.epoch_ns + (2 * number * n + d) // (2 * d) + self.offset_ns
        return steady_ns - due
