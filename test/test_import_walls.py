"""The rooms of the package and the doors between them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Set
from graphlib import CycleError, TopologicalSorter

import pytest

from rooms import MODULES, PACKAGE, imported, imports, room

# What each room may import of the package besides itself and what is for all. A room is a folder or a module of the
# package, and its own __init__ is the room "".
SCENARIO = {"arithmetic", "compilation", "lie", "mechanics", "motion", "sensors", "scenario"}
BAG = SCENARIO | {"simulation", "messages", "recording"}
EDGE = BAG | {"certificate", "evaluation", "runs", "estimates", "report", "command_line"}
MAY_IMPORT: dict[str, set[str]] = {
    "foundation": set(),
    "errors": set(),
    "system": set(),
    "compilation": set(),
    "arithmetic": {"compilation"},
    "lie": set(),
    "mechanics": {"lie"},
    "motion": {"arithmetic", "compilation", "lie", "mechanics"},
    "groups": {"lie", "mechanics", "motion"},
    "sensors": {"lie", "mechanics", "motion"},
    "scenario": SCENARIO - {"scenario", "compilation"},
    "simulation": SCENARIO,
    "messages": SCENARIO | {"simulation"},
    "recording": SCENARIO | {"simulation", "messages"},
    "proof": {"mechanics"},
    "certificate": BAG | {"proof"},
    "evaluation": {"lie"},
    "runs": BAG | {"certificate", "evaluation"},
    "estimates": BAG | {"evaluation", "runs"},
    "conformance": {"lie", "mechanics", "motion", "scenario"},
    "inspection": {"lie", "sensors", "evaluation", "runs"},
    "diagnosis": SCENARIO | {"estimates", "evaluation", "runs"},
    "campaign": BAG | {"certificate", "estimates", "evaluation", "runs"},
    "league": SCENARIO | {"estimates", "evaluation", "runs", "diagnosis"},
    "testing": SCENARIO | {"estimates", "evaluation", "runs", "report"},
    "command_line": {"scenario", "recording"},
    "report": EDGE - {"report"} | {"diagnosis", "campaign", "inspection", "league"},
    "cli": EDGE | {"campaign", "diagnosis", "inspection", "league"},
    "ros": EDGE,
    "": SCENARIO | {"simulation", "evaluation", "runs", "inspection", "diagnosis", "certificate", "campaign"},
    "__main__": {"report"},
}
FOR_ALL = {"foundation", "system"}
# Who may import which part of `system`.
PARTS_OF_SYSTEM = {
    "bounded_input": {"campaign", "cli", "estimates", "league", "messages", "recording", "scenario", "simulation"},
    "portable": {"campaign", "cli", "command_line", "compilation", "diagnosis", "recording", "ros"},
    "output_file": {"campaign", "cli", "estimates", "recording", "report", "ros"},
    "interpreters": {"campaign", "cli", "estimates"},
    "interruption": {"campaign", "cli", "ros"},
    "console": {"cli", "command_line", "report", "ros", "__main__"},
}
PURE = {"arithmetic", "evaluation", "groups", "lie", "mechanics", "motion", "proof"}
WITHOUT_FILES_AND_CLOCKS = PURE | {"sensors"}
IMPURE = {"datetime", "io", "os", "pathlib", "random", "secrets", "shutil", "tempfile", "time"}
ROS = {"ament_index_python", "builtin_interfaces", "launch", "launch_ros", "rclpy", "rosidl_runtime_py"}
ROS_SUFFIXES = ("_msgs", "_srvs", "_interfaces")
MOTION = f"{PACKAGE}.motion"


def head(module: str) -> str:
    return module.partition(".")[0]


def wall_between_rooms(module: str, target: str) -> bool:
    return head(target) == PACKAGE and room(target) not in {room(module), *FOR_ALL, *MAY_IMPORT.get(room(module), ())}


def wall_around_system(module: str, target: str) -> bool:
    """As a whole it is imported by nobody: who sees an import knows which part of it is meant."""
    if room(target) != "system" or head(target) != PACKAGE:
        return False
    return room(module) not in {"system", *PARTS_OF_SYSTEM.get(target.removeprefix(f"{PACKAGE}.system."), ())}


def wall_around_ros(module: str, target: str) -> bool:
    return room(module) != "ros" and (head(target) in ROS or head(target).endswith(ROS_SUFFIXES))


def wall_around_mathematics(module: str, target: str) -> bool:
    if room(module) in WITHOUT_FILES_AND_CLOCKS and head(target) in IMPURE:
        return True
    return room(module) in PURE and target.startswith("numpy.random")


def wall_around_referee(module: str, target: str) -> bool:
    """The closed form and the moving chart know the contract, and nothing of each other."""
    if not module.startswith(f"{MOTION}.") or not (target == MOTION or target.startswith(f"{MOTION}.")):
        return False
    return side(target) not in {side(module), "contract"}


def side(module: str) -> str:
    name = module.removeprefix(MOTION).removeprefix(".").partition(".")[0]
    contract = dict.fromkeys(("motion", "kicks", "harmonics", "mass_centre", "translation"), "contract")
    return {"": "all", **contract, "closed_form": "closed form", "description": "closed form"}.get(name, "moving chart")


WALLS = (wall_between_rooms, wall_around_system, wall_around_ros, wall_around_mathematics, wall_around_referee)


def breaches(source: str, module: str, *, is_package: bool = False) -> list[str]:
    """What a source imports as a module and must not, as sentences."""
    return of_those(imports(source, module, is_package=is_package), module)


def of_those(targets: Iterable[str], module: str) -> list[str]:
    return [
        f"{module} imports {target} through the {wall.__name__.replace('_', ' ')}"
        for target in sorted(set(targets))
        for wall in WALLS
        if wall(module, target)
    ]


def test_every_module_keeps_to_its_room() -> None:
    assert [module for module in MODULES if room(module) not in MAY_IMPORT] == []
    assert [breach for module in MODULES for breach in of_those(imported(module), module)] == []


def test_progress_bars_are_made_in_one_place() -> None:
    """`console.progress`, in which no signal leaves half a bar."""
    assert {module for module in MODULES if "tqdm" in imported(module)} == {f"{PACKAGE}.system.console"}


def test_one_door_leads_upwards() -> None:
    """Imports of names that are made as the program runs: of the verbs, and of what `report` shows of results."""
    made = re.compile(r'import_module\(f"(lie_rigid_body|\{PACKAGE\})')
    found = {module for module, path in MODULES.items() if made.search(path.read_text("utf-8"))}
    assert found == {f"{PACKAGE}.__main__", f"{PACKAGE}.foundation.showing"}


def circle(graph: Mapping[str, Set[str]]) -> list[str]:
    """The modules of a circle of imports, from one of them back to itself; empty if there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_module_imports_itself_through_others() -> None:
    """Imports within functions and those for types count as well: who reads one module need not read a circle."""
    assert circle({module: imported(module) - {module} for module in MODULES}) == []


