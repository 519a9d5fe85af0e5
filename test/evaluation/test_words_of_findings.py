"""The words of findings: one estimate for each, and parts of the sentence that is said of it.

All other tests of this folder assert on codes, and on the numbers in sentences.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from motions import PLACES, STAMPS, UNTOLD, about_up, attitude, truth_of
from test_turning import CYCLED, SWAPPED, UNCHANGED, remarks_on

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation import ExactTruth, SampledTruth, Truth, evaluate
from lie_rigid_body.evaluation.remarks import DEGREE
from lie_rigid_body.lie import quaternion

Given = tuple[np.ndarray, np.ndarray, Truth]
MOTION = "slow_tumble"
TRUE = attitude(MOTION)
NED, FRD = [np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
EVERY = np.arange(len(STAMPS))


def of(estimate: np.ndarray, kept: np.ndarray = EVERY) -> Given:
    """An estimate at some of the stamps, and the truth."""
    return STAMPS[kept], estimate[kept], truth_of(MOTION)


def alternating() -> np.ndarray:
    return np.where(EVERY[:, np.newaxis] % 2, TRUE[::-1], TRUE)


def coarse() -> Given:
    fast = attitude("fast_tumble")
    return STAMPS, fast, SampledTruth(STAMPS[::20], fast[::20])


def spinning() -> Given:
    spin = ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0]))
    truth = ExactTruth(lambda t_ns: spin.at(t_ns).attitude_xyzw, 0, int(STAMPS[-1]))
    return STAMPS, quaternion.multiply(about_up(4.0), spin.at(STAMPS).attitude_xyzw), truth


WORDS: dict[str, tuple[Callable[[], Given], str, tuple[str, ...]]] = {
    "inverse": (
        lambda: of(quaternion.conjugate(TRUE)),
        "inverted",
        ("it takes world vectors to the body: publish its conjugate, -x -y -z w", "median error "),
    ),
    "scalar first": (
        lambda: of(np.roll(TRUE, 1, axis=-1)),
        "scalar_first",
        ("scalar first, w x y z, where x y z w is read: move the first number to the end",),
    ),
    "NED": (
        lambda: of(quaternion.multiply(NED, TRUE)),
        "ned_world",
        ("The world of the estimate is north-east-down: multiply it on the left by (√½, √½, 0, 0)",),
    ),
    "NED and FRD": (
        lambda: of(quaternion.multiply(quaternion.multiply(NED, TRUE), FRD)),
        "ned_world",
        ("north-east-down and its body forward-right-down", ", and on the right by (1, 0, 0, 0)"),
    ),
    "heading": (
        lambda: of(quaternion.multiply(about_up(-12.0), TRUE)),
        "heading_offset",
        ("-12° about the vertical: turn the estimate by +12° about the world's z axis", "magnetic declination"),
    ),
    "mounting": (
        lambda: of(quaternion.multiply(TRUE, quaternion.exp([0.0, 0.0, np.pi / 2]))),
        "body_mounting",
        ("are turned by 90° about (0, 0, 1) of the body", f"-0.707107, 0.707107); {PLACES}y, -x, z of the body"),
    ),
    "late": (
        lambda: of(attitude(MOTION, 0.5)),
        "lagging",
        ("is late by 0.5 s, 25 of its samples: stamp it with the time of the readings it is made of",),
    ),
    "ahead": (
        lambda: of(attitude(MOTION, -0.5)),
        "leading",
        ("is ahead by 0.5 s, 25 of its samples: stamp it with the end of the last gyro step it contains",),
    ),
    "world": (
        lambda: of(quaternion.multiply(quaternion.exp([0.0, np.pi / 3, 0.0]), TRUE)),
        "world_turned",
        ("is turned by 60° about (0, 1, 0) of the world: see whether nothing corrects a wrong first attitude",),
    ),
    "stuck": (
        lambda: of(np.tile(TRUE[:1], (len(STAMPS), 1))),
        "stuck",
        (
            "turns by 0° from 0 s to 30 s after its first stamp, the body by ",
            "see whether the filter gets its readings",
        ),
    ),
    "stuck for a while": (
        lambda: of(TRUE[np.where((EVERY >= 100) & (EVERY < 700), 100, EVERY)]),
        "stuck",
        ("turns by 0° from 2 s to 13.98 s after its first stamp, the body by ",),
    ),
    "spin": (spinning, "heading_offset", (f"; {UNTOLD}body mounting or lag.",)),
    "mixed": (lambda: of(alternating()), "mixed", ("its samples are of two attitudes in turns",)),
    "gap": (
        lambda: of(TRUE, np.delete(EVERY, slice(200, 300))),
        "gaps",
        ("1 gap in the estimate, the longest of 2.02 s after 3.98 s, where samples come every 0.02 s",),
    ),
    "doubles": (lambda: of(TRUE, np.repeat(EVERY, 2)), "gaps", ("1501 of 3002 samples are doubles",)),
    "late begin": (
        lambda: of(TRUE, EVERY[600:]),
        "gaps",
        ("begins 12 s after the truth: that part of the run",),
    ),
    "early end": (lambda: of(TRUE, EVERY[:900]), "gaps", ("The estimate ends 12.02 s before the run does",)),
    "coarse truth": (coarse, "gaps", ("Samples of the truth are so far apart", "give the truth at a higher rate")),
    "norm": (
        lambda: of(1.01 * TRUE),
        "not_unit",
        ("1501 of 1501 quaternions are not of unit norm, the worst has 1.01",),
    ),
}
"""Estimates, each with the code and parts of the sentence of its first finding."""


@pytest.mark.parametrize("case", WORDS)
def test_a_finding_says_what_is_wrong_and_what_to_do(case: str) -> None:
    given, code, words = WORDS[case]
    finding = evaluate(*given()).findings[0]
    assert finding.code == code
    assert [part for part in words if part not in finding.message] == []


TURNS = {
    "The estimate turns 57.3 times as fast as the body: its gyro is in deg/s where the filter wants rad/s; ": (
        DEGREE * UNCHANGED
    ),
    "The estimate turns 57.3 times as slow as the body: its gyro is in rad/s where the filter wants deg/s; ": (
        UNCHANGED / DEGREE
    ),
    "The estimate turns 2 times as fast as the body: the rate of a quaternion is ½ q ω, or ": 2.0 * UNCHANGED,
    "The estimate turns 10 times as fast as the body: see the time step of the filter, and the unit ": 10.0 * UNCHANGED,
    "The estimate turns 3.33 times as slow as the body: see the time step ": 0.3 * UNCHANGED,
    "The estimate turns about x, y, z as the body does about y, x, z: give the filter its gyro on the axes of the "
    "body, which are right-handed; these are not; a mistake in its readings does the same, which ": SWAPPED,
    "The estimate turns about x, y, z as the body does about z, x, y: give the filter its gyro on the axes of the "
    "body; ": CYCLED,
    "The estimate turns about x, y, z as the body does about y, x, z, 57.3 times as fast as the body: give ": (
        DEGREE * SWAPPED
    ),
}
"""Beginnings of remarks, each with the matrix by which a gyro reads the turns of a body."""


@pytest.mark.parametrize("said", TURNS)
def test_a_remark_on_turns_says_what_is_wrong_with_the_gyro(said: str) -> None:
    [remark] = remarks_on(TURNS[said])
    assert remark.message.startswith(said)
