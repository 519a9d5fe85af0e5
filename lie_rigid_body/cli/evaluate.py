"""``evaluate``: what an attitude estimate in a bag is worth, and why."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from lie_rigid_body import console

if TYPE_CHECKING:
    from lie_rigid_body.evaluation import Limits, Score
    from lie_rigid_body.runs.recorded_estimate import RecordedEstimate

BROKEN: Final = 1
"""Exit status of a score that breaks a limit."""


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    console.require_suffix("--plot", given.plot, ".png")
    console.require_suffix("--report", given.report, ".html")

    from lie_rigid_body.cli import score_text
    from lie_rigid_body.evaluation import Limits, evaluate
    from lie_rigid_body.recording.output_file import write_file
    from lie_rigid_body.runs.recorded_estimate import recorded_estimate

    limits = Limits.parse(given.max_rms, tuple(given.max_after))
    read = recorded_estimate(given.run, given.estimate, given.truth)
    track = read.track
    score = evaluate(track.stamps_ns, track.attitude_xyzw, read.truth, limits=limits, covariance=read.covariance)
    title = f"{given.run}: {track.topic}"
    for path, draw in ((given.plot, _picture), (given.report, _page)):
        if path is not None:
            write_file(path, draw(title, read, score, limits), overwrite=given.force)
    files = [path for path in (given.plot, given.report) if path is not None]
    if given.json:
        content = score_text.as_json(given.run, read, score, series=given.series)
        text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    else:
        text = "\n".join([score_text.as_table(title, read, score, limits), *(f"wrote {path}" for path in files)])
    console.say(text, done=", ".join(f"{path} is written" for path in files))
    return console.SUCCESS if score.passed else BROKEN


def _parser() -> console.Parser:
    parser = console.Parser("evaluate", "Score and diagnose an attitude estimate in a bag against the truth.")
    parser.add_argument("run", metavar="RUN", help="an MCAP file, or a folder that 'ros2 bag record' made")
    parser.add_argument(
        "--estimate",
        metavar="TOPIC",
        required=True,
        help="PoseStamped, PoseWithCovarianceStamped, QuaternionStamped, Imu, Odometry or TFMessage",
    )
    parser.add_argument("--truth", metavar="OTHER", help="the bag of the truth, if it is not in RUN")
    parser.add_argument("--json", action="store_true", help="print the score for programs")
    parser.add_argument("--series", action="store_true", help="with --json: also the errors of every sample")
    parser.add_argument("--plot", metavar="OUT.png", help="draw the errors over time")
    parser.add_argument("--report", metavar="OUT.html", help="write score, findings and picture as one page")
    parser.add_argument("--max-rms", metavar="ANGLE", help="largest RMS of the total error, such as 1deg")
    parser.add_argument(
        "--max-after",
        metavar="TIME:ANGLE",
        action="append",
        default=[],
        help="largest total error after a time since the first estimate, such as 10s:2deg; may be repeated",
    )
    parser.add_argument("--force", action="store_true", help="replace OUT.png and OUT.html if they exist")
    return parser


def _picture(title: str, read: RecordedEstimate, score: Score, limits: Limits) -> bytes:
    from lie_rigid_body.cli.score_figure import png

    return png(title, score, limits)


def _page(title: str, read: RecordedEstimate, score: Score, limits: Limits) -> bytes:
    from lie_rigid_body.cli.score_figure import svg
    from lie_rigid_body.cli.score_page import page

    return page(title, read, score, limits, svg(title, score, limits))
