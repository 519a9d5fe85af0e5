"""Readings of a run played to a filter's node, in a process of its own, which ends with the one that asks for it."""

from __future__ import annotations

import os
import random
import signal
import socket
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import BinaryIO, Final

from lie_rigid_body.estimates.programs import Answered, NodeEstimator, Reading, last_words, words
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.ros.installation import require_ros
from lie_rigid_body.system.output_file import reason

DOMAINS: Final = range(1, 102)
"""Domains whose ports are not in the range that Linux hands out to clients, but for 0, everybody's default."""
ENDING_S: Final = 2.0
"""Time that a node has to end when it is asked to, s."""
MAX_PRINTED: Final = 2**28
"""Largest output of a node, bytes."""
_PLAYED: Final = "\0lie_rigid_body/played-to/{}"
"""Name of the socket that holds a domain. It is in no folder, and ends with its process (unix(7), abstract)."""
_PORTS: Final = (7400, 250, (0, *range(10, 250, 2)))
"""UDP ports of a domain on one machine: the first of domain 0, how far the next domain's are, and places of those at
which participants listen (DDSI-RTPS 2.5, 9.6.2.3)."""


def played(estimator: NodeEstimator, readings: Sequence[Reading]) -> Answered | str:
    """Answer of a node, or the reason why there is none."""
    with tempfile.TemporaryFile() as output, tempfile.TemporaryDirectory() as logs:
        try:
            with own_domain() as domain:
                os.environ.update(
                    ROS_DOMAIN_ID=f"{domain}", ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", ROS_LOG_DIR=logs
                )
                require_ros()
                from lie_rigid_body.ros.session import is_zenoh  # only now: it needs ROS

                if is_zenoh():
                    raise LieRigidBodyError(
                        "needs DDS, in which it has a domain without other nodes: set RMW_IMPLEMENTATION to one, such "
                        "as rmw_fastrtps_cpp"
                    )
                with _started(estimator.command, output) as require_alive:
                    from lie_rigid_body.ros.player import answers_to

                    try:
                        return answers_to(estimator, readings, require_alive)
                    except LieRigidBodyError as error:
                        return f"{error}{last_words(output)}"
        except LieRigidBodyError as error:
            return str(error)


@contextmanager
def own_domain() -> Iterator[int]:
    """A ROS domain that no other player uses while the context lasts, and in which no node of this machine is yet."""
    for domain in random.sample(DOMAINS, len(DOMAINS)):
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as held:
            try:
                held.bind(_PLAYED.format(domain))
            except OSError:  # another player's
                continue
            if f"{domain}" == os.environ.get("ROS_DOMAIN_ID") or not _is_empty(domain):
                continue
            yield domain
            return
    raise LieRigidBodyError(f"finds no free ROS domain among {len(DOMAINS)}: end other filters and nodes")


def _is_empty(domain: int) -> bool:
    """Whether no participant of a domain runs on this machine."""
    first, distance, places = _PORTS
    for place in places:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
            try:
                port.bind(("", first + distance * domain + place))
            except OSError:
                return False
    return True


@contextmanager
def _started(command: str, output: BinaryIO) -> Iterator[Callable[[], None]]:
    """Keep a node running; what is given raises an error once it has ended, or printed too much."""
    try:
        process = subprocess.Popen(words(command), stdin=subprocess.DEVNULL, stdout=output, stderr=output)
    except (OSError, ValueError) as error:  # the second of a text that no program can be given
        raise LieRigidBodyError(
            f"cannot be started: {reason(error)}: give a program, such as 'ros2 run PACKAGE NODE'"
        ) from None

    def require_alive() -> None:
        if process.poll() is not None:
            raise LieRigidBodyError(f"ended with status {process.returncode}: correct it")
        if os.fstat(output.fileno()).st_size > MAX_PRINTED:
            raise LieRigidBodyError(f"prints more than {MAX_PRINTED} bytes: let it log less")

    try:
        yield require_alive
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        os.killpg(0, signal.SIGINT)  # 'ros2 run' starts the node as a process of its own
        with suppress(subprocess.TimeoutExpired):
            process.wait(ENDING_S)
