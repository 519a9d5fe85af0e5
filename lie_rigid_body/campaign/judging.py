"""An estimator in one run of a campaign: its scores, and its errors at a few times for what is told of all runs."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeAlias

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.campaign.estimators import Entry
from lie_rigid_body.errors import said
from lie_rigid_body.evaluation.arguments import numbers, unit
from lie_rigid_body.evaluation.attitudes import attitude_error, error_vectors
from lie_rigid_body.evaluation.consistency import AXES, rotation_block
from lie_rigid_body.runs import Run
from lie_rigid_body.runs.estimate import Estimate
from lie_rigid_body.wording import short_repr, shortened

Scores: TypeAlias = dict[str, float | str | None]

ERROR: Final = "estimator_error"
"""Column that says why a run has no score."""
SCORES: Final = ("total_rms_deg", "heading_rms_deg", "inclination_rms_deg", "converged_s")
"""Columns of a score: root mean squares of the errors, degrees, and the time to converge, s, if they do."""
MORE_SCORES: Final = ("nees_mean", "gyro_bias_rms_rad_s")
"""Further columns: mean NEES of the covariance, and RMS error of the gyro's bias, rad/s, of what has them."""
CURVE: Final = 50
"""Number of times, evenly over the run, at which the total error is kept."""
SERIES: Final = 20
"""Number of times, evenly over the run, at which errors are kept with their covariances."""
_UPPER: Final = np.triu_indices(3)
"""Places of the numbers of a symmetric matrix that are kept."""
_ATTITUDE: Final = 3 + 6 + 4
_BIAS: Final = 3 + 6


@dataclass(frozen=True)
class Judgement:
    """What an estimator is worth in one run, of which JSON is made.

    Attributes
    ----------
    scores : dict of str to float, str or None
        By the columns `SCORES`, `ERROR` and `MORE_SCORES`.
    reading_s : float or None
        Time that it took, by attitudes, s.
    curve_deg : list of float or None
        Total error, degrees, at `CURVE` times; None where there is no estimate.
    axes : str
        ``world`` or ``body``: the axes of the covariance.
    covariance : list of list of float
        At `SERIES` times: the error as a small rotation, rad, about these axes, the upper triangle of its covariance,
        rad², row by row, and the estimated attitude, scalar last.
    gyro_bias : list of list of float
        At the same times: the error of the gyro's bias, rad/s, and the upper triangle of its covariance, rad²/s².
    """

    scores: Scores
    reading_s: float | None = None
    curve_deg: list[float | None] = field(default_factory=list)
    axes: str = "world"
    covariance: list[list[float]] = field(default_factory=list)
    gyro_bias: list[list[float]] = field(default_factory=list)

    __repr__ = short_repr

    @classmethod
    def read(cls, content: Any) -> Judgement:
        """The judgement of its fields, as JSON has them.

        Raises
        ------
        TypeError, ValueError
            If they are none.
        """
        found = cls(**content)
        scores, series = found.scores, ((found.covariance, _ATTITUDE), (found.gyro_bias, _BIAS))
        numbers = [found.reading_s, *(scores.get(name) for name in (*SCORES, *MORE_SCORES))]
        if (
            scores.keys() != {*SCORES, *MORE_SCORES, ERROR}
            or not {*map(type, numbers)} <= {float, type(None)}
            or not isinstance(scores[ERROR], str | None)
            or found.axes not in AXES
            or len(found.curve_deg) not in (0, CURVE)
            or not {*map(type, found.curve_deg)} <= {float, type(None)}
            or any(rows and not _is_finite(rows, (SERIES, columns)) for rows, columns in series)
        ):
            raise ValueError("no judgement")
        return found

    @property
    def error(self) -> str | None:
        """Why there is no score; None if there is one."""
        return self.scores[ERROR]  # type: ignore[return-value]  # a text is in no other column


def judged(entry: Entry, run: Run) -> Judgement:
    """Call an estimator with a run and score what it returns.

    An estimator that fails, or whose result is of no use, has no score but the reason: nothing else fails of it. It may
    raise anything, also KeyboardInterrupt: no signal raises that here, in a thread of a worker.
    """
    try:
        estimate = entry.load()
        begin = time.perf_counter()
        found = Estimate.of(estimate(run))
        taken = time.perf_counter() - begin
        return replace(_judged(found, run, series=not entry.contender.grid), reading_s=taken / max(1, len(found)))
    except BaseException as error:
        return Judgement({**dict.fromkeys((*SCORES, *MORE_SCORES)), ERROR: shortened(said(error))})


