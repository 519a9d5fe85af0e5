"""Chasles: the displacement of a body is found from its points, properly, and refused when they do not tell it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from scipy.stats import special_ortho_group

from lie_rigid_body import InputError
from lie_rigid_body.groups import SO, chasles
from lie_rigid_body.lie import so3

DIMENSIONS = range(2, 7)
seeds = st.integers(0, 2**32 - 1)


def rotation_of(n, rng):
    return special_ortho_group.rvs(n, random_state=rng)


def flat_points(count, n, rank, rng):
    """Points of a subspace through a far centre, turned out of the coordinate planes."""
    inside = np.hstack([rng.normal(size=(count, rank)), np.zeros((count, n - rank))])
    return inside @ rotation_of(n, rng).T + rng.normal(size=n)


def assert_proper(rotation):
    n = len(rotation)
    np.testing.assert_allclose(rotation.T @ rotation, np.eye(n), rtol=0, atol=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1.0, abs=1e-13)


@given(st.integers(2, 6), seeds)
def test_exact_displacements_are_found(n, seed):
    rng = np.random.default_rng(seed)
    A, t = rotation_of(n, rng), rng.normal(size=n)
    x = rng.normal(size=(3 * n, n))
    found = chasles(x, x @ A.T + t)
    assert_proper(found.rotation)
    np.testing.assert_allclose(found.rotation, A, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.translation, t, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.apply(x), x @ A.T + t, rtol=0, atol=1e-12)
    assert found.residual < 1e-13
    assert not found.rotation.flags.writeable
    assert not found.translation.flags.writeable


def test_velocities_of_a_turning_body_are_those_of_its_rate():
    """u̇ = Ȧx with Ȧ = A hat(ω), eq. (8): by differences of displaced points, and A (ω × x) in three dimensions."""
    rng, h = np.random.default_rng(9), 1e-4
    for group in (SO(3), SO(5)):
        A, rate, x = group.random(rng), rng.normal(size=group.dimension), rng.normal(size=(4, group.size))
        ahead, behind = (x @ (A @ expm(t * np.tensordot(rate, group.generators, 1))).T for t in (h, -h))
        found = x @ (A @ group.hat(rate)).T
        np.testing.assert_allclose(found, (ahead - behind) / (2 * h), rtol=0, atol=1e-6)
        if group.size == 3:
            np.testing.assert_allclose(found, np.cross(rate, x) @ A.T, rtol=0, atol=1e-13)


@given(st.integers(2, 6), seeds)
def test_as_few_as_n_points_of_a_hyperplane_hold_a_proper_rotation(n, seed):
    rng = np.random.default_rng(seed)
    A, t = rotation_of(n, rng), rng.normal(size=n)
    x = flat_points(n, n, n - 1, rng)
    found = chasles(x, x @ A.T + t)
    assert_proper(found.rotation)
    # the smallest singular value enters squared
    tolerance = 1e-13 / found.determinacy
    np.testing.assert_allclose(found.rotation, A, rtol=0, atol=tolerance)
    np.testing.assert_allclose(found.translation, t, rtol=0, atol=10 * tolerance)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_half_turns_of_flat_bodies_are_not_taken_for_reflections(n):
    rng = np.random.default_rng(n)
    x = flat_points(10, n, n - 1, rng)
    normal = np.linalg.svd(x - x.mean(axis=0))[2][-1]
    other = np.linalg.svd(x - x.mean(axis=0))[2][0]
    A = np.eye(n) - 2 * np.outer(normal, normal) - 2 * np.outer(other, other)
    found = chasles(x, x @ A.T)
    assert_proper(found.rotation)
    np.testing.assert_allclose(found.rotation, A, rtol=0, atol=1e-11)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_reflected_bodies_get_the_rotation_that_turns_back_their_thinnest_direction(n):
    rng = np.random.default_rng(n)
    # exact second moments diag(n², …, 4, 1): each point with its mirror images along an axis
    x = np.vstack([np.diag(np.arange(n, 0, -1.0)), -np.diag(np.arange(n, 0, -1.0))])
    A = rotation_of(n, rng)
    mirror = np.eye(n)
    mirror[0, 0] = -1.0
    turned_back = np.eye(n)
    turned_back[0, 0] = turned_back[-1, -1] = -1.0
    found = chasles(x, x @ (A @ mirror).T)
    assert_proper(found.rotation)
    np.testing.assert_allclose(found.rotation, A @ turned_back, rtol=0, atol=1e-13)
    # only the thinnest pair misses, by 2 each
    assert found.residual == pytest.approx(np.sqrt(2 * 2.0**2 / len(x)), rel=1e-13)
    assert found.determinacy == pytest.approx((4 - 1) / n**2, rel=1e-12)


@pytest.mark.parametrize("reflected", [False, True])
@pytest.mark.parametrize("n", DIMENSIONS)
def test_no_other_rotation_fits_better(n, reflected):
    rng = np.random.default_rng(10 * n + reflected)
    x, w = rng.normal(size=(2 * n, n)), rng.uniform(0.1, 3.0, 2 * n)
    y = rng.normal(size=(2 * n, n)) * 0.3 + x @ rotation_of(n, rng).T
    if reflected:
        y[:, 0] *= -1.0

    def cost(rotation, translation):
        return float(np.sqrt(np.sum(w[:, None] * (y - x @ rotation.T - translation) ** 2) / w.sum()))

    found = chasles(x, y, w)
    best = cost(found.rotation, found.translation)
    assert found.residual == pytest.approx(best, rel=1e-12)
    for size in (1e-3, 1e-1, 1.0):
        for _ in range(20):
            bend = rng.normal(size=(n, n)) * size
            other = np.linalg.qr(found.rotation + bend - bend.T)[0]
            other[:, 0] *= np.sign(np.linalg.det(other))
            assert cost(other, (w @ y - other @ (w @ x)) / w.sum()) > best
            assert cost(found.rotation, found.translation + size * rng.normal(size=n)) > best


def test_scipy_finds_the_same_rotation_in_three_dimensions():
    rng = np.random.default_rng(5)
    x, w = rng.normal(size=(20, 3)), rng.uniform(0.5, 2.0, 20)
    x -= w @ x / w.sum()
    y = x @ so3.exp([2.0, 0.3, -1.0]).T + 0.05 * rng.normal(size=(20, 3))
    y -= w @ y / w.sum()
    theirs = Rotation.align_vectors(y, x, weights=w)[0].as_matrix()
    np.testing.assert_allclose(chasles(x, y, w).rotation, theirs, rtol=0, atol=1e-13)


def test_a_point_of_weight_two_counts_as_two_points_and_of_weight_zero_as_none():
    rng = np.random.default_rng(8)
    x, y = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    one = chasles(x, y, [2.0, 1.0, 1.0, 1.0, 1.0, 0.0])
    other = chasles(x[[0, 0, 1, 2, 3, 4]], y[[0, 0, 1, 2, 3, 4]])
    np.testing.assert_allclose(one.rotation, other.rotation, rtol=0, atol=1e-13)
    np.testing.assert_allclose(one.translation, other.translation, rtol=0, atol=1e-13)
    assert one.residual == pytest.approx(other.residual, rel=1e-13)


@pytest.mark.parametrize("unit", [1e-100, 1e-9, 1e9, 1e100])
def test_the_unit_of_length_does_not_matter(unit):
    rng = np.random.default_rng(4)
    x, y = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    one, other = chasles(x, y), chasles(unit * x, y)
    np.testing.assert_allclose(other.rotation, one.rotation, rtol=0, atol=1e-13)
    both = chasles(unit * x, unit * y)
    assert both.residual == pytest.approx(unit * one.residual, rel=1e-12)


def test_a_far_origin_costs_only_the_digits_it_takes():
    rng = np.random.default_rng(6)
    A = rotation_of(3, rng)
    x = rng.normal(size=(10, 3))
    found = chasles(x + 1e6, x @ A.T - 1e7)
    np.testing.assert_allclose(found.rotation, A, rtol=0, atol=1e-8)
    assert found.residual < 1e-8


@pytest.mark.parametrize(("n", "rank"), [(n, rank) for n in DIMENSIONS for rank in range(n - 1)])
def test_too_flat_bodies_are_refused(n, rank):
    rng = np.random.default_rng(n)
    x = flat_points(4 * n, n, rank, rng)
    exact = x @ rotation_of(n, rng).T + 1.0
    for y in (exact, exact + 0.01 * rng.normal(size=x.shape)):
        with pytest.raises(InputError):
            chasles(x, y)


def test_a_line_far_away_is_still_a_line():
    line = np.outer(np.linspace(-1.0, 1.0, 10_000), [0.3, -0.5, 0.7])
    for offset in (0.0, 1.0, 1e4, 1e8):
        with pytest.raises(InputError):
            chasles(line + offset, line @ so3.exp([0.1, 0.2, 0.3]).T)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_mirror_images_of_symmetric_bodies_are_refused(n):
    x = np.vstack([np.eye(n), -np.eye(n)])
    A = rotation_of(n, np.random.default_rng(n))
    mirror = np.diag([-1.0] + [1.0] * (n - 1))
    np.testing.assert_allclose(chasles(x, x @ A.T).rotation, A, rtol=0, atol=1e-13)
    with pytest.raises(InputError):
        chasles(x, x @ (A @ mirror).T)
