"""The equations of motion against the principle they come from: the action is extremal among curves on the group.

Nothing here uses Euler's equations but to make the curve that is tried: L is evaluated from the matrices A and Ȧ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from group_bodies import affine_line, diagonal_body, random_metric, rigid_motions_of_the_plane
from mpmath import mp
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from lie_rigid_body.groups import SO, SU, Lagrangian, metric_at

DURATION = 1.2
PANELS = 3
GROUPS = {
    "SO3": SO(3),
    "SO4": SO(4),
    "SU2": SU(2),
    "SU3": SU(3),
    "SE2": rigid_motions_of_the_plane(),
    "affine line": affine_line(),
}
SIZES = np.logspace(-3.0, -1.5, 4)


class Curve(NamedTuple):
    """A curve on the group at the nodes of a quadrature: times, weights, A and ω."""

    times: np.ndarray
    weights: np.ndarray
    elements: np.ndarray
    rates: np.ndarray


def nodes():
    """Gauss's nodes and weights, 12 on each panel of [0, T]."""
    x, w = np.polynomial.legendre.leggauss(12)
    width = DURATION / PANELS
    starts = width * np.arange(PANELS)[:, np.newaxis]
    return (starts + 0.5 * width * (x + 1.0)).ravel(), np.tile(0.5 * width * w, PANELS)


def curve(body, acceleration):
    """The curve with Ȧ = A hat ω and the given law for ω̇, from a random start."""
    group, rng = body.group, np.random.default_rng(51)
    d, n = group.dimension, group.size
    times, weights = nodes()

    def law(_, y):
        w, a = y[:d].real, y[d:].reshape(n, n)
        return np.concatenate([acceleration(w), (a @ group.hat(w)).ravel()])

    start = np.concatenate([rng.normal(size=d), group.random(rng).ravel()])
    y = solve_ivp(law, (0.0, DURATION), start, t_eval=times, method="DOP853", rtol=1e-12, atol=1e-13, max_step=0.1).y
    return Curve(times, weights, y[d:].T.reshape(-1, n, n), y[:d].T.real)


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


def random_body(name):
    group = GROUPS[name]
    return Lagrangian(group, random_metric(np.random.default_rng(52), group.dimension))


@pytest.mark.long
@pytest.mark.parametrize("name", GROUPS)
def test_the_action_is_extremal(name):
    body = random_body(name)
    path = curve(body, body.acceleration)
    for seed in range(3):
        ahead, behind = action_changes(body, path, *variation(body.group.dimension, path.times, seed))
        assert abs(first_order(ahead, behind)) < 5e-9
        assert slope(0.5 * (ahead + behind)) == pytest.approx(2.0, abs=0.02)
        assert slope(ahead) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("name", GROUPS)
@pytest.mark.parametrize("factor", [-1.0, 0.0, 1.001])
def test_it_is_not_for_other_equations(name, factor):
    """With factor·ω̇ the action changes in first order, by (1 − factor) ∫ η·ṗ dt, if the variation follows ṗ."""
    body = random_body(name)
    path = curve(body, lambda w: factor * body.acceleration(w))
    bump, bump_rate = np.sin(np.pi * path.times / DURATION), np.pi / DURATION * np.cos(np.pi * path.times / DURATION)
    pushed = (path.weights * bump) @ body.momentum_rate(path.rates)
    along = pushed / np.linalg.norm(pushed)
    changes = action_changes(body, path, np.outer(bump, along), np.outer(bump_rate, along))
    assert np.linalg.norm(pushed) > 0.1
    assert first_order(*changes) == pytest.approx((1.0 - factor) * np.linalg.norm(pushed), rel=1e-4)


def exact(array):
    return np.vectorize(mp.mpmathify, otypes=[object])(array)


def with_derivative(x, y, terms):
    """exp(x) and its derivative along y, by the power series."""
    unit = exact(np.eye(len(x)))
    power, power_rate, total, total_rate = unit, 0 * unit, unit, 0 * unit
    for k in range(1, terms):
        power, power_rate = power @ x / k, (power_rate @ x + power @ y) / k
        total, total_rate = total + power, total_rate + power_rate
    return total, total_rate


