"""Casimirs beyond compact simple groups: invariant forms, quadratic Casimirs of any group, products by factors."""

from __future__ import annotations

import numpy as np
import pytest
from sample_groups import (
    COMPACT,
    GROUPS,
    affine_line,
    assert_still,
    gradient,
    heisenberg,
    random_body,
    random_metric,
    rank,
    se3,
    skewed_rotations,
    sl2,
    so4_split,
)

from lie_rigid_body.groups import (
    SO,
    SU,
    U1,
    Lagrangian,
    MatrixLieGroup,
    casimirs,
    invariant_form,
    killing_form,
    momentum_matrix,
    product,
    quadratic_casimirs,
    unitary_casimirs,
)

OPEN = {
    name: MatrixLieGroup.from_generators(make(), name=name)
    for name, make in (("SL2", sl2), ("SE3", se3), ("Heisenberg", heisenberg))
} | {"affine line": affine_line(), "SE2": GROUPS["SE2"]}
"""Groups that are not compact."""


@pytest.mark.parametrize("group", [*COMPACT.values(), *OPEN.values()], ids=lambda g: g.name)
def test_the_killing_form_is_the_trace_of_two_adjoint_matrices(group):
    ad = group.adjoint_representation
    form = killing_form(group)
    np.testing.assert_allclose(form, np.einsum("aij,bji->ab", ad, ad), atol=1e-13)
    lowered = group.structure_constants @ form
    np.testing.assert_allclose(lowered, -np.swapaxes(lowered, 1, 2), atol=1e-12)


def test_the_killing_form_tells_what_basis_a_group_has():
    """Totally antisymmetric constants in some basis need tr(ad x ad x) < 0 off the centre: there is none to choose."""
    for group in COMPACT.values():
        assert np.all(np.linalg.eigvalsh(killing_form(group)) < 1e-12)
    assert np.linalg.eigvalsh(killing_form(OPEN["SL2"])).max() > 1.0
    assert np.linalg.eigvalsh(killing_form(OPEN["affine line"])).max() > 0.5
    for name in ("SE2", "SE3", "Heisenberg"):
        group = OPEN[name]
        values, directions = np.linalg.eigh(killing_form(group))
        flat = directions[:, np.abs(values) < 1e-12]
        # directions in which the form is 0 and that are not in the centre
        assert np.abs(np.einsum("abc,ak->kbc", group.structure_constants, flat)).max() > 0.1


@pytest.mark.parametrize(
    "group", [*COMPACT.values(), skewed_rotations(), product(U1(), SU(2), SU(3)), OPEN["SL2"]], ids=lambda g: g.name
)
def test_the_invariant_form_is_invariant_and_gives_a_casimir(group):
    """On SL(2) g is indefinite, and p·g⁻¹p stands still where p·p does not."""
    rng = np.random.default_rng(44)
    form, A = invariant_form(group), group.exp(rng.normal(size=group.dimension))
    np.testing.assert_allclose(group.Ad(A).T @ form @ group.Ad(A), form, atol=1e-11)
    trace = -np.real(np.einsum("aij,bji->ab", group.generators, group.generators))
    ratio = np.sum(form * trace) / np.sum(trace * trace)
    assert ratio > 0.0
    if not group.factors:
        np.testing.assert_allclose(form, ratio * trace, atol=1e-13)
    body, p = Lagrangian(group, random_metric(rng, group.dimension)), rng.normal(size=group.dimension)
    rate = body.momentum_rate(body.rates(p))
    assert abs(p @ np.linalg.solve(form, rate)) < 1e-12
    np.testing.assert_array_equal(form, trace if group.name == "SL2" else group.trace_metric)
    if group.name == "SL2":
        assert abs(p @ rate) > 1e-2


@pytest.mark.parametrize(
    ("group", "count"),
    [
        (SO(3), 1),
        (SU(3), 1),
        (SO(4), 2),
        (MatrixLieGroup.from_generators(so4_split()), 2),
        (product(U1(), SU(2), SU(3)), 3),
        (product(U1(), U1()), 3),
        (skewed_rotations(), 1),
        (OPEN["SL2"], 1),
        (OPEN["SE2"], 1),
        (OPEN["SE3"], 2),
        (OPEN["Heisenberg"], 1),
        (OPEN["affine line"], 0),
    ],
    ids=lambda value: getattr(value, "name", value),
)
def test_quadratic_casimirs_are_conserved_by_every_body(group, count):
    found = quadratic_casimirs(group)
    assert found.shape == (count, group.dimension, group.dimension)
    np.testing.assert_allclose(found, np.swapaxes(found, 1, 2), atol=1e-15)
    np.testing.assert_allclose(np.einsum("kab,lab->kl", found, found), np.eye(count), atol=1e-13)
    rng = np.random.default_rng(45)
    body, p = Lagrangian(group, random_metric(rng, group.dimension)), rng.normal(size=(20, group.dimension))
    rates = body.momentum_rate(body.rates(p))
    np.testing.assert_allclose(np.einsum("na,kab,nb->kn", p, found, rates), 0.0, atol=1e-12)
    # and none is missing: of all products pᵃpᵇ no more combinations stand still
    rows, columns = np.triu_indices(group.dimension)
    many = rng.normal(size=(3 * len(rows), 2, group.dimension))
    moved = np.array([Lagrangian(group, np.eye(group.dimension)).momentum_rate(w) for w, _ in many])
    for extra in (random_metric(rng, group.dimension) for _ in range(2)):
        body = Lagrangian(group, extra)
        moved = np.concatenate([moved, body.momentum_rate(body.rates(many[:, 0]))])
    momenta = np.concatenate([many[:, 0]] * 3)
    slopes = moved[:, rows] * momenta[:, columns] + momenta[:, rows] * moved[:, columns]
    sizes = np.linalg.svd(slopes, compute_uv=False)
    assert np.sum(sizes <= 1e-9 * max(1.0, sizes.max())) == count


@pytest.mark.parametrize("name", OPEN)
def test_the_square_of_the_momentum_is_not_conserved_where_a_group_is_not_compact(name):
    """Against "on a generic Lie group" after eq. (24)."""
    body, rng = random_body(OPEN[name], 46)
    p = rng.normal(size=body.group.dimension)
    assert abs(p @ body.momentum_rate(body.rates(p))) > 1e-3


STANDARD_MODEL = product(U1(), SU(2), SU(3))


@pytest.mark.parametrize(
    ("group", "count"), [(STANDARD_MODEL, 4), (product(SO(4), U1()), 3), (product(product(SO(3), SU(2)), SO(2)), 3)]
)
def test_the_casimirs_of_a_product_are_those_of_its_factors(group, count):
    body, rng = random_body(group, 47)
    p = rng.normal(size=(3, group.dimension))
    assert casimirs(group, p).shape == (3, count)
    for one in p:
        assert_still(lambda q: casimirs(group, q), one, body.momentum_rate(body.rates(one)))
    assert rank(gradient(lambda q: casimirs(group, q), p[0])) == count


def test_the_casimirs_of_the_standard_model_are_charge_isospin_and_two_of_colour():
    p = np.random.default_rng(48).normal(size=12)
    colour = unitary_casimirs(momentum_matrix(SU(3), p[4:]))
    np.testing.assert_allclose(casimirs(STANDARD_MODEL, p), [p[0], 0.5 * p[1:4] @ p[1:4], *colour], rtol=1e-13)
    np.testing.assert_allclose(colour[0], 0.5 * p[4:] @ p[4:], rtol=1e-13)
