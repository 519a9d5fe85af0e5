"""Sentences, of pages and docstrings, and pages that one reads once: at most 30 words, and 2 500 words."""

from __future__ import annotations

import ast
import re
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


def docstrings(source: str) -> Iterator[str]:
    """Docstrings of modules, classes, functions and constants as text, without formulas."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            text = INDENTED.sub("\n\n", cleandoc(node.value.value))
            # in NumPy's style a name with its type, or a type, stands above what it is
            text = re.sub(r"^(\S.*)\n    (?=\S)|^(    .*)\n(?=\S)", r"\1\2\n\n", text, flags=re.MULTILINE)
            yield re.sub(r"^    ", "", text, flags=re.MULTILINE)


def test_no_sentence_of_a_docstring_has_more_words_than_one_reads_at_once() -> None:
    found = [
        f"{module}: {' '.join(words)}"
        for module, path in MODULES.items()
        for text in docstrings(path.read_text(encoding="utf-8"))
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
    [text] = docstrings(f'def f():\n    """{docstring}"""')
    assert [len(words) for words in sentences(text) if words] == counts
