"""Share of small faults in a file that the tests of its room notice: what a shorter test suite must not lower.

    python benchmarks/mutants.py lie_rigid_body/motion/closed_form/jacobi.py -- test/motion/closed_form test/proof

A mutant is the file with one operator, comparison, sign or number changed. The sample is drawn from all that are
possible, always the same for the same file. Everything happens in a copy of the clone; the tests after ``--`` run until
the first that fails.
"""

from __future__ import annotations

import argparse
import ast
import copy
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.And: ast.Or,
    ast.Or: ast.And,
}


def changes(node: ast.AST) -> Iterator[Callable[[], None]]:
    """Calls that each put one fault into a node."""
    if isinstance(node, (ast.BinOp, ast.BoolOp, ast.AugAssign)) and type(node.op) in OPERATORS:
        yield lambda: setattr(node, "op", OPERATORS[type(node.op)]())
    if isinstance(node, ast.Compare):
        yield lambda: node.ops.__setitem__(0, OPERATORS[type(node.ops[0])]())  # type: ignore[call-overload]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
        yield lambda: setattr(node, "op", ast.UAdd() if isinstance(node.op, ast.USub) else ast.Invert())
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        yield lambda: setattr(node, "value", node.value + 1)  # type: ignore[operator]
    if isinstance(node, ast.IfExp):
        yield lambda: setattr(node, "test", ast.UnaryOp(ast.Not(), node.test))


def places(tree: ast.Module) -> Iterator[tuple[int, Callable[[], None]]]:
    """Line and call of every fault; annotations have none."""
    skipped = {
        inner
        for node in ast.walk(tree)
        for part in (getattr(node, "annotation", None), getattr(node, "returns", None))
        if part
        for inner in ast.walk(part)
    }
    for node in ast.walk(tree):
        if node not in skipped:
            yield from ((getattr(node, "lineno", 0), change) for change in changes(node))


def mutants(source: str, most: int) -> Iterator[tuple[int, str]]:
    """Line of the fault and text of each mutant of a sample."""
    tree = ast.parse(source)
    count = sum(1 for _ in places(tree))
    for number in sorted(random.Random(0).sample(range(count), min(most, count))):
        changed = copy.deepcopy(tree)
        line, change = list(places(changed))[number]
        change()
        yield line, ast.unparse(ast.fix_missing_locations(changed))


def passes(clone: Path, tests: list[str], limit_s: float) -> bool:
    """Whether the tests pass in time."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *tests]
    environment = {**os.environ, "PYTHONPATH": str(clone)}
    try:
        done = subprocess.run(command, cwd=clone, env=environment, capture_output=True, timeout=limit_s, check=False)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    parser.add_argument("tests", nargs="+")
    parser.add_argument("--most", type=int, default=20, help="size of the sample")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder, "clone")
        shutil.copytree(".", clone, ignore=shutil.ignore_patterns(".venv*", ".git", ".*cache", ".hypothesis"))
        begin = time.monotonic()
        if not passes(clone, given.tests, 3600.0):
            sys.exit("the tests fail without a fault: give tests that pass")
        limit_s = 60.0 + 5.0 * (time.monotonic() - begin)
        killed, total = 0, 0
        for line, text in mutants(given.file.read_text(encoding="utf-8"), given.most):
            (clone / given.file).write_text(text, encoding="utf-8")
            survives = passes(clone, given.tests, limit_s)
            killed, total = killed + (not survives), total + 1
            print(f"{given.file}:{line} {'SURVIVES' if survives else 'killed'}", flush=True)
        print(f"{given.file}: {killed} of {total} killed", flush=True)


if __name__ == "__main__":
    main()
