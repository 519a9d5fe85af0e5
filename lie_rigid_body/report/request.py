"""Request of a command line for a score, and the answer: table or JSON, picture, page, exit status."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from lie_rigid_body import console
from lie_rigid_body.errors import InputError
from lie_rigid_body.wording import listed, printable

if TYPE_CHECKING:
    from lie_rigid_body.evaluation import Score
    from lie_rigid_body.runs.recorded_estimate import RecordedEstimate

_OF_A_BAG: Final = {"run": "run", "estimate": "estimate", "truth": "truth", "topic": "truth"}
"""Options that go with a bag, each with the topic that one remaps without a bag."""
_OF_TOPICS: Final = {"duration": "", "wait": ""}
_EPILOG: Final = """
Without RUN it follows the estimate on a topic of ROS 2 while it runs, until Ctrl-C, SIGTERM or --duration, and then
says the score. The topics are named after --ros-args: -r estimate:=/imu/data, and where the truth is not found by
itself -r truth:=TOPIC, a scenario or poses. Exit status: 0, 1 when a limit is broken, 2 when there is nothing to score.
"""


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
    own, ros = console.split_ros_arguments(argv)
    given = _parser().parse_args(own)
    given.ros = ros
    live = given.run is None
    if ros and not live:
        raise InputError(f"--ros-args: {given.run} is read without ROS: leave it out, or leave out the bag")
    for name, remapped in (_OF_A_BAG if live else _OF_TOPICS).items():
        if getattr(given, name) not in (None, []):
            remedy = f"remap the topic, --ros-args -r {remapped}:=TOPIC" if live else "leave it out"
            raise InputError(f"--{name} goes only {'with' if live else 'without'} a bag: {remedy}")
    if not live and given.estimate is None:
        _parser().error("the following arguments are required: --estimate")
    if given.max_rms and len(given.max_rms) > 1:
        raise InputError(f"--max-rms is given {len(given.max_rms)} times, {listed(given.max_rms)}: give one limit")
    given.max_rms = given.max_rms[0] if given.max_rms else None
    console.require_suffix("--plot", given.plot, ".png")
    console.require_suffix("--report", given.report, ".html")
    return given


def _parser() -> console.Parser:
    parser = console.Parser("evaluate", "Score and diagnose an attitude estimate against the truth.")
    parser.epilog = _EPILOG
    parser.add_argument(
        "run", metavar="RUN", type=console.path, nargs="?", help="an MCAP file, or a folder that 'ros2 bag record' made"
    )
    parser.add_argument(
        "--estimate",
        metavar="TOPIC",
        help="of a bag: PoseStamped, PoseWithCovarianceStamped, QuaternionStamped, Imu, Odometry or TFMessage",
    )
    parser.add_argument("--truth", metavar="OTHER", type=console.path, help="the bag of the truth, if it is not in RUN")
    console.add_topic_argument(parser)
    parser.add_argument("--json", action="store_true", help="print the score for programs")
    parser.add_argument("--series", action="store_true", help="with --json: also the errors of every sample")
    parser.add_argument("--plot", metavar="OUT.png", type=console.path, help="draw the errors over time")
    parser.add_argument(
        "--report", metavar="OUT.html", type=console.path, help="write score, findings and picture as one page"
    )
    parser.add_argument(
        "--max-rms", metavar="ANGLE", action="append", help="largest RMS of the total error, such as 1deg"
    )
    parser.add_argument(
        "--max-after",
        metavar="TIME:ANGLE",
        action="append",
        default=[],
        help="largest total error after a time since the first estimate, such as 10s:2deg; may be repeated",
    )
    parser.add_argument(
        "--covariance-axes",
        choices=("world", "body"),
        default="world",
        help="what the covariance of the estimate is about (default: %(default)s)",
    )
    parser.add_argument("--force", action="store_true", help="replace OUT.png and OUT.html if they exist")
    parser.add_argument(
        "--duration", metavar="SECONDS", type=float, help="of topics: end when the stamps of the estimate span this"
    )
    parser.add_argument(
        "--wait", metavar="SECONDS", type=float, help="of topics: end when no estimate could be compared for so long"
    )
    return parser


def require_room(given: argparse.Namespace) -> None:
    """Refuse picture and page before the work if they could not be written after it, or are inputs or one file.

    Parameters
    ----------
    given : argparse.Namespace
        As `parse` gives it.

    Raises
    ------
    BagError
    """
    from lie_rigid_body.recording import output_file
    from lie_rigid_body.recording.bag_files import files_of

    bags = [bag for bag in (given.run, given.truth) if bag is not None]
    for path in (given.plot, given.report):
        if path is not None:
            output_file.require_room(path, (file for bag in bags for file in files_of(bag)), overwrite=given.force)
    if given.plot is not None and given.report is not None:
        output_file.require_other(given.report, [given.plot], "output")


def answer(given: argparse.Namespace, source: str, read: RecordedEstimate, score: Score) -> int:
    """Write and print what is asked for.

    Parameters
    ----------
    given : argparse.Namespace
        As `parse` gives it.
    source : str
        Of the estimate: a bag, or empty for topics.
    read : RecordedEstimate
    score : Score

    Returns
    -------
    int
        The exit status.
    """
    from lie_rigid_body.recording.output_file import write_file
    from lie_rigid_body.report import score_page, score_picture, score_text

    title = f"{source}: {read.track.topic}" if source else read.track.topic
    makes = {
        given.plot: lambda: score_picture.png(title, score),
        given.report: lambda: score_page.page(title, read, score),
    }
    files = [path for path in makes if path is not None]
    for path in files:
        write_file(path, makes[path](), overwrite=given.force)
    if given.json:
        content = score_text.as_json(source or None, read, score, series=given.series)
        said = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    else:
        said = "\n".join([score_text.as_table(title, read, score), *(f"wrote {printable(path)}" for path in files)])
    console.say(said, done=", ".join(f"{path} is written" for path in files))
    return console.SUCCESS if score.passed else console.BROKEN
