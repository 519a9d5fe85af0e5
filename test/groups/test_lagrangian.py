"""The Lagrangian on a group: Euler's equations for n = 3, the paper's form for compact groups, conservation for all."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sample_groups import COMPACT, GROUPS, random_body

from lie_rigid_body.groups import (
    SO,
    SU,
    U1,
    Lagrangian,
    legendre_transform,
    mass_matrix,
    metric_at,
    product,
    spatial_momentum,
)

seeds = st.integers(0, 2**32 - 1)


def random_case(group, seed):
    body, rng = random_body(group, seed)
    return body, rng.normal(size=(5, group.dimension))


@given(seeds)
def test_on_so3_they_are_eulers_equations(seed):
    body, w = random_case(SO(3), seed)
    torque = np.cross(w @ body.metric, w)
    np.testing.assert_allclose(body.momentum_rate(w), torque, rtol=0, atol=1e-13 * np.abs(w).max() ** 2)
    np.testing.assert_allclose(
        body.acceleration(w), np.linalg.solve(body.metric, torque.T).T, rtol=0, atol=1e-12 * np.abs(w).max() ** 2
    )


@pytest.mark.parametrize("name", COMPACT)
def test_for_compact_groups_they_are_the_papers_equations(name):
    body, w = random_case(COMPACT[name], 1)
    f = body.group.structure_constants
    paper = np.einsum("adc,db,nb,nc->na", f, body.metric, w, w)
    np.testing.assert_allclose(
        body.acceleration(w) @ body.metric, paper, rtol=0, atol=1e-13 * (1 + np.abs(paper).max())
    )


@pytest.mark.parametrize("name", GROUPS)
def test_momentum_pairs_with_the_bracket(name):
    """ṗ is defined by ⟨ṗ, η⟩ = ⟨p, [ω, η]⟩, the bracket being that of the matrices."""
    group = GROUPS[name]
    body, w = random_case(group, 2)
    p, rate = body.momenta(w), body.momentum_rate(w)
    for eta, component in zip(np.eye(group.dimension), rate.T, strict=True):
        x, y = group.hat(w), group.hat(eta)
        bracket = group.vee(x @ y - y @ x)
        np.testing.assert_allclose(
            component, np.sum(p * bracket, axis=-1), rtol=0, atol=1e-12 * (1 + np.abs(rate).max())
        )


class PapersChart:
    """L in the chart exp(αᵃTᵃ)A₀, with the metric of the space frame at the point of the chart."""

    def __init__(self, body, centre):
        self.body, self.group, self.centre = body, body.group, centre

    def energy(self, alpha, rate):
        """½ M(α) of a rate in the space frame."""
        return 0.5 * rate @ metric_at(self.body, self.group.exp(alpha) @ self.centre) @ rate

    def value(self, alpha, alpha_rate):
        return self.energy(alpha, self.group.dexp(alpha) @ alpha_rate)

    def slopes(self, function, h=1e-4):
        return np.array([function(h * e) - function(-h * e) for e in np.eye(self.group.dimension)]) / (2 * h)


HALVED = {**GROUPS, "U1×SU2×SU3": product(U1(), SU(2), SU(3))}


@pytest.mark.parametrize("name", HALVED)
def test_derivatives_at_constant_chart_velocity_are_half_of_those_at_constant_rate(name):
    """The two halves of the equations of motion: of ∂L/∂α (16), (18), and of d/dt ∂L/∂α̇ (20), on the motion."""
    group = HALVED[name]
    body, rng = random_body(group, 7)
    w = rng.normal(size=group.dimension)
    chart = PapersChart(body, group.random(rng))
    there = Lagrangian(group, metric_at(body, chart.centre))
    scale = 1e-6 * (1.0 + np.abs(there.metric).max() * np.abs(w).max() ** 2)
    constant_rate = chart.slopes(lambda alpha: chart.energy(alpha, w))
    constant_velocity = chart.slopes(lambda alpha: chart.value(alpha, w))
    np.testing.assert_allclose(constant_rate, there.momentum_rate(w), rtol=0, atol=scale)
    np.testing.assert_allclose(constant_velocity, there.chart_force(w), rtol=0, atol=scale)
    np.testing.assert_allclose(constant_velocity, 0.5 * constant_rate, rtol=0, atol=scale)
    bend, h = there.acceleration(w), 1e-4

    def momenta(t):
        return chart.slopes(lambda v: chart.value(t * w + 0.5 * t**2 * bend, w + t * bend + v), 1e-2)

    left = (momenta(h) - momenta(-h)) / (2 * h)
    np.testing.assert_allclose(left, there.metric @ bend - there.chart_force(w), rtol=0, atol=10 * scale)
    np.testing.assert_allclose(left, constant_velocity, rtol=0, atol=10 * scale)


@pytest.mark.parametrize("n", [3, 4, 5])
def test_the_force_is_the_trace_of_a_commutator(n):
    """¼ tr(A₀KA₀ᵀ [Tᵃ, {Tᵇ, Tᶜ}]) ωᵇωᶜ, eq. (16), and ½ tr(A₀KA₀ᵀ {Tᵇ, Tᵈ}) fᵃᶜᵈ ωᵇωᶜ in (18)."""
    group, rng = SO(n), np.random.default_rng(n)
    K, A, w = np.diag(rng.uniform(0.2, 1.0, n)), group.random(rng), rng.normal(size=group.dimension)
    turned, W, T = A @ K @ A.T, group.hat(w), group.generators
    square = 2.0 * W @ W
    traces = [0.25 * np.trace(turned @ (t @ square - square @ t)) for t in T]
    both = np.einsum("bij,djk->bdik", T, T) + np.einsum("dij,bjk->bdik", T, T)
    brackets = 0.5 * np.einsum("ij,bdji,acd,b,c->a", turned, both, group.structure_constants, w, w)
    rate = Lagrangian(group, mass_matrix(K, T, A)).momentum_rate(w)
    np.testing.assert_allclose(rate, traces, atol=1e-13)
    np.testing.assert_allclose(rate, brackets, atol=1e-13)


@pytest.mark.parametrize("name", GROUPS)
def test_the_action_of_a_path_is_the_integral_of_its_energy(name):
    """Exact at constant rate, in any unit of time; for exp(t x) exp(t² y) with an error of the order of h²."""
    group = GROUPS[name]
    body, w = random_case(group, 8)
    t = np.linspace(0.0, 0.6, 7)
    straight = group.exp(t[:, np.newaxis] * 0.3 * w[0])
    assert body.action(straight, 0.1) == pytest.approx(0.6 * float(body.value(0.3 * w[0])), rel=1e-12)
    assert body.action(straight, 0.2) == pytest.approx(0.3 * float(body.value(0.3 * w[0])), rel=1e-12)
    x, y = 0.4 * w[1:3]

    def bent(count):
        s = np.linspace(0.0, 1.0, count + 1)[:, np.newaxis]
        return body.action(group.exp(s * x) @ group.exp(s**2 * y), 1.0 / count)

    nodes, weights = np.polynomial.legendre.leggauss(20)
    s = 0.5 * (nodes + 1.0)
    # A⁻¹Ȧ of the product: the first rate carried over the second factor, plus that of the second
    rates = np.array([group.Ad(group.exp(-(u**2) * y)) @ x + 2.0 * u * y for u in s])
    exact = 0.5 * weights @ body.value(rates)
    errors = [abs(bent(count) - exact) for count in (20, 40)]
    assert errors[1] < 1e-3 * exact
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)


def test_the_metric_in_space_keeps_energy_and_turns_momentum():
    body, w = random_case(SO(4), 6)
    group = body.group
    a = group.random(np.random.default_rng(6))
    there = Lagrangian(group, metric_at(body, a))
    in_space = w @ group.Ad(a).T
    np.testing.assert_allclose(there.value(in_space), body.value(w), rtol=1e-13)
    np.testing.assert_allclose(there.momenta(in_space), spatial_momentum(group, a, body.momenta(w)), atol=1e-13)
    # the momentum of the space frame stands still; what M(A₀) gives is that of the frame frozen at A₀, turned
    np.testing.assert_allclose(
        there.momentum_rate(in_space), spatial_momentum(group, a, body.momentum_rate(w)), atol=1e-12
    )


def test_neither_a_lagrangian_nor_its_hamiltonian_takes_another_metric():
    L = Lagrangian(SO(3), np.diag([1.0, 2.0, 3.0]))
    H = legendre_transform(L)
    assert not L.metric.flags.writeable
    for made, name in ((L, "metric"), (L, "inverse_metric"), (L, "group"), (H, "inverse_metric"), (H, "group")):
        with pytest.raises(AttributeError):
            setattr(made, name, np.eye(3))
