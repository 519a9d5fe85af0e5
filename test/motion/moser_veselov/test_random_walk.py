"""How the errors of the Moser–Veselov steps grow, long before a state in doubles shows them.

A sample is rounded to 1e-16, more than the errors of some millions of steps. So the double-double state behind it is
compared here with an enclosure of the true one: by the angle of the body about its momentum, and by where on its orbit
the momentum is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.moser_veselov.records import StepperState

pytest.importorskip("flint", reason="python-flint is not installed")
from lie_rigid_body.proof import enclose

BODY = RigidBody([0.6, 0.8, 1.0])
START = State([0, 0, 0, 1], [1.8 / 0.6, 0.4 / 0.8, -0.9])
LONG_STEP_NS, SHORT_STEP_NS = 70_000_000, 10_000_000
"""Of 0.22 rad, near the largest, whose errors soon show, and of the 0.03 rad that the limits are given for."""


class Drift(NamedTuple):
    """Errors of one state: the angle about the momentum, rad, and the time by which the momentum is ahead, s."""

    angle: float
    time: float


def starts(count: int) -> list[State]:
    """States along the motion: the same orbit, but for the last bits of its constants."""
    states = ClosedForm(BODY, START).at(np.random.default_rng(1).integers(0, 10**12, size=count))
    return [states[i] for i in range(count)]


def drifts(start: State, step_ns: int, numbers: list[int]) -> list[Drift]:
    """The drift after these numbers of steps."""
    chart, found = MovingChart(BODY, start, max_step=1e-9 * step_ns), []
    for number in numbers:
        chart.at(number * step_ns)
        found.append(drift(chart._reached[0], start, number * step_ns))
    return found


def drift(state: StepperState, start: State, t_ns: int) -> Drift:
    truth = enclose(BODY.inertia, start.attitude_xyzw, start.body_rate, t_ns, width=1e-28)
    with mp.workdps(40):
        # this body's own axes are those of the stepper, in their order
        momentum, attitude = ([mpf(hi) + mpf(lo) for hi, lo in part] for part in state[:2])
        x, y, z, w = midpoints(truth.attitude_xyzw)
        *vector, scalar = quaternion.product(attitude, (-x, -y, -z, w))
        axis = BODY.angular_momentum(start) / np.linalg.norm(BODY.angular_momentum(start))
        angle = float(2 * mp.fdot(vector, axis.tolist()) / scalar)
        rate = midpoints(truth.body_rate)
        true = [mpf(moment) * w for moment, w in zip(np.diag(BODY.inertia).tolist(), rate, strict=True)]
        length = mp.sqrt(mp.fdot(true, true))
        ahead = np.array([float(m - t / length) for m, t in zip(momentum, true, strict=True)])
        velocity = np.cross([float(t / length) for t in true], [float(w) for w in rate])
        return Drift(angle, float(ahead @ velocity / (velocity @ velocity)))


def midpoints(balls) -> list[mpf]:
    """Midpoints of balls."""
    return [mpf(int(mantissa)) * mpf(2) ** int(exponent) for mantissa, exponent in (x.mid().man_exp() for x in balls)]


def growth(step_ns: int, numbers: list[int], count: int) -> np.ndarray:
    """The exponents with which root mean squares of the angle and of the time grow with the number of steps."""
    runs = np.array([drifts(start, step_ns, numbers) for start in starts(count)])
    rms = np.sqrt(np.mean(runs**2, axis=0))
    return np.polyfit(np.log(numbers), np.log(rms), 1)[0]


@pytest.mark.long
def test_angle_and_momentum_drift_like_a_random_walk():
    exponents = growth(
        LONG_STEP_NS, [1000, 10_000, 100_000] if MovingChart(BODY, START).compile() else [100, 1000, 10_000], 32
    )
    assert 0.3 < exponents.min() < exponents.max() < 0.7


@pytest.mark.slow
def test_ten_million_steps_drift_like_a_random_walk():
    if not MovingChart(BODY, START).compile():
        pytest.skip("1e7 steps need numba")
    of_angle, of_time = growth(SHORT_STEP_NS, [10_000, 100_000, 1_000_000, 10_000_000], 8)
    assert 0.35 < of_angle < 0.65
    assert 0.35 < of_time < 0.65
