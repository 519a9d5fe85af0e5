"""An estimate beside the error that the sensors' noise makes unavoidable."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation.statistics import Statistics
from lie_rigid_body.evaluation.unavoidable import UnavoidableError, mean_square
from lie_rigid_body.wording import short_repr

RARE: Final = 0.01
"""Probability below which an estimate is remarked as nearer to the truth than the noise allows."""


@dataclass(frozen=True)
class BestPossible:
    """Bounds of the total error at the samples of a score.

    Attributes
    ----------
    filtered_deg, smoothed_deg : ndarray, shape (N,)
        Root mean square of the total error at best, degrees, from the readings up to each sample, and from all of them.
        The constants of the sensors (scale, mounting, soft iron) are not known.
    unobserved : str
        What no reading tells; then no bound is of use.
    beaten : bool
        Whether the estimate is nearer to the truth than the noise allows, even where the constants are known.
    calibrated : BestPossible or None
        The same where the constants are known; None where there are none.
    """

    filtered_deg: Array
    smoothed_deg: Array
    unobserved: str
    beaten: bool
    calibrated: BestPossible | None = None

    __repr__ = short_repr

    @classmethod
    def of(cls, bound: UnavoidableError, stamps_ns: Integers, rms_deg: float) -> BestPossible:
        """Interpolate the bound at stamps, ns, for an estimate whose total error has the given RMS, degrees."""
        calibrated = None if bound.calibrated is None else cls.of(bound.calibrated, stamps_ns, rms_deg)
        since = stamps_ns - bound.stamps_ns[0]
        times = bound.stamps_ns - bound.stamps_ns[0]
        filtered, smoothed = (
            np.degrees(np.sqrt(np.interp(since, times, mean_square(part)))) for part in (bound.filtered, bound.smoothed)
        )
        # errors that do not change, as by constant biases, are small by luck: no more often than those of one sample
        deviations = np.degrees(np.sqrt(np.linalg.eigvalsh(bound.smoothed).mean(axis=0).clip(1e-300)))
        luck = math.prod(math.erf(rms_deg / (math.sqrt(2.0) * deviation)) for deviation in deviations)
        beaten = not bound.unobserved and luck < RARE
        return cls(filtered, smoothed, bound.unobserved, calibrated.beaten if calibrated else beaten, calibrated)

    @property
    def filtered(self) -> Statistics | None:
        """Statistics of the best filter, by the readings up to each sample, degrees; None where no attitude is told."""
        return None if self.unobserved else Statistics.of(self.filtered_deg)

    @property
    def smoothed(self) -> Statistics | None:
        """Statistics of the best smoother, by all readings, degrees; None where the attitude is not told."""
        return None if self.unobserved else Statistics.of(self.smoothed_deg)

    def to_json(self) -> dict[str, object]:
        """JSON-serialisable data: statistics, what is not observed, whether an estimate is nearer than noise allows."""
        filtered, smoothed = self.filtered, self.smoothed
        return {
            "filtered_deg": filtered.to_json() if filtered else None,
            "smoothed_deg": smoothed.to_json() if smoothed else None,
            "unobserved": self.unobserved,
            "beaten": self.beaten,
            "calibrated": self.calibrated.to_json() if self.calibrated else None,
        }
