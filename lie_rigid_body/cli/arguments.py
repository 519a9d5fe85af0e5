"""What the verbs share, from where the node shares it too."""

from __future__ import annotations

from lie_rigid_body.console import (
    INTERRUPTED,
    SUCCESS,
    UNUSABLE,
    Parser,
    add_scenario_arguments,
    complain,
    parameters,
    program,
    run,
)

__all__ = [
    "INTERRUPTED",
    "SUCCESS",
    "UNUSABLE",
    "Parser",
    "add_scenario_arguments",
    "complain",
    "parameters",
    "program",
    "run",
]
