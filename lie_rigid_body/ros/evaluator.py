"""The evaluator: the node that follows an estimate and its truth, what it publishes, and the score at its end.

On ``~/error`` it publishes the error of every estimate, on ``/diagnostics`` the score so far.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from rclpy.clock import Clock
from rclpy.node import Node
from rclpy.qos import QoSProfile

from lie_rigid_body.estimates.buffers import UNUSABLE, left_out_sentence
from lie_rigid_body.estimates.live_estimate import INTERIM, LiveEstimate
from lie_rigid_body.evaluation import AttitudeError, Finding, Limits, Score
from lie_rigid_body.evaluation.consistency import require_axes
from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.foundation.parameters import Given, exact_duration
from lie_rigid_body.foundation.wording import in_degrees, suggestion
from lie_rigid_body.messages.layout import Layout, header
from lie_rigid_body.report.score_options import answer
from lie_rigid_body.ros.control.parameters import overrides
from lie_rigid_body.ros.following import Following
from lie_rigid_body.ros.publishing.diagnostics import DIAGNOSTICS_TOPIC, Status, report
from lie_rigid_body.ros.session import OF_EVERY_NODE, listening, own_node, require_distinct
from lie_rigid_body.system import console
from lie_rigid_body.system.interruption import Interruption

EVALUATOR_NAME: Final = "evaluator"
NODE_PARAMETERS: Final = ("max_rms", "max_after", "duration", "wait", "covariance_axes")
"""Parameters of the evaluator's node, which win over the options of the same names."""
TICK_S: Final = 0.05
"""Time between two looks at what has come, s."""
GRAPH_S: Final = (0.25, 2.0)
"""Time between two searches for topics, s, before and after the comparison has begun."""
WORD_S: Final = (5.0, 30.0)
"""Time until the first line about what is missing, and between two later lines, s."""
LAST_POSE_S: Final = 5.0
"""Longest wait for the poses up to the end of the last estimate, which come on another topic, s."""
ERROR_TOPIC: Final = "~/error"
ERRORS_KEPT: Final = 1000
INTERVAL_S: Final = 1.0
"""Time between two reports on /diagnostics, s."""
FIRST_DIAGNOSIS_S: Final = 5.0
"""Shortest estimate, by its stamps, of which a diagnosis is made, s."""
DIAGNOSIS_SHARE: Final = 0.03
"""Largest share of the time spent on diagnoses; one is always made when the time of the estimate has doubled."""
DOUBTFUL_CODES: Final = frozenset({"heading_offset", "body_mounting"})
"""Codes of findings that the slow error of a healthy filter resembles for some seconds."""
PLAIN_DEG: Final = 1.0
"""Median error from which on the findings in `DOUBTFUL_CODES` are told at once, degrees."""


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
        doubtful = DOUBTFUL_CODES if score.total_deg.median < PLAIN_DEG else frozenset()
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
        self._due = time.monotonic() + INTERVAL_S
        self._diagnosis_due = np.inf
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
            if live.tally.span_s >= 2.0 * self._diagnosed_s or now >= self._diagnosis_due:
                self._diagnose(live)
            status = self._status(live)
        self._diagnostics.publish(report(self._node, "attitude error", Clock().now().to_msg(), *status))

    def _diagnose(self, live: LiveEstimate) -> None:
        begin = time.monotonic()
        self._diagnosed_s = live.tally.span_s
        try:
            self._score = live.score(INTERIM)[1]
            self._fault = ""
            self._findings = self._confirmed.findings(self._score, self._diagnosed_s)
        except LieRigidBodyError as error:
            self._score = None
            self._findings = ()
            self._fault = str(error)
        end = time.monotonic()
        self._diagnosis_due = end + max(INTERVAL_S, (end - begin) / DIAGNOSIS_SHARE)

    def _status(self, live: LiveEstimate) -> Status:
        tally = live.tally
        score = self._score
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
        return level, f"{in_degrees(total)} RMS{f'; found: {codes}' if codes else ''}", values


