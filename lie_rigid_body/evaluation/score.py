"""The score of an attitude estimate: errors, their statistics and their causes."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lie_rigid_body.evaluation.attitudes import AttitudeError
from lie_rigid_body.evaluation.consistency import Consistency
from lie_rigid_body.evaluation.cramer_rao_bound import CramerRaoBound, mean_square
from lie_rigid_body.evaluation.statistics import Limits, Statistics, bias_error
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.showing import Shown, data_frame, report
from lie_rigid_body.foundation.wording import counted, in_degrees, listed

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

MAX_LUCK: Final = 1e-3
"""Largest probability of an error that is called smaller than the noise allows."""


@short_dataclass
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


@short_dataclass
class ScoreNote:
    """Property of an estimate that is no mistake.

    Attributes
    ----------
    code : str
        ``ahead_by_a_sample``.
    message : str
    value : float
        Size of its effect, degrees.
    """

    code: str
    message: str
    value: float


@short_dataclass(eq=False)
class BiasEstimate:
    """Estimated biases of a gyro beside the true ones, rad/s.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    estimate, truth : ndarray, shape (N, 3)
    covariance : ndarray, shape (N, 3, 3) or (3, 3), or None
        That the estimator claims, rad²/s².
    """

    stamps_ns: Integers
    estimate: Array
    truth: Array
    covariance: Array | None = None

    @property
    def claimed_exact(self) -> int:
        """Number of estimates with an error whose covariance is 0."""
        if self.covariance is None:
            return 0
        return int(np.sum((self.estimate != self.truth).any(axis=-1) & ~self.covariance.any(axis=(-2, -1))))

    def at(self, stamps_ns: Integers) -> dict[str, Array]:
        """Length of the error at stamps, ns, rad/s, interpolated between the estimates; with the name of its column."""
        t_ns, times = (stamps - self.stamps_ns[0] for stamps in (self.stamps_ns, stamps_ns))
        return {"gyro_bias_error_rad_s": np.interp(times, t_ns, np.linalg.norm(self.estimate - self.truth, axis=-1))}


@short_dataclass(eq=False)
class BoundComparison:
    """Cramér–Rao bounds of the total error at the samples of a score, for estimators that do not know the dynamics.

    Attributes
    ----------
    filtered_deg : ndarray, shape (N,)
        Bound of the root mean square of the total error, degrees, from the readings up to each sample. The constants of
        the sensors (scale, mounting, soft iron) are not known.
    filtered, smoothed : Statistics or None
        Statistics of this, and of the bound from all readings, degrees; None where no reading tells the attitude.
    unobserved : str
        What no reading tells; then no bound is of use.
    beaten : bool
        Whether the error is so small that estimators which know the constants and the dynamics have it in fewer than
        1 of 1000 runs.
    calibrated : BoundComparison or None
        Bounds for known constants; None where there are no constants.
    dynamic : BoundComparison or None
        Bounds for estimators that know the constants, the inertia and Euler's equations; None of a body that is kicked.
    carried : bool
        Whether the body is accelerated, and its acceleration counts as known along its own axes.
    """

    filtered_deg: Array
    filtered: Statistics | None
    smoothed: Statistics | None
    unobserved: str
    beaten: bool
    calibrated: BoundComparison | None
    dynamic: BoundComparison | None
    carried: bool

    @classmethod
    def of(cls, bound: CramerRaoBound, stamps_ns: Integers, rms_deg: float) -> BoundComparison:
        """Interpolate the bound at stamps, ns, for an estimate whose total error has the given RMS, degrees."""
        calibrated, dynamic = (
            None if part is None else cls.of(part, stamps_ns, rms_deg) for part in (bound.calibrated, bound.dynamic)
        )
        since, times = (stamps - bound.stamps_ns[0] for stamps in (stamps_ns, bound.stamps_ns))
        filtered, smoothed = (
            np.degrees(np.sqrt(np.interp(since, times, mean_square(part)))) for part in (bound.filtered, bound.smoothed)
        )
        beaten = dynamic.beaten if dynamic else bound.is_below(stamps_ns, np.radians(rms_deg) ** 2, MAX_LUCK)
        of_filtered, of_smoothed = (None if bound.unobserved else Statistics.of(e) for e in (filtered, smoothed))
        return cls(filtered, of_filtered, of_smoothed, bound.unobserved, beaten, calibrated, dynamic, bound.carried)

    def to_json(self) -> dict[str, object]:
        """JSON-serialisable data: statistics, what is not observed, and whether an error is below the bounds."""
        return {
            "filtered_deg": self.filtered and asdict(self.filtered),
            "smoothed_deg": self.smoothed and asdict(self.smoothed),
            "unobserved": self.unobserved,
            "beaten": self.beaten,
            "carried": self.carried,
            "calibrated": self.calibrated and self.calibrated.to_json(),
            "dynamic": self.dynamic and self.dynamic.to_json(),
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
        second half of the run, at most `MAX_SETTLED_DEG`.
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
        Cramér–Rao bounds by the sensors' noise, where it is known.
    limits : Limits
        Limits with which the errors were compared.
    of_sensors_deg : float or None
        Largest constant turn that these sensors leave to a right filter, degrees; None unless such a turn was found.
    settled_deg : float or None
        Largest total error of the second half of the run, degrees, where no limit of convergence was given.
    gyro_at_limit : float
        Share of the gyro's readings that are at the limit of its range, from 0 to 1.
    remarks : tuple of str
        Sentences that come before the errors.
    notes : tuple of ScoreNote
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
    consistency: Consistency | None
    gyro_bias: BiasEstimate | None
    best: BoundComparison | None
    limits: Limits
    of_sensors_deg: float | None
    gyro_at_limit: float
    settled_deg: float | None
    remarks: tuple[str, ...]
    notes: tuple[ScoreNote, ...]

    def __repr__(self) -> str:
        """The error, the causes and the verdict; no call, as only `evaluate` makes one."""
        found = f"; {listed([finding.code for finding in self.findings])}" if self.findings else ""
        broken = "" if self.passed else "; a limit is broken"
        return f"<Score: {in_degrees(self.total_deg.rms)} rms of {counted(self.samples, 'sample')}{found}{broken}>"

    def __str__(self) -> str:
        """Verdict, tables and findings in several lines, as ``evaluate`` prints them."""
        return str(report("scores").as_text(self))

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
        """Figure of Matplotlib: the errors over time, with the limits and the Cramér–Rao bound."""
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
        content = {
            "samples": self.samples,
            "outside": self.outside,
            "total_deg": asdict(self.total_deg),
            "heading_deg": asdict(self.heading_deg),
            "inclination_deg": asdict(self.inclination_deg),
            "time_to_converge_s": self.time_to_converge_s,
            "converged_deg": self.converged_deg,
            "settled_deg": self.settled_deg,
            "lag_s": self.lag_s,
            "lag_standard_error_s": self.lag_standard_error_s,
            "truth_uncertainty_deg": self.truth_uncertainty_deg,
            "nees": self.consistency and self.consistency.to_json(),
            "gyro_bias_rad_s": self.gyro_bias_rad_s and asdict(self.gyro_bias_rad_s),
            "cramer_rao_bound": self.best and self.best.to_json(),
            "findings": [asdict(finding) for finding in self.findings],
            "notes": [asdict(note) for note in self.notes],
            "remarks": list(self.remarks),
            "broken": list(self.broken),
            "passed": self.passed,
        }
        columns = {"stamps_ns": self.stamps_ns, **self._columns()}
        return content | ({"series": {name: of.tolist() for name, of in columns.items()}} if series else {})

    def _columns(self) -> dict[str, Array]:
        angles = {f"{name}_deg": np.degrees(angle) for name, angle in self.error._asdict().items()}
        nees = {"nees": self.consistency.nees} if self.consistency else {}
        best = {"cramer_rao_bound_deg": self.best.filtered_deg} if self.best and not self.best.unobserved else {}
        return {**angles, **nees, **best, **(self.gyro_bias.at(self.stamps_ns) if self.gyro_bias else {})}
