"""The result of holding a law against samples: how near it came to its limit, and where."""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol, TypeAlias

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass

SHOWN: Final = 4
"""Number of samples of a broken law, or of faults of a kind, that are listed."""


@short_dataclass
class LawResult:
    """The result of one law on one segment, or on a bag as a whole.

    Parameters
    ----------
    name : str
        Name of the law.
    unit : str
        Unit of ``worst`` and ``limit``; ``rel`` means relative.
    worst : float
        The largest residual; of a broken law the one that went farthest beyond its limit.
    limit : float
        Its limit; infinite where the residual is reported and not judged.
    sample : int or None
        Number of the sample where that was.
    stamp_ns : int or None
        Its stamp.
    broken : int
        How many residuals exceed their limits.
    checked : int
        How many residuals there were.
    message : str
        What is wrong and where, or empty.
    """

    name: str
    unit: str
    worst: float
    limit: float
    sample: int | None
    stamp_ns: int | None
    broken: int
    checked: int
    message: str = ""

    @classmethod
    def of_faults(cls, name: str, faults: int, message: str, checked: int = 1) -> LawResult:
        """The result of a law that counts faults, and holds where there are none."""
        return cls(name, "", float(faults), 0.0, None, None, faults, checked, message if faults else "")

    @property
    def holds(self) -> bool:
        """Whether no residual exceeds its limit."""
        return self.broken == 0

    @property
    def is_judged(self) -> bool:
        """Whether residuals have a limit; otherwise they are reported alone."""
        return self.limit < np.inf

    @property
    def share(self) -> float:
        """The largest residual as a share of its limit; above 1 where the law is broken, and infinite for NaN."""
        if not self.is_judged:
            return 0.0
        if self.limit > 0.0:
            return np.inf if np.isnan(self.worst) else self.worst / self.limit
        return 0.0 if self.holds else np.inf


Laws: TypeAlias = tuple[LawResult, ...]
"""Results of laws, in the order in which they are told."""


class Watch(Protocol):
    """Receiver of residuals as they are compared with their limits."""

    def __call__(self, name: str, unit: str, residuals: Array, limits: Array | float, stamps_ns: Integers) -> None:
        """Take the residuals of a law for the samples that come next."""


class _Worst(NamedTuple):
    """The residual of the largest weight, the first of several."""

    weight: float = -np.inf
    residual: float = 0.0
    limit: float = 0.0
    sample: int = 0
    stamp_ns: int = 0

    def or_among(self, weights: Array, *arrays: Array | Integers) -> _Worst:
        """Whichever is larger, it or the largest of some weights, with residuals, limits, samples and stamps."""
        i = np.argmax(weights)
        return _Worst(*(array[i].item() for array in (weights, *arrays))) if weights[i] > self.weight else self


class LawTally:
    """A law held against residuals as they come.

    Parameters
    ----------
    name, unit : str
        Name of the law, unit of its residuals.
    what : str
        The message for a broken law, with ``{worst}``, ``{limit}``, ``{where}`` and ``{count}`` to be filled in.
    noun : str, optional
        What its samples are called.
    watch : Watch, optional
        It is told of all residuals.
    """

    def __init__(self, name: str, unit: str, what: str, noun: str = "sample", watch: Watch | None = None) -> None:
        self.name = name
        self._unit = unit
        self._what = what
        self._noun = noun
        self._watch = watch
        self._checked = self._broken = self._last = 0
        self._first = list[int]()
        self._largest = self._farthest = _Worst()

    def add(self, residuals: Array, limits: Array | float, samples: Integers, stamps_ns: Integers) -> None:
        """Hold residuals against their limits.

        Parameters
        ----------
        residuals : ndarray, shape (N,)
            Not negative; NaN counts as broken.
        limits : ndarray, shape (N,), or float
        samples, stamps_ns : ndarray of int64, shape (N,)
            Where each residual belongs.
        """
        if residuals.size == 0:
            return
        if self._watch is not None:
            self._watch(self.name, self._unit, residuals, limits, stamps_ns)
        limits = np.broadcast_to(np.asarray(limits, dtype=np.float64), residuals.shape)
        self._checked += residuals.size
        broken = ~((residuals <= limits) | np.isinf(limits))
        weights = np.where(np.isnan(residuals), np.inf, residuals)
        self._largest = self._largest.or_among(weights, residuals, limits, samples, stamps_ns)
        if broken.any():
            beyond = np.divide(weights, limits, out=np.where(broken, np.inf, 0.0), where=limits > 0.0)
            self._farthest = self._farthest.or_among(beyond, residuals, limits, samples, stamps_ns)
            self._broken += int(np.count_nonzero(broken))
            self._first += samples[broken][: SHOWN - len(self._first)].tolist()
            self._last = int(samples[broken][-1])

    def result(self) -> LawResult:
        """The result for all residuals so far."""
        broken = self._broken
        checked = self._checked
        at = self._farthest if broken else self._largest
        numbers = {"worst": f"{at.residual:.3g}", "limit": f"{at.limit:.2g}", "count": f"{broken} of {checked}"}
        message = self._what.format(**numbers, where=self._where(at.sample)) if broken else ""
        sample, stamp = (at.sample, at.stamp_ns) if checked else (None, None)
        return LawResult(self.name, self._unit, at.residual, at.limit, sample, stamp, broken, checked, message)

    def _where(self, worst: int) -> str:
        """The samples of a broken law in words."""
        if self._broken == 1:
            return f"{self._noun} {worst}"
        if self._broken <= SHOWN:
            return f"{self._noun}s " + ", ".join(str(k) for k in self._first)
        return f"{self._broken} {self._noun}s from {self._first[0]} to {self._last}, worst at {worst}"
