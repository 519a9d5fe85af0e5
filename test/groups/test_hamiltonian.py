"""The Hamiltonian on a group: Legendre's transform, Hamilton's equations and the laws of the Lie–Poisson bracket."""

from __future__ import annotations

from functools import partial
from itertools import permutations

import numpy as np
import pytest
from sample_groups import GROUPS, ROTATIONS, UNITARY, gradient, random_body, random_metric

from lie_rigid_body.groups import (
    SO,
    Hamiltonian,
    casimirs,
    inverse_legendre_transform,
    legendre_transform,
    lie_poisson_bracket,
    poisson_tensor,
)

NAMES = pytest.mark.parametrize("name", GROUPS)


@NAMES
def test_legendre_there_and_back(name):
    body, rng = random_body(GROUPS[name], 12)
    w = rng.normal(size=(4, body.group.dimension))
    energy, p = legendre_transform(body), body.momenta(w)
    np.testing.assert_allclose(energy.value(p), np.sum(p * w, axis=-1) - body.value(w), rtol=1e-12)
    np.testing.assert_allclose(energy.rates(p), w, atol=1e-13)
    np.testing.assert_allclose(body.rates(p), w, atol=1e-13)
    np.testing.assert_allclose(inverse_legendre_transform(energy).metric, body.metric, atol=1e-13)


@NAMES
def test_legendre_transform_is_the_maximum_of_pw_minus_l(name):
    body, rng = random_body(GROUPS[name], 13)
    p, *others = rng.normal(size=(201, body.group.dimension)) * 3
    assert np.all(others @ p - body.value(np.array(others)) <= legendre_transform(body).value(p))


@NAMES
def test_hamiltons_equations_are_lagranges(name):
    body, rng = random_body(GROUPS[name], 14)
    w = rng.normal(size=(4, body.group.dimension))
    moved = legendre_transform(body).equations(body.momenta(w))
    np.testing.assert_allclose(moved.rate, w, atol=1e-13)
    np.testing.assert_allclose(moved.momentum_rate, body.momentum_rate(w), atol=1e-12)
    np.testing.assert_allclose(moved.momentum_rate, body.acceleration(w) @ body.metric, atol=1e-12)


@NAMES
def test_the_bracket_with_the_hamiltonian_is_the_rate_of_change(name):
    group, rng = GROUPS[name], np.random.default_rng(15)
    energy, p = Hamiltonian(group, random_metric(rng, group.dimension)), rng.normal(size=group.dimension)
    ours = [lie_poisson_bracket(group, p, e, energy.rates(p)) for e in np.eye(group.dimension)]
    np.testing.assert_allclose(ours, energy.equations(p).momentum_rate, atol=1e-12)


@NAMES
def test_the_bracket_is_the_formula(name):
    """Jacobi's identity, which the structure constants have, is then that of the bracket."""
    group = GROUPS[name]
    p, left, right = np.random.default_rng(11).normal(size=(3, group.dimension))
    formula = -np.einsum("abc,c,a,b", group.structure_constants, p, left, right)
    assert lie_poisson_bracket(group, p, left, right) == pytest.approx(formula, abs=1e-11)
    assert left @ poisson_tensor(group, p) @ right == pytest.approx(formula, abs=1e-11)


@pytest.mark.parametrize("group", [*ROTATIONS.values(), *UNITARY.values()], ids=lambda g: g.name)
def test_casimirs_commute_with_everything(group):
    p = np.random.default_rng(16).normal(size=group.dimension)
    slopes = gradient(partial(casimirs, group), p).T
    anything = np.random.default_rng(17).normal(size=(50, 1, group.dimension))
    brackets = lie_poisson_bracket(group, p, slopes, anything)
    assert np.all(np.abs(brackets) <= 1e-12 * np.linalg.norm(slopes, axis=1) * np.linalg.norm(p) * 10)


def test_the_momenta_of_so3_have_the_brackets_of_body_components():
    """{p₁, p₂} = −p₃: the minus sign is that of the body frame."""
    p = np.array([0.3, -0.5, 0.7])
    for a, b, c in permutations(range(3)):
        sign = np.linalg.det(np.eye(3)[[a, b, c]])
        assert poisson_tensor(SO(3), p)[a, b] == pytest.approx(-sign * p[c], abs=1e-15)
