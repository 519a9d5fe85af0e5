"""Request for a score, from a command line or from Python, and the answer: table or JSON, picture, page, status."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lie_rigid_body.command_line import TOPIC_OPTION, Parser, argument, file_name, require_suffix, split_ros_arguments
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.system import console
from lie_rigid_body.system.output_file import write_file

if TYPE_CHECKING:
    from lie_rigid_body.estimates.recorded_estimate import RecordedEstimate
    from lie_rigid_body.evaluation import Score

TITLE: Final = "attitude estimate"
"""Title of a picture or a page that is given none."""
_INSTEAD: Final = {
    "Run": "give run.score(attitude_xyzw)",
    "Certificate": "lie-rigid-body check BAG --report OUT.html writes its page",
    "FilterDiagnosis": "lie-rigid-body diagnose ESTIMATOR --report OUT.html writes its page",
}
"""Remedies where another result is given for a score, by its class."""
_OF_A_BAG: Final = {"run": "run", "estimate": "estimate", "truth": "truth", "topic": "truth", "out": ""}
"""Options that go with a bag, each with the topic that one remaps without a bag, if there is one."""
_OF_TOPICS: Final = {"duration": "", "wait": ""}
_EPILOG: Final = """
Without RUN it follows the estimate on a topic of ROS 2 while it runs, until Ctrl-C, SIGTERM or --duration, and then
says the score. The topics are named after --ros-args: -r estimate:=/imu/data, and where the truth is not found by
itself -r truth:=TOPIC, a scenario or poses. Exit status: 0, 1 when a limit is broken, 2 when there is nothing to score.
"""
_ARGUMENTS: Final = (
    argument(
        "run",
        metavar="RUN",
        type=file_name,
        nargs="?",
        help="an MCAP file, or a folder that 'ros2 bag record' made",
    ),
    argument(
        "--estimate",
        metavar="TOPIC",
        action="append",
        help="of a bag: PoseStamped, PoseWithCovarianceStamped, QuaternionStamped, Imu, Odometry or TFMessage; "
        "several are compared",
    ),
    argument("--truth", metavar="OTHER", type=file_name, help="the bag of the truth, if it is not in RUN"),
    TOPIC_OPTION,
    argument("--json", action="store_true", help="print the score for programs"),
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
    argument("--force", action="store_true", help="replace outputs that exist"),
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


def parse(argv: Sequence[str]) -> argparse.Namespace:
    """Read the arguments, without the program's name; those for ROS, which are not read, are in ``ros``.

    Raises
    ------
    InputError
        If an option goes only with a bag, and there is none, or the other way round.
    """
    own, ros = split_ros_arguments(argv)
    parser = Parser(
        "evaluate", "Score and diagnose an attitude estimate against the truth.", *_ARGUMENTS, epilog=_EPILOG
    )
    given = parser.parse_args(own, argparse.Namespace(ros=ros))
    live = given.run is None
    if ros and not live:
        raise InputError(f"--ros-args: {given.run} is read without ROS: leave it out, or leave out the bag")
    for name, remapped in (_OF_A_BAG if live else _OF_TOPICS).items():
        if getattr(given, name) not in (None, []):
            remedy = f"remap the topic, --ros-args -r {remapped}:=TOPIC" if remapped and live else "leave it out"
            raise InputError(f"--{name} goes only {'with' if live else 'without'} a bag: {remedy}")
    if not live and given.estimate is None:
        parser.error("the following arguments are required: --estimate")
    if given.estimate and len({topic.lstrip("/") for topic in given.estimate}) < len(given.estimate):
        raise InputError(f"--estimate {listed(given.estimate)}: give each topic once")
    if len(given.max_rms) > 1:
        raise InputError(f"--max-rms is given {len(given.max_rms)} times, {listed(given.max_rms)}: give one limit")
    given.max_rms = next(iter(given.max_rms), None)
    return given


def require_room(given: argparse.Namespace) -> None:
    """Refuse outputs before the work, of arguments as `parse` gives them; see `report.drawing.require_outputs`."""
    from lie_rigid_body.recording.bag_files import files_of
    from lie_rigid_body.report.drawing import require_outputs

    bags = filter(None, (given.run, given.truth))
    require_outputs(given, (file for bag in bags for file in files_of(bag)), ("plot", "report", "out"))


def answer(given: argparse.Namespace, source: str, scored: Sequence[tuple[RecordedEstimate, Score]]) -> int:
    """Write and print what is asked for.

    Parameters
    ----------
    given : argparse.Namespace
        As `parse` gives it.
    source : str
        Of the estimates: a bag, or empty for topics.
    scored : sequence of (RecordedEstimate, Score)

    Returns
    -------
    int
        The exit status: that of an unusable input where a covariance is none.
    """
    status = _answer(given, source, scored)
    for fault in filter(None, (read.fault for read, _ in scored)):
        console.complain(console.program("evaluate"), fault)
        status = console.UNUSABLE
    return status


def _answer(given: argparse.Namespace, source: str, scored: Sequence[tuple[RecordedEstimate, Score]]) -> int:
    from lie_rigid_body.estimates.recorded_estimate import write_scored
    from lie_rigid_body.report import drawing, scores

    (read, score), *others = scored
    title = source if others else ": ".join(filter(None, (source, read.track.topic)))
    truth, axes = given.truth or given.run, given.covariance_axes
    bag = {given.out: partial(write_scored, given.out, truth, scored, axes, overwrite=given.force)}
    if others:
        return drawing.answer(
            given,
            {
                **bag,
                given.plot: lambda: drawing.png(partial(scores.curves, title, scored)),
                given.report: lambda: scores.page_of_several(title, scored),
            },
            lambda: scores.table_of_several(title, scored),
            lambda: scores.json_of_several(source, scored, series=given.series),
            passed=all(score.passed for _, score in scored),
        )
    return drawing.answer(
        given,
        {
            **bag,
            given.plot: lambda: drawing.png(partial(scores.draw, title, score)),
            given.report: lambda: scores.page(title, read, score),
        },
        lambda: scores.as_table(title, read, score),
        lambda: scores.as_json(source or None, read, score, series=given.series),
        passed=score.passed,
    )


def _write(
    score: object, path: str | Path, suffix: str, title: object, content: Callable[[], bytes], *, overwrite: bool
) -> None:
    """Write what shows a score, unless it is none, the title no text, or the name of the file ends otherwise."""
    from lie_rigid_body.evaluation import Score

    if not isinstance(title, str):
        raise InputError(f"title {shown(title)} is no text: give one, or leave it out")
    if not isinstance(score, Score):
        kind = type(score).__name__
        raise InputError(f"a {kind} is no score: {_INSTEAD.get(kind, 'give what evaluate() or run.score() returns')}")
    require_suffix("path", str(path), suffix)
    write_file(path, content(), overwrite=overwrite)


def write_plot(score: Score, path: str | Path, *, title: str = TITLE, overwrite: bool = False) -> None:
    """Draw the errors over time, with the limits and the best that the noise allows, as a PNG.

    Parameters
    ----------
    score : Score
    path : str or Path
        Its name ends in ``.png``.
    title : str, optional
    overwrite : bool, optional
        Whether an existing file is replaced.

    Raises
    ------
    InputError, BagError
        If it is no score, the title no text, the name ends otherwise, or the file exists or cannot be written.
    """
    from lie_rigid_body.report import drawing, scores

    picture = partial(scores.draw, title, score)
    _write(score, path, ".png", title, partial(drawing.png, picture), overwrite=overwrite)


def write_report(score: Score, path: str | Path, *, title: str = TITLE, overwrite: bool = False) -> None:
    """Write score, findings and picture as one HTML page, which needs no network.

    Parameters and errors are those of `write_plot`, but the name of the file ends in ``.html``.
    """
    from lie_rigid_body.report import scores

    _write(score, path, ".html", title, partial(scores.page, title, None, score), overwrite=overwrite)
