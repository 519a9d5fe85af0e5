"""``check``: bags held against the conservation laws, without ROS."""

from __future__ import annotations

import argparse

from lie_rigid_body.command_line import FORCE, TOPIC_OPTION, argument, file_name, json_option, verb


@verb(
    "Certify that a bag obeys the laws of torque-free motion, and how exactly.",
    argument(
        "bags",
        metavar="BAG",
        type=file_name,
        nargs="+",
        help="an MCAP file, a folder that 'ros2 bag record' made, or a folder of such bags, also in folders below it",
    ),
    json_option("print the certificate for programs"),
    argument(
        "--inertia",
        metavar="a,b,c",
        help="3 principal moments or 6 tensor entries to use in place of the declared ones",
    ),
    TOPIC_OPTION,
    argument(
        "--max-attitude",
        metavar="ANGLE",
        help="largest error of the attitude, such as 1e-9rad, in place of the declared motion's: 5.3e-15 rad of "
        "closed_form, 1e-12 of dmv20, 1e-7 of the others",
    ),
    argument(
        "--prove",
        metavar="N",
        type=int,
        help="enclose the true motion at N samples spread over the bag, and at the worst ones, in ball arithmetic "
        "(needs python-flint)",
    ),
    argument(
        "--report",
        metavar="OUT.html",
        type=file_name,
        help="write laws, drifts and the motion in 3-D as one page (needs plotly)",
    ),
    FORCE,
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    from lie_rigid_body.cli.checking import check

    return check(given)
