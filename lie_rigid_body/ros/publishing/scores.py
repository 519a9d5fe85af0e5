"""``~/error`` and ``/diagnostics`` of the live evaluator: the error of every estimate, and the score so far."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Final

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from rclpy.clock import Clock
from rclpy.node import Node
from rclpy.qos import QoSProfile

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import LieRigidBodyError
from lie_rigid_body.estimates.kept import UNUSABLE
from lie_rigid_body.estimates.live_estimate import INTERIM, LiveEstimate
from lie_rigid_body.evaluation import AttitudeError, Finding, Score
from lie_rigid_body.messages.layout import Layout, header
from lie_rigid_body.ros.publishing.diagnostics import DIAGNOSTICS_TOPIC, Status, report
from lie_rigid_body.ros.session import OF_EVERY_NODE, require_distinct

ERROR_TOPIC: Final = "~/error"
ERRORS_KEPT: Final = 1000
INTERVAL_S: Final = 1.0
"""Time between two reports on /diagnostics, s."""
FIRST_DIAGNOSIS_S: Final = 5.0
"""Shortest estimate, by its stamps, of which a diagnosis is made, s."""
DIAGNOSIS_SHARE: Final = 0.03
"""Largest share of the time spent on diagnoses; one is always made when the time of the estimate has doubled."""
SLOW: Final = frozenset({"heading_offset", "body_mounting"})
"""Codes of findings that the slow error of a healthy filter resembles for some seconds."""
PLAIN_DEG: Final = 1.0
"""Median error from which on the findings in `SLOW` are told at once, degrees."""


class Confirmed:
    """Findings on the way that are worth telling: small slow ones once samples of another time have shown them too."""

    def __init__(self) -> None:
        self._found: deque[tuple[float, frozenset[str]]] = deque()

    def findings(self, score: Score, span_s: float) -> tuple[Finding, ...]:
        """The findings worth telling of a score of the second half of so many seconds; seconds never decrease."""
        self._found.append((span_s, frozenset(finding.code for finding in score.findings)))
        while len(self._found) > 1 and self._found[1][0] <= span_s / 2.0:
            self._found.popleft()
        earlier_s, earlier = self._found[0]
        doubtful = SLOW if score.total_deg.median < PLAIN_DEG else frozenset()
        doubtful -= earlier if earlier_s <= span_s / 2.0 else frozenset()
        return tuple(finding for finding in score.findings if finding.code not in doubtful)


class Scores:
    """The publishers of the evaluator.

    Parameters
    ----------
    node : Node
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        topics = (ERROR_TOPIC, DIAGNOSTICS_TOPIC, *OF_EVERY_NODE)
        require_distinct("topics", {topic: node.resolve_topic_name(topic) for topic in topics})
        self._error = node.create_publisher(Vector3Stamped, ERROR_TOPIC, QoSProfile(depth=ERRORS_KEPT))
        self._diagnostics = node.create_publisher(DiagnosticArray, DIAGNOSTICS_TOPIC, 10)
        self._layout = Layout(header(""), [0.0] * 3, [range(3)])
        self._due, self._diagnosis_due = time.monotonic() + INTERVAL_S, np.inf
        self._diagnosed_s = FIRST_DIAGNOSIS_S / 2.0
        self._score: Score | None = None
        self._findings: tuple[Finding, ...] = ()
        self._confirmed = Confirmed()
        self._fault = ""

    def errors(self, stamps_ns: Integers, error: AttitudeError) -> None:
        """Publish total, heading and inclination error, rad, at each stamp."""
        for payload in self._layout.encode(stamps_ns, np.stack(error, axis=-1)):
            self._error.publish(payload)

    def report(self, live: LiveEstimate | None, missing: Callable[[], str]) -> None:
        """Publish the score so far, once in `INTERVAL_S`.

        Parameters
        ----------
        live : LiveEstimate or None
        missing : callable
            Tells what is waited for; asked as long as there is nothing to score.
        """
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + INTERVAL_S
        if live is None or not live.tally.count:
            status: Status = DiagnosticStatus.WARN, f"waiting: {missing()}", {}
        else:
            if live.estimate.span_s >= 2.0 * self._diagnosed_s or now >= self._diagnosis_due:
                self._diagnose(live)
            status = self._status(live)
        self._diagnostics.publish(report(self._node, "attitude error", Clock().now().to_msg(), *status))

    def _diagnose(self, live: LiveEstimate) -> None:
        begin, self._diagnosed_s = time.monotonic(), live.estimate.span_s
        try:
            self._score, self._fault = live.score(INTERIM)[1], ""
            self._findings = self._confirmed.findings(self._score, self._diagnosed_s)
        except LieRigidBodyError as error:
            self._score, self._findings, self._fault = None, (), str(error)
        end = time.monotonic()
        self._diagnosis_due = end + max(INTERVAL_S, (end - begin) / DIAGNOSIS_SHARE)

    def _status(self, live: LiveEstimate) -> Status:
        tally, score = live.tally, self._score
        total, heading, inclination = tally.rms_deg.tolist()
        values = {
            "estimates compared": str(tally.count),
            "total error, RMS (deg)": f"{total:.4g}",
            "heading error, RMS (deg)": f"{heading:.4g}",
            "inclination error, RMS (deg)": f"{inclination:.4g}",
            "total error, largest (deg)": f"{tally.largest_deg[0]:.4g}",
        }
        if score is not None and score.lag_s is not None:
            values["lag (s)"] = f"{score.lag_s:+.4g}"
        if score is not None and (bias := score.gyro_bias_rad_s):
            values["gyro bias error, RMS of the second half (rad/s)"] = f"{bias.rms:.4g}"
        values |= {f"finding {finding.code}": finding.message for finding in self._findings}
        fault = self._fault or live.left_out().get(UNUSABLE, "")
        if fault:
            return DiagnosticStatus.ERROR, fault, values
        # that the run is still shorter than a limit is no fault yet
        broken = [sentence for sentence in tally.broken() if "above the limit" in sentence]
        if broken:
            return DiagnosticStatus.ERROR, "; ".join(broken), values
        codes = ", ".join(dict.fromkeys(finding.code for finding in self._findings))
        level = DiagnosticStatus.WARN if codes else DiagnosticStatus.OK
        return level, f"{total:.4g}° RMS{f'; found: {codes}' if codes else ''}", values
