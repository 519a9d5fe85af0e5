"""The connection of a left-invariant metric: Koszul's conditions, geodesics, and Christoffel symbols of a chart."""

from __future__ import annotations

import numpy as np
import pytest
from group_bodies import COMPACT, GROUPS, random_metric

from lie_rigid_body.groups import (
    GroupMovingChart,
    GroupState,
    Lagrangian,
    chart_metric,
    christoffel_symbols,
    connection_coefficients,
)

NAMES = pytest.mark.parametrize("name", GROUPS)


def random_body(name, seed=71):
    rng = np.random.default_rng(seed)
    return Lagrangian(GROUPS[name], random_metric(rng, GROUPS[name].dimension)), rng


@NAMES
def test_it_has_no_torsion_and_keeps_the_metric(name):
    """The two conditions that single it out: ∇_X Y − ∇_Y X = [X, Y], and ⟨∇_X Y, Z⟩ + ⟨Y, ∇_X Z⟩ = 0."""
    body, _ = random_body(name)
    gamma = connection_coefficients(body)
    np.testing.assert_allclose(gamma - np.swapaxes(gamma, 0, 1), body.group.structure_constants, atol=1e-12)
    lowered = gamma @ body.metric
    np.testing.assert_allclose(lowered, -np.swapaxes(lowered, 1, 2), atol=1e-12)


@NAMES
def test_its_geodesics_are_the_motions(name):
    body, rng = random_body(name)
    w = rng.normal(size=(5, body.group.dimension))
    for symbols in (connection_coefficients(body), christoffel_symbols(body)):
        np.testing.assert_allclose(-np.einsum("abc,na,nb->nc", symbols, w, w), body.acceleration(w), atol=1e-12)


@pytest.mark.parametrize("name", COMPACT)
def test_of_a_bi_invariant_metric_it_is_half_the_bracket(name):
    group = COMPACT[name]
    body = Lagrangian(group, 2.5 * group.trace_metric)
    np.testing.assert_allclose(connection_coefficients(body), 0.5 * group.structure_constants, atol=1e-14)
    np.testing.assert_allclose(christoffel_symbols(body), 0.0, atol=1e-14)


@NAMES
def test_christoffel_symbols_are_those_of_the_metric_in_the_chart(name):
    """Γᶜ_ab = ½ Gᶜᵈ (∂_a G_db + ∂_b G_da − ∂_d G_ab) at the centre, by central differences of G(β)."""
    body, _ = random_body(name)
    h = 1e-4
    slope = np.array([chart_metric(body, h * e) - chart_metric(body, -h * e) for e in np.eye(body.group.dimension)])
    slope = slope / (2 * h)
    lowered = 0.5 * (np.einsum("adb->abd", slope) + np.einsum("bda->abd", slope) - np.einsum("dab->abd", slope))
    np.testing.assert_allclose(christoffel_symbols(body), lowered @ body.inverse_metric, atol=1e-6)


@pytest.mark.parametrize("name", ["SO3", "SU2", "SE2", "affine line"])
def test_a_motion_has_the_length_of_its_energy_and_no_detour_is_shorter(name):
    """Between near points: paths A exp(ε hat η) of the same ends are longer, and by the order of ε²."""
    body, rng = random_body(name)
    group, d, step = body.group, body.group.dimension, 2e-3
    t = step * np.arange(201)
    start = GroupState(group.exp(0.3 * rng.normal(size=d)), rng.normal(size=d))
    path = GroupMovingChart(body, start, max_step=step).at(np.rint(1e9 * t).astype(np.int64)).element

    def length(elements):
        chords = group.log(group.inverse(elements[:-1]) @ elements[1:])
        return np.sqrt(np.einsum("na,ab,nb->n", chords, body.metric, chords)).sum()

    straight = length(path)
    assert straight == pytest.approx(t[-1] * np.sqrt(2.0 * body.value(start.rate)), rel=1e-6)
    bump = np.outer(np.sin(np.pi * t / t[-1]), rng.normal(size=d))
    near, far = (length(path @ group.exp(size * bump)) - straight for size in (1e-2, 2e-2))
    assert near > 0.0
    assert far / near == pytest.approx(4.0, rel=0.05)
