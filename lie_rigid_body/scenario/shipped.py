"""The files that come with the package."""

from __future__ import annotations

from pathlib import Path

CONFIG = Path(__file__).parent.parent / "config"


def scenario_files() -> dict[str, Path]:
    """Return the parameter file of every named scenario.

    Returns
    -------
    dict[str, Path]
        Name, as given to ``--scenario``, to file; in the order of the names.
    """
    return {file.stem: file for file in sorted(CONFIG.glob("*.yaml"))}
