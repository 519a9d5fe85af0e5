"""The notebook of the examples runs from its first cell to its last, and shows what it did when it was written."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")


def told(path: Path) -> Iterator[tuple[int, str]]:
    """The texts of the outputs with the number of their cell, but those of other libraries, and without digits."""
    cells: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["cells"]
    for number, cell in enumerate(cells):
        for output in cell.get("outputs", []):
            text = "".join(output.get("text") or output["data"].get("text/html", ""))
            yield number, NUMBER.sub("0", text) if "dataframe" not in text else "a table of pandas"


@pytest.mark.slow
def test_the_notebook_shows_what_it_did(tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    new = tmp_path / "new.ipynb"
    command = [sys.executable, str(ROOT / "docs" / "run_notebook.py"), str(new)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    shown = [*told(ROOT / "examples" / "first_filter.ipynb")]
    assert [*told(new)] == shown, "run it anew: python docs/run_notebook.py"
    texts = [text for _, text in shown]
    assert any("heading_offset" in text for text in texts)
    assert any("fails 0 of 0 probes: linear_acceleration" in text for text in texts)  # no mistake is left
    assert "image/png" in new.read_text(encoding="utf-8")
