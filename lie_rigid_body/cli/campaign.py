"""The ``campaign`` command: many runs with parameters drawn at random, on all cores or a Dask cluster."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lie_rigid_body import console
from lie_rigid_body.errors import BagError, InputError, LieRigidBodyError
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.wording import counted, shortened, shown

if TYPE_CHECKING:
    from lie_rigid_body.campaign import Campaign
    from lie_rigid_body.campaign.journal import Journal

NOT_CERTIFIED: Final = 1
_NEEDED: Final = ("dask", "distributed", "pyarrow")


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    console.require_suffix("--report", given.report, ".html")
    missing = [name for name in _NEEDED if not find_spec(name)]
    if missing:
        raise InputError(f"campaign needs {' and '.join(missing)}: pip install 'lie-rigid-body[campaign]'")

    from lie_rigid_body.campaign import Campaign
    from lie_rigid_body.campaign.estimator import estimator
    from lie_rigid_body.campaign.journal import Journal

    if given.report is not None:
        from lie_rigid_body.report import html_page

        html_page.require_room(given.report, overwrite=given.force)
    campaign = Campaign.from_file(given.campaign)
    _require_scenarios(campaign, given.campaign)
    if given.scheduler is not None:
        from lie_rigid_body.campaign.cluster import require_address

        require_address(given.scheduler)
    if campaign.estimator is not None:
        estimator(campaign.estimator)
    with Interruption() as interruption, Journal(campaign, Path(given.out)) as journal:
        try:
            with interruption.allowed():
                failed = _carry_out(campaign, journal, given, interruption)
        except KeyboardInterrupt:
            done = len(journal.rows)
            console.complain(
                console.program("campaign"),
                f"interrupted after {done} of {campaign.runs} runs, which are kept; the same command does the rest",
            )
            return console.INTERRUPTED
        return _report(campaign, journal, failed, given)


def _parser() -> console.Parser:
    parser = console.Parser("campaign", "Record and certify many runs with parameters drawn at random.")
    parser.add_argument(
        "campaign", metavar="CAMPAIGN.yaml", type=console.path, help="what varies, and how many runs there are"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=console.path,
        required=True,
        help="folder of the table and the bags; resumed if begun",
    )
    parser.add_argument(
        "--workers", metavar="N", type=_workers, help="processes on this machine; one per core if absent"
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask cluster that runs already, such as tcp://host:8786"
    )
    parser.add_argument("--no-bags", action="store_true", help="keep the table only")
    parser.add_argument(
        "--report",
        metavar="OUT.html",
        type=console.path,
        help="write the runs and the sizes of their residuals as one page (needs plotly)",
    )
    parser.add_argument("--force", action="store_true", help="replace OUT.html if it exists")
    return parser


def _workers(text: str) -> int:
    if not (text.isascii() and text.isdigit() and 1 <= len(text) <= 4 and int(text) > 0):
        raise argparse.ArgumentTypeError(f"{shown(text)} is not a number of processes from 1 to 9999")
    return int(text)


def _require_scenarios(campaign: Campaign, path: str) -> None:
    """Refuse what no run can be before the first is begun, and warn of what has no effect in any."""
    try:
        idle = [campaign.scenario_of(run).without_effect for run in range(campaign.runs)]
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if all(idle):
        console.complain(console.program("campaign"), f"{path}: {idle[0]}", "warning")


def _carry_out(
    campaign: Campaign, journal: Journal, given: argparse.Namespace, interruption: Interruption
) -> list[BaseException]:
    """Do what is still to be done, and return what runs without a row failed of."""
    from tqdm import tqdm

    from lie_rigid_body.campaign.cluster import client_of, finished

    runs = [run for run in range(campaign.runs) if run not in journal.rows]
    failed: list[BaseException] = []
    if not runs:
        return failed
    # disable=None: shown on a terminal only
    with (
        client_of(given.workers, given.scheduler, interruption.put_off) as client,
        tqdm(total=campaign.runs, initial=len(journal.rows), unit=" runs", file=sys.stderr, disable=None) as bar,
    ):
        elsewhere = given.scheduler is not None
        for row in finished(client, campaign, runs, journal.folder, bags=not given.no_bags, elsewhere=elsewhere):
            if isinstance(row, BaseException):
                failed.append(row)
            else:
                journal.add(row)
            bar.update()
    return failed


def _report(campaign: Campaign, journal: Journal, failed: list[BaseException], given: argparse.Namespace) -> int:
    from lie_rigid_body.campaign.estimator import ERROR

    if failed:
        first = failed[0]
        reason = str(first) if isinstance(first, LieRigidBodyError) else f"{type(first).__name__}: {first}"
        raise BagError(
            f"{len(failed)} of {campaign.runs} runs failed, the first of: {shortened(reason, 90)}; "
            "the others are kept: mend that, and the same command does the rest"
        )
    table = journal.write_table()
    rows = [journal.rows[run] for run in sorted(journal.rows)]
    broken = sorted(row.run for row in rows if not row.certified)
    worst = max(row.attitude_accuracy_rad for row in rows)
    count, certified = counted(len(rows), "run"), len(rows) - len(broken)
    lines = [f"{count}, {certified} certified, attitudes within {worst:.2g} rad, in {table}"]
    if broken:
        lines.append(f"not certified: {', '.join(map(str, broken[:10]))}{', ...' if len(broken) > 10 else ''}")
    if campaign.estimator is not None:
        lines.append(_of_scores(journal))
    if given.report is not None:
        from lie_rigid_body.cli.campaign_page import page
        from lie_rigid_body.recording.output_file import write_file

        write_file(given.report, page(f"Campaign {given.campaign}", campaign, rows), overwrite=given.force)
        lines.append(f"wrote {given.report}")
    console.say("\n".join(lines), done=f"{table} is written")
    if broken:
        return NOT_CERTIFIED
    if campaign.estimator is not None and all(row.scores[ERROR] is not None for row in rows):
        raise InputError(f"estimator {campaign.estimator} gave no score in any run: mend it, and give a new folder")
    return console.SUCCESS


def _of_scores(journal: Journal) -> str:
    """The scores in a line."""
    from lie_rigid_body.campaign.estimator import ERROR

    rows = [journal.rows[run] for run in sorted(journal.rows)]
    failed = [row for row in rows if row.scores[ERROR] is not None]
    totals = sorted(float(row.scores["total_rms_deg"] or 0.0) for row in rows if row.scores[ERROR] is None)
    said = f"{len(totals)} scored" + (f", median {totals[len(totals) // 2]:.3g}° rms" if totals else "")
    return f"{said}; run {failed[0].run} is not: {failed[0].scores[ERROR]}" if failed else said
