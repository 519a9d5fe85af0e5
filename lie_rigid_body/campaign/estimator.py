"""The estimator of a campaign: a function that is named, called with each run, and scored."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any, Final, TypeAlias

import numpy as np

from lie_rigid_body.campaign.definition import Campaign
from lie_rigid_body.errors import InputError, said
from lie_rigid_body.runs import Run, simulate
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.wording import shortened, shown

Estimator: TypeAlias = Callable[[Run], Any]
Scores: TypeAlias = dict[str, float | str | None]

MENDED: Final = "mend it"
"""Remedy at the end of an error line about an estimator that cannot be imported."""
ERROR: Final = "estimator_error"
"""Column of the table that says why a run has no score."""
SCORES: Final = ("total_rms_deg", "heading_rms_deg", "inclination_rms_deg", "converged_s")
"""Columns of a score: root mean squares of the errors, degrees, and the time to converge, s, if they do."""


def estimator(name: str) -> Estimator:
    """The function that a campaign names, in a module of the working directory or one that is installed.

    Parameters
    ----------
    name : str
        ``module:function``.

    Raises
    ------
    InputError
        If there is no such module or function.
    """
    module, _, function = name.partition(":")
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())  # an executable has its own folder there, not where it was started
    try:
        found = getattr(import_module(module), function, None)
    except (Exception, SystemExit) as error:
        raise InputError(f"estimator {shown(name)} cannot be imported: {shortened(said(error))}: {MENDED}") from None
    if not callable(found):
        raise InputError(f"estimator {shown(name)}: {shown(module)} has no function {shown(function)}: define it there")
    estimate: Estimator = found
    return estimate


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
    result = estimate(run)
    t_ns, given = result if isinstance(result, tuple) and len(result) == 2 else (None, result)
    attitude_xyzw = np.asarray(given)
    if attitude_xyzw.ndim != 2 or attitude_xyzw.shape[1] != 4:
        shape = f"{type(result).__name__} of shape {attitude_xyzw.shape}"
        raise InputError(f"the estimate is a {shape}: return attitudes (N, 4), or a tuple of stamps and attitudes")
    score = run.score(attitude_xyzw, t_ns, diagnosed=False)
    errors = (score.total_deg.rms, score.heading_deg.rms, score.inclination_deg.rms)
    return dict(zip(SCORES, (*errors, score.time_to_converge_s), strict=True))
