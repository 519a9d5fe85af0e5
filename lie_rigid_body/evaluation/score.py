"""The score of an attitude estimate: numbers, and words and columns for terminals, pages and the messages of tests."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple, NoReturn

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation.attitude_error import AttitudeError
from lie_rigid_body.evaluation.best_possible import BestPossible
from lie_rigid_body.evaluation.consistency import Consistency
from lie_rigid_body.evaluation.findings import Finding
from lie_rigid_body.evaluation.limits import Limits
from lie_rigid_body.evaluation.statistics import SMALLEST_LIMIT, Statistics, bias_error
from lie_rigid_body.showing import Shown, data_frame, report
from lie_rigid_body.wording import counted, listed, short_repr

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

LARGEST_SETTLED_DEG: Final = 20.0
"""Largest total error of an estimate that has converged, degrees, unless a larger limit is given."""
WIDTH: Final = 88
"""Width of a line of sentences, characters."""
HEADINGS: Final = ("rms", "median", "95 %", "largest", "final")
"""Headings of the columns of statistics."""


class BiasEstimate(NamedTuple):
    """Estimated biases of a gyro beside the true ones, rad/s.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    estimate, truth : ndarray, shape (N, 3)
    """

    stamps_ns: Integers
    estimate: Array
    truth: Array

    def __repr__(self) -> str:
        return short_repr(self)


@dataclass(frozen=True)
class Score(Shown):
    """Errors of an estimate, and their causes.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
        Of the estimates that were compared.
    error : AttitudeError
        Their errors, rad, shape (N,) each.
    total_deg, heading_deg, inclination_deg : Statistics
        Of these errors, degrees.
    time_to_converge_s : float or None
        From the first sample until the total error stays below `converged_deg`; None if it never does.
    converged_deg : float
        As given, or one and a half times the largest total error in the second half of the run, at most
        `LARGEST_SETTLED_DEG`.
    lag_s : float or None
        Positive if the estimate is late. None if the motion does not tell it.
    lag_standard_error_s : float or None
    findings : tuple of Finding
    broken : tuple of str
        One sentence for each limit that is broken.
    outside : int
        Estimates that were left out because the truth is not known at their stamps.
    truth_uncertainty_deg : float
        Bound of the error of the truth by interpolation, degrees.
    consistency : Consistency or None
        Where a covariance was given.
    gyro_bias : BiasEstimate or None
        Where one was given.
    best : BestPossible or None
        What the sensors' noise leaves at best, where it is known.
    limits : Limits
        Those that it was held against.
    of_sensors_deg : float or None
        Where a constant turn was found that is no mistake: the largest that these sensors leave to a right filter.
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
    best: BestPossible | None = None
    limits: Limits = field(default_factory=Limits)
    of_sensors_deg: float | None = None

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

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            how = {"report": ": call write_report(score, 'score.html') of lie_rigid_body.report"}.get(name, "")
            raise AttributeError(f"a score has no {name}{how}")

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
        return seconds(self.stamps_ns)

    @property
    def passed(self) -> bool:
        """Whether no limit is broken."""
        return not self.broken

    def plot(self, title: str = "attitude estimate") -> Figure:
        """Figure of Matplotlib: the errors over time, with the limits and the best that the noise allows."""
        figure: Figure = report("scores").draw(title, self)
        return figure

    def to_dataframe(self) -> DataFrame:
        """Table of pandas with the errors of every sample, degrees, by ``t_ns``; NEES and bound where they are known.

        Raises
        ------
        LieRigidBodyError
            If pandas is not installed: ``to_dict(series=True)`` has the same numbers.
        """
        return data_frame(self.stamps_ns, self._columns())

    def to_dict(self, *, series: bool = False) -> dict[str, object]:
        """JSON-serialisable data of the score, with its series if they are wanted."""
        content: dict[str, object] = {
            "samples": self.samples,
            "outside": self.outside,
            "total_deg": self.total_deg.to_json(),
            "heading_deg": self.heading_deg.to_json(),
            "inclination_deg": self.inclination_deg.to_json(),
            "time_to_converge_s": self.time_to_converge_s,
            "converged_deg": self.converged_deg,
            "lag_s": self.lag_s,
            "lag_standard_error_s": self.lag_standard_error_s,
            "truth_uncertainty_deg": self.truth_uncertainty_deg,
            "nees": self.consistency.to_json() if self.consistency else None,
            "gyro_bias_rad_s": self.gyro_bias_rad_s.to_json() if self.gyro_bias_rad_s else None,
            "unavoidable": self.best.to_json() if self.best else None,
            "findings": [finding.to_json() for finding in self.findings],
            "broken": list(self.broken),
            "passed": self.passed,
        }
        return content | ({"series": self.series()} if series else {})

    def series(self) -> dict[str, list[float] | list[int]]:
        """Stamps, ns, and error angles, degrees, of every sample; NEES and bound where they are known."""
        return {"stamps_ns": self.stamps_ns.tolist(), **{name: of.tolist() for name, of in self._columns().items()}}

    def _columns(self) -> dict[str, Array]:
        angles = {f"{name}_deg": np.degrees(angle) for name, angle in self.error._asdict().items()}
        nees = {"nees": self.consistency.nees} if self.consistency else {}
        best = {"unavoidable_deg": self.best.filtered_deg} if self.best and not self.best.unobserved else {}
        return {**angles, **nees, **best}


