"""A score as one HTML page, which needs no other file and no network."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from html import escape
from typing import Final

from lie_rigid_body import __version__
from lie_rigid_body.evaluation import Limits, Score, summary
from lie_rigid_body.report import text
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate

_STYLE: Final = """
body { font-family: sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { padding: 0.3rem 0.9rem; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; }
.passed, .broken { display: inline-block; padding: 0.2rem 0.8rem; border-radius: 0.4rem; color: white; }
.passed { background: #0a7a55; } .broken { background: #b3261e; }
li { margin: 0.5rem 0; } code { background: #f2f4f6; padding: 0 0.3rem; }
figure { margin: 1rem 0; } svg { width: 100%; height: auto; }
pre { background: #f2f4f6; padding: 0.8rem; overflow-x: auto; }
"""


def page(title: str, read: RecordedEstimate, score: Score, limits: Limits, picture: str) -> str:
    """The page.

    Parameters
    ----------
    title : str
    read : RecordedEstimate
    score : Score
    limits : Limits
    picture : str
        An SVG element.

    Returns
    -------
    str
        HTML.
    """
    return "\n".join(
        [
            "<!DOCTYPE html>",
            f'<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title><style>{_STYLE}</style></head>',
            f"<body><h1>{escape(title)}</h1>",
            *_verdict(score, limits),
            f"<p>{escape(text.extent(read, score))}.</p>",
            *_table(score),
            *_list("Findings", (f"<code>{f.code}</code> {escape(f.message)}" for f in score.findings), "None."),
            *_list("Notes", map(escape, read.notes), ""),
            f"<h2>Errors over time</h2><figure>{picture}</figure>",
            *_scenarios(read),
            f"<p>Errors as defined by BROAD (Data 6(7):72, 2021). Made by lie_rigid_body {__version__}.</p>",
            "</body></html>",
            "",
        ]
    )


def _verdict(score: Score, limits: Limits) -> Iterator[str]:
    name = "passed" if score.passed else "broken"
    for sentence in text.verdict(score, limits):
        yield f'<p><span class="{name}">{escape(sentence)}</span></p>'


def _table(score: Score) -> Iterator[str]:
    headings = "".join(f"<th>{heading}</th>" for heading in ("error, deg", *summary.HEADINGS))
    yield f"<table><tr>{headings}</tr>"
    for name, statistics in summary.angles(score):
        cells = "".join(f"<td>{number}</td>" for number in summary.numbers(statistics))
        yield f"<tr><td>{name}</td>{cells}</tr>"
    yield "</table><table>"
    for name, value in summary.facts(score):
        yield f'<tr><td>{name}</td><td style="text-align: left">{escape(value)}</td></tr>'
    yield "</table>"


def _list(heading: str, items: Iterable[str], empty: str) -> Iterator[str]:
    entries = [f"<li>{item}</li>" for item in items]
    if entries:
        yield f"<h2>{heading}</h2><ul>{''.join(entries)}</ul>"
    elif empty:
        yield f"<h2>{heading}</h2><p>{empty}</p>"


def _scenarios(read: RecordedEstimate) -> Iterator[str]:
    for segment in read.segments:
        shown = json.dumps(json.loads(segment.to_json()), indent=2, ensure_ascii=False)
        yield f"<details><summary>Scenario from {segment.start_ns} ns on</summary><pre>{escape(shown)}</pre></details>"
