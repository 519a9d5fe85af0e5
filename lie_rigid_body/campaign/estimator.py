"""The estimator of a campaign: a function that is named, called with each run, and scored."""

from __future__ import annotations

from typing import Final, TypeAlias

from lie_rigid_body.campaign.definition import Campaign
from lie_rigid_body.errors import said
from lie_rigid_body.runs import Run, simulate
from lie_rigid_body.runs.estimators import MENDED, Estimator, estimator, returned
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.wording import shortened

__all__ = ["ERROR", "MENDED", "SCORES", "Estimator", "Scores", "estimator", "scores"]

Scores: TypeAlias = dict[str, float | str | None]

ERROR: Final = "estimator_error"
"""Column of the table that says why a run has no score."""
SCORES: Final = ("total_rms_deg", "heading_rms_deg", "inclination_rms_deg", "converged_s")
"""Columns of a score: root mean squares of the errors, degrees, and the time to converge, s, if they do."""


def scores(campaign: Campaign, scenario: Scenario) -> Scores:
    """The scores of the campaign's estimator in the run of a scenario, by column; empty without an estimator.

    An estimator that fails, or whose result is of no use, has no score but the reason: nothing else fails of it. It may
    raise anything, also KeyboardInterrupt: no signal raises that here, in a thread of a worker.
    """
    if campaign.estimator is None:
        return {}
    try:
        return {**_scored(estimator(campaign.estimator), simulate(scenario, duration=campaign.duration)), ERROR: None}
    except BaseException as error:
        return {**dict.fromkeys(SCORES), ERROR: shortened(said(error))}


def _scored(estimate: Estimator, run: Run) -> Scores:
    found = returned(estimate(run))
    score = run.score(found.attitude_xyzw, found.t_ns, diagnosed=False)
    errors = (score.total_deg.rms, score.heading_deg.rms, score.inclination_deg.rms)
    return dict(zip(SCORES, (*errors, score.time_to_converge_s), strict=True))
