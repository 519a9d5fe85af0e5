"""The words of the package: a docstring that stands by itself, and a name that means one thing."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator

import pytest

from rooms import MODULES

RIDDLE = re.compile(r"\s*(Of|That of|Those of|By|Nor|The same|So|Where)\b")
"""Beginnings that need the line above: a docstring begins with a noun of the field or a verb."""


@pytest.fixture(scope="module")
def trees() -> dict[str, ast.Module]:
    """The package as syntax trees, which take 80 MB: only the process that reads them makes them."""
    return {module: ast.parse(path.read_text(encoding="utf-8")) for module, path in MODULES.items()}


def riddles(tree: ast.AST) -> Iterator[int]:
    """Lines of the docstrings, of modules, classes, functions and constants, that begin as riddles."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            text = node.value.value
            if isinstance(text, str) and RIDDLE.match(text):
                yield node.lineno


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
