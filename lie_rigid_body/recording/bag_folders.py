"""The bags in a folder of bags."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from lie_rigid_body.errors import BagError
from lie_rigid_body.recording.bag_files import METADATA, SUFFIXES, BagFiles, is_one_bag, natural_order


def whole_of(file: Path) -> Path | None:
    """The folder of the bag that was split into several files, of which this is one; None if it is not."""
    folder = file.parent
    parts = [*folder.glob(f"*{file.suffix}")] if file.suffix in SUFFIXES and file.is_file() else []
    return folder if len(parts) > 1 and is_one_bag(folder) else None


def missing_beside(file: Path) -> str | None:
    """The first file that is missing where all in a folder are called as those of a bag that was split; else None."""
    if file.suffix not in SUFFIXES or not file.is_file():
        return None
    folder, name = file.parent, file.resolve().parent.name
    there = {path.name for path in folder.glob(f"*{file.suffix}")}
    numbers = [
        int(found[1]) for each in there if (found := re.fullmatch(rf"{re.escape(name)}_(\d{{1,6}}){file.suffix}", each))
    ]
    if len(numbers) < len(there) or not numbers:
        return None
    wanted = (f"{name}_{i}{file.suffix}" for i in range(max(numbers)))
    return next((each for each in wanted if each not in there), None)


def bags_in(folder: Path) -> list[Path]:
    """The bags in a folder and the folders below it: MCAP and SQLite files, and rosbag2 folders, each as one.

    Folders that are hidden, or symbolic links, are left out.

    Parameters
    ----------
    folder : Path
        If it is a rosbag2 folder itself, it is the only bag.

    Returns
    -------
    list of Path
        By their names, numbers in them in their order. A folder that cannot be read, or has no bag in it, stands for
        itself: whoever opens it is told why it is none.
    """
    return sorted(_bags_below(folder), key=natural_order) or [folder]


def files_of(bag: str | Path) -> Iterator[Path]:
    """The files of a bag, or of all bags in a folder, whatever is wrong with them."""
    if not Path(bag).is_dir():
        yield Path(bag)
        return
    for each in bags_in(Path(bag)):
        with suppress(BagError):
            yield from BagFiles(each).files
        yield from (file for file in each.glob("*") if file.suffix in SUFFIXES or file.name == METADATA)


def _bags_below(folder: Path) -> Iterator[Path]:
    try:
        if is_one_bag(folder):
            yield folder
            return
        with os.scandir(folder) as entries:
            inside = [entry for entry in entries if not entry.name.startswith(".")]
    except OSError:
        yield folder
        return
    for entry in inside:
        if entry.is_dir(follow_symlinks=False):
            yield from _bags_below(folder / entry.name)
        elif entry.name.endswith(SUFFIXES):
            yield folder / entry.name