def evaluate(given: argparse.Namespace, interruption: Interruption) -> int:
    """Follow the topics of a command line; return the exit status, as `ros.evaluate.main` tells it."""
    with own_node(EVALUATOR_NAME, given.ros) as node, listening(node) as spin:
        _override(given, overrides(node))
        limits = Limits.parse(given.max_rms, tuple(given.max_after))
        axes = given.covariance_axes
        require_axes(axes)
        begin = partial(LiveEstimate, limits=limits, duration_s=given.duration, covariance_axes=axes)
        following = Following(node, spin, begin)
        complete = _follow(node, following, given, interruption)
        missing = following.silence()
    return _score(given, following, missing, complete)


def _override(given: argparse.Namespace, parameters: Given) -> None:
    """Take the parameters of the node, which win over the options of the same names."""
    for name, value in parameters.items():
        if name not in NODE_PARAMETERS:
            raise InputError(f"parameter {name} is unknown: {suggestion(name, NODE_PARAMETERS, 'parameters')}")
        many = value if isinstance(value, (list, tuple)) else [value]
        texts = {"max_rms": str(value), "max_after": [str(each) for each in many]}
        setattr(given, name, texts.get(name, value))
    for name in ("duration", "wait"):
        value = getattr(given, name)
        if value is not None:
            exact_duration(value, name, "60.0")


def _follow(node: Node, following: Following, given: argparse.Namespace, interruption: Interruption) -> bool:
    """Listen until asked to end; return False if that was before an estimate came."""
    scores = Scores(node)
    complaints = set[str]()
    compared = 0
    compared_at = time.monotonic()
    look_at = 0.0
    word_at = time.monotonic() + WORD_S[0]
    _say(f"{node.get_fully_qualified_name()} waits for {following.estimate}; Ctrl-C ends it")
    was_still = False
    complete_at = np.inf
    while True:
        requested = interruption.requested  # what came before it is in the score
        now = time.monotonic()
        if now >= look_at:
            following.look()
            look_at = time.monotonic() + GRAPH_S[compared > 0]
        following.take()
        live = following.live
        if live is not None:
            judged = live.judge()
            if judged is not None:
                scores.errors(*judged)
            if live.tally.count != compared:
                if not compared:
                    _say(f"comparing {following.estimate} with the truth")
                compared = live.tally.count
                compared_at = now
            left_out = live.left_out()
            for kind in left_out.keys() - complaints:  # as soon as there is one
                complaints.add(kind)
                _say(left_out[kind])
        if not compared and now > word_at:
            word_at = now + WORD_S[1]
            _say(f"still waiting: {following.silence()}")
        is_still = compared > 0 and now - compared_at > WORD_S[0]
        if is_still and not was_still:
            _say(f"still waiting: {following.stop()}; Ctrl-C ends it with the score")
        was_still = is_still
        scores.report(live, following.silence)
        if requested:
            return live is not None and live.messages > 0
        if live is not None and live.is_complete:
            complete_at = min(complete_at, now)
            if live.has_its_truth or now - complete_at > LAST_POSE_S:
                return True
        if given.wait and now - compared_at > given.wait:
            return True
        time.sleep(TICK_S)


def _say(text: str) -> None:
    """A line on stderr: stdout is for the score."""
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def _score(given: argparse.Namespace, following: Following, missing: str, complete: bool) -> int:
    live = following.live
    if not complete:
        console.complain(console.program("evaluate"), f"interrupted: {missing}")
        return console.INTERRUPTED
    if live is None or not live.messages or not live.truth.is_known:
        raise InputError(missing)
    read, score = live.score()
    read = replace(read, notes=(*read.notes, *following.notes()))
    status = answer(given, "", [(read, score)])
    if UNUSABLE in live.estimate.faults:
        stamps = live.estimate.scorable()[1][UNUSABLE]
        which = f"{len(stamps)} of {live.estimate.count} estimates"
        console.complain(console.program("evaluate"), left_out_sentence(UNUSABLE, which, stamps))
        return console.UNUSABLE
    return status