def seconds(stamps_ns: Integers) -> Array:
    """Time since the first stamp, s."""
    return np.asarray((stamps_ns - stamps_ns[0]) / 1e9)


def table(score: Score) -> list[str]:
    """Statistics of the errors and of the best possible, and below what else the score tells, in aligned columns."""
    return [
        f"{'error, deg':<14}" + "".join(f"{heading:>11}" for heading in HEADINGS),
        *(f"{name:<14}" + "".join(f"{n:>11}" for n in numbers(statistics)) for name, statistics in angles(score)),
        "",
        *(f"{name:<14}{value}" for name, value in facts(score)),
    ]


def findings(score: Score) -> list[str]:
    """Findings under their codes, wrapped; if there is none, a line that says so, with a warning of large errors."""
    found = [line for finding in score.findings for line in wrapped(finding.message, f"{finding.code}: ")]
    large = score.total_deg.median > LARGEST_SETTLED_DEG
    return found or [f"no findings{': no mistake that is known explains errors as large' if large else ''}"]


def angles(score: Score) -> Iterator[tuple[str, Statistics]]:
    """Statistics of the three errors by name, and of the best total error that the noise allows, where it is known."""
    yield "total", score.total_deg
    yield "heading", score.heading_deg
    yield "inclination", score.inclination_deg
    if score.best is not None and score.best.filtered and score.best.smoothed:
        yield "best filter", score.best.filtered
        yield "best smoother", score.best.smoothed
        calibrated = score.best.calibrated
        if calibrated is not None and calibrated.filtered and calibrated.smoothed:
            yield "… calibrated", calibrated.filtered
            yield "… smoother", calibrated.smoothed


def numbers(statistics: Statistics) -> list[str]:
    """Statistics as text, in the order of `HEADINGS`."""
    return [f"{value:.4g}" for value in statistics.to_json().values()]


def facts(score: Score) -> Iterator[tuple[str, str]]:
    """Other facts of a score by name."""
    if score.time_to_converge_s is None:
        yield "converged", f"never: the last error is above {score.converged_deg:.4g}°"
    else:
        yield "converged", f"{score.time_to_converge_s:.4g} s after the first, to below {score.converged_deg:.4g}°"
    if score.lag_s is None:
        yield "lag", "not told by this motion and these errors"
    else:
        yield "lag", f"{score.lag_s:+.4g} s ± {score.lag_standard_error_s:.2g} s; positive is late"
    if score.of_sensors_deg is not None:
        yield (
            "sensors",
            f"a constant turn is about what these sensors leave to a right filter, {score.of_sensors_deg:.2g}°",
        )
    if score.truth_uncertainty_deg > SMALLEST_LIMIT:
        yield "truth", f"uncertain by up to {score.truth_uncertainty_deg:.2g}° between its samples"
    consistency = score.consistency
    if consistency is not None:
        low, high = consistency.mean_bounds
        yield (
            "NEES",
            f"{consistency.mean:.4g} on average, expected {consistency.dimension} "
            f"({low:.3g} to {high:.3g} if errors were independent): {consistency.verdict}",
        )
        if consistency.remark:
            yield "remark", consistency.remark
    bias = score.gyro_bias_rad_s
    if bias is not None:
        yield "gyro bias", f"off by {bias.rms:.4g} rad/s rms, {bias.final:.4g} rad/s at the end"
    if score.best is not None and score.best.unobserved:
        yield "best filter", f"not known: no sensor tells {score.best.unobserved}"
    if score.best is not None and score.best.beaten:
        yield "remark", "nearer than noise allows: it has seen the truth, or the noise is not as declared"


def verdict(score: Score) -> list[str]:
    """Sentences about whether limits are kept; none if none were given."""
    broken = [f"BROKEN: {sentence}." for sentence in score.broken]
    return broken or ([] if score.limits == Limits() else ["PASSED: every limit is kept."])


def wrapped(sentence: str, mark: str = "") -> list[str]:
    """Lines of a sentence for a terminal, the first after a mark."""
    return textwrap.wrap(sentence, WIDTH, initial_indent=mark, subsequent_indent="  ")
