"""``league``: a filter over the cases of the league, and its row among those of the reference set."""

from __future__ import annotations

import argparse

from lie_rigid_body.cli.diagnose import given_estimator, named_by
from lie_rigid_body.command_line import ESTIMATOR, FORCE, WORKERS, argument, file_name, json_option, verb
from lie_rigid_body.diagnosis.examination import TIMEOUT_S
from lie_rigid_body.system import console


@verb(
    "Run an attitude filter over the cases of the league, or print its table.",
    argument(
        "--with",
        metavar="ROWS.json",
        dest="others",
        type=file_name,
        action="append",
        default=[],
        help="rows of other filters, as --json writes them; may be repeated",
    ),
    json_option("print the filter's row, or all rows, for programs"),
    argument("--report", metavar="OUT.html", type=file_name, help="write the table as one page"),
    FORCE,
    WORKERS,
    argument(
        "--timeout",
        metavar="SECONDS",
        type=float,
        default=TIMEOUT_S,
        help="longest time of a case (default: %(default)g)",
    ),
    either=ESTIMATOR,
    epilog="Exit status: 0, or 2 when the filter gives no estimate.",
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    from lie_rigid_body.estimates.estimators import source_of
    from lie_rigid_body.league import CASES, EDITION, reference
    from lie_rigid_body.league.playing import play
    from lie_rigid_body.league.table import require_names, rows_of
    from lie_rigid_body.report.answer import as_page, as_text
    from lie_rigid_body.report.filters import parts_of_league
    from lie_rigid_body.report.outputs import emit, require_outputs
    from lie_rigid_body.system.portable import cores

    require_outputs(given, [*given.others, *named_by(given)], "json", "report")
    own = [row for path in given.others for row in rows_of(path)]
    name, estimate = given_estimator(given)
    require_names([*([name] if estimate else []), *(row.name for row in (*own, *reference().rows))])
    if estimate is not None:
        source = source_of(estimate)
        assert source is not None  # it is no function
        with console.progress(total=len(CASES), desc="league", unit=" cases") as bar:
            own.insert(
                0, play(name, source, workers=given.workers or cores(), timeout_s=given.timeout, progress=bar.update)
            )
    table = reference().with_rows(own)
    parts = parts_of_league(table, own)
    return emit(
        given,
        {given.report: lambda: as_page(f"League of attitude filters {EDITION}", parts)},
        lambda: as_text(parts),
        lambda: {
            "edition": EDITION,
            "rows": [row.to_json(table) for row in (own[:1] if estimate else table.rows)],
            "cases": [{"name": name, "hash": digest} for name, digest in table.readings.items()],
        },
    )
