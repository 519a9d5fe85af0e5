"""The league of attitude filters: ``make league``.

Every filter of ``league/filters`` runs over every case of the league, at its library's defaults. The best point of the
grid that its file declares is chosen on other cases and seeds, and is advised where it is shown to be better.

    make league                   prints the table, some 70 minutes on two cores; results are kept, so it may be stopped
    make league ARGS=--save       also writes docs/reference/league.md, picture, and rows of the verb league
"""

from __future__ import annotations

import argparse
import json
import os
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from league import page, recordings
from league.contender import filters, missing
from league.tournament import play
from lie_rigid_body.league.table import EDITION, REFERENCE, reference
from lie_rigid_body.report.filters import draw_league

ROOT: Final = Path(__file__).resolve().parent.parent


def main() -> None:
    """Play, print the table, and write what was asked for."""
    parser = argparse.ArgumentParser(description="Attitude filters of other libraries over shipped cases.")
    parser.add_argument("--save", action="store_true", help="write the table, the picture and the numbers of docs/")
    save = parser.parse_args().save
    print(", ".join(f"{name} {version(name)}" for name in sorted({each.library for each in filters()})), flush=True)
    for module in missing():
        print(f"{module} is left out: its library is not installed", flush=True)
    entries, hashes, bounds = play(len(os.sched_getaffinity(0)))
    league = page.reference(entries, hashes, bounds, recordings.medians())
    parts = page.table(entries, league), page.advice(entries, league.real_deg), page.remarks(entries)
    print(*parts, sep="\n\n")
    if not REFERENCE.exists():
        print(f"The reference set {EDITION} is made for the first time.")
    elif lines := page.change(reference(), league):
        print("\n".join(lines))
    else:
        print(f"The reference set {EDITION} is made again: nothing changed.")
    if save:
        draw_league(page.plain(league), 8.5).savefig(ROOT / "docs" / "images" / "league.png", dpi=110)
        REFERENCE.write_text(
            f"{json.dumps({'edition': EDITION, **without_empty(league)}, indent=0)}\n", encoding="utf-8"
        )
        reference_page = ROOT / "docs" / "reference" / "league.md"
        reference_page.write_text(page.replaced(reference_page.read_text(encoding="utf-8"), *parts), encoding="utf-8")


def without_empty(league: Any) -> dict[str, Any]:
    """The fields of a table, without those of its results that are empty."""
    content = asdict(league)
    for row in content["rows"]:
        row["results"] = {
            case: {name: value for name, value in result.items() if value not in (None, "")}
            for case, result in row["results"].items()
        }
    return content


if __name__ == "__main__":
    main()
