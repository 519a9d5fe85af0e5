"""rclpy for the node and for `listen`: initialised, spinning in the background, its errors translated.

The samples do not go through a timer of an executor. Its wait set costs several times what a sample does, and a timer
waits for the other callbacks that are ready. Nor does rclpy handle the signals: it would shut down amid a batch.
"""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from importlib import import_module
from itertools import combinations
from threading import Event, Thread
from typing import Any, Final

import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import (
    Executor,
    ExternalShutdownException,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)
from rclpy.logging import LoggingSeverity, get_logger_level, set_logger_level
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import get_rmw_implementation_identifier

from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.foundation.wording import shown

ZENOH: Final = "rmw_zenoh_cpp"
_RCL: Final = "rcl"
_NAME: Final = re.compile(r"(?:\w+:)?__(?:node|name|ns):=(.*)")
MAX_NODE_NAME_LENGTH: Final = 200
"""Longest name of a node and longest namespace, characters: those of its services are longer, and may have 247."""
MAX_DEPTH: Final = 2**31 - 1
"""Most messages of a topic that can be kept."""
MAX_LOOK: Final = 0.05
"""Longest wait for the next callback, s, before it is seen whether the node ends."""
MAX_JOIN: Final = 0.5
"""Longest wait for the background thread at the end, s."""
THREADS: Final = 4
"""Number of threads for callbacks, so that services answer while some wait for long steps."""
OF_EVERY_NODE: Final = ("/rosout", "/parameter_events")
"""Topics of every node of ROS."""
_REMEDIES: Final = {
    r"log directory|\.log for writing": "name a folder that can be written as ROS_LOG_DIR",
    "(?i)security": "mend the keys in ROS_SECURITY_KEYSTORE, or set ROS_SECURITY_ENABLE to false",
    "Zenoh router": "start one, rmw_zenohd of rmw_zenoh_cpp",
    "peer": "name machines that are known as ROS_STATIC_PEERS",
}
"""Remedies for refusals of ROS, by words of their messages."""
_MIDDLEWARE: Final = {"RMW_FASTRTPS_PUBLICATION_MODE": "ASYNCHRONOUS", "ZENOH_ROUTER_CHECK_ATTEMPTS": "5"}
"""Settings where the user has none. Fast DDS sends in a thread of its own: else a subscriber that is frozen holds a
publisher up for two seconds. Zenoh looks for its router for 5 s, and not for ever."""


@contextmanager
def initialised(arguments: Sequence[str]) -> Iterator[None]:
    """Keep rclpy initialised, without signal handlers of its own.

    Parameters
    ----------
    arguments : sequence of str
        The command-line arguments for ROS.

    Raises
    ------
    InputError
        If ROS does not understand them.
    """
    _require_short_name(arguments)
    for name, value in _MIDDLEWARE.items():
        os.environ.setdefault(name, value)
    with translated_errors(" ".join(arguments) or "to start"):
        # what rcl logs of bad arguments is in the exception as well
        set_logger_level(_RCL, LoggingSeverity.FATAL)
        rclpy.init(args=list(arguments), signal_handler_options=SignalHandlerOptions.NO)
    if get_logger_level(_RCL) == LoggingSeverity.FATAL:
        set_logger_level(_RCL, LoggingSeverity.UNSET)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "failed to send response", RuntimeWarning)  # its client has gone away
            yield
    finally:
        rclpy.try_shutdown()


def _require_short_name(arguments: Sequence[str]) -> None:
    for argument in arguments:
        if (rule := _NAME.fullmatch(argument)) and len(rule[1]) > MAX_NODE_NAME_LENGTH:
            raise InputError(
                f"{shown(argument)}: this node would have a name of {len(rule[1])} characters: at most "
                f"{MAX_NODE_NAME_LENGTH} leave room for those of its services"
            )


@contextmanager
def destroying(node: Node) -> Iterator[None]:
    """Destroy a node at the end, whatever happens: until then others see it and its topics, in a process that lives."""
    try:
        yield
    finally:
        node.destroy_node()


@contextmanager
def own_node(name: str, arguments: Sequence[str] = ()) -> Iterator[Node]:
    """Keep a node of this process without services of its own, in an rclpy that is initialised for it alone."""
    with initialised(arguments):
        with translated_errors("this node"):
            node = rclpy.create_node(
                name, start_parameter_services=False, automatically_declare_parameters_from_overrides=True
            )
        with destroying(node):
            yield node


