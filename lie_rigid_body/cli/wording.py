"""How the explanation writes numbers and lines, and what it calls the axes."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

LABELS: Final = {
    "asymmetric": ("smallest", "intermediate", "largest"),
    "oblate": ("equal", "equal", "axis of symmetry"),
    "prolate": ("axis of symmetry", "equal", "equal"),
    "spherical": ("equal", "equal", "equal"),
}
"""What is said of the moments' axes, in ascending order of the moments."""
_WIDTH: Final = 98


def number(value: float) -> str:
    """Six digits: more than anybody compares by eye, and enough to recognise the number elsewhere."""
    return f"{value:.6g}"


def degrees(angle_rad: float) -> str:
    """An angle in degrees, to three digits."""
    return f"{math.degrees(angle_rad):.3g}°"


def period(rate_rad_s: float) -> str:
    """The time of one turn at an angular rate."""
    return f"{number(2.0 * math.pi / rate_rad_s)} s" if rate_rad_s else "no finite time"


def vector(values: Sequence[float]) -> str:
    """Numbers in brackets."""
    return "[" + ", ".join(number(value) for value in values) + "]"


def axis_name(kind: str, index: int) -> str:
    """An axis by its number and what is said of it."""
    return f"axis {index + 1} ({LABELS[kind][index]})"


def wrapped(sentences: str, indent: str = "") -> list[str]:
    """Sentences broken into lines for a terminal."""
    return textwrap.wrap(sentences, _WIDTH, initial_indent=indent, subsequent_indent=indent)


def columns(rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    """Rows of cells as lines, each column as wide as its widest cell."""
    table = list(rows)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for row in table:
        yield "   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