def _judged(found: Estimate, run: Run, *, series: bool) -> Judgement:
    score = run.score(found, diagnosed=False)
    errors = (score.total_deg.rms, score.heading_deg.rms, score.inclination_deg.rms)
    scores: Scores = {
        **dict(zip(SCORES, (*errors, score.time_to_converge_s), strict=True)),
        ERROR: None,
        "nees_mean": None if score.consistency is None else score.consistency.mean,
        "gyro_bias_rms_rad_s": None if score.gyro_bias_rad_s is None else score.gyro_bias_rad_s.rms,
    }
    found = replace(found, t_ns=run.stamps_of(len(found)) if found.t_ns is None else found.t_ns)
    places, known = _nearest(found.t_ns, run, CURVE)
    total = np.degrees(attitude_error(found.attitude_xyzw[places], run.attitude().at(found.t_ns[places])).total)
    curve = [value if is_known else None for value, is_known in zip(_short(total), known, strict=True)]
    places, known = _nearest(found.t_ns, run, SERIES)
    if not (series and known.all()):
        return Judgement(scores, curve_deg=curve)
    return Judgement(
        scores,
        curve_deg=curve,
        axes=found.covariance_axes,
        covariance=_attitude_series(found, run, places),
        gyro_bias=_bias_series(found, run, places),
    )


def _nearest(stamps_ns: Integers, run: Run, count: int) -> tuple[Integers, Any]:
    """Indexes of the estimates at even times from first to last sample of a run, and whether each is at such a time."""
    wanted = np.linspace(run.t_ns[0], run.t_ns[-1], count).astype(np.int64)
    after = np.clip(np.searchsorted(stamps_ns, wanted), 1, max(1, len(stamps_ns) - 1))
    before = after - 1
    after = np.minimum(after, len(stamps_ns) - 1)
    nearest = np.where(wanted - stamps_ns[before] <= stamps_ns[after] - wanted, before, after)
    near = 2 * np.abs(stamps_ns[nearest] - wanted) <= (run.t_ns[-1] - run.t_ns[0]) // (count - 1)
    return nearest, run.attitude().covers(stamps_ns[nearest]) & near


def _attitude_series(found: Estimate, run: Run, places: Integers) -> list[list[float]]:
    if found.covariance is None:
        return []
    stamps, attitudes = found.t_ns[places], unit("estimate", found.attitude_xyzw[places])
    P = np.broadcast_to(rotation_block(found.covariance), (len(found), 3, 3))[places]
    errors = error_vectors(attitudes, run.attitude().at(stamps), found.covariance_axes)
    return _rows(errors, P, attitudes)


def _bias_series(found: Estimate, run: Run, places: Integers) -> list[list[float]]:
    if found.gyro_bias is None or found.gyro_bias_covariance is None:
        return []
    stamps, bias = found.t_ns[places], numbers("gyro_bias", found.gyro_bias, 3)
    P = numbers("gyro_bias_covariance", found.gyro_bias_covariance, 3, 3)
    P = np.broadcast_to(P, (len(found), 3, 3))[places]
    return _rows(bias[places] - run.gyro_bias_at(stamps), P)


def _rows(error: Array, P: Array, *more: Array) -> list[list[float]]:
    return [_short(row) for row in np.column_stack([error, P[:, _UPPER[0], _UPPER[1]], *more])]


def errors_of(series: list[list[list[float]]]) -> tuple[Array, Array, Array]:
    """Errors, (R, T, 3), covariances, (R, T, 3, 3), and what is kept beside them, of the series of R judgements."""
    values = np.array(series, dtype=float)
    P = np.empty((*values.shape[:2], 3, 3))
    P[..., _UPPER[0], _UPPER[1]] = P[..., _UPPER[1], _UPPER[0]] = values[..., 3:_BIAS]
    return values[..., :3], P, values[..., _BIAS:]


def _is_finite(rows: list[list[float]], shape: tuple[int, int]) -> bool:
    values = np.array(rows, dtype=float)
    return values.shape == shape and bool(np.isfinite(values).all())


def _short(values: Array) -> list[float]:
    """Numbers of nine digits, as there are many of them."""
    return [float(f"{value:.9g}") for value in values]
