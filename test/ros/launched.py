"""The launch files, run with stand-ins for the launch libraries, which PyPI does not have."""

from __future__ import annotations

import runpy
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from unittest.mock import patch

LAUNCH = Path(__file__).parents[2] / "launch"
EXECUTABLES = {
    "lie_rigid_body": "sim",
    "tf2_ros": "static_transform_publisher",
    "rviz2": "rviz2",
    "imu_filter_madgwick": "imu_filter_madgwick_node",
    "imu_complementary_filter": "complementary_filter_node",
    "mine": "filter",
}
"""Executables that the launch files may start, by their packages."""

Node = dict[str, Any]


class Context(dict[str, str]):
    """A launch context: the launch configurations, and the words of the command line."""

    def __init__(self, configurations: dict[str, str], argv: list[str]) -> None:
        super().__init__(configurations)
        self.argv = argv


@contextmanager
def stand_ins() -> Iterator[None]:
    names = {
        "LaunchContext": object,
        "LaunchDescription": lambda actions: actions,
        "DeclareLaunchArgument": lambda name, **settings: (name, settings),
        "OpaqueFunction": lambda function: function,
        "LaunchConfiguration": lambda name: SimpleNamespace(perform=lambda context: context[name]),
        "Node": lambda **settings: settings,
        "Shutdown": lambda reason: f"end everything: {reason}",
    }
    found = {}
    for name in ("launch", "launch.actions", "launch.substitutions", "launch_ros", "launch_ros.actions"):
        found[name] = ModuleType(name)
        vars(found[name]).update(names)
    with patch.dict(sys.modules, found):
        yield


def described(file: str) -> Any:
    """The description of a launch file: its arguments, and the function that starts nodes."""
    with stand_ins():
        return runpy.run_path(str(LAUNCH / file))["generate_launch_description"]()


def install(folder: Path, left_out: str = "") -> str:
    """The prefixes in which the executables are, in a folder: all but that of one package."""
    for package, executable in EXECUTABLES.items():
        prefix = "workspace" if package == "lie_rigid_body" else "jazzy"
        for name in [executable, *(["evaluate"] if package == "lie_rigid_body" else [])]:
            path = folder / prefix / "lib" / package / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch(mode=0o644 if package == left_out else 0o755)
    return f"{folder / 'workspace'}:{folder / 'jazzy'}"


def launched(file: str, folder: Path, /, without: str = "", **given: str) -> list[Node]:
    """The nodes that a launch file starts, with its defaults where an argument is not given."""
    argv = [f"{name}:={value}" for name, value in given.items()]
    words = ["ros2", "launch", "lie_rigid_body", file, *argv]
    environment = {"AMENT_PREFIX_PATH": install(folder, without), "ROS_DISTRO": "jazzy"}
    *declared, function = described(file)
    defaults = {name: settings["default_value"] for name, settings in declared}
    with stand_ins(), patch.object(sys, "argv", words), patch.dict("os.environ", environment):
        nodes: list[Node] = function(Context(defaults | given, argv))
    return nodes
