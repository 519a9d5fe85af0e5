"""Estimators on the command line: a function, a program that reads and writes CSV, or a ROS 2 node."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Final

from lie_rigid_body.command_line import argument
from lie_rigid_body.errors import InputError

if TYPE_CHECKING:
    from lie_rigid_body.runs.estimators import CommandEstimator

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
    argument(
        "--node",
        metavar="COMMAND",
        help="in its place: a ROS 2 node that hears imu/data_raw and imu/mag and publishes attitudes on imu/data; one "
        "process a run, in lock-step",
    ),
)
WORKERS: Final = argument("--workers", metavar="N", type=int, help="processes; one per core if absent")
"""Arguments that `given_estimator` reads."""


def given_estimator(given: argparse.Namespace) -> tuple[str, CommandEstimator | str | None]:
    """The words by which the estimator is given, and what they name; nothing where none is.

    Raises
    ------
    InputError
        If there are several.
    """
    kinds = {"": given.estimator, "--command ": given.command, "--node ": given.node}
    there = [f"{kind}{name}" for kind, name in kinds.items() if name is not None]
    if len(there) > 1:
        raise InputError(f"{len(there)} estimators, {' and '.join(there)}: give one of them")
    if given.node is not None:
        from lie_rigid_body.runs.node import NodeEstimator

        return given.node, NodeEstimator(given.node, given.timeout)
    if given.command is not None:
        from lie_rigid_body.runs.estimators import CommandEstimator

        return given.command, CommandEstimator(given.command, given.timeout)
    return given.estimator or "", given.estimator
