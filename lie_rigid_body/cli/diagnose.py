"""``diagnose``: what is wrong with an attitude filter, by repairing it from outside; and how a filter is given.

A filter is a function, a program that reads and writes CSV, or a ROS 2 node.
"""

from __future__ import annotations

import argparse
from typing import Any

from lie_rigid_body.command_line import ESTIMATOR, FORCE, WORKERS, argument, file_name, json_option, verb
from lie_rigid_body.diagnosis.examination import MAX_RUNS, MAX_RUNS_OF_NODE, TIMEOUT_S, diagnose
from lie_rigid_body.estimates.programs import CommandEstimator, NodeEstimator, ProgramEstimator, words
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import printable
from lie_rigid_body.system import console


def given_estimator(given: argparse.Namespace) -> tuple[str, ProgramEstimator | str | None]:
    """Words, printable, that give the estimator on the command line, and what they name; nothing without one."""
    if given.node is not None:
        return printable(given.node), NodeEstimator(given.node, given.timeout)
    if given.command is not None:
        return printable(given.command), CommandEstimator(given.command, given.timeout)
    return given.estimator or "", given.estimator


def named_by(given: argparse.Namespace) -> list[str]:
    """Words of the command that is given, which may name files that it reads."""
    return words(given.command or given.node or "")


@verb(
    "Say what is wrong with an attitude filter, by repairing it from outside.",
    json_option("print what is found for programs"),
    argument("--report", metavar="OUT.html", type=file_name, help="write what is found as one page"),
    FORCE,
    WORKERS,
    argument(
        "--max-runs",
        metavar="N",
        type=int,
        help="runs of the filter after which no constant is fitted and no pair of repairs is begun "
        f"(default: {MAX_RUNS}, and {MAX_RUNS_OF_NODE} of a node)",
    ),
    argument(
        "--timeout",
        metavar="SECONDS",
        type=float,
        default=TIMEOUT_S,
        help="longest time of one run of the filter (default: %(default)g)",
    ),
    either=ESTIMATOR,
    scenario=True,
    epilog="Exit status: 0, 1 where a mistake is named or a probe failed, 2 when the filter cannot be run.",
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    name, estimate = given_estimator(given)
    if estimate is None:
        raise InputError(
            "no estimator: give MODULE:FUNCTION, such as my_filter:estimate, --command PROGRAM, or --node COMMAND"
        )

    from lie_rigid_body.report.answer import as_page, as_text
    from lie_rigid_body.report.filters import parts_of_diagnosis
    from lie_rigid_body.report.outputs import emit, require_outputs
    from lie_rigid_body.scenario.parameter_file import gather

    require_outputs(given, [*given.params_file, *named_by(given)], "json", "report")
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
    parts = parts_of_diagnosis(found)
    status = emit(
        given,
        {given.report: lambda: as_page(f"Diagnosis of {name}", parts)},
        lambda: as_text(parts),
        found.to_dict,
        passed=found.passed,
    )
    if found.interrupted:
        console.complain(console.program("diagnose"), "interrupted: this is what was found so far")
        return console.INTERRUPTED
    return status
