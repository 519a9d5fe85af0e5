"""``inspect``: what is wrong with a log of sensors, by its stamps and by its sensors against each other."""

from __future__ import annotations

import argparse

from lie_rigid_body.command_line import FORCE, LOG_OPTIONS, argument, columns_of, file_name, json_option, verb
from lie_rigid_body.foundation.wording import printable


@verb(
    "Say what is wrong with a log of sensors, without truth.",
    argument(
        "log",
        metavar="LOG",
        type=file_name,
        help="a bag with sensor_msgs/Imu (MCAP, or sqlite3), a CSV, or a folder or a zip with one CSV a sensor",
    ),
    *LOG_OPTIONS,
    argument(
        "--truth",
        metavar="TOPIC|FILE",
        help="true attitudes: a topic of the bag, another bag, or a trajectory; its clock and mounting are reported",
    ),
    json_option("print what is found for programs"),
    argument("--report", metavar="OUT.html", type=file_name, help="write what is found as one page, with pictures"),
    argument(
        "--parameters",
        metavar="OUT.yaml",
        type=file_name,
        help="write a parameter file with which the simulator's sensors are like these",
    ),
    argument("--out", metavar="FIXED.csv", type=file_name, help="write the readings with their mistakes undone"),
    FORCE,
    epilog="Exit status: 0, 1 where a mistake is named, 2 when the log cannot be read.",
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    from lie_rigid_body.inspection import inspect
    from lie_rigid_body.report.answer import as_page
    from lie_rigid_body.report.inspections import as_text, csv_of, parameters_of, parts_of_inspection
    from lie_rigid_body.report.outputs import emit, require_outputs
    from lie_rigid_body.runs import Run

    inputs = [*filter(None, (given.log, given.truth))]
    require_outputs(given, inputs, "json", "report", "parameters", "out", suffixes={"out": ".csv"})
    run = Run.from_log(
        given.log,
        truth=given.truth,
        imu=given.imu,
        magnetometer=given.magnetometer,
        columns=columns_of(given.columns),
    )
    found = inspect(run)
    parts = parts_of_inspection(found)
    log = printable(given.log)
    return emit(
        given,
        {
            given.report: lambda: as_page(f"Inspection of {log}", parts),
            given.parameters: lambda: parameters_of(found.sensors, log),
            given.out: lambda: csv_of(found.repaired()),
        },
        lambda: as_text(found),
        found.to_dict,
        passed=found.passed,
    )
