"""``evaluate`` of a bag: what an attitude estimate in it is worth, and why."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from lie_rigid_body import console
from lie_rigid_body.cli.bag_progress import progress_bar
from lie_rigid_body.report.request import answer, parse, require_room


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = parse(sys.argv[1:] if argv is None else argv)
    require_room(given)

    from lie_rigid_body.evaluation import Limits, evaluate
    from lie_rigid_body.runs.recorded_estimate import TRUE_TOPICS, recorded_estimate
    from lie_rigid_body.runs.unavoidable import bound_of

    limits = Limits.parse(given.max_rms, tuple(given.max_after))
    topics = console.topic_names(given.topic, TRUE_TOPICS)
    with progress_bar([path for path in (given.run, given.truth) if path], passes=1) as bar:
        read = recorded_estimate(given.run, given.estimate, given.truth, topics, bar.update)
    track = read.track
    bound = bound_of(read.segments, read.truth, track.stamps_ns)
    score = evaluate(
        track.stamps_ns,
        track.attitude_xyzw,
        read.truth,
        limits=limits,
        covariance=read.covariance,
        covariance_axes=given.covariance_axes,
        bound=bound,
        left_out=read.left_out,
        due_ns=read.truth.last_ns,
    )
    return answer(given, given.run, read, score)