class Pool(Executor):
    """Executor whose callbacks run in threads that can be waited for: rclpy's own waits for none at its end.

    Parameters
    ----------
    node : Node
    """

    def __init__(self, node: Node) -> None:
        super().__init__(context=node.context)
        self._threads = ThreadPoolExecutor(THREADS)
        self._node = node
        self.add_node(node)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for the next callback, and have it carried out."""
        with suppress(TimeoutException, ShutdownException, ExternalShutdownException):
            callback, _, _ = self.wait_for_ready_callbacks(timeout_sec=timeout_sec)
            self._threads.submit(self._carry_out, callback)

    def _carry_out(self, callback: Any) -> None:
        callback()
        error = callback.exception() if callback.done() else None
        if error is not None and rclpy.ok():  # one malformed request must not silence all services
            self._node.get_logger().error(f"a callback failed: {error!r}")

    def finish(self) -> None:
        """Wait for the callbacks that have begun: one that goes on without ROS prints its error."""
        self._threads.shutdown()


@contextmanager
def spinning(node: Node) -> Iterator[None]:
    """Answer the node's services in background threads. At the end those that are called are answered, and no others.

    Then rclpy is shut down.
    """
    executor = Pool(node)
    ended = Event()
    thread = Thread(target=_spin, args=(executor, ended), name="services", daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join(MAX_JOIN)
        executor.finish()
        rclpy.try_shutdown()  # which also ends a wait for the next callback, should a clock have been set back
        thread.join(MAX_JOIN)


def _spin(executor: Pool, ended: Event) -> None:
    while rclpy.ok() and not ended.is_set():
        try:
            executor.spin_once(MAX_LOOK)
        except Exception:
            if rclpy.ok():  # else it ended amid a look of the executor, or between two, whose wait set then fails
                raise


@contextmanager
def listening(node: Node) -> Iterator[Callable[[float], None]]:
    """Take the messages of a node in bulk: what is given calls back for those that have come, or come in so many s.

    The executor of events takes 2 µs a message, the one with a wait set 90 µs; it is in rclpy since 7.1.4.
    """
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        EventsExecutor = SingleThreadedExecutor
    executor = EventsExecutor(context=node.context)
    executor.add_node(node)
    try:
        yield lambda seconds: executor.spin_once(timeout_sec=seconds)
    finally:
        executor.remove_node(node)
        executor.shutdown()


def offered(node: Node, kind: type, topic: str, quality: QoSProfile) -> Publisher:
    """Publisher of a topic, whose quality of service the user may override by parameters.

    Raises
    ------
    InputError
        If ROS refuses the name or the quality.
    """
    options = QoSOverridingOptions.with_default_policies(callback=_possible)
    with translated_errors(f"the topic {topic} as {node.resolve_topic_name(topic)}"):
        return node.create_publisher(kind, topic, quality, qos_overriding_options=options)


def latched(depth: int) -> QoSProfile:
    """Quality of service of a topic whose last messages late subscribers hear as well."""
    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def _possible(quality: QoSProfile) -> SetParametersResult:
    """Whether ROS would take a quality of service: of a wrong depth it warns, or tells no value."""
    reason = ""
    if not 1 <= quality.depth <= MAX_DEPTH:
        reason = f"depth {quality.depth} is outside [1, {MAX_DEPTH}]: give for example 10"
    elif is_zenoh() and quality.history is HistoryPolicy.KEEP_ALL:
        reason = f"history keep_all may wait in publish for ever with {ZENOH}: leave it keep_last"
    return SetParametersResult(successful=not reason, reason=reason)


def is_zenoh() -> bool:
    """Whether the middleware is Zenoh, which has neither domains nor confirmations."""
    return bool(get_rmw_implementation_identifier() == ZENOH)


def message_class(name: str) -> type:
    """The class of a message type, by its name in ROS."""
    package, _, kind = name.partition("/msg/")
    found: type = getattr(import_module(f"{package}.msg"), kind)
    return found


@contextmanager
def translated_errors(request: str) -> Iterator[None]:
    """Turn any error but our own, so of rclpy, into an InputError of one line.

    Parameters
    ----------
    request : str
        What ROS is asked for, in the words of the user.

    Raises
    ------
    InputError
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what it cannot undo after the error, or of what is refused here
            yield
    except LieRigidBodyError:
        raise
    except Exception as error:
        reason = _reason(error)
        remedy = next((f": {remedy}" for words, remedy in _REMEDIES.items() if re.search(words, reason)), "")
        raise InputError(f"ROS refuses {request}: {reason}{remedy}") from None


def _reason(error: Exception) -> str:
    """The first line of rclpy's message, without the place in its source."""
    first = (str(error).splitlines() or [type(error).__name__])[0]
    return first.partition(", at ")[0].removeprefix("failed to initialize rcl: ").rstrip(": ")


def require_distinct(kind: str, full_names: Mapping[str, str]) -> None:
    """Refuse two topics, or services, of one name: some middlewares do if their types differ, others take both."""
    for (one, its_name), (other, other_name) in combinations(full_names.items(), 2):
        if its_name == other_name:
            raise InputError(f"the {kind} {one} and {other} would both be {its_name}: give each a name of its own")
