"""The ``campaign`` command: many runs with parameters drawn at random, on all cores or a Dask cluster."""

from __future__ import annotations

import argparse
import sys
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lie_rigid_body import console
from lie_rigid_body.errors import BagError, InputError, LieRigidBodyError, said
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.wording import MOST_NAMES, counted, listed, printable, shortened, shown

if TYPE_CHECKING:
    from lie_rigid_body.campaign import Campaign
    from lie_rigid_body.campaign.journal import Journal
    from lie_rigid_body.campaign.run import Row

MOST_TRIED: Final = 1000
"""Runs whose parameters are tried before the first is begun: each takes some milliseconds."""
_LONGEST_REASON: Final = 70
"""Largest length of what a run failed of in an error line, characters."""
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
    from lie_rigid_body.campaign.journal import RESUMED, Journal

    if given.report is not None:
        from lie_rigid_body.report import html_page

        html_page.require_room(given.report, [given.campaign], overwrite=given.force)
    campaign = Campaign.from_file(given.campaign)
    if not Journal.is_begun(campaign, Path(given.out)):
        _require_scenarios(campaign, given.campaign)
    if given.scheduler is not None:
        from lie_rigid_body.campaign.cluster import require_address

        require_address(given.scheduler)
    if campaign.estimator is not None:
        estimator(campaign.estimator)
    with Interruption() as interruption, Journal(campaign, Path(given.out)) as journal:
        try:
            with interruption.allowed():
                _look_at_bags(journal, wanted=not given.no_bags)
                failed = _carry_out(campaign, journal, given, interruption)
        except KeyboardInterrupt:
            console.complain(
                console.program("campaign"),
                f"interrupted after {len(journal)} of {campaign.runs} runs, which are kept; {RESUMED}",
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
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--workers", metavar="N", type=_workers, help="processes on this machine; one per core if absent"
    )
    where.add_argument(
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
    """Refuse what no run can be before the first is begun, and warn of what has no effect in any.

    Of very many runs those that come later are their own.
    """
    from tqdm import tqdm

    first = range(min(campaign.runs, MOST_TRIED))
    try:
        bar = tqdm(first, "parameters", unit=" runs", file=sys.stderr, disable=None, leave=False)
        idle = [campaign.scenario_of(run).without_effect for run in bar]
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if idle and all(idle):
        console.complain(console.program("campaign"), f"{path}: {idle[0]}", "warning")


def _look_at_bags(journal: Journal, *, wanted: bool) -> None:
    """Have finished runs done again that lack their bags, where bags are wanted, and say what is done of bags."""
    finished = len(journal)
    if wanted:
        lacking = [row.run for row in journal.rows() if not row.has_bag(journal.folder)]
        for run in lacking:
            journal.forget(run)
        if lacking:
            console.say(
                f"doing again {len(lacking)} of {counted(finished, 'finished run')}, which had no bag, "
                f"or one of another size: {listed(lacking)}"
            )
    elif kept := sum(row.bag is not None for row in journal.rows()):
        console.say(f"--no-bags: the bags of {kept} of {counted(finished, 'finished run')} are kept, and not looked at")


def _carry_out(
    campaign: Campaign, journal: Journal, given: argparse.Namespace, interruption: Interruption
) -> dict[int, BaseException]:
    """Do what is still to be done, and return what runs without a row failed of."""
    from tqdm import tqdm

    from lie_rigid_body.campaign.cluster import MOST_FAILURES, client_of, finished
    from lie_rigid_body.campaign.connection import SchedulerGoneError
    from lie_rigid_body.campaign.journal import RESUMED

    failed: dict[int, BaseException] = {}
    first: list[Row] = []
    if len(journal) == campaign.runs:
        return failed
    runs = (run for run in range(campaign.runs) if run not in journal)
    # disable=None: shown on a terminal only
    with (
        tqdm(total=campaign.runs, initial=len(journal), unit=" runs", file=sys.stderr, disable=None) as bar,
        client_of(given.workers, given.scheduler, interruption.put_off) as client,
    ):
        rows = finished(
            client,
            campaign,
            runs,
            journal.folder,
            bags=not given.no_bags,
            elsewhere=given.scheduler is not None,
            lost=lambda count: bar.set_postfix_str(f"{count} lost with a process that died, tried again at the end"),
            alone=_say_alone,
        )
        try:
            for run, row in rows:
                if isinstance(row, BaseException):
                    failed[run] = row
                    journal.require_intact()
                else:
                    journal.add(row)
                    if len(first) < MOST_FAILURES:
                        first.append(row)
                        _require_a_score(campaign, first, MOST_FAILURES)
                bar.update()
        except SchedulerGoneError as error:
            if len(journal) + len(failed) < campaign.runs:
                kept = f"{len(journal)} of {campaign.runs} runs are kept in {journal.folder}"
                raise BagError(f"{error}; {kept}: start one, and {RESUMED}") from None
    return failed


def _say_alone(address: str) -> None:
    from tqdm import tqdm

    with tqdm.external_write_mode(sys.stderr):
        console.complain(
            console.program("campaign"), f"no worker at {address}: waiting for one; Ctrl-C ends it", "warning"
        )


def _require_a_score(campaign: Campaign, rows: Sequence[Row], most: int) -> None:
    """Refuse to go on with an estimator that gave no score in so many runs: it has a mistake."""
    from lie_rigid_body.campaign.estimator import ERROR

    errors = [row.scores.get(ERROR) for row in rows]
    if len(errors) == most and None not in errors:
        raise _without_a_score(campaign, f"{most} runs", f"{errors[0]}")


def _without_a_score(campaign: Campaign, runs: str, error: str) -> InputError:
    """That an estimator gave no score, and why not in the first of its runs."""
    from lie_rigid_body.campaign.estimator import MENDED

    reason = shortened(error.removesuffix(f": {MENDED}"), _LONGEST_REASON)
    return InputError(
        f"estimator {campaign.estimator} gave no score in {runs}: {reason}: mend it, and give a new folder"
    )


def _failure(campaign: Campaign, journal: Journal, failed: dict[int, BaseException]) -> BagError:
    """That runs failed, and what the first of them failed of; the table has the others."""
    from lie_rigid_body.campaign.journal import RESUMED

    error = failed[min(failed)]
    reason = said(error).partition("; ")[0]  # without the rescue of its bag, as the run is done again
    reason = reason.replace(f"{journal.folder}/", "")
    if isinstance(error, LieRigidBodyError) and len(reason) > _LONGEST_REASON:
        reason = reason.rpartition(": ")[0] or reason  # the cause stays, its remedy goes
    reason = shortened(reason, _LONGEST_REASON)
    named = f" ({listed(sorted(failed))})" if len(failed) <= MOST_NAMES else ""
    kept = f"{len(journal)} are kept" + (f", in {journal.write_table().name}" if len(journal) else "")
    return BagError(
        f"{len(failed)} of {campaign.runs} runs failed{named}, first: {reason}; {kept}: mend that, and {RESUMED}"
    )


def _report(campaign: Campaign, journal: Journal, failed: dict[int, BaseException], given: argparse.Namespace) -> int:
    if failed:
        raise _failure(campaign, journal, failed)
    table, tally = journal.write_table(), _Tally.of(journal.rows())
    broken, certified = tally.broken, tally.count - len(tally.broken)
    lines = [
        f"{counted(tally.count, 'run')}, {certified} certified, attitudes within {tally.worst:.2g} rad, "
        f"in {printable(str(table))}"
    ]
    if broken:
        lines.append(f"not certified: {', '.join(map(str, broken[:10]))}{', ...' if len(broken) > 10 else ''}")
    if campaign.estimator is not None:
        lines += [tally.of_scores(), f"what is wrong with it: {console.program('diagnose')} {campaign.estimator}"]
    if given.report is not None:
        from lie_rigid_body.cli.campaign_page import page
        from lie_rigid_body.recording.output_file import write_file

        content = page(f"Campaign {given.campaign}", campaign, [*journal.rows()])
        write_file(given.report, content, overwrite=given.force)
        lines.append(f"wrote {printable(given.report)}")
    console.say("\n".join(lines), done=f"{table} is written")
    if broken:
        return console.BROKEN
    if campaign.estimator is not None and not tally.totals_deg:
        raise _without_a_score(campaign, "any run", tally.first_error)
    return console.SUCCESS


@dataclass
class _Tally:
    """What is told of all runs, without their rows."""

    count: int = 0
    worst: float = 0.0
    broken: list[int] = field(default_factory=list)
    totals_deg: array[float] = field(default_factory=lambda: array("d"))
    unscored: str = ""
    first_error: str = ""

    @classmethod
    def of(cls, rows: Iterable[Row]) -> _Tally:
        """The tally of rows in the order of their numbers."""
        from lie_rigid_body.campaign.estimator import ERROR

        tally = cls()
        for row in rows:
            tally.count += 1
            tally.worst = max(tally.worst, row.attitude_accuracy_rad)
            if not row.certified:
                tally.broken.append(row.run)
            error = row.scores.get(ERROR)
            if error is None and row.scores:
                tally.totals_deg.append(float(row.scores["total_rms_deg"] or 0.0))
            elif error is not None:
                tally.unscored = tally.unscored or f"; run {row.run} is not: {error}"
                tally.first_error = tally.first_error or f"{error}"
        return tally

    def of_scores(self) -> str:
        """The scores in a line."""
        ordered = sorted(self.totals_deg)
        return (
            f"{len(ordered)} scored"
            + (f", median {ordered[len(ordered) // 2]:.3g}° rms" if ordered else "")
            + self.unscored
        )
