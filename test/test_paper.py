"""The page that follows the paper: its table leads from each equation to code and tests, its errata are measured."""

from __future__ import annotations

import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest

import lie_rigid_body.mechanics
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import top

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
PARTS = {25: "abc", 27: "ab", 28: "ab", 35: "ab"}
EQUATIONS = [f"{n}{part}" for n in range(1, 44) for part in PARTS.get(n, [""])]

SECTIONS = {
    heading: "\n".join(re.findall(r"^```python\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL))
    for heading, text in re.findall(r"^##+ (.+?)\n(.*?)(?=^##+ |\Z)", PAGE, flags=re.MULTILINE | re.DOTALL)
}
ERRATA = {heading.partition(" ")[0]: heading for heading in SECTIONS if re.match(r"E\d+ ", heading)}
CELLS = [[cell.strip() for cell in line.split("|")[1:-1]] for line in PAGE.splitlines() if line.startswith("| (")]
ROWS = {first.strip("()"): others for first, *others in CELLS}
LINK = re.compile(r"\[`?([^\]`]+)`?\]\(([^)]*)\)")

WITHOUT_NUMBERS = {"E12", "E14"}
"""Errata that one line says."""
WITHOUT_EQUATION = {
    "MassMoments.dimension",
    "MassMoments.first_moment",
    "RigidBody.batch_shape",
    "RigidBody.trusted",
    "State.batch_shape",
    "State.trusted",
    "norm",  # of vectors
    "equal_moments",
}
"""What is arithmetic, or a size."""


def anchor(heading: str) -> str:
    """The anchor of a heading, as GitHub and MyST make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def named(path: str) -> Any:
    """What a dotted name below the package stands for."""
    parts = path.split(".")
    found: Any = importlib.import_module("lie_rigid_body." + ".".join(parts[:2]))
    for part in parts[2:]:
        found = inspect.getattr_static(found, part)
    return found


@pytest.mark.parametrize("heading", [h for h, code in SECTIONS.items() if code and h not in ERRATA.values()])
def test_each_section_runs_on_its_own(heading):
    exec(compile(SECTIONS[heading], heading, "exec"), {})


def test_the_table_has_every_equation_in_its_order():
    assert len(EQUATIONS) == 48
    assert list(ROWS) == EQUATIONS


@pytest.mark.parametrize("equation", EQUATIONS)
def test_an_equation_leads_to_code_that_names_it_and_to_its_tests(equation):
    _, code, tests, status = ROWS[equation]
    for name, file in LINK.findall(code):
        assert (ROOT / "docs" / file).samefile(ROOT / "lie_rigid_body" / Path(*name.split(".")[:2]).with_suffix(".py"))
        numbers = re.findall(r"\((\d+)[a-c]?\)", inspect.getdoc(named(name)) or "")
        assert equation.rstrip("abc") in numbers, f"{name} does not say that it is ({equation})"
    for name, file in LINK.findall(tests):
        assert f"def {name}(" in (ROOT / "docs" / file).read_text(encoding="utf-8"), name
    assert LINK.findall(code)
    assert LINK.findall(tests)
    assert status.startswith(("printed", "corrected"))
    anchors = {f"#{anchor(heading)}" for heading in SECTIONS}
    assert {target for _, target in LINK.findall(status)} <= anchors
    # what is corrected has its numbers
    assert set(re.findall(r"\bE\d+\b", status)) <= set(ERRATA)
    assert "E" in status or status.startswith("printed")


def test_every_name_of_the_table_is_reached_from_the_package_alone():
    names = sorted({name for row in ROWS.values() for name, _ in LINK.findall(row[1])})
    program = "import operator, sys, lie_rigid_body; operator.attrgetter(*sys.argv[1:])(lie_rigid_body)"
    subprocess.run([sys.executable, "-c", program, *names], check=True)


def test_every_erratum_is_reached_from_the_table_and_every_link_of_the_page_ends_somewhere():
    cited = set(re.findall(r"\[(E\d+)\]", " ".join(row[-1] for row in ROWS.values())))
    assert cited == set(ERRATA)
    anchors = {anchor(heading) for heading in SECTIONS}
    assert set(re.findall(r"\]\(#([^)]*)\)", PAGE)) <= anchors


@pytest.mark.parametrize("number", sorted(ERRATA.keys() - WITHOUT_NUMBERS))
def test_an_erratum_is_measured(number):
    names: dict[str, Any] = {}
    exec(compile(SECTIONS["Errata"] + SECTIONS[ERRATA[number]], number, "exec"), names)
    measured, printed, corrected = (np.asarray(names[name]) for name in ("measured", "printed", "corrected"))
    gap = np.abs(measured - printed).max()
    assert gap > 1e-2
    assert np.abs(measured - corrected).max() < 1e-4 * gap


def functions(module: Any) -> dict[str, Any]:
    """Public functions of a module, and public methods and properties of its classes."""
    found: dict[str, Any] = {}
    own = [n for n, thing in vars(module).items() if getattr(thing, "__module__", "") == module.__name__]
    for name in getattr(module, "__all__", [n for n in own if not n.startswith("_")]):
        thing = getattr(module, name)
        if isinstance(thing, FunctionType) and thing.__module__.startswith("lie_rigid_body"):
            found[name] = thing
        if inspect.isclass(thing) and thing.__module__.startswith("lie_rigid_body.mechanics"):
            members = {n: m for n, m in vars(thing).items() if not n.startswith("_") and hasattr(m, "__doc__")}
            methods = {n: m for n, m in members.items() if isinstance(m, FunctionType | classmethod | property)}
            found |= {name: thing, **{f"{name}.{n}": m for n, m in methods.items()}}
    return found


@pytest.mark.parametrize("module", [so3, quaternion, lie_rigid_body.mechanics, top], ids=lambda m: m.__name__)
def test_functions_of_rotations_and_bodies_name_their_equation(module):
    for name, thing in functions(module).items():
        if getattr(thing, "__module__", "").endswith(".wording"):
            continue
        assert re.search(r"eqs?\. \(\d+[a-c]?\)", thing.__doc__ or "") or name in WITHOUT_EQUATION, name
