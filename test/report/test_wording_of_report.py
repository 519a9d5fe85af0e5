"""Words of pictures and pages of reports: other tests of this folder assert on numbers, names and what is drawn."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_check import write_bag
from test_recording_picture import segments

from lie_rigid_body import LieRigidBodyError, simulate
from lie_rigid_body.cli.check import main as check
from lie_rigid_body.report import recording_picture
from lie_rigid_body.report.overview import Line, Verdict, page, page_of_verdicts

FAR = ", far "
"""What is said of a limit beyond the axis."""
CERTIFIED = Line(("a",), True, 1e-15, {"closed form [rad]": (1e-15, 1e-11)})
EXACT = Line(("b",), True, 0.0, {"closed form [rad]": (0.0, 1e-11)})
BROKEN = Line(("c",), False, np.nan, {"closed form [rad]": (1e-3, 1e-11)})
TITLE = "inertia [1, 2, 2.5] kg m², initial body rate [0.01, 1, 0.01] rad/s\n"


def of_segments(folder: Path, count: int) -> str:
    """What is written above the picture of so many segments of a sample."""
    return recording_picture._title(segments(folder, 1) * count, "first segment: " if count > 1 else "")


def certificate(folder: Path) -> str:
    assert check([str(write_bag(folder / "bag.mcap", 5)), "--report", str(folder / "bag.html")]) == 0
    return (folder / "bag.html").read_text(encoding="utf-8")


def bags(*lines: Line) -> str:
    return page("Bags", "bags", ("bag",), lines).decode()


SAID: dict[str, Callable[[Path], str]] = {
    f"torque-free body, {TITLE}": lambda folder: of_segments(folder, 1),
    "; 1 sample at 100 Hz": lambda folder: of_segments(folder, 1),
    f"torque-free body, first segment: {TITLE}": lambda folder: of_segments(folder, 2),
    "; 2 samples at 100 Hz, 1 reset (dashed)": lambda folder: of_segments(folder, 2),
    "; 41 samples at 100 Hz, 40 resets (marks above)": lambda folder: of_segments(folder, 41),
    ">Not certified<": certificate,
    ">1 of 2 bags CERTIFIED<": lambda folder: bags(CERTIFIED, BROKEN),
    "within the limit": lambda folder: bags(CERTIFIED, BROKEN),
    "beyond the limit": lambda folder: bags(CERTIFIED, BROKEN),
    "0 in 1 bags": lambda folder: bags(CERTIFIED, EXACT),
    ">Not judged<": lambda folder: page_of_verdicts("Bags", [Verdict("x", None, None, "no pose")]).decode(),
}
"""Words, each with what is written."""


@pytest.mark.parametrize("words", SAID)
def test_what_is_shown_is_said(words: str, tmp_path: Path) -> None:
    assert words in SAID[words](tmp_path)


REFUSED: dict[str, Callable[[], Any]] = {
    "no sample has both a pose and a twist of the same stamp: record both topics together": lambda: (
        recording_picture.draw([])
    ),
    "to_dataframe needs pandas, which is not installed: pip install pandas": lambda: simulate(
        duration=0.1
    ).to_dataframe(),
}


@pytest.mark.parametrize("said", REFUSED)
def test_it_is_refused_in_one_line(said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(LieRigidBodyError) as caught:
        REFUSED[said]()
    assert str(caught.value) == said
