"""Words of pages and docstrings: sentences of at most 30, pages of at most 2 500, no riddle, no name of two things."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from inspect import cleandoc
from pathlib import Path

import pytest

from rooms import MODULES

ROOT = Path(__file__).parent.parent
LONGEST_SENTENCE = 30
LONGEST_PAGE = 2500
PAGES = sorted(
    [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "docs").rglob("*.rst")]
)
EDITION = ROOT / "docs" / "paper.md"

INDENTED = re.compile(r"(?<=\n\n)(?:    .*\n)+")  # code, or formulas
NO_SENTENCE = [
    re.compile(r"^(```|~~~).*?^\1|<!--.*?-->|\$\$.*?\$\$", re.MULTILINE | re.DOTALL),  # blocks of code, notes, formulas
    INDENTED,
    re.compile(r"^\.\. .*\n(?:\s*\n|   .*\n)*", re.MULTILINE),  # directives and what belongs to them
]
ONE_WORD = re.compile(r"``[^`]+``|`[^`]+`|\$[^$]+\$")
LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
ROW = re.compile(r"^\s*\|.*$", re.MULTILINE)
ITEM = re.compile(r"^\s*(?:[-*] |\d+\. |#)", re.MULTILINE)
END = re.compile(r"\n\s*\n|(?<=[.?!])[*)\"]*\s+")
RIDDLE = re.compile(r"\s*(Of|That of|Those of|By|Nor|The same|So|Where)\b")
"""Beginnings that need the line above: a docstring begins with a noun of the field or a verb."""


@pytest.fixture(scope="module")
def trees() -> dict[str, ast.Module]:
    """The package as syntax trees, which take 80 MB: only the process that reads them makes them."""
    return {module: ast.parse(path.read_text(encoding="utf-8")) for module, path in MODULES.items()}


def sentences(text: str) -> list[list[str]]:
    """Words of each sentence of a page.

    Code, or a formula, within a line is one word; an item of a list is a sentence, and so is a cell of a table, whole.
    """
    for pattern in NO_SENTENCE:
        text = pattern.sub("\n\n", text)
    text = ITEM.sub("\n\n", LINK.sub(r"\1", ONE_WORD.sub("x", text)))
    text = ROW.sub(lambda row: re.sub(r"[.?!](?= )", "", row[0]).replace("|", "\n\n"), text)
    return [re.findall(r"\S*\w\S*", sentence) for sentence in END.split(text)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_sentence_has_more_words_than_one_reads_at_once(page: Path) -> None:
    found = [" ".join(words) for words in sentences(page.read_text(encoding="utf-8")) if len(words) > LONGEST_SENTENCE]
    assert found == []


def docstrings(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Lines and texts of the docstrings of modules, classes, functions and constants."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            yield node.lineno, node.value.value


def plain(docstring: str) -> str:
    """A docstring without formulas; in NumPy's style a name with its type, or a type, stands above what it is."""
    text = INDENTED.sub("\n\n", cleandoc(docstring))
    text = re.sub(r"^(\S.*)\n    (?=\S)|^(    .*)\n(?=\S)", r"\1\2\n\n", text, flags=re.MULTILINE)
    return re.sub(r"^    ", "", text, flags=re.MULTILINE)


def test_no_sentence_of_a_docstring_has_more_words_than_one_reads_at_once(trees: dict[str, ast.Module]) -> None:
    found = [
        f"{module}: {' '.join(words)}"
        for module, tree in trees.items()
        for text in (plain(docstring) for _, docstring in docstrings(tree) if len(docstring.split()) > LONGEST_SENTENCE)
        for words in sentences(text)
        if len(words) > LONGEST_SENTENCE
    ]
    assert found == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_page_is_longer_than_one_reads(page: Path) -> None:
    """But for the edition of the paper, which is as long as the paper is."""
    assert page == EDITION or len(page.read_text(encoding="utf-8").split()) <= LONGEST_PAGE


