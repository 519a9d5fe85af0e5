"""``explain``: what the mathematics says about a scenario, before it is run."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence

from lie_rigid_body import console
from lie_rigid_body.cli.scenarios import describe as describe_file
from lie_rigid_body.errors import InputError


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)

    from lie_rigid_body.cli import explanation_text
    from lie_rigid_body.motion.description import describe

    if given.name is not None and given.scenario is not None:
        raise InputError(f"two scenarios, {given.name} and --scenario {given.scenario}: give one of them")
    given.scenario = given.scenario or given.name
    scenario = console.scenario(given)
    description = describe(scenario.body(), scenario.start())
    if given.json:
        facts = explanation_text.as_json(scenario, description)
        console.say(json.dumps(facts, indent=2, allow_nan=False))
    else:
        console.say(explanation_text.as_text(scenario, description, _title(given)))
    return console.SUCCESS


def _title(given: argparse.Namespace) -> str:
    """Scenario name and summary; empty if files or assignments override it."""
    if given.scenario is None or given.params_file or given.assignments:
        return ""

    from lie_rigid_body.scenario.parameter_file import scenario_files

    return f"{given.scenario}: {describe_file(scenario_files()[given.scenario])}"


def _parser() -> console.Parser:
    parser = console.Parser(
        "explain",
        "Tell what the mathematics says about a scenario, without running it.",
        console.argument("name", metavar="NAME", nargs="?", help="a scenario of the package, as by --scenario"),
        console.argument(
            "--json", action="store_true", help="print it for programs; infinite and absent numbers are null"
        ),
    )
    return console.add_scenario_arguments(parser)
