"""The result of holding a law against samples: how near it came to its limit, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.wording import short_repr


@dataclass(frozen=True)
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
        Its limit.
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

    __repr__ = short_repr

    @property
    def holds(self) -> bool:
        """Whether no residual exceeds its limit."""
        return self.broken == 0


def judge(
    name: str,
    unit: str,
    residuals: Array,
    limits: Array | float,
    samples: Integers,
    stamps_ns: Integers,
    what: str,
) -> LawResult:
    """Hold residuals against their limits.

    Parameters
    ----------
    name, unit : str
        Name of the law, unit of its residuals.
    residuals : ndarray, shape (N,)
        Not negative; NaN counts as broken.
    limits : ndarray, shape (N,), or float
    samples, stamps_ns : ndarray of int64, shape (N,)
        Where each residual belongs.
    what : str
        The message for a broken law, with ``{worst}``, ``{limit}``, ``{where}`` and ``{count}`` to be filled in.

    Returns
    -------
    LawResult
    """
    limits = np.broadcast_to(np.asarray(limits, dtype=np.float64), residuals.shape)
    if residuals.size == 0:
        return LawResult(name, unit, 0.0, 0.0, None, None, 0, 0)
    broken = ~(residuals <= limits)
    weights = np.where(np.isnan(residuals), np.inf, residuals)
    at = int(np.argmax(weights / limits if broken.any() else weights))
    sample, stamp, count = int(samples[at]), int(stamps_ns[at]), int(broken.sum())
    worst, limit = float(residuals[at]), float(limits[at])
    message = ""
    if count:
        message = what.format(
            worst=f"{worst:.3g}",
            limit=f"{limit:.2g}",
            where=_where(samples[broken], sample),
            count=f"{count} of {residuals.size}",
        )
    return LawResult(name, unit, worst, limit, sample, stamp, count, residuals.size, message)


def _where(broken: Integers, worst: int) -> str:
    """The samples of a broken law, in words."""
    if broken.size == 1:
        return f"sample {worst}"
    if broken.size <= 4:
        return "samples " + ", ".join(str(k) for k in broken)
    return f"{broken.size} samples from {broken[0]} to {broken[-1]}, worst at {worst}"
