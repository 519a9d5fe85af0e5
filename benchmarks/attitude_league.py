"""The league of attitude filters: ``make league``.

Every filter of ``league/filters`` runs over every case of ``config/league``, at its library's defaults and at the best
of the grid that its file declares. Settings are chosen on runs with other noise than those that are scored.

    make league                   prints the table, half an hour on two cores
    make league ARGS=--save       also writes docs/reference/league.md, picture, and rows of the verb league
"""

from __future__ import annotations

import argparse
import json
import os
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Final

from league import page
from league.contender import filters, missing
from league.tournament import play
from lie_rigid_body.league.table import EDITION, REFERENCE, reference

ROOT: Final = Path(__file__).resolve().parent.parent


def main() -> None:
    """Play, print the table, and write what was asked for."""
    parser = argparse.ArgumentParser(description="Attitude filters of other libraries over shipped cases.")
    parser.add_argument("--save", action="store_true", help="write the table, the picture and the numbers of docs/")
    save = parser.parse_args().save
    print(", ".join(f"{name} {version(name)}" for name in sorted({each.library for each in filters()})), flush=True)
    for module in missing():
        print(f"{module} is left out: its library is not installed", flush=True)
    defaults, best, bounds = play(len(os.sched_getaffinity(0)))
    rows, table = page.ranking(defaults, best), page.reference(defaults, best, bounds)
    print(page.table(rows, bounds), page.advice(rows), sep="\n\n")
    print("\n".join(page.change(reference(), table)) or f"The reference set {EDITION} is made again: nothing changed.")
    if save:
        page.heat_map(rows, bounds).savefig(ROOT / "docs" / "images" / "league.png")
        REFERENCE.write_text(f"{json.dumps({'edition': EDITION, **asdict(table)}, indent=0)}\n", encoding="utf-8")
        reference_page = ROOT / "docs" / "reference" / "league.md"
        reference_page.write_text(
            page.replaced(reference_page.read_text(encoding="utf-8"), rows, bounds), encoding="utf-8"
        )


if __name__ == "__main__":
    main()
