"""Motions, their exact truth, and noise, that an estimate is made of."""

from __future__ import annotations

import numpy as np

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.evaluation import ExactTruth
from lie_rigid_body.lie import quaternion

START = [0.1, -0.3, 0.2, np.sqrt(1.0 - 0.14)]
MOTIONS = {
    "dzhanibekov": ClosedForm(RigidBody([1.0, 2.0, 3.0]), State(START, [0.01, 1.0, 0.01])),
    "precession": ClosedForm(RigidBody([1.0, 1.0, 0.5]), State(START, [0.6, 0.0, 1.5])),
    "slow_tumble": ClosedForm(RigidBody([0.04, 0.05, 0.06]), State(START, [0.2, 0.3, -0.15])),
    "fast_tumble": ClosedForm(RigidBody([1.0, 2.0, 2.5]), State(START, [3.0, 2.0, -4.0])),
}
PERIOD_NS = 20_000_000
STAMPS = np.arange(1501) * PERIOD_NS


UNTOLD = "this motion does not tell it from "
"""Words of a finding beside which another cause is as likely."""
CLOCK = r"runs (\S+) times as (fast|slow) as"
"""Words of a finding about the rate of a clock."""
PLACES = "its x, y, z are "
"""Words of a mounting that only changes places and signs of the axes."""


def truth_of(motion: str) -> ExactTruth:
    return ExactTruth(lambda t_ns: MOTIONS[motion].at(t_ns).attitude_xyzw, 0, int(STAMPS[-1]))


def attitude(motion: str, lag_s: float = 0.0) -> np.ndarray:
    return MOTIONS[motion].at(STAMPS - round(lag_s * 1e9)).attitude_xyzw


def turns(size_deg: float, seed: int, count: int = len(STAMPS)) -> np.ndarray:
    """Small random rotations, Gaussian, of a standard deviation on each axis."""
    return quaternion.exp(np.random.default_rng(seed).normal(size=(count, 3)) * np.radians(size_deg))


def about_up(angle_deg: float) -> np.ndarray:
    return quaternion.exp([0.0, 0.0, np.radians(angle_deg)])


def codes(score) -> list[str]:
    return [finding.code for finding in score.findings]


def correlated(draws: np.random.Generator, count: int, memory: float) -> np.ndarray:
    """Three stationary processes of first order, of variance 1 each, shape (count, 3)."""
    from scipy.signal import lfilter  # slow to load

    steps = draws.normal(size=(count, 3)) * np.sqrt(1.0 - memory**2)
    steps[0] /= np.sqrt(1.0 - memory**2)
    return lfilter([1.0], [1.0, -memory], steps, axis=0)


NED, FRD = [np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
MOUNTING = quaternion.exp([0.1, 0.2, -0.3])
FAULTS = {
    "inverted": quaternion.conjugate,
    "scalar_first": lambda q: np.roll(q, 1, axis=-1),
    "ned_world": lambda q: quaternion.multiply(NED, q),
    "heading_offset": lambda q: quaternion.multiply(about_up(-12.0), q),
    "body_mounting": lambda q: quaternion.multiply(q, MOUNTING),
}
"""What becomes of right attitudes, by the name of the finding."""
