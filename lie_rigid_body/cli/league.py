"""``league``: a filter over the cases of the league, and its row among those of the reference set."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence

from lie_rigid_body import console


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    console.require_suffix("--report", given.report, ".html")

    from lie_rigid_body.diagnosis.filter import NamedFunction
    from lie_rigid_body.league import CASES, EDITION, reference
    from lie_rigid_body.league.playing import play
    from lie_rigid_body.league.table import rows_of
    from lie_rigid_body.recording.output_file import require_room, write_file
    from lie_rigid_body.report import league_page, league_text
    from lie_rigid_body.system import cores
    from lie_rigid_body.wording import printable

    if given.report is not None:
        require_room(given.report, given.others, overwrite=given.force)
    own = [row for path in given.others for row in rows_of(path)]
    if given.estimator is not None:
        from tqdm import tqdm

        source = NamedFunction(given.estimator)
        source.load()
        # disable=None: shown on a terminal only
        with tqdm(total=len(CASES), desc="league", unit=" cases", file=sys.stderr, disable=None, leave=False) as bar:
            own.insert(
                0,
                play(
                    given.estimator,
                    source,
                    workers=given.workers or cores(),
                    timeout_s=given.timeout,
                    progress=bar.update,
                ),
            )
    table = reference().with_rows(own)
    wrote = ""
    if given.report is not None:
        write_file(given.report, league_page.page(table, own), overwrite=given.force)
        wrote = f"\nwrote {printable(given.report)}"
    if given.json:
        rows = [row.to_json() for row in (own[:1] if given.estimator else table.rows)]
        console.say(json.dumps({"edition": EDITION, "rows": rows}, indent=2, ensure_ascii=False))
    else:
        console.say(f"{league_text.as_text(table, own)}{wrote}")
    return console.SUCCESS


def _parser() -> console.Parser:
    from lie_rigid_body.diagnosis.examination import TIMEOUT_S

    parser = console.Parser("league", "Run an attitude filter over the league's cases, or print the league's table.")
    parser.epilog = "Exit status: 0, or 2 when the filter gives no estimate."
    parser.add_argument(
        "estimator",
        metavar="ESTIMATOR",
        nargs="?",
        help="MODULE:FUNCTION, a function of a run that returns attitudes (N, 4), scalar last",
    )
    parser.add_argument(
        "--with",
        metavar="ROWS.json",
        dest="others",
        type=console.path,
        action="append",
        default=[],
        help="rows of other filters, as --json writes them; may be repeated",
    )
    parser.add_argument("--json", action="store_true", help="print the filter's row, or all rows, for programs")
    parser.add_argument("--report", metavar="OUT.html", type=console.path, help="write the table as one page")
    parser.add_argument("--force", action="store_true", help="replace OUT.html if it exists")
    parser.add_argument("--workers", metavar="N", type=int, help="processes; one per core if absent")
    parser.add_argument(
        "--timeout",
        metavar="SECONDS",
        type=float,
        default=TIMEOUT_S,
        help="longest time of a case (default: %(default)g)",
    )
    return parser
