"""Everyone who can take part on this machine."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from typing import Final

from peers.contender import Contender
from peers.task import Task

NEEDS: Final = {
    "mujoco_joint": "mujoco",
    "drake_plant": "pydrake",
    "dart_skeleton": "dartpy",
    "pybullet_body": "pybullet",
}
MODULES: Final = ("ours", *NEEDS, "scipy_solvers", "rotation_spline")


def missing() -> list[str]:
    """The libraries that are not installed, so that their contenders are left out."""
    return [library for library in NEEDS.values() if find_spec(library) is None]


def contenders(task: Task) -> Iterator[Contender]:
    """All contenders for a task, this package first."""
    for name in MODULES:
        if NEEDS.get(name) not in missing():
            yield from import_module(f"peers.{name}").contenders(task)
