"""Compiled code is kept under a name that changes with everything it is made from."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from lie_rigid_body.compilation import cache
from lie_rigid_body.motion.moser_veselov import loop as moser_veselov_loop

PACKAGE = {
    "__init__.py": "",
    "constants.py": "from sizes_of_something import SIZE\nFACTOR = 2.0\n",
    "kernels.py": "from made_up.constants import FACTOR\ndef twice(x):\n    return FACTOR * x\n",
    "inner/__init__.py": "",
    "inner/loop.py": "def advance(x):\n    from .. import kernels\n    return kernels.twice(x)\n",
    "inner/neighbour.py": "BESIDE = 1\n",
}


@pytest.fixture
def made_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    folder = tmp_path / "made_up"
    for name, source in PACKAGE.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield folder
    for name in [name for name in sys.modules if name.partition(".")[0] == "made_up"]:
        del sys.modules[name]


@pytest.mark.parametrize(
    ("file", "counts"),
    [("constants.py", True), ("kernels.py", True), ("inner/loop.py", True), ("inner/neighbour.py", False)],
)
def test_a_change_of_any_file_that_the_code_is_made_from_changes_its_name(made_up: Path, file: str, counts: bool):
    advance = importlib.import_module("made_up.inner.loop").advance

    before = cache._digest(advance)
    (made_up / file).write_text(PACKAGE[file] + "# changed\n", encoding="utf-8")
    assert (cache._digest(advance) != before) is counts


def test_the_digest_is_that_of_another_process_which_loaded_less_or_more():
    """It follows the imports in the source, not what happens to be loaded: the process that compiles imports little."""
    files = {path.name for path in cache._source_files(moser_veselov_loop.__name__)}
    assert {"double_double.py", "numbers.py", "layout.py", "kernels.py"} <= files
    assert "scenario.py" not in files


def test_the_series_that_a_loop_has_taken_in_are_part_of_it():
    files = cache._source_files("lie_rigid_body.motion.munthe_kaas.loop")
    assert any(path.parts[-2:] == ("lie", "series.py") for path in files)
