"""The equations of motion against the principle they come from: the action is extremal among curves on the group.

Nothing here uses Euler's equations but to make the curve that is tried: L is evaluated from the matrices A and Ȧ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from sample_groups import GROUPS, random_body
from scipy.integrate import solve_ivp
from scipy.linalg import expm

DURATION = 1.2
SOME = pytest.mark.parametrize("name", ["SO3", "SO4", "SU2", "SU3", "SE2", "affine line"])
SIZES = np.logspace(-3.0, -1.5, 4)


class Curve(NamedTuple):
    """A curve on the group at the nodes of a quadrature: times, weights, A and ω."""

    times: np.ndarray
    weights: np.ndarray
    elements: np.ndarray
    rates: np.ndarray


def curve(body, acceleration):
    """The curve with Ȧ = A hat ω and the given law for ω̇, from a random start."""
    group, rng = body.group, np.random.default_rng(51)
    d, n = group.dimension, group.size
    x, weights = np.polynomial.legendre.leggauss(36)
    times = 0.5 * DURATION * (x + 1.0)

    def law(_, y):
        w, a = y[:d].real, y[d:].reshape(n, n)
        return np.concatenate([acceleration(w), (a @ group.hat(w)).ravel()])

    start = np.concatenate([rng.normal(size=d), group.random(rng).ravel()])
    y = solve_ivp(law, (0.0, DURATION), start, t_eval=times, method="DOP853", rtol=1e-12, atol=1e-13, max_step=0.1).y
    return Curve(times, 0.5 * DURATION * weights, y[d:].T.reshape(-1, n, n), y[:d].T.real)


def variation(d, times, seed):
    """A random η(t) that vanishes at both ends, and its rate."""
    modes = np.pi / DURATION * np.arange(1, 4)[:, np.newaxis]
    shape = np.random.default_rng(seed).normal(size=(3, d))
    return np.sin(modes * times).T @ shape, (modes * np.cos(modes * times)).T @ shape


def action(body, path, eta, eta_rate, size):
    """∫ L dt of A exp(ε hat η), from the matrix and its time derivative, which is exact by the block exponential."""
    group, n = body.group, body.group.size
    x, y = size * group.hat(eta), size * group.hat(eta_rate)
    both = expm(np.block([[x, y], [np.zeros_like(x), x]]))
    turn, turn_rate = both[..., :n, :n], both[..., :n, n:]
    element = path.elements @ turn
    element_rate = path.elements @ (group.hat(path.rates) @ turn + turn_rate)
    w = group.vee(np.linalg.solve(element, element_rate))
    return path.weights @ (0.5 * np.einsum("ta,ab,tb->t", w, body.metric, w))


def action_changes(body, path, eta, eta_rate):
    """What the action changes by, ahead and behind, for each of the sizes."""
    values = {size: action(body, path, eta, eta_rate, size) for size in (0.0, *SIZES, *-SIZES)}
    return np.array([values[s] - values[0.0] for s in SIZES]), np.array([values[-s] - values[0.0] for s in SIZES])


def first_order(ahead, behind):
    """The derivative of the action by ε: what is odd in ε is of first and third order, and two sizes part the two."""
    small, large = (0.5 * (ahead - behind) / SIZES)[:2]
    ratio = (SIZES[1] / SIZES[0]) ** 2
    return (ratio * small - large) / (ratio - 1.0)


def slope(changes):
    return np.polyfit(np.log(SIZES), np.log(np.abs(changes)), 1)[0]


@pytest.mark.long
@SOME
def test_the_action_is_extremal(name):
    body, _ = random_body(GROUPS[name], 52)
    path = curve(body, body.acceleration)
    for seed in range(3):
        ahead, behind = action_changes(body, path, *variation(body.group.dimension, path.times, seed))
        assert abs(first_order(ahead, behind)) < 5e-9
        assert slope(0.5 * (ahead + behind)) == pytest.approx(2.0, abs=0.02)
        assert slope(ahead) == pytest.approx(2.0, abs=0.1)


@SOME
@pytest.mark.parametrize("factor", [-1.0, 0.0, 1.001])
def test_it_is_not_for_other_equations(name, factor):
    """With factor·ω̇ the action changes in first order, by (1 − factor) ∫ η·ṗ dt, if the variation follows ṗ."""
    body, _ = random_body(GROUPS[name], 52)
    path = curve(body, lambda w: factor * body.acceleration(w))
    bump, bump_rate = np.sin(np.pi * path.times / DURATION), np.pi / DURATION * np.cos(np.pi * path.times / DURATION)
    pushed = (path.weights * bump) @ body.momentum_rate(path.rates)
    along = pushed / np.linalg.norm(pushed)
    changes = action_changes(body, path, np.outer(bump, along), np.outer(bump_rate, along))
    assert np.linalg.norm(pushed) > 0.1
    assert first_order(*changes) == pytest.approx((1.0 - factor) * np.linalg.norm(pushed), rel=1e-4)
