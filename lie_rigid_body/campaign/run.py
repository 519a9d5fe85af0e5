"""One run of a campaign: its bag, its certificate, the scores of an estimator, and the row that says what it was."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from lie_rigid_body.campaign.definition import Campaign
from lie_rigid_body.campaign.judging import judged
from lie_rigid_body.errors import BagError
from lie_rigid_body.parameters import Value
from lie_rigid_body.recording.bag_writer import BagWriter, write_run
from lie_rigid_body.runs import simulate
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

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
    judgements : list of dict
        Fields of a `Judgement` for each of the campaign's entries.
    """

    run: int
    parameters: dict[str, Value] = field(default_factory=dict)
    certified: bool = False
    attitude_accuracy_rad: float = 0.0
    bag: str | None = None
    bag_bytes: int | None = None
    residuals: dict[str, list[float]] = field(default_factory=dict)
    judgements: list[dict[str, Any]] = field(default_factory=list)

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
        judgements(campaign, scenario),
    )


def judgements(campaign: Campaign, scenario: Scenario) -> list[dict[str, Any]]:
    """What the campaign's estimators are worth in the run of a scenario: they are given the same run."""
    if not campaign.entries:
        return []
    run = simulate(scenario, duration=campaign.duration)
    return [vars(judged(entry, run)) for entry in campaign.entries]
