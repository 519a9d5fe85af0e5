"""Docstrings begin with a noun of the field or a verb, and each class of the package has a name of its own."""

from __future__ import annotations

import ast
import re
from collections import defaultdict

import pytest

from rooms import MODULES, room

RIDDLE = re.compile(r"\s*(Of|That of|Those of|By|Nor|The same|So|Where)\b")
TREES = {module: ast.parse(path.read_text(encoding="utf-8")) for module, path in MODULES.items()}
WRITTEN = [
    "campaign",
    "compilation",
    "proof",
    "scenario",
    "testing",
    "console",
    "interruption",
    "parameters",
    "wording",
]
WRITTEN += ["arrays", "bounded_input", "errors", "system", "__main__", ""]


def texts(tree: ast.AST) -> list[str]:
    """Docstrings of modules, classes, functions and constants."""
    values = [node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)]
    return [value.value for value in values if isinstance(value, ast.Constant) and isinstance(value.value, str)]


@pytest.mark.parametrize("name", WRITTEN)
def test_a_docstring_stands_without_the_line_above(name: str) -> None:
    found = [(module, text) for module, tree in TREES.items() if room(module) == name for text in texts(tree)]
    assert found
    assert [(module, text) for module, text in found if RIDDLE.match(text)] == []


def test_no_class_has_the_name_of_another() -> None:
    homes = defaultdict(set)
    for module, tree in TREES.items():
        if room(module) in WRITTEN:
            for node in tree.body:
                if isinstance(node, ast.ClassDef):
                    homes[node.name.lstrip("_")].add(module)
    assert {name: modules for name, modules in homes.items() if len(modules) > 1} == {}
