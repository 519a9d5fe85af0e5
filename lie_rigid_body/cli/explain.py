"""``explain``: what the mathematics says about a scenario, before it is run."""

from __future__ import annotations

import argparse

from lie_rigid_body import console
from lie_rigid_body.cli.scenarios import describe as describe_file
from lie_rigid_body.errors import InputError


@console.verb(
    "Tell what the mathematics says about a scenario, without running it.",
    console.argument("name", metavar="NAME", nargs="?", help="a scenario of the package, as by --scenario"),
    console.argument("--json", action="store_true", help="print it for programs; infinite and absent numbers are null"),
    scenario=True,
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    from lie_rigid_body.cli.explanation_text import as_json, as_text
    from lie_rigid_body.motion.description import describe
    from lie_rigid_body.report.drawing import answer
    from lie_rigid_body.scenario.parameter_file import scenario_files

    if given.name is not None and given.scenario is not None:
        raise InputError(f"two scenarios, {given.name} and --scenario {given.scenario}: give one of them")
    name = given.scenario = given.scenario or given.name
    scenario = console.scenario(given)
    description = describe(scenario.body(), scenario.start())
    is_whole = name and not (given.params_file or given.assignments)  # files and assignments make another of it
    title = f"{name}: {describe_file(scenario_files()[name])}" if is_whole else ""
    answer(given, lambda: as_text(scenario, description, title), lambda: as_json(scenario, description))
    return console.SUCCESS
