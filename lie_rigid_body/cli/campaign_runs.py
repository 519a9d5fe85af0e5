"""The runs of a campaign: begun, resumed, carried out, and what is said of them."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any, Final

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.cluster import (
    MOST_FAILURES,
    SchedulerGoneError,
    client_of,
    finished,
    is_open,
    require_address,
)
from lie_rigid_body.campaign.comparison import compare
from lie_rigid_body.campaign.definition import SCORES_TABLE, Contender
from lie_rigid_body.campaign.journal import RESUMED, Journal
from lie_rigid_body.campaign.run import ERROR, LONGEST_S, SCORES, Row
from lie_rigid_body.estimates.estimators import MEND_IT
from lie_rigid_body.estimates.programs import words
from lie_rigid_body.foundation.errors import BagError, InputError, describe
from lie_rigid_body.foundation.parameters import Value
from lie_rigid_body.foundation.wording import MAX_NAMES, counted, listed, printable, shown
from lie_rigid_body.report import campaign_scores, html_page
from lie_rigid_body.report.drawing import require_outputs
from lie_rigid_body.report.overview import Line, page
from lie_rigid_body.system import console
from lie_rigid_body.system.interpreters import Interpreter
from lie_rigid_body.system.interruption import Interruption
from lie_rigid_body.system.output_file import write_file

MOST_TRIED: Final = 1000
"""Number of runs whose parameters are tried before the first is begun: each takes some milliseconds."""


def run_campaign(given: argparse.Namespace) -> int:
    """Carry out the campaign that the arguments give, and return the exit status."""
    campaign = Campaign.from_file(given.campaign)
    named = [word for one in campaign.contenders.values() for word in words(one.command or "")]
    require_outputs(given, [given.campaign, *named], with_figures=True)
    if not Journal.is_begun(campaign, Path(given.out)):
        _require_scenarios(campaign, given.campaign)
    if given.scheduler is not None:
        require_address(given.scheduler)
    if campaign.contenders:
        _require_estimators([*campaign.contenders.values()])
    with Interruption.current().noted() as interruption, Journal(campaign, Path(given.out)) as journal:
        try:
            with interruption.allowed():
                _look_at_bags(journal, wanted=not given.no_bags)
                failed = _carry_out(campaign, journal, given)
        except KeyboardInterrupt:
            console.complain(
                console.program("campaign"),
                f"interrupted after {len(journal)} of {campaign.runs} runs, which are kept; {RESUMED}",
            )
            return console.INTERRUPTED
        return _report(campaign, journal, failed, given)


def _require_estimators(contenders: Sequence[Contender]) -> None:
    """Refuse estimators that cannot be imported or take other parameters.

    They are imported in a process of its own. In this one libraries would find modules in the working folder from then
    on, into which others may write.
    """
    process = Interpreter()
    try:
        process.ask(partial(_look_at, contenders), LONGEST_S)
    except (EOFError, TimeoutError) as error:
        raise InputError(f"an estimator {error} when it was imported: import it alone to see why") from None
    finally:
        process.end()


def _look_at(contenders: Sequence[Contender]) -> None:
    for one in contenders:
        one.require_parameters()


def _require_scenarios(campaign: Campaign, path: str) -> None:
    """Refuse impossible parameters before the first run is begun, and warn of those that have no effect in any run.

    Of very many runs only the first ones are tried.
    """
    try:
        bar = console.progress(range(min(campaign.runs, MOST_TRIED)), desc="parameters", unit=" runs")
        idle = [campaign.scenario_of(run).without_effect for run in bar]
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    for sentence in idle[0] if idle and all(idle) else ():
        console.complain(console.program("campaign"), f"{path}: {sentence}", "warning")


def _look_at_bags(journal: Journal, *, wanted: bool) -> None:
    """Forget finished runs that lack their bags, where bags are wanted, so that they are done again, and say so."""
    finished = len(journal)
    if wanted and (lacking := _forget_without_bags(journal)):
        console.say(
            f"doing again {len(lacking)} of {counted(finished, 'finished run')}, which had no bag, "
            f"or one of another size: {listed(lacking)}"
        )
    if not wanted and (kept := sum(row.bag is not None for row in journal.rows())):
        console.say(f"--no-bags: the bags of {kept} of {counted(finished, 'finished run')} are kept, and not looked at")


def _forget_without_bags(journal: Journal) -> list[int]:
    """Forget finished runs that lack their bags, and return their numbers."""
    lacking = [row.run for row in journal.rows() if not row.has_bag(journal.folder)]
    for run in lacking:
        journal.forget(run)
    return lacking


def _carry_out(campaign: Campaign, journal: Journal, given: argparse.Namespace) -> dict[int, BaseException]:
    """Carry out the runs that are not finished, and return the errors of those that failed, by their numbers."""
    failed: dict[int, BaseException] = {}
    errors: list[list[str | None]] = []
    if len(journal) == campaign.runs:
        return failed
    if given.scheduler is not None and is_open(given.scheduler):
        console.complain(
            console.program("campaign"),
            f"--scheduler {shown(given.scheduler)} is open to whoever reaches it, to run code there as its owner: "
            "tls:// keeps others out",
            "warning",
        )
    with (
        console.progress(total=campaign.runs, initial=len(journal), unit=" runs", leave=True) as bar,
        journal.bags.without_parts(lambda run: run < campaign.runs and run not in journal and run not in failed),
        client_of(given.workers, given.scheduler) as client,
    ):
        try:
            for run, row in finished(
                client,
                campaign,
                (run for run in range(campaign.runs) if run not in journal),
                journal.bags,
                bags=not given.no_bags,
                elsewhere=given.scheduler is not None,
                alone=partial(_say_alone, bar),
            ):
                if isinstance(row, BaseException):
                    failed[run] = row
                    journal.require_intact()
                else:
                    journal.add(row)
                    errors.append([judgement["scores"][ERROR] for judgement in row.judgements])
                    if len(errors) == MOST_FAILURES:  # one that failed in all has a mistake
                        _require_scores(campaign, errors, f"{MOST_FAILURES} runs")
                bar.update()
        except SchedulerGoneError as error:
            if len(journal) + len(failed) < campaign.runs:
                raise BagError(
                    f"{error}; {len(journal)} of {campaign.runs} runs are kept in {journal.folder}: start one, and "
                    f"{RESUMED}"
                ) from None
    return failed


def _say_alone(bar: Any, address: str) -> None:
    with bar.external_write_mode():
        console.complain(
            console.program("campaign"), f"no worker at {address}: waiting for one; Ctrl-C ends it", "warning"
        )


def _require_scores(campaign: Campaign, errors: Iterable[Sequence[str | None]], runs: str) -> None:
    """Refuse an estimator that gave no score in any run, with the reason in the first of them.

    Parameters
    ----------
    campaign : Campaign
    errors : iterable of sequence of str or None
        Of each run: why each of the campaign's entries has no score.
    runs : str
        What the runs are called.
    """
    told = [(one.name, error) for of_run in errors for one, error in zip(campaign.entries, of_run, strict=True)]
    scored = {name for name, error in told if error is None}
    if failed := [name for name in campaign.contenders if name not in scored]:
        first = next(error for name, error in told if name == min(failed) and error is not None)
        reason = first.removesuffix(f": {MEND_IT}")
        what = listed([shown(name) if name else str(campaign.estimator) for name in failed])
        raise InputError(f"estimator {what} gave no score in {runs}: {reason}: mend it, and give a new folder")


def _failure(campaign: Campaign, journal: Journal, failed: dict[int, BaseException]) -> BagError:
    """Error of runs that failed, with what the first of them failed of; the table has the others."""
    named = f" ({listed(sorted(failed))})" if len(failed) <= MAX_NAMES else ""
    kept = f"{len(journal)} are kept" + (f", in {journal.write_table().name}" if len(journal) else "")
    first = describe(failed[min(failed)])
    return BagError(
        f"{len(failed)} of {campaign.runs} runs failed{named}, first: {first}; {kept}: mend that, and {RESUMED}"
    )


def _report(campaign: Campaign, journal: Journal, failed: dict[int, BaseException], given: argparse.Namespace) -> int:
    if failed:
        raise _failure(campaign, journal, failed)
    if not given.no_bags and (lacking := _forget_without_bags(journal)):
        raise BagError(
            f"{len(lacking)} of {counted(campaign.runs, 'bag')} were deleted or changed meanwhile ({listed(lacking)}): "
            f"keep others away, also the estimator; {RESUMED}"
        )
    path, has_page = journal.write_table(), given.report is not None
    rows = [_outline(row, whole=has_page) for row in journal.rows()]

    lines = [
        Line(
            (str(row.run), *(_cell(row.parameters[name]) for name in campaign.vary if has_page)),
            row.certified,
            row.attitude_accuracy_rad,
            row.residuals,
        )
        for row in rows
    ]
    errors = [[scores[ERROR] for scores in row.judgements] for row in rows]
    totals = [scores[SCORES[0]] or 0.0 for row in rows for scores in row.judgements if scores[ERROR] is None]
    broken = [line.cells[0] for line in lines if not line.certified]
    told = [
        f"{counted(len(lines), 'run')}, {len(lines) - len(broken)} certified, attitudes within "
        f"{max(0.0, *(line.accuracy for line in lines)):.2g} rad, in {printable(str(path))}",
        *([f"not certified: {', '.join(broken[:10])}{', ...' if len(broken) > 10 else ''}"] if broken else []),
    ]
    first, worst_first = list[str](), [*campaign.contenders.values()]
    if campaign.estimator is not None:
        middle = f", median {median(totals):.3g}° rms" if totals else ""
        reasons = (f"; run {run} is not: {error}" for run, (error,) in enumerate(errors) if error is not None)
        told.append(f"{len(totals)} scored{middle}{next(reasons, '')}")
    elif campaign.estimators:
        comparison = compare(campaign, journal.rows())
        told += [f"scores in {printable(str(path.with_name(SCORES_TABLE)))}", "", campaign_scores.as_text(comparison)]
        worst_first = [one.entry for one in comparison.worst_first]
        varied = {row.run: row.parameters for row in rows}
        first = campaign_scores.sections(campaign, comparison, varied) if has_page else []
    if function := next((one.function for one in worst_first if one.function), None):
        what = "one" if campaign.estimators else "it"
        told.append(f"what is wrong with {what}: {console.program('diagnose')} {function}")
    if has_page:
        content = page(
            f"Campaign {given.campaign}",
            "runs",
            ("run", *campaign.vary),
            lines,
            [html_page.details("Campaign", campaign.to_json())],
            first=first,
        )
        write_file(given.report, content, overwrite=given.force)
        told.append(f"wrote {printable(given.report)}")
    console.say("\n".join(told), done=f"{path} is written")
    if broken:
        return console.BROKEN
    _require_scores(campaign, errors, "any run")
    return console.SUCCESS


def _outline(row: Row, *, whole: bool) -> Row:
    """A row with its scores alone for judgements: of a million runs what only a page tells would take gigabytes."""
    scores = [judgement["scores"] for judgement in row.judgements]
    return replace(row, judgements=scores) if whole else replace(row, judgements=scores, parameters={}, residuals={})


def _cell(value: Value | Sequence[float]) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value) if isinstance(value, str | int) else f"[{', '.join(f'{v:.4g}' for v in value)}]"
