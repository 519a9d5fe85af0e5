"""Who imports whom in the package, and the picture of it: ``python docs/rooms.py`` writes docs/images/rooms.svg.

A room is a folder of the package or a module beside these folders. The picture leaves out `foundation`, which everyone
may import, `errors`, the public name of its errors, and each arrow to a room that other arrows reach as well.
"""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Iterator
from functools import cache
from html import escape
from itertools import pairwise
from pathlib import Path
from statistics import fmean
from typing import Final

PACKAGE: Final = "lie_rigid_body"
SOURCES: Final = Path(__file__).resolve().parent.parent / PACKAGE
PICTURE: Final = Path(__file__).resolve().parent / "images" / "rooms.svg"

FOR_ALL: Final = {"foundation", "errors"}
"""What everyone may import, and the public name of its errors."""

Arrows = dict[str, set[str]]
"""For each room, the rooms that it imports."""

WIDTH: Final = 210
HEIGHT: Final = 70
GAP: Final = 28
"""Sizes of a box and of the space between boxes, px."""


def source_modules() -> dict[str, Path]:
    """Every module of the package by its full name."""
    found = {}
    for path in sorted(SOURCES.rglob("*.py")):
        parts = path.relative_to(SOURCES.parent).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


MODULES: Final = source_modules()


def imports(source: str, module: str, *, is_package: bool = False) -> Iterator[str]:
    """Every module that a source imports, wherever in it, by its full name."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                folder = module.split(".")[: -node.level + is_package or None]
                base = ".".join([*folder, *([base] if base else [])])
            full_names = [f"{base}.{alias.name}" for alias in node.names]
            yield from (full if full in MODULES else base for full in full_names if full != f"{PACKAGE}.__version__")
        elif isinstance(node, ast.Call) and _name(node.func).endswith(("import_module", "__import__")):
            yield from (a.value for a in node.args if isinstance(a, ast.Constant) and isinstance(a.value, str))


@cache
def imported(module: str) -> frozenset[str]:
    """Every module that a module of the package imports."""
    path = MODULES[module]
    return frozenset(imports(path.read_text(encoding="utf-8"), module, is_package=path.name == "__init__.py"))


def _name(function: ast.expr) -> str:
    """What is called, without the object that it belongs to."""
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def room(module: str) -> str:
    """The room of a module; that of the package's own __init__ is ''."""
    return module.removeprefix(PACKAGE).removeprefix(".").partition(".")[0]


def arrows() -> Arrows:
    """Every import between two rooms of the package, but those of what everyone may import."""
    found: Arrows = {room(module): set() for module in MODULES if room(module) not in FOR_ALL}
    for module in MODULES:
        ours = {room(target) for target in imported(module) if target.partition(".")[0] == PACKAGE}
        found.get(room(module), set()).update(ours - {room(module), *FOR_ALL})
    return found


def reached(start: str, by: Arrows) -> set[str]:
    """The rooms that a room imports, directly or through others."""
    return by[start].union(*(reached(target, by) for target in by[start]))


def shortest(full: Arrows) -> Arrows:
    """The arrows that the others do not imply."""
    return {
        start: {target for target in targets if not any(target in reached(other, full) for other in targets)}
        for start, targets in full.items()
    }


def levels(drawn: Arrows) -> dict[str, int]:
    """The row of each room from the bottom: above all that it imports, and as near as can be below who imports it."""

    def height(start: str) -> int:
        return 1 + max((height(target) for target in drawn[start]), default=-1)

    level = {start: height(start) for start in drawn}
    for start in sorted(drawn, key=lambda name: -level[name]):
        level[start] = min((level[user] - 1 for user in drawn if start in drawn[user]), default=level[start])
    return level


def rows(drawn: Arrows) -> tuple[list[list[str]], Arrows]:
    """Rooms in rows from the bottom; an arrow across a row passes a point `from>to` of it."""
    level = levels(drawn)
    grid: list[list[str]] = [[] for _ in range(max(level.values()) + 1)]
    for name in sorted(drawn):
        grid[level[name]].append(name)
    links: Arrows = {name: set() for name in drawn}
    for start, target in sorted((user, used) for user in drawn for used in drawn[user]):
        above = start
        for row in range(level[start] - 1, level[target], -1):
            point = f"{start}>{target}>{row}"
            grid[row].append(point)
            links[above].add(point)
            links[point] = set()
            above = point
        links[above].add(target)
    return grid, links


