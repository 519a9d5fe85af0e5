"""``scenarios``: the named scenarios that come with the package."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from lie_rigid_body.command_line import FORCE, json_option, verb


@verb(
    "List the scenarios that come with the package, for --scenario NAME.",
    json_option("print them for programs, with all parameters"),
    FORCE,
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    from lie_rigid_body.report.outputs import emit, require_outputs
    from lie_rigid_body.scenario import Scenario
    from lie_rigid_body.scenario.parameter_file import read_parameter_file, scenario_files

    require_outputs(given, (), "json")
    entries = [
        {
            "name": name,
            "description": describe(path),
            "file": str(path),
            **Scenario.from_parameters(read_parameter_file(path)).parameters(),
        }
        for name, path in scenario_files().items()
    ]
    return emit(given, {}, lambda: "\n".join(map(_paragraph, entries)), lambda: entries)


def describe(path: Path) -> str:
    """Description of a scenario: the first comment line of its parameter file."""
    comments = (line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#"))
    return next(comments, "").lstrip("# ").rstrip()


def _paragraph(entry: dict[str, Any]) -> str:
    inertia = " ".join(f"{value:g}" for value in entry["inertia"])
    return (
        f"{entry['name']}\n    {entry['description']}\n"
        f"    inertia {inertia} kg m², {entry['rate']:g} samples/s, {entry['motion']}"
    )
