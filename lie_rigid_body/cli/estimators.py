"""Estimators on the command line: a function, or a program that reads and writes CSV."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Final

from lie_rigid_body.console import argument
from lie_rigid_body.errors import InputError

if TYPE_CHECKING:
    from lie_rigid_body.runs.command import CommandEstimator

ESTIMATOR: Final = (
    argument(
        "estimator",
        metavar="ESTIMATOR",
        nargs="?",
        help="MODULE:FUNCTION, a function of a run that returns attitudes (N, 4), scalar last",
    ),
    argument(
        "--command",
        metavar="PROGRAM",
        help="in its place: a program that reads readings as CSV and prints attitudes, t_ns,x,y,z,w",
    ),
)
"""Arguments that `given_estimator` reads."""


def given_estimator(given: argparse.Namespace) -> CommandEstimator | str | None:
    """The estimator of the arguments, if there is one.

    Raises
    ------
    InputError
        If there are two.
    """
    if given.command is None:
        found: str | None = given.estimator
        return found
    if given.estimator is not None:
        raise InputError(f"two estimators, {given.estimator} and --command {given.command}: give one of them")

    from lie_rigid_body.runs.command import CommandEstimator

    return CommandEstimator(given.command, given.timeout)
