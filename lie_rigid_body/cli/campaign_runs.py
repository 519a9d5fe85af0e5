"""The runs of a campaign: begun, resumed, carried out, and what is said of them."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Final

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.comparison import compare
from lie_rigid_body.campaign.definition import SCORES_TABLE, EstimatorSpec
from lie_rigid_body.campaign.results import RESUMED, Results
from lie_rigid_body.campaign.run import ERROR, MAX_ESTIMATOR_S, SCORES, Row
from lie_rigid_body.campaign.workers import on_a_cluster, on_this_machine
from lie_rigid_body.estimates.estimators import CORRECT_IT
from lie_rigid_body.estimates.programs import words
from lie_rigid_body.foundation.errors import BagError, InputError, describe
from lie_rigid_body.foundation.parameters import Value
from lie_rigid_body.foundation.wording import MAX_NAMES, counted, listed, printable, shown
from lie_rigid_body.report import campaign_scores
from lie_rigid_body.report.answer import Conclusion, Details, Parts, Table, as_page
from lie_rigid_body.report.outputs import require_outputs
from lie_rigid_body.system import console
from lie_rigid_body.system.interpreters import Interpreter
from lie_rigid_body.system.interruption import Interruption
from lie_rigid_body.system.output_file import write_file
from lie_rigid_body.system.portable import cores

MAX_TRIED: Final = 1000
"""Number of runs whose parameters are tried before the first is begun: each takes some milliseconds."""
MAX_ROWS: Final = 500
"""Largest number of runs in the table of a page; those that are not certified come first."""
MAX_FAILURES: Final = 20
"""Number of runs that may fail one after another before no more are begun; and that may have no score."""


def run_campaign(given: argparse.Namespace) -> int:
    """Carry out the campaign that the arguments give, and return the exit status."""
    campaign = Campaign.from_file(given.campaign)
    named = [word for one in campaign.estimator_specs.values() for word in words(one.command or "")]
    require_outputs(given, [given.campaign, *named], "report")
    if not Results.is_begun(campaign, Path(given.out)):
        _require_scenarios(campaign, given.campaign)
    if campaign.estimator_specs:
        _require_estimators([*campaign.estimator_specs.values()])
    results = Results(campaign, Path(given.out))
    with results.held, Interruption.current().noted() as interruption:
        try:
            with interruption.allowed():
                if not given.no_bags:
                    _look_for_bags(results)
                failed = _carry_out(campaign, results, given)
        except KeyboardInterrupt:
            console.complain(
                console.program("campaign"),
                f"interrupted after {len(results)} of {campaign.runs} runs, which are kept; {RESUMED}",
            )
            return console.INTERRUPTED
        finally:
            results.remove_parts()
        if failed:
            raise _failure(campaign, results, failed)
        return _answer(campaign, results, given)


def _require_estimators(estimator_specs: Sequence[EstimatorSpec]) -> None:
    """Refuse estimators that cannot be imported or take other parameters.

    They are imported in a process of its own. In this one libraries would find modules in the working folder from then
    on, into which others may write.
    """
    process = Interpreter()
    try:
        process.ask(partial(_look_at, estimator_specs), MAX_ESTIMATOR_S)
    except (EOFError, TimeoutError) as error:
        raise InputError(f"an estimator {error} when it was imported: import it alone to see why") from None
    finally:
        process.end()


def _look_at(estimator_specs: Sequence[EstimatorSpec]) -> None:
    for one in estimator_specs:
        one.require_parameters()


def _require_scenarios(campaign: Campaign, path: str) -> None:
    """Refuse impossible parameters before the first run is begun, and warn of those that have no effect in any run.

    Of very many runs only the first ones are tried.
    """
    try:
        bar = console.progress(range(min(campaign.runs, MAX_TRIED)), desc="parameters", unit=" runs")
        idle = [campaign.scenario_of(run).without_effect for run in bar]
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    for sentence in idle[0] if idle and all(idle) else ():
        console.complain(console.program("campaign"), f"{path}: {sentence}", "warning")


def _look_for_bags(results: Results) -> None:
    """Say which finished runs lack their bags, and are done again."""
    finished = counted(len(results), "finished run")
    if lacking := results.forget_without_bags():
        console.say(
            f"doing again {len(lacking)} of {finished}, which had no bag, or one of another size: {listed(lacking)}"
        )


def _carry_out(campaign: Campaign, results: Results, given: argparse.Namespace) -> dict[int, Exception]:
    """Carry out the runs that are not finished, and return the errors of those that failed, by their numbers."""
    failed: dict[int, Exception] = {}
    errors: list[list[str | None]] = []
    in_a_row = 0
    if len(results) == campaign.runs:
        return failed
    runs = (run for run in range(campaign.runs) if run not in results.finished)
    folder = results.folder.absolute()
    if given.scheduler is None:
        count = given.workers or cores()
        outcomes = on_this_machine(campaign, runs, folder, count, keep=not given.no_bags)
    else:
        outcomes = on_a_cluster(campaign, runs, folder, given.scheduler, keep=not given.no_bags)
    with console.progress(total=campaign.runs, initial=len(results), unit=" runs", leave=True) as bar:
        try:
            for run, outcome in outcomes:
                in_a_row = in_a_row + 1 if isinstance(outcome, Exception) else 0
                if isinstance(outcome, Row):
                    results.add(outcome)
                    errors.append([run_score["scores"][ERROR] for run_score in outcome.run_scores])
                else:
                    failed[run] = outcome
                if len(errors) == MAX_FAILURES and not any(None in of_run for of_run in errors):
                    _require_scores(campaign, errors, f"{MAX_FAILURES} runs")
                bar.update()
                if in_a_row == MAX_FAILURES:
                    break
        finally:
            outcomes.close()
    return failed


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
    if failed := [name for name in campaign.estimator_specs if name not in scored]:
        first = next(error for name, error in told if name == min(failed) and error is not None)
        reason = first.removesuffix(f": {CORRECT_IT}").removesuffix(": correct that first")
        what = listed([shown(name) if name else str(campaign.estimator) for name in failed])
        raise InputError(f"estimator {what} gave no score in {runs}: {reason}: correct it, and give a new folder")


def _failure(campaign: Campaign, results: Results, failed: dict[int, Exception]) -> BagError:
    """Error of runs that failed, with what the first of them failed of; the table has the others."""
    named = f" ({listed(sorted(failed))})" if len(failed) <= MAX_NAMES else ""
    kept = f"{len(results)} are kept" + (f", in {results.write_table().name}" if len(results) else "")
    first = describe(failed[min(failed)])
    return BagError(
        f"{len(failed)} of {campaign.runs} runs failed{named}, first: {first}; {kept}: correct that, and {RESUMED}"
    )


def _answer(campaign: Campaign, results: Results, given: argparse.Namespace) -> int:
    """Write the tables and the page, say what is in them, and return the exit status."""
    if not given.no_bags and (lacking := results.forget_without_bags()):
        raise BagError(
            f"{len(lacking)} of {counted(campaign.runs, 'bag')} were deleted or changed meanwhile ({listed(lacking)}): "
            f"keep others away, also the estimator; {RESUMED}"
        )
    path = results.write_table()
    rows = [_outline(row, whole=given.report is not None) for row in results.rows()]
    broken = [str(row.run) for row in rows if not row.certified]
    told = [
        f"{counted(len(rows), 'run')}, {len(rows) - len(broken)} certified, attitudes within "
        f"{max(row.attitude_accuracy_rad for row in rows):.2g} rad, in {printable(str(path))}",
        *([f"not certified: {listed(broken)}"] if broken else []),
    ]
    first: Parts = []
    worst_first = [*campaign.estimator_specs.values()]
    if campaign.estimator is not None:
        told.append(_scored(rows))
    elif campaign.estimators:
        comparison = compare(campaign, results.rows())
        told += [f"scores in {printable(str(path.with_name(SCORES_TABLE)))}", "", campaign_scores.as_text(comparison)]
        worst_first = [one.entry for one in comparison.worst_first]
        if given.report is not None:
            first = campaign_scores.parts(campaign, comparison, {row.run: row.parameters for row in rows})
    if campaign.gives:
        told.append(f"given to estimators beside the readings: {', '.join(campaign.gives)}")
    if function := next((one.function for one in worst_first if one.function), None):
        told.append(f"what is wrong with it: {console.program('diagnose')} {function}")
    if given.report is not None:
        write_file(given.report, _page(campaign, given.campaign, rows, first), overwrite=given.force)
        told.append(f"wrote {printable(given.report)}")
    console.say("\n".join(told), done=f"{path} is written")
    if broken:
        return console.BROKEN
    _require_scores(campaign, ([scores[ERROR] for scores in row.run_scores] for row in rows), "any run")
    return console.SUCCESS


def _outline(row: Row, *, whole: bool) -> Row:
    """A row with the columns of its scores alone: of a million runs what only a page tells would take gigabytes."""
    scores = [run_score["scores"] for run_score in row.run_scores]
    return replace(row, run_scores=scores, parameters=row.parameters if whole else {})


def _scored(rows: Sequence[Row]) -> str:
    """How many runs the only estimator is scored in, its median error, and why a run has no score."""
    scores = [row.run_scores[0] for row in rows]
    totals = [each[SCORES[0]] for each in scores if each[ERROR] is None]
    middle = f", median {median(totals):.3g}° rms" if totals else ""
    reasons = (f"; run {row.run} is not: {each[ERROR]}" for row, each in zip(rows, scores, strict=True) if each[ERROR])
    return f"{len(totals)} scored{middle}{next(reasons, '')}"


def _page(campaign: Campaign, name: str, rows: Sequence[Row], first: Parts) -> bytes:
    """The answer about estimators, or a table of the runs, and how many are certified."""
    certified = sum(row.certified for row in rows)
    count = Conclusion([f"{certified} of {len(rows)} runs CERTIFIED"], certified == len(rows))
    parts = first or [_table(campaign, sorted(rows, key=lambda row: row.certified)[:MAX_ROWS])]
    return as_page(f"Campaign {name}", [*parts, count, Details("Campaign", campaign.to_json())])


def _table(campaign: Campaign, rows: Sequence[Row]) -> Table:
    return Table(
        ("run", *campaign.vary, "attitude, rad"),
        [
            (
                str(row.run),
                *(_cell(row.parameters[name]) for name in campaign.vary),
                f"{row.attitude_accuracy_rad:.2g}" if row.certified else "NOT CERTIFIED",
            )
            for row in rows
        ],
        "Runs",
        [not row.certified for row in rows],
    )


def _cell(value: Value | Sequence[float]) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value) if isinstance(value, str | int) else f"[{', '.join(f'{v:.4g}' for v in value)}]"
