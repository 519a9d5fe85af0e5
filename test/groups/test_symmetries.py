"""Conserved momenta: the isotropy of the body, whatever basis it is given in."""

from __future__ import annotations

import numpy as np
import pytest
from group_bodies import COMPACT, GROUPS, ROTATIONS, diagonal_body, random_metric
from hypothesis import given
from hypothesis import strategies as st

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.groups import SO, Lagrangian, MatrixLieGroup, conserved_momenta, metric_at

seeds = st.integers(0, 2**32 - 1)


def projector(rows):
    return rows.T @ rows


@pytest.mark.parametrize(
    ("moments", "expected"),
    [
        ([1.0, 1.0, 2.0], [[0, 0, 1]]),
        ([2.0, 1.0, 1.0], [[1, 0, 0]]),
        ([1.0, 2.0, 1.0], [[0, 1, 0]]),
        ([3.0, 3.0, 3.0], np.eye(3)),
        ([1.0, 2.0, 3.0], np.empty((0, 3))),
        ([1.0, 1.0 + 1e-9, 3.0], np.empty((0, 3))),
    ],
)
def test_tops(moments, expected):
    np.testing.assert_allclose(conserved_momenta(SO(3), np.diag(moments)), expected, atol=1e-15)


@given(seeds, st.floats(1e-8, 1e8))
def test_a_tilted_symmetric_top_keeps_its_axis_in_any_unit(seed, unit):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    found = conserved_momenta(SO(3), unit * (np.eye(3) + rng.uniform(0.1, 3.0) * np.outer(axis, axis)))
    assert found.shape == (1, 3)
    np.testing.assert_allclose(np.abs(found @ axis), 1.0, rtol=1e-12)
    assert found[0, np.argmax(np.abs(found[0]))] > 0.0


@pytest.mark.parametrize("name", COMPACT)
def test_the_unit_keeps_everything_and_a_random_metric_nothing(name):
    group = COMPACT[name]
    np.testing.assert_array_equal(conserved_momenta(group, 3.0 * np.eye(group.dimension)), np.eye(group.dimension))
    metric = random_metric(np.random.default_rng(21), group.dimension)
    assert len(conserved_momenta(group, metric)) == (name == "U1")


@pytest.mark.parametrize(
    "moments",
    [
        [1, 1, 2, 3],
        [1, 1, 2, 2],
        [1, 1, 1, 2],
        [1, 2, 3, 4],
        [1, 1, 2, 2, 2],
        [1, 2, 2, 3, 3],
        [1, 1, 1, 2, 2, 2],
        [1, 1, 2, 2, 3, 3],
        [2, 1, 2, 1, 2, 1],
    ],
)
def test_equal_second_moments_are_turns_into_each_other(moments):
    """The isotropy of K is the product of rotation groups, one for each of its eigenvalues."""
    n, (_, counts) = len(moments), np.unique(moments, return_counts=True)
    group = ROTATIONS[n]
    found = conserved_momenta(group, diagonal_body(group, np.array(moments, float)))
    assert len(found) == np.sum(counts * (counts - 1) // 2)
    k = np.diag(np.array(moments, float))
    commutators = group.hat(found) @ k - k @ group.hat(found)
    np.testing.assert_allclose(commutators, 0.0, atol=1e-13)


@pytest.mark.parametrize("name", GROUPS)
@given(seed=seeds)
def test_exactly_these_momenta_stand_still(name, seed):
    """The condition asked of motions: ξ·ṗ = 0 for many random rates, and for no direction outside the span."""
    group, rng = GROUPS[name], np.random.default_rng(seed)
    d = group.dimension
    # a metric with a symmetry in about half of the cases: 1 plus what two random directions add
    add = rng.normal(size=(rng.integers(0, 2), d))
    metric = np.eye(d) + add.T @ add
    w = rng.normal(size=(d * d + 5, d))
    rates = Lagrangian(group, metric).momentum_rate(w)
    found = conserved_momenta(group, metric)
    np.testing.assert_allclose(found @ found.T, np.eye(len(found)), atol=1e-13)
    np.testing.assert_allclose(rates @ found.T, 0.0, atol=1e-11 * (1 + np.abs(rates).max()))
    others = np.linalg.svd(rates, compute_uv=False) if d else np.empty(0)
    assert np.sum(others > 1e-9 * (1 + others.max())) == d - len(found)


@pytest.mark.parametrize("moments", [[1, 1, 2, 2], [1, 1, 1, 2], [1, 1, 2, 2, 2]])
def test_turning_the_body_turns_its_conserved_momenta(moments):
    group = ROTATIONS[len(moments)]
    body = Lagrangian(group, diagonal_body(group, np.array(moments, float)))
    a = group.random(np.random.default_rng(23))
    here, there = conserved_momenta(group, body.metric), conserved_momenta(group, metric_at(body, a))
    np.testing.assert_allclose(projector(here @ group.Ad(a).T), projector(there), atol=1e-12)


def test_they_close_under_the_bracket():
    group = ROTATIONS[6]
    found = conserved_momenta(group, diagonal_body(group, np.array([1.0, 1.0, 1.0, 2.0, 2.0, 3.0])))
    brackets = np.einsum("xa,yb,abc->xyc", found, found, group.structure_constants)
    np.testing.assert_allclose(brackets @ projector(found), brackets, atol=1e-13)


def test_the_basis_does_not_hang_on_round_off():
    group, rng = ROTATIONS[5], np.random.default_rng(24)
    metric = diagonal_body(group, np.array([1.0, 1.0, 1.0, 2.0, 2.0]))
    body = Lagrangian(group, metric)
    tilted = metric_at(body, group.random(rng))
    first = conserved_momenta(group, tilted)
    for _ in range(5):
        noise = rng.normal(size=metric.shape) * 1e-15
        np.testing.assert_allclose(conserved_momenta(group, tilted + noise + noise.T), first, atol=1e-11)


def test_a_tie_is_for_the_first_generator_whatever_round_off_says():
    """The axis (1, −1, 0)/√2 is as near to the first generator as to the second: the first gives the sign."""
    axis, rng = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0), np.random.default_rng(25)
    for _ in range(20):
        noise = rng.normal(size=(3, 3)) * 1e-15
        metric = np.eye(3) + np.outer(axis, axis) + noise + noise.T
        np.testing.assert_allclose(conserved_momenta(SO(3), metric), [axis], atol=1e-13)


def test_the_tolerance_is_asymmetry_relative_to_the_metric():
    nearly = 1e5 * np.diag([1.0, 1.0 + 1e-6, 2.0])
    assert len(conserved_momenta(SO(3), nearly)) == 0
    assert len(conserved_momenta(SO(3), nearly, tolerance=1e-5)) == 1


def test_what_is_no_metric_is_refused():
    with pytest.raises(InputError):
        conserved_momenta(SO(4), np.eye(3))


@pytest.mark.parametrize("stretch", [1e-6, 1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize(("moments", "count"), [((1.0, 2.0, 1.8), 0), ((1.0, 1.0, 1.8), 1), ((2.0, 2.0, 2.0), 3)])
def test_what_is_conserved_does_not_depend_on_the_scale_of_a_generator(stretch, moments, count):
    scales = np.array([1.0, 1.0, stretch])
    group = MatrixLieGroup.from_generators(scales[:, None, None] * SO(3).generators)
    assert len(conserved_momenta(group, np.diag(scales * moments * scales))) == count
