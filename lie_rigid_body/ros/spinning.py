"""rclpy in the background: it answers services while the main thread keeps time.

The samples do not go through an executor's timer: its wait set costs several times what a sample does, and its turn
comes after whatever else is ready. Nor does rclpy handle the signals: it would shut down publishers in the middle of a
burst.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Thread
from typing import Final

import rclpy
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.logging import LoggingSeverity, get_logger_level, set_logger_level
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from lie_rigid_body.ros.refusal import told

_RCL: Final = "rcl"
LONGEST_GOODBYE: Final = 0.5
"""s to wait for the thread at the end."""
THREADS: Final = 4
"""Some may wait for long steps while the others answer."""


@contextmanager
def initialised(arguments: Sequence[str]) -> Iterator[None]:
    """Keep rclpy initialised.

    Parameters
    ----------
    arguments : sequence of str
        Those for ROS.

    Raises
    ------
    InputError
        If ROS does not understand them.
    """
    # what rcl logs of bad arguments is in the exception as well
    set_logger_level(_RCL, LoggingSeverity.FATAL)
    with told(" ".join(arguments) or "to start"):
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    if get_logger_level(_RCL) == LoggingSeverity.FATAL:
        set_logger_level(_RCL, LoggingSeverity.UNSET)
    try:
        yield
    finally:
        rclpy.try_shutdown()


@contextmanager
def spinning(node: Node) -> Iterator[None]:
    """Answer the node's services in another thread. At the end rclpy is shut down, which is what wakes that thread."""
    executor = MultiThreadedExecutor(THREADS)
    executor.add_node(node)
    thread = Thread(target=_spin, args=(executor, node), name="services", daemon=True)
    thread.start()
    try:
        yield
    finally:
        rclpy.try_shutdown()
        thread.join(LONGEST_GOODBYE)


def _spin(executor: MultiThreadedExecutor, node: Node) -> None:
    while rclpy.ok():
        try:
            executor.spin()
        except ExternalShutdownException:
            return
        except Exception as error:
            # one malformed request must not silence all services
            node.get_logger().error(f"a callback failed: {error!r}")