@pytest.mark.parametrize(
    ("text", "counts"),
    [
        ("One two. Three?", [2, 1]),
        ("One\ntwo, three: four; five", [5]),
        ("- one two\n- three", [2, 1]),
        ("# One\nTwo three.", [3]),
        ("One `a b c` $x + y$ [two three](four.md) **five.** Six.", [6, 1]),
        ("One\n\n```bash\na b c\n```\n\ntwo", [1, 1]),
        ("One ``a b`` :doc:`c d <e f>` two.", [4]),
        ("| a b | c. d e |\n| --- | --- |\n\nOne", [2, 3, 1]),
        (".. image:: a\n   :alt: b c d\n\nOne", [1]),
        ("One $$\na b c\n$$ two", [1, 1]),
        ("One\n\n    a b c\n\ntwo", [1, 1]),
        ("- one\n  - two\n    three", [1, 2]),
    ],
)
def test_words_are_counted(text: str, counts: list[int]) -> None:
    assert [len(words) for words in sentences(text) if words] == counts


@pytest.mark.parametrize(
    ("docstring", "counts"),
    [
        ("One two.", [2]),
        ("One:\n\n        a b c\n\n    two.", [1, 1]),
        ("One.\n\n    Parameters\n    ----------\n    a : b, shape (2,)\n        Two three.\n    ", [1, 5, 2]),
        ("One\n\n    - two\n      three\n    - four", [1, 2, 1]),
    ],
)
def test_words_of_a_docstring_are_counted(docstring: str, counts: list[int]) -> None:
    [(_, text)] = docstrings(ast.parse(f'def f():\n    """{docstring}"""'))
    assert [len(words) for words in sentences(plain(text)) if words] == counts


def riddles(tree: ast.AST) -> Iterator[int]:
    """Lines of the docstrings, of modules, classes, functions and constants, that begin as riddles."""
    return (line for line, text in docstrings(tree) if RIDDLE.match(text))


def twins(trees: dict[str, ast.Module]) -> dict[str, list[str]]:
    """Names of classes with several homes, leading underscores ignored, and these homes."""
    homes: dict[str, list[str]] = defaultdict(list)
    for module, tree in trees.items():
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                homes[node.name.lstrip("_")].append(module)
    return {name: modules for name, modules in homes.items() if len(modules) > 1}


def pages(tree: ast.AST) -> Iterator[int]:
    """Lines of texts, docstrings left out, that name a page of the clone: an installed package has none."""
    read = {node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and node not in read and "docs/" in str(node.value):
            yield node.lineno


def test_no_message_names_a_page_that_an_installed_package_lacks(trees: dict[str, ast.Module]) -> None:
    assert [f"{module}:{line}" for module, tree in trees.items() for line in pages(tree)] == []
    assert list(pages(ast.parse('"""See docs/a.md."""\nx = f"{y}: see docs/a.md"'))) == [2]


def test_no_docstring_begins_as_a_riddle(trees: dict[str, ast.Module]) -> None:
    assert [f"{module}:{line}" for module, tree in trees.items() for line in riddles(tree)] == []


def test_no_class_name_has_two_homes(trees: dict[str, ast.Module]) -> None:
    assert twins(trees) == {}


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ('"""Of a motion."""', 1),
        ('"""The same, for one."""', 1),
        ('"""\n    Where it ends."""', 1),
        ('class A:\n    """That of a motion."""', 1),
        ('def f():\n    """By the step."""', 1),
        ('LIMIT = 1.0\n"""Nor less."""', 1),
        ('def f():\n    """So many."""', 1),
        ('"""Offset of the clock, s."""', 0),
        ('"""Samples, by number."""', 0),
        ('x = "Of a motion"', 0),
    ],
)
def test_a_riddle_is_found(source: str, found: int) -> None:
    assert len(list(riddles(ast.parse(source)))) == found


def test_a_twin_is_found() -> None:
    two = {name: ast.parse("class A: ...") for name in ("one", "other")}
    assert twins({**two, "third": ast.parse("class _A: ...\nclass B: ...")}) == {"A": ["one", "other", "third"]}
