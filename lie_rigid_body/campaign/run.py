"""One run of a campaign: its bag, its certificate, what its estimators are worth, and the row that says so.

Of an estimator's errors those at a few times are kept, for what is told of all runs.
"""

from __future__ import annotations

import tempfile
import time
import warnings
from collections import defaultdict
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path
from threading import local
from typing import Any, Final, TypeAlias

import numpy as np

from lie_rigid_body.campaign.definition import Campaign, EstimatorSpec
from lie_rigid_body.certificate import certify
from lie_rigid_body.estimates.estimators import called
from lie_rigid_body.evaluation.arguments import numbers, unit
from lie_rigid_body.evaluation.attitudes import Truth, attitude_error, error_vectors
from lie_rigid_body.evaluation.consistency import factor_of
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import Value
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.bag_writer import BagWriter, write_run
from lie_rigid_body.runs import Run, simulate
from lie_rigid_body.runs.ensemble import BlindRun
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system.interpreters import STARTING_S, Interpreter

BAGS: Final = "bags"
"""Name of the folder of the bags in the folder of a campaign."""
Scores: TypeAlias = dict[str, float | str | None]
Series: TypeAlias = list[list[float]]
"""Numbers at `SERIES` times of a run, a row for each time."""

ERROR: Final = "estimator_error"
"""Column that says why a run has no score."""
SCORES: Final = ("total_rms_deg", "heading_rms_deg", "inclination_rms_deg", "converged_s")
"""Columns of a score: RMS errors, degrees, and the time to converge, s, if the estimate converges."""
MORE_SCORES: Final = ("nees_mean", "gyro_bias_rms_rad_s")
"""Further columns of a score: mean NEES, if there is a covariance, and RMS error of an estimated gyro bias, rad/s."""
CURVE: Final = 50
"""Number of times, evenly over the run, at which the total error is kept."""
SERIES: Final = 20
"""Number of times, evenly over the run, at which errors are kept with their covariances."""
MAX_ESTIMATOR_S: Final = 60.0
"""Longest time of an estimator in a run, s, unless the run is longer; its process has `STARTING_S` more."""
_of_thread: Final = local()
"""State of each thread of a worker: its campaign, and a Python interpreter for each estimator, which calls it."""


@dataclass(frozen=True)
class Row:
    """A finished run.

    Parameters
    ----------
    run : int
        Its number.
    parameters : dict of str to value
        Those that vary, as its scenario has them.
    certified : bool
        Whether its bag keeps every law.
    attitude_accuracy_rad : float
        Bound of the error of its attitudes, rad.
    bag : str or None
        Path of its bag in the folder of the campaign.
    bag_bytes : int or None
        The size of that bag, bytes; None without one.
    run_scores : list of dict
        Fields of a `RunScore` for each of the campaign's entries.
    """

    run: int
    parameters: dict[str, Value] = field(default_factory=dict)
    certified: bool = False
    attitude_accuracy_rad: float = 0.0
    bag: str | None = None
    bag_bytes: int | None = None
    run_scores: list[dict[str, Any]] = field(default_factory=list)

    def has_bag(self, folder: Path) -> bool:
        """Whether its bag is in the folder of the campaign, and has the size that it had when it was finished."""
        try:
            return self.bag is not None and (folder / self.bag).stat().st_size == self.bag_bytes
        except OSError:
            return False


def bag_name(run: int) -> str:
    """The path of a run's bag in the folder of the campaign."""
    return f"{BAGS}/{run:06d}.mcap"


def carry_out(campaign: Campaign, run: int, folder: Path, *, keep: bool) -> Row:
    """Simulate, record and certify a run, and score estimators in it.

    Parameters
    ----------
    campaign : Campaign
    run : int
    folder : Path
        Folder of the campaign, with one for its bags.
    keep : bool
        Whether the bag is kept. Else it is certified and thrown away.
    """
    scenario = campaign.scenario_of(run)
    simulation = Simulation(scenario)
    last_ns = simulation.clock.last_ns_before(campaign.exact_duration)
    with tempfile.TemporaryDirectory() as own:
        path = folder / bag_name(run) if keep else Path(own, "run.mcap")
        # part of it is of no use, as the run is done again
        with BagWriter(path, stamped_twist=scenario.stamped_twist, overwrite=True, rescued=False) as bag:
            for _ in write_run(bag, simulation, last_ns):
                pass
        certificate = certify(path)
        size = path.stat().st_size
    return Row(
        run,
        campaign.varied(scenario),
        certificate.passed,
        certificate.attitude_accuracy,
        bag_name(run) if keep else None,
        size if keep else None,
        run_scores(campaign, run),
    )


