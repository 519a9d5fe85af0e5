"""The evaluator: the node that follows an estimate and its truth, and the score at its end."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Final

from rclpy.node import Node

from lie_rigid_body import console
from lie_rigid_body.errors import InputError
from lie_rigid_body.estimates.kept import UNUSABLE
from lie_rigid_body.estimates.live_estimate import LiveEstimate
from lie_rigid_body.evaluation import Limits
from lie_rigid_body.evaluation.consistency import require_axes
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.parameters import exact_duration
from lie_rigid_body.report.request import answer
from lie_rigid_body.ros.control.parameters import overrides
from lie_rigid_body.ros.following import Following
from lie_rigid_body.ros.publishing.scores import Scores
from lie_rigid_body.ros.session import own_node
from lie_rigid_body.wording import suggestion

EVALUATOR_NAME: Final = "evaluator"
NODE_PARAMETERS: Final = ("max_rms", "max_after", "duration", "wait", "covariance_axes")
"""Parameters of the evaluator's node, which win over the options of the same names."""
TICK_S: Final = 0.05
"""Time between two looks at what has come, s."""
GRAPH_S: Final = (0.25, 2.0)
"""Time between two searches for topics, s, before and after the comparison has begun."""
WORD_S: Final = (5.0, 30.0)
"""Time until the first line about what is missing, and between two later lines, s."""


def evaluate(given: argparse.Namespace, interruption: Interruption) -> int:
    """Follow the topics of a command line; return the exit status, as `ros.evaluate.main` tells it."""
    with own_node(EVALUATOR_NAME, given.ros) as node:
        _override(given, overrides(node))
        limits, axes = Limits.parse(given.max_rms, tuple(given.max_after)), given.covariance_axes
        require_axes(axes)
        begin = partial(LiveEstimate, limits=limits, duration_s=given.duration, covariance_axes=axes)
        following = Following(node, begin)
        complete = _follow(node, following, given, interruption)
        missing = following.silence()
    return _score(given, following, missing, complete)


def _override(given: argparse.Namespace, parameters: Mapping[str, object]) -> None:
    """Take the parameters of the node, which win over the options of the same names."""
    for name, value in parameters.items():
        if name not in NODE_PARAMETERS:
            raise InputError(f"parameter {name} is unknown: {suggestion(name, NODE_PARAMETERS, 'parameters')}")
        if name == "max_rms":
            given.max_rms = str(value)
        elif name == "max_after":
            given.max_after = [str(v) for v in value] if isinstance(value, (list, tuple)) else [str(value)]
        else:
            setattr(given, name, value)
    for name in ("duration", "wait"):
        value = getattr(given, name)
        if value is not None:
            exact_duration(value, name, "60.0")


def _follow(node: Node, following: Following, given: argparse.Namespace, interruption: Interruption) -> bool:
    """Listen until asked to end; return False if that was before an estimate came."""
    scores, complaints = Scores(node), set[str]()
    compared, compared_at, look_at, word_at = 0, time.monotonic(), 0.0, time.monotonic() + WORD_S[0]
    _say(f"{node.get_fully_qualified_name()} waits for {following.estimate}; Ctrl-C ends it")
    was_still = False
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
                compared, compared_at = live.tally.count, now
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
        if live is not None and live.estimate.complete:
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
    if live.estimate.number_of(UNUSABLE):
        console.complain(console.program("evaluate"), f"estimate: {live.left_out()[UNUSABLE]}")
        return console.UNUSABLE
    return status
