"""Everyone who can take part on this machine."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from typing import Final

from peers.contender import Contender
from peers.task import Task

NEEDS: Final = {
    "orekit_torque_free": ("orekit_jpype", "java"),
    "mujoco_joint": ("mujoco",),
    "drake_plant": ("pydrake",),
    "dart_skeleton": ("dartpy",),
    "pybullet_body": ("pybullet",),
    "diffrax_solvers": ("diffrax",),
    "jaxlie_rkmk": ("jaxlie",),
}
PROGRAMS: Final = ("java",)
"""What is looked for on the path; all else is a library of Python."""

MODULES: Final = ("ours", "frb", "theta_series", *NEEDS, "scipy_solvers", "rotation_spline")


def missing() -> list[str]:
    """What is not installed, so that its contenders are left out."""
    return [needed for module in NEEDS for needed in NEEDS[module] if not _is_there(needed)]


def contenders(task: Task) -> Iterator[Contender]:
    """All contenders for a task, this package first."""
    absent = missing()
    for name in MODULES:
        if not any(needed in absent for needed in NEEDS.get(name, ())):
            yield from import_module(f"peers.{name}").contenders(task)


def _is_there(needed: str) -> bool:
    return shutil.which(needed) is not None if needed in PROGRAMS else find_spec(needed) is not None
