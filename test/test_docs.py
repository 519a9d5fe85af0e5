"""The code in the documents runs, and what they point to exists."""

from __future__ import annotations

import re
import shlex
from contextlib import redirect_stdout
from io import StringIO
from itertools import takewhile
from pathlib import Path

import pytest

import lie_rigid_body
import rooms
import tables
from lie_rigid_body.diagnosis.probes import NOTES, PROBES
from lie_rigid_body.diagnosis.repairs import ORDER
from lie_rigid_body.estimates import programs
from lie_rigid_body.ros.play import MAX_PRINTED
from reader import DOCS, FENCED, ROOT, blocks, commands, is_run

PAGES = sorted(DOCS.rglob("*.md"))


OWN = ("paper.md", "python.md")
SHELL = {page: commands(*blocks(page.read_text(encoding="utf-8"), "bash", "console")) for page in PAGES}
PYTHON = {page: blocks(page.read_text(encoding="utf-8"), "python") for page in PAGES}


# of paper.md each section is a program, of python.md each block: test_paper.py and test_readme.py; those that have
# commands as well are followed by test_followed_pages.py
@pytest.mark.parametrize(
    "page",
    [page for page, code in PYTHON.items() if code and not any(map(is_run, SHELL[page])) and page.name not in OWN],
    ids=lambda page: page.relative_to(DOCS).as_posix(),
)
def test_the_python_of_a_page_runs_as_one_program(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with redirect_stdout(StringIO()) as printed:
        exec(compile("\n".join(PYTHON[page]), page.name, "exec"), {})
    assert all(shown in printed.getvalue() for shown in blocks(page.read_text(encoding="utf-8"), "json", "text"))


def verbs(text: str) -> list[list[str]]:
    """Command lines of the package, in blocks and within a line, without what is given to ROS."""
    spans = re.findall(r"`(lie-rigid-body \w+ [^`]+)`", FENCED.sub("", text))
    lines = commands(*blocks(text, "bash", "console"))
    found = [re.match(r"(?:timeout .*)?\blie-rigid-body (\w.*)", line) for line in (*lines, *spans)]
    words = [shlex.split(line[1], comments=True) for line in found if line]
    return [list(takewhile(lambda word: word != "--ros-args", line)) for line in words]


SHOWN = [(page, *line) for page in [DOCS.parent / "README.md", *PAGES] for line in verbs(page.read_text("utf-8"))]


@pytest.mark.parametrize(
    ("page", "verb", "words"),
    [(page, verb, words) for page, verb, *words in SHOWN if verb != "VERB"],
    ids=lambda given: given.stem if isinstance(given, Path) else None,
)
def test_a_verb_understands_what_a_page_gives_it(page, verb, words):
    tables.parser_of(verb).parse_args(words)


def test_commands_are_found():
    assert len(SHOWN) > 30
    console, bash = "```console\n$ lie-rigid-body a b  # c\n```\n", "```bash\nlie-rigid-body f --ros-args g\n```\n"
    assert verbs(f"{console}`lie-rigid-body d e`\n\n{bash}") == [["a", "b"], ["f"], ["d", "e"]]


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=lambda p: p.relative_to(ROOT).as_posix())
def test_pictures_pages_and_tests_it_names_exist(page):
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", text):
        assert (page.parent / target).is_file(), target
    for target in re.findall(r"`(?:test/([\w/]+(?:\.py)?)/?|((?:\w+/)+test_\w+\.py))`", text):
        assert (DOCS.parent / "test" / "".join(target)).exists(), target
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


def test_the_page_of_source_code_has_a_line_for_every_mistake():
    text = (DOCS / "how-to" / "mistakes_in_code.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `(\w+)`", text, re.MULTILINE)) == {*ORDER}


def test_the_page_of_reliability_has_the_limits_of_what_filters_print():
    text = (DOCS / "explanation" / "reliability.md").read_text(encoding="utf-8")
    of_program, of_node = re.findall(r"^\| what the .*? prints.* \| (.+) \|$", text, re.MULTILINE)
    least, each = programs._MIN_BYTES >> 20, programs._BYTES_OF_A_LINE
    assert of_program == f"{least} MiB, and {each} bytes for each line that it is given"
    assert of_node == f"{MAX_PRINTED >> 20} MiB"


def test_what_a_page_of_the_reference_excludes_is_on_another():
    reference = "".join(page.read_text(encoding="utf-8") for page in sorted((DOCS / "reference").glob("*.rst")))
    own = set(re.findall(r"auto(?:class|function):: (\w+)", reference))
    for module, names in re.findall(r"automodule:: (\S+)\n   :members:\n   :exclude-members: (.+)", reference):
        there = own if module == "lie_rigid_body" else own | set(lie_rigid_body.__all__)
        assert set(names.split(", ")) <= there, module


def test_the_reference_has_every_room_for_use_from_python():
    reference = "".join(page.read_text(encoding="utf-8") for page in sorted((DOCS / "reference").glob("*.rst")))
    named = set(re.findall(r"automodule:: lie_rigid_body\.(\w+)", reference))
    every = {rooms.room(module) for module in rooms.MODULES}
    folders = {room for room in every if (rooms.SOURCES / room / "__init__.py").is_file()}
    assert folders - named == {"", "cli", "ros"}
