"""What ROS refuses, told in one line."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from lie_rigid_body.errors import InputError


@contextmanager
def told(what: str) -> Iterator[None]:
    """Turn whatever rclpy raises into one line.

    Parameters
    ----------
    what : str
        What ROS is asked for, as the user named it.

    Raises
    ------
    InputError
    """
    try:
        yield
    except Exception as error:
        raise InputError(f"ROS refuses {what}: {reason(error)}") from None


def reason(error: Exception) -> str:
    """What rclpy says, without the place in its source and the picture of the name."""
    first = (str(error).splitlines() or [type(error).__name__])[0]
    return first.partition(", at ")[0].removeprefix("failed to initialize rcl: ").rstrip(": ")
