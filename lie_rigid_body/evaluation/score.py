"""The score of an attitude estimate: numbers, and words and columns for terminals, pages and the messages of tests."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from lie_rigid_body.evaluation.attitudes import AttitudeError
from lie_rigid_body.evaluation.consistency import Consistency
from lie_rigid_body.evaluation.cramer_rao_bound import CramerRaoBound, mean_square
from lie_rigid_body.evaluation.statistics import SMALLEST_LIMIT, Limits, Statistics, bias_error
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.showing import Shown, data_frame, report
from lie_rigid_body.foundation.wording import counted, listed

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

LARGEST_SETTLED_DEG: Final = 20.0
"""Largest total error of an estimate that has converged, degrees, unless a larger limit is given."""
HEADINGS: Final = ("rms", "median", "95 %", "largest", "final")
"""Headings of the columns of statistics."""


@short_dataclass(frozen=True)
class Finding:
    """Mistake in an estimate, with what to do.

    Attributes
    ----------
    code : str
        ``inverted``, ``scalar_first``, ``ned_world``, ``heading_offset``, ``body_mounting``, ``lagging``, ``leading``,
        ``clock_rate``, ``world_turned``, ``stuck``, ``mixed``, ``turn_rate``, ``turn_axes``, ``gaps`` or ``not_unit``.
    message : str
        One sentence with numbers, and what to do.
    rms_deg_after : float
        RMS of the total error that is left when this cause and those before it are undone, degrees. Of what cannot be
        undone that of the estimate.
    """

    code: str
    message: str
    rms_deg_after: float


@short_dataclass(frozen=True, eq=False)
class BiasEstimate:
    """Estimated biases of a gyro beside the true ones, rad/s.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    estimate, truth : ndarray, shape (N, 3)
    """

    stamps_ns: Integers
    estimate: Array
    truth: Array

    def at(self, stamps_ns: Integers) -> dict[str, Array]:
        """Length of the error at stamps, ns, rad/s, interpolated between the estimates; with the name of its column."""
        t_ns, times = (stamps - self.stamps_ns[0] for stamps in (self.stamps_ns, stamps_ns))
        return {"gyro_bias_error_rad_s": np.interp(times, t_ns, np.linalg.norm(self.estimate - self.truth, axis=-1))}


@short_dataclass(frozen=True, eq=False)
class BoundComparison:
    """Bounds of the total error at the samples of a score.

    Attributes
    ----------
    filtered_deg : ndarray, shape (N,)
        Root mean square of the total error at best, degrees, from the readings up to each sample. The constants of the
        sensors (scale, mounting, soft iron) are not known.
    filtered, smoothed : Statistics or None
        Statistics of this, and of the best from all readings, degrees; None where no reading tells the attitude.
    unobserved : str
        What no reading tells; then no bound is of use.
    beaten : bool
        Whether the estimate is nearer to the truth than the noise allows, even where the constants are known.
    calibrated : BoundComparison or None
        Bounds for known constants; None where there are no constants.
    """

    filtered_deg: Array
    filtered: Statistics | None
    smoothed: Statistics | None
    unobserved: str
    beaten: bool
    calibrated: BoundComparison | None = None

    @classmethod
    def of(cls, bound: CramerRaoBound, stamps_ns: Integers, rms_deg: float) -> BoundComparison:
        """Interpolate the bound at stamps, ns, for an estimate whose total error has the given RMS, degrees."""
        calibrated = None if bound.calibrated is None else cls.of(bound.calibrated, stamps_ns, rms_deg)
        since, times = (stamps - bound.stamps_ns[0] for stamps in (stamps_ns, bound.stamps_ns))
        filtered, smoothed = (
            np.degrees(np.sqrt(np.interp(since, times, mean_square(part)))) for part in (bound.filtered, bound.smoothed)
        )
        # errors that do not change, as by constant biases, are small by luck: no more often than those of one sample
        deviations = np.degrees(np.sqrt(np.linalg.eigvalsh(bound.smoothed).mean(axis=0).clip(1e-300)))
        luck = math.prod(math.erf(rms_deg / (math.sqrt(2.0) * deviation)) for deviation in deviations)
        beaten = calibrated.beaten if calibrated else not bound.unobserved and luck < 0.01
        of_filtered, of_smoothed = (None if bound.unobserved else Statistics.of(e) for e in (filtered, smoothed))
        return cls(filtered, of_filtered, of_smoothed, bound.unobserved, beaten, calibrated)

    def to_json(self) -> dict[str, object]:
        """JSON-serialisable data: statistics, what is not observed, whether an estimate is nearer than noise allows."""
        return {
            "filtered_deg": self.filtered and asdict(self.filtered),
            "smoothed_deg": self.smoothed and asdict(self.smoothed),
            "unobserved": self.unobserved,
            "beaten": self.beaten,
            "calibrated": self.calibrated and self.calibrated.to_json(),
        }


@dataclass(frozen=True, eq=False)
class Score(Shown):
    """Errors of an estimate, and their causes.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
        Stamps of the estimates that were compared, ns.
    error : AttitudeError
        Errors of these estimates, rad, shape (N,) each.
    total_deg, heading_deg, inclination_deg : Statistics
        Statistics of these errors, degrees.
    time_to_converge_s : float or None
        Time from the first sample until the total error stays below `converged_deg`, s; None if it never does.
    converged_deg : float
        Largest total error of a converged estimate, degrees: as given, or one and a half times the largest in the
        second half of the run, at most `LARGEST_SETTLED_DEG`.
    lag_s : float or None
        Lag of the estimate behind the truth, s; None if the motion does not tell it.
    lag_standard_error_s : float or None
    findings : tuple of Finding
    broken : tuple of str
        One sentence for each limit that is broken.
    outside : int
        Estimates that were left out because the truth is not known at their stamps.
    truth_uncertainty_deg : float
        Bound of the error of the truth by interpolation, degrees.
    consistency : Consistency or None
        Consistency of the covariance, where one was given.
    gyro_bias : BiasEstimate or None
        Estimated gyro bias beside the true one, where one was given.
    best : BoundComparison or None
        Bounds that the sensors' noise sets, where it is known.
    limits : Limits
        Limits with which the errors were compared.
    of_sensors_deg : float or None
        Largest constant turn that these sensors leave to a right filter, degrees; None unless such a turn was found.
    gyro_at_limit : float
        Share of the gyro's readings that are at the limit of its range, from 0 to 1.
    """

    stamps_ns: Integers
    error: AttitudeError
    total_deg: Statistics
    heading_deg: Statistics
    inclination_deg: Statistics
    time_to_converge_s: float | None
    converged_deg: float
    lag_s: float | None
    lag_standard_error_s: float | None
    findings: tuple[Finding, ...]
    broken: tuple[str, ...]
    outside: int
    truth_uncertainty_deg: float
    consistency: Consistency | None = None
    gyro_bias: BiasEstimate | None = None
    best: BoundComparison | None = None
    limits: Limits = field(default_factory=Limits)
    of_sensors_deg: float | None = None
    gyro_at_limit: float = 0.0

    def __repr__(self) -> str:
        """The error, the causes and the verdict; no call, as only `evaluate` makes one."""
        found = f"; {listed([finding.code for finding in self.findings])}" if self.findings else ""
        broken = "" if self.passed else "; a limit is broken"
        return f"<Score: {self.total_deg.rms:.4g}° rms of {counted(self.samples, 'sample')}{found}{broken}>"

    def __str__(self) -> str:
        """Table and findings in several lines, as ``evaluate`` prints them."""
        return "\n".join(
            [*table(self), "", *findings(self), *(line for text in verdict(self) for line in wrapped(text))]
        )

    @property
    def gyro_bias_rad_s(self) -> Statistics | None:
        """Statistics of the norm of the error of an estimated gyro bias, rad/s; None where none was given."""
        return None if self.gyro_bias is None else bias_error(self.gyro_bias.estimate, self.gyro_bias.truth)

    @property
    def samples(self) -> int:
        """Number of estimates that were compared."""
        return len(self.stamps_ns)

    @property
    def t_s(self) -> Array:
        """Times of the samples since the first, s, shape (N,)."""
        return np.asarray((self.stamps_ns - self.stamps_ns[0]) / 1e9)

    @property
    def passed(self) -> bool:
        """Whether no limit is broken."""
        return not self.broken

    def plot(self, title: str = "attitude estimate") -> Figure:
        """Figure of Matplotlib: the errors over time, with the limits and the best that the noise allows."""
        figure: Figure = report("scores").draw(title, self)
        return figure

    def to_dataframe(self) -> DataFrame:
        """Table of pandas with the errors of every sample, degrees, by ``t_ns``; and NEES, bound and bias, if known.

        Raises
        ------
        LieRigidBodyError
            If pandas is not installed: ``to_dict(series=True)`` has the same numbers.
        """
        return data_frame(self.stamps_ns, self._columns())

    def to_dict(self, *, series: bool = False) -> dict[str, object]:
        """JSON-serialisable data of the score, if wanted with stamps, ns, and the errors of every sample."""
        content: dict[str, object] = {
            "samples": self.samples,
            "outside": self.outside,
            "total_deg": asdict(self.total_deg),
            "heading_deg": asdict(self.heading_deg),
            "inclination_deg": asdict(self.inclination_deg),
            "time_to_converge_s": self.time_to_converge_s,
            "converged_deg": self.converged_deg,
            "lag_s": self.lag_s,
            "lag_standard_error_s": self.lag_standard_error_s,
            "truth_uncertainty_deg": self.truth_uncertainty_deg,
            "nees": self.consistency and self.consistency.to_json(),
            "gyro_bias_rad_s": self.gyro_bias_rad_s and asdict(self.gyro_bias_rad_s),
            "unavoidable": self.best and self.best.to_json(),
            "findings": [asdict(finding) for finding in self.findings],
            "broken": list(self.broken),
            "passed": self.passed,
        }
        columns = {"stamps_ns": self.stamps_ns, **self._columns()}
        return content | ({"series": {name: of.tolist() for name, of in columns.items()}} if series else {})

    def _columns(self) -> dict[str, Array]:
        angles = {f"{name}_deg": np.degrees(angle) for name, angle in self.error._asdict().items()}
        nees = {"nees": self.consistency.nees} if self.consistency else {}
        best = {"unavoidable_deg": self.best.filtered_deg} if self.best and not self.best.unobserved else {}
        return {**angles, **nees, **best, **(self.gyro_bias.at(self.stamps_ns) if self.gyro_bias else {})}


def table(score: Score) -> list[str]:
    """Statistics of the errors and of the best possible, and below what else the score tells, in aligned columns."""
    return [
        f"{'error, deg':<20}" + "".join(f"{heading:>11}" for heading in HEADINGS),
        *(f"{name:<20}" + "".join(f"{n:>11}" for n in numbers(statistics)) for name, statistics in angles(score)),
        "",
        *(f"{name:<14}{value}" for name, value in facts(score)),
    ]


def findings(score: Score) -> list[str]:
    """Findings under their codes, wrapped; if there is none, a line that says so, with a warning of large errors."""
    found = [line for finding in score.findings for line in wrapped(finding.message, f"{finding.code}: ")]
    large = ": no known mistake in it explains errors as large: diagnose looks for those in what a filter reads"
    return found or [f"no findings{large if score.total_deg.median > LARGEST_SETTLED_DEG else ''}"]


def angles(score: Score) -> Iterator[tuple[str, Statistics]]:
    """Statistics of the three errors by name, and of the best total error that the noise allows, where it is known."""
    best = score.best if score.best and score.best.filtered else None
    calibrated = best and best.calibrated
    rows = {
        "total": score.total_deg,
        "heading": score.heading_deg,
        "inclination": score.inclination_deg,
        "best filter": best and best.filtered,
        "best smoother": best and best.smoothed,
        "calibrated filter": calibrated and calibrated.filtered,
        "calibrated smoother": calibrated and calibrated.smoothed,
    }
    return ((name, found) for name, found in rows.items() if found)


def numbers(statistics: Statistics) -> list[str]:
    """Statistics as text, degrees, in the order of `HEADINGS`: round-off, of 1e-13°, counts as 0."""
    return [f"{round(value, 12):.4g}" for value in asdict(statistics).values()]


def facts(score: Score) -> Iterator[tuple[str, str]]:
    """Other facts of a score by name, each a sentence."""
    limit = f"{score.converged_deg:.4g}°"
    if score.time_to_converge_s is None:
        yield "converged", f"never: the last error is above {limit}"
    else:
        yield "converged", f"{score.time_to_converge_s:.4g} s after the first, to below {limit}"
    if score.lag_s is None:
        yield "lag", "not told by this motion and these errors"
    else:
        # stamps are whole nanoseconds
        yield "lag", f"{round(score.lag_s, 9):+.4g} s ± {score.lag_standard_error_s:.2g} s; positive is late"
    if score.of_sensors_deg is not None:
        left = f"{score.of_sensors_deg:.2g}°"
        yield "sensors", f"a constant turn is about what these sensors leave to a right filter, {left}"
    if score.gyro_at_limit:
        share = f"{100.0 * score.gyro_at_limit:.3g} %"
        yield "gyro", f"at the limit of its range in {share} of the readings: the body turns faster"
    if score.truth_uncertainty_deg > SMALLEST_LIMIT:
        yield "truth", f"uncertain by up to {score.truth_uncertainty_deg:.2g}° between its samples"
    if score.consistency:
        yield "NEES", score.consistency.sentence
        if score.consistency.remark:
            yield "remark", score.consistency.remark
    if bias := score.gyro_bias_rad_s:
        yield "gyro bias", f"off by {bias.rms:.4g} rad/s rms, {bias.final:.4g} rad/s at the end"
    if score.best and score.best.unobserved:
        yield "best filter", f"not known: no sensor tells {score.best.unobserved}"
    if score.best and score.best.beaten:
        yield "remark", "nearer than noise allows: it has seen the truth, or the noise is not as declared"


def verdict(score: Score) -> list[str]:
    """Sentences about whether limits are kept; none if none were given."""
    kept = [] if score.limits == Limits() else ["PASSED: every limit is kept."]
    return [f"BROKEN: {sentence}." for sentence in score.broken] or kept


def wrapped(sentence: str, mark: str = "", width: int = 88) -> list[str]:
    """Lines of a sentence for a terminal, the first after a mark."""
    return textwrap.wrap(sentence, width, initial_indent=mark, subsequent_indent="  ")
