"""Options of ``evaluate``, of a bag and of topics, and the answer that they ask for."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lie_rigid_body.command_line import (
    ESTIMATOR,
    FORCE,
    LOG_OPTIONS,
    TOPIC_OPTION,
    Parser,
    argument,
    file_name,
    json_option,
    split_ros_arguments,
)
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import listed
from lie_rigid_body.system import console

if TYPE_CHECKING:
    from lie_rigid_body.estimates.recorded_estimate import RecordedEstimate
    from lie_rigid_body.evaluation import Score

_OF_AN_ESTIMATOR: Final = ("estimator", "command", "node")
_OF_A_LOG: Final = ("imu", "magnetometer", "columns")
_OF_A_BAG: Final = {
    "run": "run",
    "estimate": "estimate",
    "truth": "truth",
    "topic": "truth",
    "out": "",
    **dict.fromkeys((*_OF_AN_ESTIMATOR, *_OF_A_LOG), ""),
}
"""Options that go with a bag, each with the topic that one remaps without a bag, if there is one."""
_OF_TOPICS: Final = {"duration": "", "wait": ""}
_EPILOG: Final = """
Without RUN it follows the estimate on a topic of ROS 2 while it runs, until Ctrl-C, SIGTERM or --duration, and then
says the score. The topics are named after --ros-args: -r estimate:=/imu/data, and where the truth is not found by
itself -r truth:=TOPIC, a scenario or poses. Exit status: 0, 1 when a limit is broken, 2 when there is nothing to score.
"""
ARGUMENTS: Final = (
    argument(
        "run",
        metavar="RUN",
        type=file_name,
        nargs="?",
        help="an MCAP file, or a folder that 'ros2 bag record' made; a trajectory, which is the truth: TUM, EuRoC or "
        "t_ns,x,y,z,w; or a log of sensors, with an ESTIMATOR",
    ),
    argument(
        "--estimate",
        metavar="TOPIC|FILE",
        action="append",
        help="a trajectory, or a topic of a bag: PoseStamped, PoseWithCovarianceStamped, QuaternionStamped, Imu, "
        "Odometry, TransformStamped or TFMessage; several are compared",
    ),
    argument(
        "--truth",
        metavar="TOPIC|FILE",
        type=file_name,
        help="the topic of the truth in RUN, of the same types, or the bag or the trajectory that has the truth",
    ),
    TOPIC_OPTION,
    *LOG_OPTIONS,
    json_option("print the score for programs"),
    argument("--series", action="store_true", help="with --json: also the errors of every sample"),
    argument("--plot", metavar="OUT.png", type=file_name, help="draw the errors over time"),
    argument("--report", metavar="OUT.html", type=file_name, help="write score, findings and picture as one page"),
    argument(
        "--out",
        metavar="SCORED.mcap",
        type=file_name,
        help="write truth, estimates and their errors over time as a bag, for PlotJuggler and Foxglove",
    ),
    argument(
        "--max-rms",
        metavar="ANGLE",
        action="append",
        default=[],
        help="largest RMS of the total error, such as 1deg",
    ),
    argument(
        "--max-after",
        metavar="TIME:ANGLE",
        action="append",
        default=[],
        help="largest total error after a time since the first estimate, such as 10s:2deg; may be repeated",
    ),
    argument(
        "--covariance-axes",
        choices=("world", "body"),
        default="world",
        help="what the covariance of the estimate is about (default: %(default)s)",
    ),
    FORCE,
    argument(
        "--duration", metavar="SECONDS", type=float, help="of topics: end when the stamps of the estimate span this"
    ),
    argument(
        "--wait",
        metavar="SECONDS",
        type=float,
        help="of topics: end when no estimate could be compared for so long",
    ),
)


def is_live(argv: Sequence[str]) -> bool:
    """Whether arguments, without the program's name, ask for topics: they give no bag."""
    return not parse(argv).run


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """Read the arguments, without the program's name; those for ROS, which are not read, are in ``ros``.

    Raises
    ------
    InputError
        If an option goes only with a bag, and there is none, or the other way round.
    """
    own, ros = split_ros_arguments(argv)
    parser = Parser(
        "evaluate",
        "Score and diagnose an attitude estimate against the truth.",
        *ARGUMENTS,
        either=ESTIMATOR,
        epilog=_EPILOG,
    )
    given = parser.parse_args(own, argparse.Namespace(ros=ros))
    live = given.run is None
    if ros and not live:
        raise InputError(f"--ros-args: {given.run} is read without ROS: leave it out, or leave out the bag")
    for name, remapped in (_OF_A_BAG if live else _OF_TOPICS).items():
        if getattr(given, name) not in (None, []):
            remedy = f"remap the topic, --ros-args -r {remapped}:=TOPIC" if remapped and live else "leave it out"
            raise InputError(f"--{name} goes only {'with' if live else 'without'} a bag: {remedy}")
    estimators = [name for name in _OF_AN_ESTIMATOR if getattr(given, name) is not None]
    if not live and bool(given.estimate) == bool(estimators):
        parser.error("give either --estimate, or an estimator: MODULE:FUNCTION, --command or --node")
    of_log = [f"--{name}" for name in _OF_A_LOG if getattr(given, name) is not None]
    if of_log and not estimators:
        raise InputError(f"{listed(of_log)}: they choose readings of a log for an estimator: give one")
    if estimators and given.topic:
        raise InputError("--topic goes only with --estimate: name the truth of a log by --truth")
    if given.estimate and len({topic.lstrip("/") for topic in given.estimate}) < len(given.estimate):
        raise InputError(f"--estimate {listed(given.estimate)}: give each topic once")
    given.truth_topic = None if given.truth is None or Path(given.truth).exists() else given.truth
    given.truth = None if given.truth_topic else given.truth
    if given.series and given.json is None:
        raise InputError("--series goes only with --json: give both, or leave it out")
    if len(given.max_rms) > 1:
        raise InputError(f"--max-rms is given {len(given.max_rms)} times, {listed(given.max_rms)}: give one limit")
    given.max_rms = next(iter(given.max_rms), None)
    return given


