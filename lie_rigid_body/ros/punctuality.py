"""How punctual the samples are."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Punctuality:
    """What a run has sent so far, and how late.

    Parameters
    ----------
    sent : int
        Samples of the truth.
    missed : int
        Of these, the ones sent later than a sample period, or a millisecond if that is longer, after they were due.
    lateness_ns : int
        How late the latest was, ns.
    worst_ns : int
        How late the worst was, ns.
    """

    sent: int = 0
    missed: int = 0
    lateness_ns: int = 0
    worst_ns: int = 0

    def after(self, sent: int, missed: int, lateness_ns: int) -> Punctuality:
        """The same after another burst, whose first sample was the latest."""
        worst = max(self.worst_ns, lateness_ns)
        return Punctuality(self.sent + sent, self.missed + missed, lateness_ns, worst)
