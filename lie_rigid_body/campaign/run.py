"""One run of a campaign: its bag, its certificate, the scores of an estimator, and the row that says what it was."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, TypeAlias

from lie_rigid_body.campaign.definition import Campaign
from lie_rigid_body.errors import BagError, said
from lie_rigid_body.parameters import Value
from lie_rigid_body.recording.bag_writer import BagWriter, write_run
from lie_rigid_body.runs import Run, simulate
from lie_rigid_body.runs.estimate import Estimate
from lie_rigid_body.runs.estimators import Estimator, estimator
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.wording import shortened

Scores: TypeAlias = dict[str, float | str | None]

ERROR: Final = "estimator_error"
"""Column of the table that says why a run has no score."""
SCORES: Final = ("total_rms_deg", "heading_rms_deg", "inclination_rms_deg", "converged_s")
"""Columns of a score: root mean squares of the errors, degrees, and the time to converge, s, if they do."""
BAGS: Final = "bags"
"""Name of the folder of the bags in the folder of a campaign."""
LARGEST_IN_MEMORY: Final = 8 * 2**20
"""Largest size, bytes, of a bag that is read into memory as a whole to be certified, which saves 5 % of the time."""


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
        The size of that bag, bytes; None also in rows of before sizes were kept.
    residuals : dict of str to list of float
        The worst residual of each law, and its limit.
    scores : dict of str to float, str or None
        Those of the estimator, by column; empty if none was asked for.
    """

    run: int
    parameters: dict[str, Value] = field(default_factory=dict)
    certified: bool = False
    attitude_accuracy_rad: float = 0.0
    bag: str | None = None
    bag_bytes: int | None = None
    residuals: dict[str, list[float]] = field(default_factory=dict)
    scores: Scores = field(default_factory=dict)

    def has_bag(self, folder: Path) -> bool:
        """Whether its bag is in the folder of the campaign, and has the size that it had when it was finished."""
        try:
            return self.bag is not None and self.bag_bytes in (None, (folder / self.bag).stat().st_size)
        except OSError:
            return False


def bag_name(run: int) -> str:
    """The path of a run's bag in the folder of the campaign."""
    return f"{BAGS}/{run:06d}.mcap"


def carry_out(campaign: Campaign, run: int, folder: str | None) -> Row:
    """Simulate, record and certify a run.

    Parameters
    ----------
    campaign : Campaign
    run : int
    folder : str or None
        The folder of the campaign, in which the bag is kept. Without it the bag is certified and thrown away.
    """
    if folder is not None:
        return _recorded(campaign, run, Path(folder, bag_name(run)), bag_name(run))
    with tempfile.TemporaryDirectory() as own:
        return _recorded(campaign, run, Path(own, "run.mcap"), None)


def carry_out_elsewhere(campaign: Campaign, run: int, *, keep: bool) -> tuple[Row, bytes | None]:
    """Carry out a run on a machine that may not see the folder of the campaign: also the bytes of the bag to keep."""
    with tempfile.TemporaryDirectory() as own:
        path = Path(own, "run.mcap")
        row = _recorded(campaign, run, path, bag_name(run) if keep else None)
        return row, path.read_bytes() if keep else None


def _recorded(campaign: Campaign, run: int, path: Path, name: str | None) -> Row:
    from lie_rigid_body.certificate import certify
    from lie_rigid_body.recording.bag_reader import Bag, read_bag

    scenario = campaign.scenario_of(run)
    simulation = Simulation(scenario)
    last_ns = simulation.clock.last_ns_before(campaign.exact_duration)
    try:
        with BagWriter(path, stamped_twist=scenario.stamped_twist, overwrite=True) as bag:
            for _ in write_run(bag, simulation, last_ns):
                pass
    except BagError:
        with suppress(OSError):  # part of it is of no use, as the run is done again
            path.unlink()
        raise
    size = path.stat().st_size
    certificate = certify(read_bag(path) if size <= LARGEST_IN_MEMORY else Bag(path))
    return Row(
        run,
        campaign.varied(scenario),
        certificate.passed,
        certificate.attitude_accuracy,
        name,
        None if name is None else size,
        {law: list(pair) for law, pair in certificate.residuals.items()},
        scores(campaign, scenario),
    )


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
    score = run.score(Estimate.of(estimate(run)), diagnosed=False)
    errors = (score.total_deg.rms, score.heading_deg.rms, score.inclination_deg.rms)
    return dict(zip(SCORES, (*errors, score.time_to_converge_s), strict=True))
