"""Bags that arguments name, and how far they have been read."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from tqdm import tqdm

PASSES: Final = 3
"""Largest number of times that a bag is read: to open it, to find its segments, and to take its samples."""


def is_folder_of_bags(name: str) -> bool:
    """Whether an argument is a folder that is not one bag itself."""
    from lie_rigid_body.recording.bag_files import is_one_bag

    return Path(name).is_dir() and not is_one_bag(Path(name))


def bags_of(names: Sequence[str]) -> list[str]:
    """Bags that the arguments name, each once; folders of bags are searched."""
    from lie_rigid_body.recording.bag_files import bags_in

    found: dict[Path, str] = {}
    for name in names:
        for bag in bags_in(Path(name)) if is_folder_of_bags(name) else [name]:
            found.setdefault(Path(bag).resolve(), str(bag))
    return list(found.values())


def progress_bar(bags: Iterable[str | Path], passes: int = PASSES) -> tqdm[Any]:
    """Progress bar of the bytes to be read of bags in so many passes, as a context; `tqdm.update` takes those read."""
    from tqdm import tqdm

    total = passes * sum(map(size, bags))
    # disable=None: shown on a terminal only
    return tqdm(total=total, unit="B", unit_scale=True, file=sys.stderr, disable=None, leave=False, delay=0.5)


def size(bag: str | Path) -> int:
    """Number of bytes of a bag's files; 0 where there are none."""
    path = Path(bag)
    files = [*path.glob("*.mcap"), *path.glob("*.db3")] if path.is_dir() else [path]
    return sum(file.stat().st_size for file in files if file.is_file())