def test_a_circle_is_found() -> None:
    assert circle({"a": {"b"}, "b": {"c"}, "c": set()}) == []
    assert sorted(circle({"a": {"b"}, "b": {"c"}, "c": {"b"}})[:-1]) == ["b", "c"]


@pytest.mark.parametrize(
    ("module", "source", "wall"),
    [
        ("lie.so3", "from lie_rigid_body.mechanics import State", "rooms"),
        ("lie.so3", "import lie_rigid_body.motion.moving_chart", "rooms"),
        ("lie.so3", "from lie_rigid_body import State", "rooms"),
        ("lie.so3", "from ..motion import moving_chart", "rooms"),
        ("lie.so3", "def f():\n    from .. import scenario", "rooms"),
        ("cli.explain", "from lie_rigid_body.groups import SO", "rooms"),
        ("cli.record", "from lie_rigid_body.ros import node", "rooms"),
        ("cli.record", "import importlib\nimportlib.import_module('lie_rigid_body.ros.sim')", "rooms"),
        ("ros.sim", "if True:\n    from lie_rigid_body.cli.record import main", "rooms"),
        ("recording.writer", "from lie_rigid_body import certificate", "rooms"),
        ("__main__", "from lie_rigid_body.cli.record import main", "rooms"),
        ("proof.enclosure", "from lie_rigid_body.motion import ClosedForm", "rooms"),
        ("recording.writer", "from lie_rigid_body.system import console", "system"),
        ("report.drawing", "from lie_rigid_body import system", "system"),
        ("scenario.definition", "from ..system.interpreters import Interpreters", "system"),
        ("cli.record", "import rclpy", "ros"),
        ("messages.layout", "try:\n    import std_srvs.srv\nexcept ImportError:\n    pass", "ros"),
        ("mechanics.state", "import os.path", "mathematics"),
        ("motion.moving_chart", "from numpy.random import default_rng", "mathematics"),
        ("sensors.noise", "import random", "mathematics"),
        ("motion.closed_form.solution", "from ..moving_chart import MovingChart", "referee"),
        ("motion.moving_chart", "from .closed_form.elliptic import rf", "referee"),
        ("motion.motion", "from lie_rigid_body.motion.closed_form import ClosedForm", "referee"),
        ("motion.moving_chart", "from lie_rigid_body.motion.description import describe", "referee"),
    ],
)
def test_breach_is_found(module: str, source: str, wall: str) -> None:
    found = breaches(source, f"{PACKAGE}.{module}")
    assert len(found) == 1
    assert found[0].endswith(wall)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("lie.so3", "from ..foundation.errors import InputError\nfrom lie_rigid_body.lie import series\nimport numpy"),
        ("motion.description", "from lie_rigid_body.motion.closed_form.decimal_constants import Polhode"),
        ("sensors.noise", "from numpy.random import Philox"),
        ("scenario", "from lie_rigid_body.foundation import parameters\nfrom lie_rigid_body.motion import ClosedForm"),
        ("recording.writer", "from lie_rigid_body.simulation import simulate\nimport mcap.writer\nimport os"),
        ("certificate.proved", "from lie_rigid_body.proof import enclose"),
        ("ros.sim", "import rclpy\nfrom geometry_msgs.msg import PoseStamped"),
    ],
)
def test_open_door_is_no_breach(module: str, source: str) -> None:
    assert breaches(source, f"{PACKAGE}.{module}") == []


def test_relative_imports_of_a_package_start_in_itself() -> None:
    source = "from .closed_form import ClosedForm\nfrom .moving_chart import MovingChart"
    assert breaches(source, MOTION, is_package=True) == []
    assert len(breaches("from ..scenario import Scenario", MOTION, is_package=True)) == 1