def places(grid: list[list[str]], links: Arrows) -> dict[str, tuple[float, float]]:
    """The middle of each room and point, px: each as near to its neighbours in x as the others of its row let it."""
    middle = {name: (WIDTH + GAP) * (column - len(row) / 2) for row in grid for column, name in enumerate(row)}
    joined = {name: [*links[name], *(other for other in links if name in links[other])] for name in links}
    for turn in range(60):
        for row in (*grid, *reversed(grid)):
            wanted = {name: fmean([middle[other] for other in joined[name]] or [middle[name]]) for name in row}
            if turn < 20:
                row.sort(key=wanted.__getitem__)
            middle.update(apart(row, wanted))
    left = min(middle[name] - width(name) / 2 for name in middle) - GAP / 2
    return {
        name: (middle[name] - left, (len(grid) - index - 0.5) * (HEIGHT + GAP))
        for index, row in enumerate(grid)
        for name in row
    }


def apart(row: list[str], wanted: dict[str, float]) -> dict[str, float]:
    """Middles nearest to those wanted at which the rooms of a row do not overlap, in the order of the row."""
    ahead, back = dict(wanted), dict(wanted)
    for left, right in pairwise(row):
        ahead[right] = max(ahead[right], ahead[left] + (width(left) + width(right)) / 2 + GAP)
    for right, left in pairwise(reversed(row)):
        back[left] = min(back[left], back[right] - (width(left) + width(right)) / 2 - GAP)
    return {name: (ahead[name] + back[name]) / 2 for name in row}


def width(name: str) -> int:
    """The width of a room, or of a point that an arrow passes, px."""
    return 0 if ">" in name else WIDTH


def svg() -> str:
    """The picture as text, the same on every machine."""
    grid, links = rows(shortest(arrows()))
    place = places(grid, links)
    right = max(x for x, _ in place.values()) + (WIDTH + GAP) / 2
    bottom = len(grid) * (HEIGHT + GAP)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {right:.0f} {bottom}" font-family="sans-serif">',
        '<rect width="100%" height="100%" fill="white"/>',
        '<marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="6" markerHeight="6" orient="auto">',
        '<path d="M0 0 L8 4 L0 8 z" fill="#0072B2"/></marker>',
        *(_arrow(start, target, place) for start in sorted(links) for target in sorted(links[start])),
        *(line for name in sorted(place) if ">" not in name for line in _box(name, *place[name])),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _arrow(start: str, target: str, place: dict[str, tuple[float, float]]) -> str:
    (x, y), (to_x, to_y) = place[start], place[target]
    y, to_y = y + HEIGHT / 2, to_y - HEIGHT / 2
    bend = (to_y - y) / 2
    curve = f"M{x:.0f} {y:.0f} C{x:.0f} {y + bend:.0f} {to_x:.0f} {to_y - bend:.0f} {to_x:.0f} {to_y:.0f}"
    end = f"v{HEIGHT}" if ">" in target else '" marker-end="url(#head)'
    return f'<path d="{curve}{end}" fill="none" stroke="#0072B2" stroke-width="1.5"/>'


def _box(name: str, x: float, y: float) -> Iterator[str]:
    left, top = x - WIDTH / 2, y - HEIGHT / 2
    size = f'width="{WIDTH}" height="{HEIGHT}" rx="6"'
    yield f'<rect x="{left:.0f}" y="{top:.0f}" {size} fill="#F2F7FB" stroke="#33506B"/>'
    yield f'<text x="{x:.0f}" y="{top + 18:.0f}" text-anchor="middle" font-weight="bold">{name or PACKAGE}</text>'
    for number, line in enumerate(textwrap.wrap(subject(name), 37, max_lines=3, placeholder=" …")):
        baseline = top + 34 + 14 * number
        yield f'<text x="{x:.0f}" y="{baseline:.0f}" text-anchor="middle" font-size="11">{escape(line)}</text>'


def subject(name: str) -> str:
    """What a room is, as its docstring begins."""
    path = MODULES[f"{PACKAGE}.{name}".removesuffix(".")]
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return re.split(r"\.(?:\s|$)", text, maxsplit=1)[0].replace("\n", " ").replace("`", "")


if __name__ == "__main__":
    PICTURE.write_text(svg(), encoding="utf-8")
    for start, targets in sorted(arrows().items()):
        print(f"{start or PACKAGE}: {' '.join(sorted(targets)) or '-'}")
