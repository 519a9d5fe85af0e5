"""How far bags have been read."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lie_rigid_body import console


def progress_bar(bags: Iterable[str | Path], passes: int = 3) -> Any:
    """Progress bar of the bytes to be read of bags in so many passes, as a context; its ``update`` takes those read.

    A bag is read three times at most: to open it, to find its segments, and to take its samples.
    """
    return console.progress(total=passes * sum(map(size, bags)), unit="B", unit_scale=True, delay=0.5)


def size(bag: str | Path) -> int:
    """Number of bytes of a bag's files; 0 where there are none."""
    path = Path(bag)
    files = path.glob("*.mcap") if path.is_dir() else [path]
    return sum(file.stat().st_size for file in files if file.is_file())
