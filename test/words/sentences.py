"""What the rooms say, as one text that a review shows: `make words` writes them, and a test compares them.

A module ``words_of_ROOM`` has triggers: calls without arguments in ``REFUSED``, by the type of the error that each
raises, and in ``SAID``, which return what is said. Each runs in an empty folder. The file ``words.txt`` has a part for
each room, with the source of each trigger and its sentence. Where a module has ``run`` instead, the triggers are the
commands of that part itself.
"""

from __future__ import annotations

import ast
import inspect
import re
import shlex
import sys
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from itertools import count
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from lie_rigid_body.foundation.wording import shown

FOLDER = Path(__file__).parent
WRITTEN_HERE = sys.platform == "linux" and sys.version_info[:2] == (3, 12) and np.__version__ >= "2"
"""Whether the texts are those of this system: older libraries and other systems word their own errors otherwise."""
TEXT = FOLDER / "words.txt"
HEAD = "What is said, below what makes it be said. `make words` writes this file from words_of_ROOM.py."
TITLE = "=== "
"""Beginning of the first line of a room's part."""
MAX_LINE = 300
"""Largest length of a refusal, characters."""
REMEDY = re.compile(r"[:;,] \S+ \S")
"""How a remedy follows: behind a colon, a semicolon or a comma."""
ROUND_OFF = re.compile(r"(?:\d(?:\.\d+)?e-1[4-9]|\d\.\d+e(?:-13|\+1[56]))(?!\d)")
"""Numbers that depend on the last bits of a machine: in their lines no number and no width is compared."""
NUMBER = re.compile(r" *(?<![\w.])-?\d[\d.]*(?:e[-+]?\d+)?(?![\w])")

VARYING = re.compile(
    r"(?<=\.py line )\d+|(?<= s, in )[\d.]+ m?s|(?<=and )[\d.]+ \w+(?= are free)|\d{4}(?:-\d\d){2}_\d\d(?:-\d\d){2}"
    r"|\b0x[0-9a-f]{6,}"
)
"""Lines of tests, times that something takes or begins, and space that is free."""

Call = Callable[[], object]
Capture = pytest.CaptureFixture[str]


def rooms() -> list[str]:
    """Names of the rooms whose sentences are written down."""
    return sorted(path.stem.removeprefix("words_of_") for path in FOLDER.glob("words_of_*.py"))


def module_of(room: str) -> ModuleType:
    return import_module(f"words_of_{room}")


def value_of(given: object) -> str:
    """A value that a loop has given, in one line."""
    return repr(given) if isinstance(given, str) and len(given) <= 120 else shown(given)


@cache
def lambdas(path: str) -> dict[int, str]:
    """Source of the body of the first lambda of each line of a file, in one line."""
    source = Path(path).read_text(encoding="utf-8")
    found: dict[int, str] = {}
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Lambda):
            text = ast.get_source_segment(source, node.body) or ""
            found.setdefault(node.lineno, re.sub(r"\s+", " ", text))
    return found


def trigger(call: Call) -> str:
    """The source of a call, with the values of its names that a loop has given."""
    code = getattr(call, "__code__", None)
    if code is None or code.co_name != "<lambda>":
        return getattr(call, "__name__", repr(call))
    given = [
        f"{name} = {value_of(parameter.default)}"
        for name, parameter in inspect.signature(call).parameters.items()
        if parameter.default is not parameter.empty
    ]
    return ", ".join([lambdas(code.co_filename)[code.co_firstlineno], *given])


def said_by(call: Call, folder: Path, kind: type[Exception] | None = None) -> str:
    """What a call returns, or raises, in a new folder, whose name is left out."""
    folder.mkdir()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        if kind is None:
            text = str(call())
        else:
            with pytest.raises(kind) as caught:
                call()
            text = f"{type(caught.value).__name__}: {caught.value}"
    return nameless(text, folder)


def nameless(text: str, folder: Path) -> str:
    """A text without what differs from run to run and from clone to clone."""
    for path, name in ((str(folder), "FOLDER"), (sys.executable, "PYTHON"), (str(FOLDER.parents[1]), "CLONE")):
        text = text.replace(path, name)
    return VARYING.sub("~", text)


def require_good(refusal: str) -> None:
    """Laws of every refusal: one line, of a bounded length, with a remedy."""
    assert len(refusal.splitlines()) == 1, refusal
    assert len(refusal) <= MAX_LINE, refusal
    assert REMEDY.search(refusal), f"no remedy: {refusal}"


def entries(module: ModuleType, folder: Path) -> Iterator[str]:
    """Each trigger of a module with what it says."""
    numbers = count()
    for kind, calls in getattr(module, "REFUSED", {}).items():
        for call in calls:
            text = said_by(call, folder / str(next(numbers)), kind)
            require_good(text)
            yield f"{trigger(call)}\n    {text}"
    for call in getattr(module, "SAID", ()):
        text = said_by(call, folder / str(next(numbers)))
        yield "\n    ".join([trigger(call), *text.splitlines()])


def parts() -> dict[str, list[str]]:
    """Lines of the text, by rooms."""
    _, *found = TEXT.read_text(encoding="utf-8").split(f"\n{TITLE}")
    return {lines[0]: lines[1:] for lines in (part.splitlines() for part in found)}


def compare(room: str, entries: Iterator[str], *, write: bool) -> None:
    """Write the part of a room, or compare it with the one that is there."""
    lines = "\n".join(entries).splitlines()
    said = [NUMBER.sub(" ~", line) if line[:1] == " " and ROUND_OFF.search(line) else line for line in lines]
    if write:
        found = {name: part for name, part in (parts() | {room: said}).items() if name in rooms()}
        text = (f"{TITLE}{name}\n" + "".join(f"{line}\n" for line in found[name]) for name in sorted(found))
        TEXT.write_text("\n".join([HEAD, "".join(text)]), encoding="utf-8")
    if WRITTEN_HERE:
        assert said == parts().get(room), "see `make words`"


def state(folder: Path) -> dict[Path, int]:
    return {path: path.lstat().st_mtime_ns for path in folder.rglob("*")}


def commands(room: str) -> list[str]:
    """Commands of a room that has none of its own to call: they stand in its part, each behind a dollar sign."""
    return [line.removeprefix("$ ") for line in parts()[room] if line.startswith("$ ")]


def command_entries(module: ModuleType, folder: Path, capture: Capture, lines: list[str]) -> Iterator[str]:
    """Each command with its status and what it prints: a good line for each fault, where it is 2, which writes nothing.

    The module has ``prepare`` for a folder, and ``run`` for the words of a command.
    """
    module.prepare(folder)
    capture.readouterr()
    for line in lines:
        before = state(folder)
        status = module.run(shlex.split(line.replace("\\0", "\0")))
        out, err = capture.readouterr()
        assert status in (0, 1, 2), line
        if status == 2:
            assert (err[-1:], state(folder)) == ("\n", before), line
        assert (status == 2) == bool(err), line
        for complaint in err.splitlines() if out else [err.removesuffix("\n")] * bool(err):
            require_good(complaint)
        said = nameless(out + err, folder).splitlines()
        yield "\n".join([f"$ {line}", f"    status {status}", *(f"    {text}".rstrip() for text in said)])
