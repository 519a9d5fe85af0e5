"""``scenarios``: the named scenarios that come with the package."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lie_rigid_body import console


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    parser = console.Parser(
        "scenarios",
        "List the scenarios that come with the package, for --scenario NAME.",
        console.argument("--json", action="store_true", help="print them for programs, with all parameters"),
    )
    given = parser.parse_args(argv)

    from lie_rigid_body.scenario.parameter_file import scenario_files

    entries = [_entry(name, path) for name, path in scenario_files().items()]
    console.say(json.dumps(entries, indent=2) if given.json else "\n".join(_paragraph(entry) for entry in entries))
    return console.SUCCESS


def _entry(name: str, path: Path) -> dict[str, Any]:
    from lie_rigid_body.scenario import Scenario
    from lie_rigid_body.scenario.parameter_file import read_parameter_file

    scenario = Scenario.from_parameters(read_parameter_file(path))
    return {"name": name, "description": describe(path), "file": str(path), **scenario.parameters()}


def describe(path: Path) -> str:
    """Description of a scenario: the first comment line of its parameter file."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return next((line.lstrip("# ").rstrip() for line in lines if line.startswith("#")), "")


def _paragraph(entry: dict[str, Any]) -> str:
    inertia = " ".join(f"{value:g}" for value in entry["inertia"])
    facts = f"inertia {inertia} kg m², {entry['rate']:g} samples/s, {entry['motion']}"
    return f"{entry['name']}\n    {entry['description']}\n    {facts}"
