"""ROS as it is found: packages that every node needs, those for what is offered besides, and the environment."""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.system.portable import limit

REQUIRED_PACKAGES: Final = (
    *("rclpy", "rcl_interfaces", "rosgraph_msgs", "std_msgs", "std_srvs"),
    *("geometry_msgs", "sensor_msgs", "diagnostic_msgs", "visualization_msgs"),
)
"""Packages without which no node starts."""
MAX_DOMAIN: Final = 232
"""Largest ROS domain for which DDS has ports."""
_MIN_FILES: Final = 32
"""Least number of files that a node may need open at once, measured: from 22 on it runs."""
_MIN_MEMORY: Final = 750_000_000
"""Least memory that a node may need, bytes, measured: from 680 MB on it runs; with less a library ends the process."""
_SWITCHES: Final = ("RCUTILS_COLORIZED_OUTPUT", "RCUTILS_LOGGING_BUFFERED_STREAM", "RCUTILS_LOGGING_USE_STDOUT")
"""Variables of rcutils that are 0, 1 or empty; of another value it prints a line of its own."""
_MIDDLEWARES: Final = "share/ament_index/resource_index/rmw_typesupport"


def require_ros() -> None:
    """Check that ROS 2 is installed, and works in this environment, before it is loaded.

    Raises
    ------
    InputError
        Naming the first package that is missing, or as `require_environment`.
    """
    missing = [name for name in REQUIRED_PACKAGES if not is_installed(name)]
    if missing:
        raise InputError(
            f"{missing[0]} is not installed: {how_to_install(missing[0])}; or use what needs no ROS, 'record' and "
            "'evaluate BAG'"
        )
    require_environment()


def how_to_install(package: str) -> str:
    """Remedy for a package of ROS that is missing: by apt, for the distribution that is sourced, if one is."""
    if distribution := os.environ.get("ROS_DISTRO"):
        return f"apt install ros-{distribution}-{package.replace('_', '-')}"
    return "source /opt/ros/DISTRIBUTION/setup.bash; without it, on Python 3.12 to 3.14, pip install '.[ros]'"


def require_environment() -> None:
    """Refuse settings with which ROS would end the process, with a status of its own, or not say what is wrong.

    Raises
    ------
    InputError
    """
    given = os.environ
    domain = given.get("ROS_DOMAIN_ID", "")
    middleware = given.get("RMW_IMPLEMENTATION", "")
    files = limit("RLIMIT_NOFILE")
    memory = limit("RLIMIT_AS")
    security = [given.get(f"ROS_SECURITY_{name}", "") for name in ("ENABLE", "STRATEGY", "KEYSTORE")]
    faults = {
        f"ROS_DOMAIN_ID {domain} is above {MAX_DOMAIN}: give one from 0 to {MAX_DOMAIN}": (
            domain.isdecimal() and int(domain[:9]) > MAX_DOMAIN
        ),
        f"RMW_IMPLEMENTATION {shown(middleware)} is not installed: install it, or unset RMW_IMPLEMENTATION": (
            middleware != "" and not _is_middleware(middleware)
        ),
        "HOME is empty, where ROS keeps its log: name a folder that can be written as ROS_LOG_DIR": (
            not any(map(given.get, ("ROS_LOG_DIR", "ROS_HOME", "HOME")))
        ),
        "ROS_SECURITY_STRATEGY is Enforce, and ROS_SECURITY_KEYSTORE is empty: name the folder of the keys, or set "
        "ROS_SECURITY_ENABLE to false": security == ["true", "Enforce", ""],
        f"open files are limited to {files:g} (ulimit -n): allow {_MIN_FILES} at least": files < _MIN_FILES,
        f"memory is limited to {memory / 1e6:g} MB (ulimit -v): allow a node {_MIN_MEMORY // 10**6} MB at least": (
            memory < _MIN_MEMORY
        ),
        **{
            f"{name} is {shown(given[name])}: give 0 or 1, or unset it": given[name] not in ("", "0", "1")
            for name in _SWITCHES
            if name in given
        },
    }
    for fault, is_there in faults.items():
        if is_there:
            raise InputError(fault)


def _is_middleware(name: str) -> bool:
    """Whether a middleware is installed: with a distribution of ROS 2, or from wheels, where it can be imported."""
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return is_installed(name) or any(Path(prefix, _MIDDLEWARES, name).is_file() for prefix in prefixes)


def is_installed(name: str) -> bool:
    """Whether a package can be imported."""
    try:
        return find_spec(name) is not None
    except ValueError:  # None in sys.modules
        return False
