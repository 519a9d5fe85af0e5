"""``diagnose``: what is wrong with an attitude filter, by repairing it from outside."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from lie_rigid_body import console
from lie_rigid_body.cli.estimators import ESTIMATOR, given_estimator, name_of
from lie_rigid_body.errors import InputError


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    console.require_suffix("--report", given.report, ".html")
    estimate = given_estimator(given)
    if estimate is None:
        raise InputError(
            "no estimator: give MODULE:FUNCTION, such as my_filter:estimate, --command PROGRAM, or --node COMMAND"
        )

    from lie_rigid_body.diagnosis import diagnose
    from lie_rigid_body.recording.output_file import require_room
    from lie_rigid_body.report.diagnoses import as_text, page
    from lie_rigid_body.report.drawing import answer
    from lie_rigid_body.scenario.parameter_file import gather

    if given.report is not None:
        require_room(given.report, given.params_file, overwrite=given.force)
    chosen = gather(given.scenario, given.params_file, ())
    parameters: dict[str, Any] = dict(gather(None, (), given.assignments))
    with console.progress(desc="diagnose", unit=" runs") as bar:
        found = diagnose(
            estimate,
            scenario=chosen,
            workers=given.workers,
            max_runs=given.max_runs,
            timeout=given.timeout,
            progress=lambda runs: bar.update(runs - bar.n),
            **parameters,
        )
    files = {}
    if given.report is not None:
        files[given.report] = page(name_of(given), found)
    text = json.dumps(found.to_dict(), indent=2, ensure_ascii=False) if given.json else as_text(found)
    answer(text, files, overwrite=given.force, named=not given.json)
    if found.interrupted:
        console.complain(console.program("diagnose"), "interrupted: this is what was found so far")
        return console.INTERRUPTED
    return console.SUCCESS if found.passed else console.BROKEN


def _parser() -> console.Parser:
    from lie_rigid_body.diagnosis.examination import MOST_RUNS, MOST_RUNS_OF_NODE, TIMEOUT_S

    parser = console.Parser(
        "diagnose",
        "Say what is wrong with an attitude filter, by repairing it from outside.",
        *ESTIMATOR,
        console.argument("--json", action="store_true", help="print what is found for programs"),
        console.argument("--report", metavar="OUT.html", type=console.path, help="write what is found as one page"),
        console.argument("--force", action="store_true", help="replace OUT.html if it exists"),
        console.argument("--workers", metavar="N", type=int, help="processes; one per core if absent"),
        console.argument(
            "--max-runs",
            metavar="N",
            type=int,
            help="runs of the filter after which no more repairs are tried "
            f"(default: {MOST_RUNS}, and {MOST_RUNS_OF_NODE} of a node)",
        ),
        console.argument(
            "--timeout",
            metavar="SECONDS",
            type=float,
            default=TIMEOUT_S,
            help="longest time of one run of the filter (default: %(default)g)",
        ),
        epilog="Exit status: 0, 1 where a mistake is named or a probe failed, 2 when the filter cannot be run.",
    )
    return console.add_scenario_arguments(parser)
