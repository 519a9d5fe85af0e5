"""The model of an answer: verdict, sentences, tables, pictures and JSON; and how a terminal and a page show it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from lie_rigid_body.foundation.wording import printable
from lie_rigid_body.report import html_page
from lie_rigid_body.report.html_page import escaped, paragraph


@dataclass(frozen=True)
class Conclusion:
    """Conclusion of an answer.

    Attributes
    ----------
    sentences : sequence of str
    passed : bool
    """

    sentences: Sequence[str]
    passed: bool


@dataclass(frozen=True)
class Sentences:
    """Sentences, as paragraphs, or as a list under a heading.

    Attributes
    ----------
    lines : sequence of str
    heading : str
    """

    lines: Sequence[str]
    heading: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of cells.

    Attributes
    ----------
    headings : sequence of str
        Empty without a line of headings.
    rows : sequence of sequence of str
    heading : str
    marked : sequence of bool
        Whether a page marks each row, as it does those that break a law; empty where it marks none.
    """

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    heading: str = ""
    marked: Sequence[bool] = ()


@dataclass(frozen=True)
class Picture:
    """Figures of a page; a terminal shows none.

    Attributes
    ----------
    draw : callable
        Gives them as HTML.
    """

    draw: Callable[[], str]


@dataclass(frozen=True)
class Details:
    """JSON that a page shows on request, and a terminal does not."""

    summary: str
    content: str


_NUMBER: Final = re.compile(r"(?:[-+]?\d\S*(?: \S+)?)?")
"""A number, perhaps with its unit, or nothing."""
Part: TypeAlias = Conclusion | Sentences | Table | Picture | Details
"""Parts that an answer is made of."""
Parts: TypeAlias = Sequence[Part]
"""Answer, part by part."""


def as_text(parts: Parts, title: str = "") -> str:
    """Lines for a terminal, which wraps those that are longer than itself; without a final newline."""
    blocks = [[printable(title)] if title else [], *map(_lines, parts)]
    return "\n\n".join("\n".join(block) for block in blocks if block)


def _lines(part: Part) -> list[str]:
    match part:
        case Conclusion(sentences):
            return list(sentences)
        case Sentences(lines, heading):
            told = [*map(printable, lines)]
            return [f"{heading}:", *(f"- {line}" for line in told)] if heading and told else told
        case Table(headings, rows, heading):
            return [*filter(None, [heading]), *columns([headings, *rows] if headings else rows)] if rows else []
    return []


def columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of aligned columns; those of numbers, below their headings, are aligned on the right."""
    padded = []
    for column in zip(*rows, strict=True):
        cells = [*map(printable, column)]
        of_numbers = all(_NUMBER.fullmatch(cell) for cell in cells[1:])
        width = max(map(len, cells))
        padded.append([cell.rjust(width) if of_numbers else cell.ljust(width) for cell in cells])
    return ["  ".join(line).rstrip() for line in zip(*padded, strict=True)]


def as_html(parts: Parts, *, pictures: bool = True) -> list[str]:
    """HTML of each part, in a notebook without pictures."""
    return [_html(part) for part in parts if pictures or not isinstance(part, Picture | Details)]


def _html(part: Part) -> str:
    match part:
        case Conclusion(sentences, passed):
            return "".join(html_page.badge(sentence, passed=passed) for sentence in sentences)
        case Sentences(lines, heading):
            return html_page.listing(heading, lines) if heading else "".join(map(paragraph, lines))
        case Table(headings, rows, heading, marked):
            head = f"<h2>{escaped(heading)}</h2>" if heading else ""
            return f"{head}{html_page.table(headings, rows, marked)}" if rows else ""
        case Picture(draw):
            return draw()
        case Details(summary, content):
            return html_page.details(summary, content)


def as_page(title: str, parts: Parts, *, with_film: bool = False) -> bytes:
    """Page that shows an answer; see `html_page.document`."""
    return html_page.document(title, as_html(parts), with_film=with_film)
