from __future__ import annotations

from pathlib import Path

import pytest
from bags import MakeBag, write_bag


@pytest.fixture
def make_bag(tmp_path: Path) -> MakeBag:
    """`write_bag` into the test's own folder."""

    def make(name: str = "bag.mcap", count: int = 100, batch: int = 1024, **parameters: object) -> Path:
        return write_bag(tmp_path / name, count, batch, **parameters)

    return make
