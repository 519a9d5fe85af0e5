"""``evaluate`` of a bag: what an attitude estimate in it is worth, and why."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from lie_rigid_body.command_line import topic_names
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.report.score_options import answer, parse, require_room
from lie_rigid_body.system import console


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = parse(sys.argv[1:] if argv is None else argv)
    if given.run is None:
        raise InputError("no bag is given: give one; without, 'lie-rigid-body evaluate' follows topics of ROS 2")
    require_room(given)

    from lie_rigid_body.estimates.recorded_estimate import TRUE_TOPICS, TRUTH, recorded_estimate
    from lie_rigid_body.evaluation import Limits

    limits = Limits.parse(given.max_rms, tuple(given.max_after))
    topics = topic_names(given.topic, TRUE_TOPICS)
    if given.truth_topic:
        topics[TRUTH] = given.truth_topic
    with console.progress_of_bags(filter(None, (given.run, given.truth)), passes=len(given.estimate)) as bar:
        reads = [recorded_estimate(given.run, topic, given.truth, topics, bar.update) for topic in given.estimate]
    return answer(given, given.run, [(read, read.score(limits, given.covariance_axes)) for read in reads])