def carry_out_elsewhere(campaign: Campaign, run: int, *, keep: bool) -> tuple[Row, bytes]:
    """Carry out a run on a machine that does not see the folder of the campaign: its row, and the bytes of its bag."""
    with tempfile.TemporaryDirectory() as own:
        Path(own, BAGS).mkdir()
        row = carry_out(campaign, run, Path(own), keep=keep)
        return row, b"" if row.bag is None else Path(own, row.bag).read_bytes()


def run_scores(campaign: Campaign, run: int) -> list[dict[str, Any]]:
    """Scores of the campaign's estimators in a run; another Python calls each, which may exit or hang."""
    limit_s = STARTING_S + max(MAX_ESTIMATOR_S, campaign.duration)
    found = []
    for entry in campaign.entries:
        try:
            found.append(_interpreter(campaign, entry).ask(partial(score_estimator, entry, campaign, run), limit_s))
        except InputError as error:
            found.append(_without_score(str(error)))
        except (EOFError, TimeoutError) as error:
            found.append(_without_score(f"it {error}"))
    return [vars(each) for each in found]


def _interpreter(campaign: Campaign, entry: EstimatorSpec) -> Interpreter:
    """Another Python for this thread, campaign and estimator: an earlier one has what others have changed in it."""
    if getattr(_of_thread, "campaign", None) != campaign:
        _of_thread.campaign = campaign
        _of_thread.interpreters = defaultdict[str | None, Interpreter](Interpreter)
    return _of_thread.interpreters[entry.function or entry.command]  # type: ignore[no-any-return]