def require_room(given: argparse.Namespace) -> None:
    """Refuse outputs before the work, of arguments as `parse` gives them; see `report.outputs.require_outputs`."""
    from lie_rigid_body.recording.bag_files import files_of
    from lie_rigid_body.recording.poses import is_bag
    from lie_rigid_body.report.outputs import require_outputs

    read = [*filter(None, (given.run, given.truth)), *(each for each in given.estimate or () if Path(each).is_file())]
    inputs = [file for path in read for file in (files_of(path) if is_bag(path) else [path])]
    require_outputs(given, inputs, "json", "plot", "report", "out")


def answer(
    given: argparse.Namespace,
    source: str,
    scored: Sequence[tuple[RecordedEstimate, Score]],
    write_out: Callable[[], None] | None = None,
) -> int:
    """Write and print what is asked for.

    Parameters
    ----------
    given : argparse.Namespace
        As `parse` gives it.
    source : str
        Of the estimates: a bag, or empty for topics.
    scored : sequence of (RecordedEstimate, Score)
    write_out : callable, optional
        Writes ``--out``; by default the run of the bag beside the estimates.

    Returns
    -------
    int
        The exit status: that of an unusable input where a covariance is none.
    """
    from lie_rigid_body.estimates.recorded_estimate import write_scored
    from lie_rigid_body.report import drawing, scores
    from lie_rigid_body.report.answer import as_page, as_text
    from lie_rigid_body.report.outputs import emit

    (read, score), *others = scored
    truth = given.truth or given.run
    if others:
        title = source
        parts = scores.parts_of_several(scored)
        draw = partial(scores.curves, title, scored)
        content = partial(scores.json_of_several, source, scored, series=given.series)
    else:
        title = ": ".join(filter(None, (source, read.track.topic)))
        parts = scores.parts(read, score)
        draw = partial(scores.draw, title, score)
        content = partial(scores.as_json, source or None, read, score, series=given.series)
    status = emit(
        given,
        {
            given.out: write_out
            or partial(write_scored, given.out, truth, scored, given.covariance_axes, overwrite=given.force),
            given.plot: lambda: drawing.png(draw),
            given.report: lambda: as_page(title, parts),
        },
        lambda: as_text(parts, title),
        content,
        passed=all(score.passed for _, score in scored),
    )
    for fault in filter(None, (read.fault for read, _ in scored)):
        console.complain(console.program("evaluate"), fault)
        status = console.UNUSABLE
    return status
