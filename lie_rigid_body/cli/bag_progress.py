"""A bag that is read with a progress bar."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lie_rigid_body.recording.bag_reader import Bag


@contextmanager
def open_bag(path: str | Path, *, passes: int) -> Iterator[Bag]:
    """Open a bag that shows on a terminal, while this context lasts, how far it has been read.

    Parameters
    ----------
    path : str or Path
    passes : int
        How often it will be read, once to open it.
    """
    from tqdm import tqdm

    from lie_rigid_body.recording.bag_reader import Bag

    files = Path(path).glob("*.mcap") if Path(path).is_dir() else [Path(path)]
    size = sum(file.stat().st_size for file in files if file.is_file())
    # disable=None: shown on a terminal only
    with tqdm(
        total=passes * size, unit="B", unit_scale=True, file=sys.stderr, disable=None, leave=False, delay=0.5
    ) as bar:
        yield Bag(path, bar.update)
