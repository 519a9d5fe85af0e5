"""The command line of ``evaluate`` on topics: the score of an attitude estimate while it runs."""

from __future__ import annotations

from collections.abc import Sequence

from lie_rigid_body.report.score_options import parse, require_room
from lie_rigid_body.ros.installation import require_ros
from lie_rigid_body.system import console
from lie_rigid_body.system.interruption import Interruption


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Follow an estimate until SIGINT, SIGTERM, SIGHUP or the given duration, and say its score.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.

    Returns
    -------
    int
        Exit status: 0, 1 when a limit is broken, 2 when there is nothing to score, 130 when interrupted before an
        estimate came. An estimate with attitudes that cannot be used has its score, and 2.
    """
    given = parse(argv)
    require_room(given)
    require_ros()
    with Interruption.current().noted() as interruption:
        from lie_rigid_body.ros.evaluator import evaluate

        return evaluate(given, interruption)