@lru_cache(maxsize=1)
def _simulated(campaign: Campaign, run: int) -> Run:
    """A run as arrays, kept for the next entry that is called in it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of what has no effect: the campaign tells it, where that is so in every run
        return simulate(campaign.scenario_of(run), duration=campaign.duration)


@short_dataclass
class RunScore:
    """Score of an estimator in one run, of which JSON is made.

    Attributes
    ----------
    scores : dict of str to float, str or None
        By the columns `SCORES`, `ERROR` and `MORE_SCORES`.
    reading_s : float or None
        Time that it took, by attitudes, s.
    curve_deg : list of float
        Total error, degrees, at `CURVE` times; NaN where there is no estimate.
    axes : str
        ``world`` or ``body``: the axes of the covariance.
    covariance : Series
        The error as a small rotation, rad, about these axes, the upper triangle of its covariance,
        rad², row by row, and the estimated attitude, scalar last.
    gyro_bias : Series
        The error of the gyro's bias, rad/s, and the upper triangle of its covariance, rad²/s².
    bias_claimed_exact : bool
        Whether the covariance of the gyro's bias is 0 beside an error.
    """

    scores: Scores
    reading_s: float | None = None
    curve_deg: list[float] = field(default_factory=list)
    axes: str = "world"
    covariance: Series = field(default_factory=list)
    gyro_bias: Series = field(default_factory=list)
    bias_claimed_exact: bool = False

    @property
    def error(self) -> str | None:
        """Why there is no score; None if there is one."""
        return self.scores[ERROR]  # type: ignore[return-value]  # a text is in no other column


def score_estimator(entry: EstimatorSpec, campaign: Campaign, run: int) -> RunScore:
    """Call an estimator with the readings of a run, and score what it returns by the truth.

    An estimator that fails, or whose result is of no use, has no score but the reason: nothing else fails of it.
    """
    true = _simulated(campaign, run)
    try:
        estimate = entry.load()
        given = deepcopy(BlindRun.without_truth(true, campaign.gives))
        begin_s = time.perf_counter()
        found = called(estimate, given, 0.0)
        taken_s = time.perf_counter() - begin_s
        return replace(_run_score(found, true, series=not entry.grid), reading_s=taken_s / max(1, len(found)))
    except InputError as error:
        return _without_score(str(error))


def _without_score(reason: str) -> RunScore:
    return RunScore({**dict.fromkeys((*SCORES, *MORE_SCORES)), ERROR: reason})


def _run_score(found: Estimate, run: Run, *, series: bool) -> RunScore:
    score = run.score(found, diagnosed=False)
    scores: Scores = {
        "total_rms_deg": score.total_deg.rms,
        "heading_rms_deg": score.heading_deg.rms,
        "inclination_rms_deg": score.inclination_deg.rms,
        "converged_s": score.time_to_converge_s,
        ERROR: None,
        "nees_mean": None if score.consistency is None else score.consistency.mean,
        "gyro_bias_rms_rad_s": None if score.gyro_bias_rad_s is None else score.gyro_bias_rad_s.rms,
    }
    truth = run.attitude()
    places, known = _nearest(found.t_ns, run.t_ns, truth, CURVE)
    total = np.degrees(attitude_error(found.attitude_xyzw[places], truth.at(found.t_ns[places])).total)
    curve = np.where(known, total, np.nan).tolist()
    places, known = _nearest(found.t_ns, run.t_ns, truth, SERIES)
    exact = score.gyro_bias is not None and score.gyro_bias.claimed_exact > 0
    if not (series and known.all()):
        return RunScore(scores, curve_deg=curve, bias_claimed_exact=exact)
    return RunScore(
        scores,
        curve_deg=curve,
        bias_claimed_exact=exact,
        axes=found.covariance_axes,
        covariance=_attitude_series(found, truth, places),
        gyro_bias=_bias_series(found, run, places),
    )


def _nearest(stamps_ns: Integers, t_ns: Integers, truth: Truth, count: int) -> tuple[Integers, Any]:
    """Indexes of the estimates at even times from first to last sample of a run, and whether each is at such a time."""
    wanted = np.linspace(t_ns[0], t_ns[-1], count).astype(np.int64)
    nearest = np.searchsorted(stamps_ns[:-1] + np.diff(stamps_ns) // 2, wanted)  # beyond so many middles between two
    near = 2 * np.abs(stamps_ns[nearest] - wanted) <= (t_ns[-1] - t_ns[0]) // (count - 1)
    return nearest, truth.covers(stamps_ns[nearest]) & near


def _attitude_series(found: Estimate, truth: Truth, places: Integers) -> Series:
    if found.covariance is None:
        return []
    attitudes = unit("estimate", found.attitude_xyzw[places])
    errors = error_vectors(attitudes, truth.at(found.t_ns[places]), found.covariance_axes)
    return _rows(errors, found.rotation_covariance()[places], attitudes)


def _bias_series(found: Estimate, run: Run, places: Integers) -> Series:
    if found.gyro_bias is None or found.gyro_bias_covariance is None:
        return []
    errors = numbers("gyro_bias", found.gyro_bias, 3)[places] - run.gyro_bias_at(found.t_ns[places])
    P = numbers("gyro_bias_covariance", found.gyro_bias_covariance, 3, 3)
    if not P.any():  # the score tells it
        return []
    factor_of(P, "gyro_bias_covariance")
    return _rows(errors, P[places])


def _rows(errors: Array, P: Array, *more: Array) -> Series:
    """Errors, their covariances, and more beside them."""
    rows: Series = np.column_stack([errors, P.reshape(-1, 9), *more]).tolist()
    return rows


def errors_of(series: list[Series]) -> tuple[Array, Array, Array]:
    """Errors, (R, T, 3), covariances, (R, T, 3, 3), and what is kept beside them, of the series of R runs."""
    errors, P, more = np.split(np.array(series, dtype=float), [3, 12], axis=-1)
    return errors, P.reshape(*P.shape[:2], 3, 3), more
