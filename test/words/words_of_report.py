"""What the pictures of recordings and the pages of many bags say."""
# mypy: ignore-errors

from __future__ import annotations

import html
import re
import sys
from pathlib import Path
from unittest.mock import patch

from test_check import write_bag
from test_recording_picture import segments

from lie_rigid_body import LieRigidBodyError, simulate
from lie_rigid_body.cli.check import main as check
from lie_rigid_body.report import recording_picture
from lie_rigid_body.report.overview import Verdict, page_of_verdicts


def of_segments(count):
    """What is written above the picture of so many segments of a sample."""
    return recording_picture._title(segments(Path.cwd(), 1) * count, "first segment: " if count > 1 else "")


def words(source):
    """The headings, paragraphs and lists of a page, without its pictures."""
    text = re.sub(r"(?s)<(style|script|svg|pre)\b.*?</\1>|<figure.*?</figure>", "", source)
    text = re.sub(r"\s*</t[dh]>\s*<t[dh][^>]*>\s*", " | ", text)
    return html.unescape(re.sub(r"\s*\n\s*", "\n", re.sub(r"<[^>]+>", "\n", text))).strip()


def certificate():
    assert check([str(write_bag(Path("bag.mcap"), 5)), "--report", "bag.html"]) == 0
    return words(Path("bag.html").read_text(encoding="utf-8"))


def without_pandas():
    with patch.dict(sys.modules, {"pandas": None}):
        simulate(duration=0.1).to_dataframe()


REFUSED = {LieRigidBodyError: [lambda: recording_picture.draw([]), without_pandas]}
SAID = [
    lambda: of_segments(1),
    lambda: of_segments(2),
    lambda: of_segments(41),
    lambda: certificate(),
    lambda: words(page_of_verdicts("Bags", [Verdict("x", None, None, "no pose")]).decode()),
]
