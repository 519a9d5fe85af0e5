"""``/diagnostics``: rate, lateness and drift of the run, and a recording that failed, once a second."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, TypeAlias

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock
from rclpy.node import Node
from std_msgs.msg import Header

from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.ros.timing.sink import Periodic, Punctuality
from lie_rigid_body.scenario.arcs import arc_changes, largest_of_arcs
from lie_rigid_body.simulation import Segment

DIAGNOSTICS_TOPIC: Final = "/diagnostics"
Status: TypeAlias = tuple[bytes, str, Mapping[str, str]]
"""Level, message and values of a report."""
MAX_DRIFT: Final = 1e-6
"""Relative drift of energy or momentum beyond which the level is ERROR."""


class Diagnostics(Periodic):
    """A sink that reports the rate, the lateness, and the drift of energy and momentum since the last reset or kick.

    Parameters
    ----------
    node : Node
    """

    interval_ns = NS

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, DIAGNOSTICS_TOPIC, 10)
        self._before: tuple[int, Punctuality] | None = None
        self._failure = ""

    def report_failure(self, reason: str) -> None:
        """Report the level ERROR for this reason from now on, first in the next turn of the run."""
        self._failure = reason
        self._due_ns = 0

    def begin_segment(self, segment: Segment) -> None:
        """Take the scenario, by whose start and kicks energy and momentum are known all along this segment."""
        self._segment = segment
        self.latest = segment.start_ns, segment.scenario.start()

    def tick(self, steady_ns: int, punctuality: Punctuality) -> int:
        """Publish a report when a second has passed since the last."""
        self._before = self._before or (steady_ns, punctuality)
        return super().tick(steady_ns, punctuality)

    def act(self, steady_ns: int, punctuality: Punctuality) -> None:
        """Publish a report."""
        stamp = Clock().now().to_msg()  # of the system: that of the node stands at 0 where it waits for /clock
        self._publisher.publish(report(self._node, "simulation", stamp, *self._status(steady_ns, punctuality)))
        self._before = (steady_ns, punctuality)

    def _status(self, steady_ns: int, punctuality: Punctuality) -> Status:
        then_ns, before = self._before or (steady_ns, punctuality)
        missed = punctuality.missed - before.missed
        energy, momentum = (0.0, 0.0) if self._segment.scenario.path() else self.drifts()
        values = {
            "samples per second": f"{(punctuality.sent - before.sent) * NS / max(1, steady_ns - then_ns):.6g}",
            "samples per second of simulated time": f"{self._segment.scenario.rate:g}",
            "samples sent": str(punctuality.sent),
            "lateness of the latest sample (ms)": f"{punctuality.lateness_ns / 1e6:.3f}",
            "worst lateness so far (ms)": f"{punctuality.worst_ns / 1e6:.3f}",
            "missed deadlines in this interval": str(missed),
            "missed deadlines so far": str(punctuality.missed),
        }
        if not self._segment.scenario.path():
            values["energy drift since the last reset or kick (relative)"] = f"{energy:.2e}"
            values["momentum drift since the last reset or kick (relative)"] = f"{momentum:.2e}"
        return *_judgement(self._failure, missed, max(energy, momentum)), values

    def drifts(self) -> tuple[float, float]:
        """Changes of the kinetic energy and of the angular momentum (world frame) since the last reset or kick.

        They are relative to the largest right after any of them in the segment.
        """
        scenario = self._segment.scenario
        assert self.latest is not None
        stamp_ns, state = self.latest
        largest = largest_of_arcs(scenario)
        if not all(largest):
            return 0.0, 0.0
        changes = arc_changes(scenario, np.array([stamp_ns - self._segment.start_ns]), state)
        energy, momentum = (np.linalg.norm(change) for change, _ in changes)
        return energy / largest[0], momentum / largest[1]


def _judgement(failure: str, missed: int, drift: float) -> tuple[bytes, str]:
    if failure:
        return DiagnosticStatus.ERROR, failure
    if drift > MAX_DRIFT:
        return DiagnosticStatus.ERROR, "energy or momentum drifts: choose a better method or a smaller max_step"
    if missed:
        return DiagnosticStatus.WARN, "samples were late; none is left out"
    return DiagnosticStatus.OK, "in time"


def report(
    node: Node, subject: str, stamp: Time, level: bytes, message: str, values: Mapping[str, str]
) -> DiagnosticArray:
    """The message of one status on /diagnostics.

    Parameters
    ----------
    node : Node
    subject : str
        What the status is about, after the name of the node.
    stamp : builtin_interfaces/Time
    level : bytes
    message : str
    values : mapping of str to str
    """
    status = DiagnosticStatus(
        level=level,
        name=f"{node.get_fully_qualified_name()}: {subject}",
        message=message,
        hardware_id=node.get_name(),
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )
    return DiagnosticArray(header=Header(stamp=stamp), status=[status])