class ExactChart:
    """L(α, α̇) in the chart exp(αᵃTᵃ)A₀ at 60 digits, from A and Ȧ."""

    def __init__(self, body, start):
        t = exact(body.group.generators)
        self.t, self.metric = t, exact(body.metric)
        self.square = np.real(np.sum(body.group.generators[0] * body.group.generators[0].conj()))
        self.centre, _ = with_derivative(self.hat(start), 0 * t[0], 80)
        self.back, _ = with_derivative(-self.hat(start), 0 * t[0], 80)

    def hat(self, x):
        return np.tensordot(exact(x), self.t, axes=1)

    def vee(self, x):
        return np.array([mp.re(-np.trace(t @ x) / self.square) for t in self.t])

    def value(self, alpha, alpha_rate):
        _, turn_rate = with_derivative(self.hat(alpha), self.hat(alpha_rate), 8)
        unturn, _ = with_derivative(-self.hat(alpha), 0 * self.t[0], 8)
        w = self.vee(self.back @ unturn @ turn_rate @ self.centre)
        return w @ self.metric @ w / 2

    def gradient(self, function, at):
        """Central differences, which leave 1e-24."""
        h = mp.mpf(10) ** -12
        units = h * exact(np.eye(len(at)))
        return np.array([(function(at + e) - function(at - e)) / (2 * h) for e in units])


@pytest.mark.parametrize(
    ("group", "seed"), [(SO(3), 0), (SO(3), 1), (SO(4), 2), (SU(2), 3)], ids=["SO3", "SO3 again", "SO4", "SU2"]
)
def test_euler_and_lagrange_in_the_papers_chart_at_60_digits(group, seed):
    rng = np.random.default_rng(seed)
    body, start, w = Lagrangian(group, random_metric(rng, group.dimension)), *rng.normal(size=(2, group.dimension))
    there = Lagrangian(group, metric_at(body, group.exp(start)))
    with mp.workdps(60):
        chart, still = ExactChart(body, start), exact(np.zeros(group.dimension))
        rate = exact(w)
        force = chart.gradient(lambda alpha: chart.value(alpha, rate), still)
        momenta = chart.gradient(lambda alpha_rate: chart.value(still, alpha_rate), rate)
        f = exact(np.round(2.0 * group.structure_constants)) / 2
        # the formulas under test at 60 digits, from the metric of the chart
        columns = np.array([chart.vee(chart.back @ t @ chart.centre) for t in chart.t])
        metric = columns @ chart.metric @ columns.T
        torque = np.einsum("cad,c,d->a", f, rate, momenta, optimize=False)
        bend = np.array(list(mp.lu_solve(mp.matrix(metric.tolist()), mp.matrix(torque.tolist()))))

        def momenta_at(time):
            alpha, alpha_rate = rate * time + bend * time**2 / 2, rate + bend * time
            return chart.gradient(lambda v: chart.value(alpha, v), alpha_rate)

        h = mp.mpf(10) ** -12
        left_over = (momenta_at(h) - momenta_at(-h)) / (2 * h) - force
        assert max(abs(x) for x in left_over) < 1e-20
        assert max(abs(x) for x in force - torque / 2) < 1e-20
        assert max(abs(x) for x in force) > 1e-2
        assert max(abs(x) for x in bend) > 1e-2
    for ours, theirs in (
        (there.chart_force(w), force),
        (there.momenta(w), momenta),
        (there.acceleration(w), bend),
        (there.metric, metric),
        (there.value(w), rate @ momenta / 2),
    ):
        np.testing.assert_allclose(ours, np.asarray(theirs, dtype=float), rtol=0, atol=1e-12)


def test_the_kinetic_energy_is_that_of_the_masses():
    """L = ½ Σ m |ẋ|² of point masses in five dimensions, x = A y, is ½ Mᵃᵇωᵃωᵇ with M from K."""
    rng, group = np.random.default_rng(53), SO(5)
    masses, places = rng.uniform(0.1, 2.0, 9), rng.normal(size=(9, 5))
    moments, axes = np.linalg.eigh(np.einsum("m,mi,mj->ij", masses, places, places))
    places = places @ axes
    body = Lagrangian(group, diagonal_body(group, moments))
    a, w = group.random(rng), rng.normal(size=10)
    velocities = places @ (a @ group.hat(w)).T
    assert body.value(w) == pytest.approx(0.5 * np.sum(masses[:, np.newaxis] * velocities**2), rel=1e-13)
