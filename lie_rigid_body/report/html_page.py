"""The frame of a page: one HTML file that needs no other file and no network, and its figures."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from html import escape
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, Final

from lie_rigid_body import __version__
from lie_rigid_body.foundation.wording import printable
from lie_rigid_body.report.drawing import of_axes, svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STYLE: Final = """
:root { color-scheme: light dark; --ink: #222; --paper: white; --line: #ddd; }
:root { --soft: #f2f4f6; --faint: #555; --bad: #fbe9e7; }
body { font-family: sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
body { color: var(--ink); background: var(--paper); }
h1 { font-size: 1.5rem; overflow-wrap: anywhere; } h2 { font-size: 1.2rem; margin-top: 2.2rem; }
h3 { font-size: 1rem; margin: 0; font-weight: 600; }
p { max-width: 62rem; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { padding: 0.3rem 0.9rem; text-align: right; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child, td:nth-child(2):last-child { text-align: left; }
td { font-variant-numeric: tabular-nums; }
tr.broken td { background: var(--bad); }
.table { overflow-x: auto; }
.badge { display: inline-block; padding: 0.2rem 0.8rem; border-radius: 0.4rem; color: white; }
.badge.passed { background: #0a7a55; } .badge.broken { background: #b3261e; }
li { margin: 0.5rem 0; overflow-wrap: anywhere; } code { background: var(--soft); padding: 0 0.3rem; }
figure { margin: 1rem 0; min-width: 0; } svg { max-width: 100%; } figure > svg { width: 100%; height: auto; }
figcaption { color: var(--faint); font-size: 0.85rem; margin-top: 0.2rem; }
.grid { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(22rem, 100%), 1fr)); gap: 0.5rem 1.5rem; }
.plot { height: 38rem; }
.controls { display: flex; gap: 1rem; align-items: center; margin: 0.5rem 0; }
.controls button { width: 6rem; padding: 0.3rem; } .controls input { flex: 1; } .controls output { min-width: 6rem; }
pre { background: var(--soft); padding: 0.8rem; overflow-x: auto; }
@media (max-width: 640px) {
  .plot { height: 26rem; }
  th, td { padding: 0.3rem 0.4rem; }
}
@media screen and (prefers-color-scheme: dark) {
  :root { --ink: #ddd; --paper: #191919; --line: #444; --soft: #2b2d30; --faint: #aaa; --bad: #4b2421; }
  .plot, figure > svg { filter: invert(0.9) hue-rotate(180deg); }
}
@media print {
  body { margin: 0; max-width: none; } .table { overflow: visible; } pre { white-space: pre-wrap; }
  th, td { padding: 0.2rem 0.4rem; } tr, figure { break-inside: avoid; } .controls { display: none; }
}
"""

_DRAW: Final = """
"use strict";
const config = {responsive: true, displayModeBar: false};
for (const data of document.querySelectorAll("script[type='application/json']")) {
  const {film, times, ...figure} = JSON.parse(data.textContent);
  const plot = data.parentElement.querySelector(".plot");
  Plotly.newPlot(plot, {...figure, config});
  project(plot, times, film);
}

function project(plot, times, {duration, pictures}) {
  const [button, slider, time] = plot.parentElement.querySelectorAll("button, input, output");
  const traces = pictures[0].x.map((_, i) => i);
  let playing = false, held = false, shown = 0, at = 0, before = 0;
  const show = k => {
    if (k !== shown) Plotly.restyle(plot, pictures[k], traces);
    [shown, slider.value, time.value] = [k, k, times[k]];
  };
  const play = now => {
    if (!playing) return;
    // the first picture may have been begun before the button was pressed
    const passed = Math.max(0, now - before) / duration * pictures.length;
    // what the mouse turns stands still meanwhile
    if (!held) show(Math.floor(at = (at + passed) % pictures.length));
    before = now;
    requestAnimationFrame(play);
  };
  const set = wanted => {
    [playing, at, before] = [wanted, shown, performance.now()];
    button.textContent = playing ? "❚❚ pause" : "▶ play";
    if (playing) requestAnimationFrame(play);
  };
  button.onclick = () => set(!playing);
  slider.oninput = () => { set(false); show(+slider.value); };
  plot.addEventListener("pointerdown", () => held = true, true);
  addEventListener("pointerup", () => held = false, true);
  addEventListener("pointercancel", () => held = false, true);
}
"""


def document(title: str, parts: Iterable[str], *, with_film: bool = False) -> bytes:
    """Make a page.

    Parameters
    ----------
    title : str
    parts : iterable of str
        HTML, of which all text from outside is escaped.
    with_film : bool, optional
        Whether there is a `film`: then plotly.js is in the page.

    Returns
    -------
    bytes
        UTF-8. No script runs but those that are meant, and nothing is loaded from anywhere, whatever the parts hold.
    """
    scripts: list[str] = []
    if with_film:
        from plotly.offline import get_plotlyjs

        scripts += [get_plotlyjs(), _DRAW]
    hashes = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    allowed = " ".join(f"'sha256-{each}'" for each in hashes) or "'none'"
    policy = f"default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; script-src {allowed}"
    heading = escaped(title)
    lines = [
        "<!DOCTYPE html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>{heading}</title>',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f'<meta http-equiv="Content-Security-Policy" content="{policy}"><style>{_STYLE}</style></head>',
        f"<body><h1>{heading}</h1>",
        *parts,
        f"<p>Made by lie_rigid_body {__version__}.</p>",
        *(f"<script>{script}</script>" for script in scripts),
        "</body></html>",
        "",
    ]
    return "\n".join(lines).encode("utf-8", "backslashreplace")  # a file's name need not be Unicode


def figure(heading: str, content: str, caption: str = "") -> str:
    """Figure under a heading, of HTML, with a caption below."""
    below = f"<figcaption>{escaped(caption)}</figcaption>" if caption else ""
    return f"<figure><h3>{escaped(heading)}</h3>{content}{below}</figure>"


def plane(heading: str, draw: Callable[[Axes], None], caption: str = "") -> str:
    """Figure of one pair of axes of Matplotlib, half a page wide."""
    return figure(heading, svg(partial(of_axes, draw)), caption)


def film(content: Mapping[str, Any], times: Sequence[str]) -> str:
    """Film that plotly.js draws, for a figure.

    Parameters
    ----------
    content : mapping
        The ``data`` and the ``layout`` of plotly.js. Its ``film`` has the ``duration``, ms, and the ``pictures``, the
        coordinates of the first traces in each.
    times : sequence of str
        Time of each picture.
    """
    from plotly.io import to_json

    data = str(to_json({**content, "times": times}, validate=False)).replace("<", "\\u003c")
    return (
        '<div class="plot body"></div><div class="controls"><button type="button">▶ play</button>'
        f'<input type="range" aria-label="time" min="0" max="{len(times) - 1}" value="0">'
        f"<output>{escaped(times[0])}</output></div>"
        f'<script type="application/json">{data}</script>'
    )


def picture(draw: Callable[[], Figure]) -> str:
    """Picture by Matplotlib as SVG, as wide as the page."""
    return f"<figure>{svg(draw)}</figure>"


def grid(figures: Iterable[str]) -> str:
    """Figures side by side, as many as there is room for."""
    return f'<div class="grid">{"".join(figures)}</div>'


def escaped(text: str) -> str:
    """Plain text from outside as HTML, in which characters that control what is shown stand as escapes."""
    return "\n".join(escape(printable(line)) for line in text.split("\n"))


def badge(sentence: str, *, passed: bool) -> str:
    """Verdict in colour."""
    return f'<p><strong class="badge {"passed" if passed else "broken"}">{escaped(sentence)}</strong></p>'


def paragraph(text: str) -> str:
    """Paragraph of plain text."""
    return f"<p>{escaped(text)}</p>"


def table(headings: Sequence[str], rows: Sequence[Sequence[str]], marked: Sequence[bool]) -> str:
    """Table of plain text, whose first rows may be marked."""
    head = "".join(f"<th>{escaped(heading)}</th>" for heading in headings)
    body = "".join(
        f"<tr{' class=broken' if is_marked else ''}>{''.join(f'<td>{escaped(cell)}</td>' for cell in cells)}</tr>"
        for cells, is_marked in zip_longest(rows, marked)
    )
    return f'<div class="table"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def listing(heading: str, lines: Iterable[str]) -> str:
    """List of plain text under a heading; nothing without a line."""
    entries = "".join(f"<li>{escaped(line)}</li>" for line in lines)
    return f"<h2>{heading}</h2><ul>{entries}</ul>" if entries else ""


def details(summary: str, content: str) -> str:
    """JSON that is shown on request, a line for each value."""
    text = json.dumps(json.loads(content), indent=2, ensure_ascii=False)
    return f"<details><summary>{escaped(summary)}</summary><pre>{escaped(text)}</pre></details>"
