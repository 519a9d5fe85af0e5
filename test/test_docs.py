"""The code in the documents runs, and what they point to exists."""

from __future__ import annotations

import re
import shlex
from itertools import takewhile
from pathlib import Path

import pytest

import rooms
import tables
from lie_rigid_body.diagnosis.probes import NOTES, PROBES
from lie_rigid_body.diagnosis.repairs import ORDER

DOCS = Path(__file__).parent.parent / "docs"
PAGES = sorted(DOCS.rglob("*.md"))


def blocks(page: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)


# of paper.md each section is a program, of python.md each block: test_paper.py and test_readme.py; test_tutorials.py
# follows the tutorials
@pytest.mark.parametrize(
    "page",
    [p for p in PAGES if blocks(p) and p.name not in ("paper.md", "python.md") and p.parent.name != "tutorials"],
    ids=lambda p: p.relative_to(DOCS).as_posix(),
)
def test_code_blocks_of_a_page_run_as_one_program(page):
    exec(compile("\n".join(blocks(page)), page.name, "exec"), {})


def commands(text: str) -> list[list[str]]:
    """Command lines of the package, in blocks and within a line, without what is given to ROS."""
    shown = re.findall(r"^```(?:bash|console)\n(.*?)^```|(?<=\n\n)((?:    .*\n)+)", text, re.MULTILINE | re.DOTALL)
    spans = re.findall(
        r"`(lie-rigid-body \w+ [^`]+)`", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    )
    lines = [line.strip() for block in shown for part in block for line in part.splitlines()]
    found = [re.match(r"(?:\$ )?(?:timeout .*)?\blie-rigid-body (\w.*)", line) for line in (*lines, *spans)]
    words = [shlex.split(line[1], comments=True) for line in found if line]
    return [list(takewhile(lambda word: word != "--ros-args", line)) for line in words]


SHOWN = [(page, *line) for page in [DOCS.parent / "README.md", *PAGES] for line in commands(page.read_text("utf-8"))]


@pytest.mark.parametrize(
    ("page", "verb", "words"),
    [(page, verb, words) for page, verb, *words in SHOWN if verb != "VERB"],
    ids=lambda given: given.stem if isinstance(given, Path) else None,
)
def test_a_verb_understands_what_a_page_gives_it(page, verb, words):
    tables.parser_of(verb).parse_args(words)


def test_commands_are_found():
    assert len(SHOWN) > 30
    assert commands(
        "```bash\n$ lie-rigid-body a b  # c\n```\n`lie-rigid-body d e`\n\n    lie-rigid-body f --ros-args g\n\n"
    ) == [
        ["a", "b"],
        ["f"],
        ["d", "e"],
    ]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(DOCS).as_posix())
def test_pictures_pages_and_tests_it_names_exist(page):
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", text):
        assert (page.parent / target).is_file(), target
    for target in re.findall(r"`(test/[\w/]+(?:\.py)?)/?`", text):
        assert (DOCS.parent / target).exists(), target
    written = "".join(file.read_text(encoding="utf-8") for file in sorted((DOCS.parent / "test").rglob("test_*.py")))
    for name in re.findall(r"`(test_\w+)`", text):
        assert f"def {name}(" in written, name


def test_the_picture_of_the_rooms_is_that_of_the_imports():
    drawn = rooms.PICTURE.read_text(encoding="utf-8")
    assert drawn == rooms.svg(), "draw it anew: python docs/rooms.py"


@pytest.mark.parametrize(("page", "text"), tables.pages().items(), ids=lambda given: getattr(given, "name", None))
def test_tables_of_the_reference_are_those_of_the_code(page, text):
    assert page.read_text(encoding="utf-8") == text, "write them anew: python docs/tables.py"


def test_every_table_of_the_code_has_a_page():
    marked = [name for text in tables.pages().values() for name, _ in tables.MARKED.findall(text)]
    assert sorted(marked) == sorted(tables.TABLES)


def test_the_page_of_diagnose_has_every_code():
    text = (DOCS / "diagnose.md").read_text(encoding="utf-8")
    told = {code for row in re.findall(r"^\| (`[^|]+) \|", text, re.MULTILINE) for code in re.findall(r"`(\w+)`", row)}
    assert {*ORDER, *(probe.code for probe in PROBES), "follows"} - told == set()
    assert all(f"`{note.code}`" in text for note in NOTES)


def test_the_reference_has_every_room_for_use_from_python():
    reference = "".join(page.read_text(encoding="utf-8") for page in sorted((DOCS / "reference").glob("*.rst")))
    named = set(re.findall(r"automodule:: lie_rigid_body\.(\w+)", reference))
    every = {rooms.room(module) for module in rooms.MODULES}
    folders = {room for room in every if (rooms.SOURCES / room / "__init__.py").is_file()}
    assert folders - named == {"", "cli", "ros"}
