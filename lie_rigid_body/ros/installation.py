"""The ROS packages that are there: those that every node needs, and those for what is offered besides."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Final

from lie_rigid_body.errors import InputError

REQUIRED_PACKAGES: Final = (
    *("rclpy", "rcl_interfaces", "rosgraph_msgs", "std_msgs", "std_srvs"),
    *("geometry_msgs", "sensor_msgs", "diagnostic_msgs", "visualization_msgs"),
)
"""Packages without which no node starts."""


def require_ros() -> None:
    """Check that ROS 2 is installed.

    Raises
    ------
    InputError
        Naming the first package that is missing.
    """
    missing = [name for name in REQUIRED_PACKAGES if not is_installed(name)]
    if missing:
        raise InputError(
            f"{missing[0]} is not installed: source /opt/ros/jazzy/setup.bash; without it, on Python 3.12, "
            "pip install '.[ros]'; or use 'record'"
        )


def is_installed(name: str) -> bool:
    """Whether a package can be imported."""
    try:
        return find_spec(name) is not None
    except ValueError:  # None in sys.modules
        return False
