"""The Hamiltonian on a group: Legendre's transform, Hamilton's equations and the laws of the Lie–Poisson bracket."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from group_bodies import GROUPS, ROTATIONS, UNITARY, gradient, random_metric

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.groups import (
    SO,
    Hamiltonian,
    Lagrangian,
    inverse_legendre_transform,
    legendre_transform,
    lie_poisson_bracket,
    momentum_matrix,
    poisson_tensor,
    rotation_casimirs,
    unitary_casimirs,
)

NAMES = pytest.mark.parametrize("name", GROUPS)


class Quadratic:
    """F(p) = ½ pSp + bp."""

    def __init__(self, rng, d):
        s = rng.normal(size=(d, d))
        self.hessian, self.slope = s + s.T, rng.normal(size=d)

    def value(self, p):
        return 0.5 * p @ self.hessian @ p + self.slope @ p

    def gradient(self, p):
        return self.hessian @ p + self.slope


class Bracket:
    """{F, G} of two quadratics as a function of p, its gradient by the product rule on the matrix commutator."""

    def __init__(self, group, first, second):
        self.group, self.first, self.second = group, first, second

    def value(self, p):
        return lie_poisson_bracket(self.group, p, self.first.gradient(p), self.second.gradient(p))

    def gradient(self, p):
        f, left, right = self.group.structure_constants, self.first.gradient(p), self.second.gradient(p)
        turned = np.einsum("abc,c->ab", f, p)
        return (
            -np.einsum("abe,a,b->e", f, left, right)
            - self.first.hessian @ turned @ right
            - self.second.hessian @ turned.T @ left
        )


def quadratics(name, count=3):
    group, rng = GROUPS[name], np.random.default_rng(11)
    return group, rng.normal(size=group.dimension), [Quadratic(rng, group.dimension) for _ in range(count)]


@NAMES
def test_legendre_there_and_back(name):
    group, rng = GROUPS[name], np.random.default_rng(12)
    body, w = Lagrangian(group, random_metric(rng, group.dimension)), rng.normal(size=(4, group.dimension))
    energy, p = legendre_transform(body), body.momenta(w)
    np.testing.assert_allclose(energy.value(p), np.sum(p * w, axis=-1) - body.value(w), rtol=1e-12)
    np.testing.assert_allclose(energy.rates(p), w, atol=1e-13)
    np.testing.assert_allclose(body.rates(p), w, atol=1e-13)
    np.testing.assert_allclose(inverse_legendre_transform(energy).metric, body.metric, atol=1e-13)


@NAMES
def test_legendre_transform_is_the_maximum_of_pw_minus_l(name):
    group, rng = GROUPS[name], np.random.default_rng(13)
    body, p = Lagrangian(group, random_metric(rng, group.dimension)), rng.normal(size=group.dimension)
    others = rng.normal(size=(200, group.dimension)) * 3
    assert np.all(others @ p - body.value(others) <= legendre_transform(body).value(p))


@NAMES
def test_hamiltons_equations_are_lagranges(name):
    group, rng = GROUPS[name], np.random.default_rng(14)
    body, w = Lagrangian(group, random_metric(rng, group.dimension)), rng.normal(size=(4, group.dimension))
    moved = legendre_transform(body).equations(body.momenta(w))
    np.testing.assert_allclose(moved.rate, w, atol=1e-13)
    np.testing.assert_allclose(moved.momentum_rate, body.momentum_rate(w), atol=1e-12)
    np.testing.assert_allclose(moved.momentum_rate, body.acceleration(w) @ body.metric, atol=1e-12)


@NAMES
def test_the_bracket_with_the_hamiltonian_is_the_rate_of_change(name):
    group, p, (first, _, _) = quadratics(name)
    energy = Hamiltonian(group, random_metric(np.random.default_rng(15), group.dimension))
    rate = energy.equations(p)
    bracket = lie_poisson_bracket(group, p, first.gradient(p), energy.rates(p))
    assert bracket == pytest.approx(first.gradient(p) @ rate.momentum_rate, abs=1e-12)
    ours = [lie_poisson_bracket(group, p, e, energy.rates(p)) for e in np.eye(group.dimension)]
    np.testing.assert_allclose(ours, rate.momentum_rate, atol=1e-12)


@NAMES
def test_the_bracket_is_the_formula(name):
    group, p, (first, second, _) = quadratics(name)
    left, right = first.gradient(p), second.gradient(p)
    formula = -np.einsum("abc,c,a,b", group.structure_constants, p, left, right)
    assert lie_poisson_bracket(group, p, left, right) == pytest.approx(formula, abs=1e-11)
    assert left @ poisson_tensor(group, p) @ right == pytest.approx(formula, abs=1e-11)


@NAMES
def test_jacobi(name):
    group, p, functions = quadratics(name)
    terms = [
        lie_poisson_bracket(group, p, Bracket(group, f, g).gradient(p), h.gradient(p))
        for f, g, h in (functions, functions[1:] + functions[:1], functions[2:] + functions[:2])
    ]
    assert abs(sum(terms)) <= 1e-12 * (1 + max(np.abs(terms)))


@pytest.mark.parametrize("group", [*ROTATIONS.values(), *UNITARY.values()], ids=lambda g: g.name)
def test_casimirs_commute_with_everything(group):
    casimirs = unitary_casimirs if np.iscomplexobj(group.generators) else rotation_casimirs
    p = np.random.default_rng(16).normal(size=group.dimension)
    slopes = gradient(lambda q: casimirs(momentum_matrix(group, q)), p).T
    anything = np.random.default_rng(17).normal(size=(50, 1, group.dimension))
    brackets = lie_poisson_bracket(group, p, slopes, anything)
    assert np.all(np.abs(brackets) <= 1e-12 * np.linalg.norm(slopes, axis=1) * np.linalg.norm(p) * 10)


def test_the_momenta_of_so3_have_the_brackets_of_body_components():
    """{p₁, p₂} = −p₃: the minus sign is that of the body frame."""
    p = np.array([0.3, -0.5, 0.7])
    for a, b, c in permutations(range(3)):
        sign = np.linalg.det(np.eye(3)[[a, b, c]])
        assert poisson_tensor(SO(3), p)[a, b] == pytest.approx(-sign * p[c], abs=1e-15)


def test_wrong_lengths_and_indefinite_energies_are_refused():
    with pytest.raises(InputError):
        lie_poisson_bracket(SO(3), np.ones(3), np.ones(4), np.ones(3))
    with pytest.raises(InputError):
        Hamiltonian(SO(3), np.eye(3)).equations(1.0)
    with pytest.raises(InputError):
        Hamiltonian(SO(3), np.diag([1.0, 1.0, -1.0]))
