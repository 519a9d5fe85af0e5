"""Masses of a body: moments, second moments, and distributions in n dimensions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from scipy.integrate import nquad
from scipy.special import erf

from lie_rigid_body import ParameterError, RigidBody
from lie_rigid_body.groups import mass_matrix
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import (
    MassMoments,
    ball,
    box,
    cylinder,
    disc,
    ellipsoid,
    inertia_from_second_moment,
    moments_of_density,
    moments_of_points,
    moments_on_grid,
    rotated_second_moment,
    second_moment_about,
    second_moment_from_inertia,
)
from random_masses import assert_same, dimensions, direct_sum, random_points, rotation_of, seeds

UNIT = np.eye(3)


@given(seeds)
def test_three_dimensions_have_the_usual_inertia(seed):
    rng = np.random.default_rng(seed)
    x, m = random_points(3, rng)
    usual = sum(a * (p @ p * np.eye(3) - np.outer(p, p)) for a, p in zip(m, x, strict=True))
    K = moments_of_points(x, m).second_moment
    scale = np.trace(usual)
    np.testing.assert_allclose(inertia_from_second_moment(K), usual, rtol=0, atol=1e-14 * scale)
    np.testing.assert_allclose(mass_matrix(K, so3.hat(np.eye(3))), usual, rtol=0, atol=1e-14 * scale)
    np.testing.assert_allclose(second_moment_from_inertia(usual), K, rtol=0, atol=1e-14 * scale)


def test_the_inertia_of_a_needle_keeps_its_digits():
    K = np.diag([1e-20, 2e-20, 1.0])
    np.testing.assert_allclose(np.diag(inertia_from_second_moment(K)), [1.0, 1.0, 3e-20], rtol=1e-15)


@given(seeds)
def test_a_rigid_body_knows_its_second_moment(seed):
    rng = np.random.default_rng(seed)
    K = moments_of_points(*random_points(3, rng)).central_second_moment
    body = RigidBody.from_second_moment(K)
    np.testing.assert_allclose(body.second_moment, K, rtol=0, atol=1e-14 * np.trace(K))
    again = RigidBody(body.inertia)
    np.testing.assert_array_equal(again.second_moment, body.second_moment)


@pytest.mark.parametrize("moments", [[0.1, 0.2, 0.3], [0.3, 0.6, 0.9], [1.0, 2.0, 3.0], [1e-12, 1.0, 1.0]])
def test_flat_bodies_have_a_second_moment_in_spite_of_round_off(moments):
    turn = so3.exp([0.3, 0.7, -1.1])
    tensor = turn @ np.diag(moments) @ turn.T
    for inertia in (np.diag(moments), (tensor + tensor.T) / 2):
        K = RigidBody(inertia).second_moment
        np.testing.assert_allclose(inertia_from_second_moment(K), inertia, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    "body",
    [
        ball(1.0, 2.0),
        ellipsoid(1.0, [1.0, 2.0, 3.0]),
        box(1.0, [1.0, 2.0, 3.0]),
        cylinder(1.0, 1.0, 3.0),
        disc(1.0, 1.0),
    ],
)
def test_shapes_in_any_attitude_make_rigid_bodies(body):
    for turn in np.random.default_rng(0).normal(size=(50, 3)):
        turned = RigidBody.from_second_moment(body.rotated(so3.exp(turn)).second_moment)
        own = RigidBody.from_second_moment(body.second_moment)
        np.testing.assert_allclose(turned.principal_moments, own.principal_moments, rtol=1e-14, atol=0)


@given(dimensions, seeds)
def test_points_by_their_definition(n, seed):
    x, m = random_points(n, np.random.default_rng(seed))
    body = moments_of_points(x, m)
    expected = direct_sum(x, m)
    assert body.dimension == n
    assert body.mass == pytest.approx(sum(m), rel=1e-14)
    np.testing.assert_allclose(body.first_moment, sum(a * b for a, b in zip(m, x, strict=True)), rtol=0, atol=1e-12)
    np.testing.assert_allclose(body.second_moment, expected, rtol=0, atol=1e-13 * np.trace(expected))


@given(dimensions, seeds)
def test_another_origin_is_the_sum_over_points_from_there(n, seed):
    rng = np.random.default_rng(seed)
    x, m = random_points(n, rng)
    origin = rng.normal(size=n)
    body, expected = moments_of_points(x, m), direct_sum(x - origin, m)
    scale = np.trace(body.second_moment) + np.trace(expected)
    np.testing.assert_allclose(body.about(origin).second_moment, expected, rtol=0, atol=1e-13 * scale)
    shifted = second_moment_about(body.second_moment, body.mass, body.centre, origin)
    np.testing.assert_allclose(shifted, expected, rtol=0, atol=1e-13 * scale)
    central = second_moment_about(body.second_moment, body.mass, body.centre, body.centre)
    np.testing.assert_allclose(central, body.central_second_moment, rtol=0, atol=1e-13 * scale)
    np.testing.assert_array_equal(body.central_second_moment, body.about(origin).central_second_moment)


@given(dimensions, seeds)
def test_a_displaced_body_is_the_sum_over_displaced_points(n, seed):
    rng = np.random.default_rng(seed)
    x, m = random_points(n, rng)
    A, t = rotation_of(n, rng), rng.normal(size=n)
    body = moments_of_points(x, m)
    assert_same(body.moved(A, t), moments_of_points(x @ A.T + t, m))
    assert_same(body.rotated(A), moments_of_points(x @ A.T, m))
    turned = rotated_second_moment(body.second_moment, A)
    np.testing.assert_allclose(turned, direct_sum(x @ A.T, m), rtol=0, atol=1e-13 * np.trace(turned))
    np.testing.assert_array_equal(turned, turned.T)
    assert_same(body.moved(A, t).moved(A.T, -A.T @ t), body)


@given(dimensions, seeds)
def test_moments_of_parts_add_and_a_hole_is_taken_away(n, seed):
    rng = np.random.default_rng(seed)
    x, m = random_points(n, rng)
    part, rest, whole = moments_of_points(x[:4], m[:4]), moments_of_points(x[4:], m[4:]), moments_of_points(x, m)
    assert_same(part + rest, whole)
    assert_same(whole - part, rest, 1e-12)


@given(dimensions, seeds)
def test_smallest_second_moment_is_that_about_the_centre(n, seed):
    rng = np.random.default_rng(seed)
    body = moments_of_points(*random_points(n, rng))
    excess = body.about(body.centre + rng.normal(size=n)).second_moment - body.about(body.centre).second_moment
    assert np.linalg.eigvalsh(excess)[0] > -1e-13 * np.trace(excess)
    assert np.linalg.matrix_rank(excess, tol=1e-12) == 1


def test_a_flat_body_far_away_keeps_its_digits():
    turn = so3.exp([0.3, -0.4, 0.5])
    flat = disc(2.0, 1.0).rotated(turn)
    far = flat.moved(np.eye(3), [1e8, 2e8, -3e8])
    np.testing.assert_array_equal(far.central_second_moment, flat.central_second_moment)
    np.testing.assert_allclose((far + far).central_second_moment, 2 * flat.central_second_moment, rtol=0, atol=1e-15)
    RigidBody.from_second_moment(far.central_second_moment)


def test_moments_are_read_only_and_do_not_alias_their_arguments():
    centre, central = np.zeros(2), np.eye(2)
    body = MassMoments(1.0, centre, central)
    centre[0] = central[0, 0] = 5.0
    assert body.centre[0] == 0.0
    assert body.central_second_moment[0, 0] == 1.0
    for array in (body.centre, body.central_second_moment):
        with pytest.raises(ValueError):
            array[0] = 1.0


@pytest.mark.parametrize("shape", [(5,), (1, 1), (3, 4), (2, 3, 4), (2, 1, 3, 2)])
def test_a_grid_of_one_density_is_a_box_whatever_its_cells(shape):
    n = len(shape)
    low, edges = np.linspace(-1.0, 0.5, n), 0.4 + np.arange(n)
    body = moments_on_grid(np.full(shape, 2.5), low, low + edges)
    expected = box(2.5 * np.prod(edges), edges).moved(np.eye(n), low + edges / 2)
    assert_same(body, expected, 1e-14)


def test_a_grid_is_the_sum_of_its_cells():
    rng = np.random.default_rng(2)
    rho, low, steps = rng.uniform(0.0, 2.0, (3, 2, 4)), np.array([-1.0, 0.5, 2.0]), np.array([0.2, 0.7, 0.3])
    cells = None
    for index in np.ndindex(rho.shape):
        cell = box(rho[index] * np.prod(steps), steps).moved(np.eye(3), low + steps * (np.array(index) + 0.5))
        cells = cell if cells is None else cells + cell
    assert_same(moments_on_grid(rho, low, low + steps * rho.shape), cells)


def test_a_finer_grid_of_a_smooth_density_is_of_second_order():
    exact = nquad(lambda x, y: x * y * np.exp(-x * x - x * y), [(-1, 1), (0, 2)])[0]
    errors = []
    counts = [10, 20, 40, 80]
    for count in counts:
        x, y = np.meshgrid(
            -1 + 2 * (np.arange(count) + 0.5) / count, 2 * (np.arange(count) + 0.5) / count, indexing="ij"
        )
        errors.append(abs(moments_on_grid(np.exp(-x * x - x * y), [-1, 0], [1, 2]).second_moment[0, 1] - exact))
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(-2.0, abs=0.05)


def gaussian(x):
    return np.exp(-np.sum(x**2, axis=1) + x[:, 0] * x[:, -1])


def test_a_density_function_by_nested_quadrature():
    ends = [(-1.0, 0.5), (0.2, 2.0)]
    body = moments_of_density(gaussian, ends)

    def moment(i, j):
        return nquad(lambda x, y: x**i * y**j * gaussian(np.array([[x, y]]))[0], ends)[0]

    assert body.mass == pytest.approx(moment(0, 0), rel=1e-12)
    np.testing.assert_allclose(body.first_moment, [moment(1, 0), moment(0, 1)], rtol=1e-12)
    expected = [[moment(2, 0), moment(1, 1)], [moment(1, 1), moment(0, 2)]]
    np.testing.assert_allclose(body.second_moment, expected, rtol=1e-12)


@pytest.mark.parametrize("n", range(1, 5))
def test_independent_gaussians_in_any_dimension(n):
    """∫exp(−x²/2) = √(2π) erf(r/√2) on −r … r, and ∫exp(−x²/2) x² is less by 2 r exp(−r²/2)."""
    body = moments_of_density(lambda x: np.exp(-np.sum((x - 1.0) ** 2, axis=1) / 2), [(-3.0, 5.0)] * n, nodes=22)
    line = np.sqrt(2 * np.pi) * erf(4 / np.sqrt(2))
    assert body.mass == pytest.approx(line**n, rel=1e-10)
    np.testing.assert_allclose(body.centre, np.ones(n), rtol=0, atol=1e-10)
    expected = (1 - 8 * np.exp(-8) / line) * np.eye(n)
    np.testing.assert_allclose(body.central_second_moment / body.mass, expected, rtol=0, atol=1e-10)


def test_a_density_that_jumps_inside_is_refused_and_its_parts_are_exact():
    def step(x):
        return np.where(x[:, 0] < 0.3, 1.0, 4.0)

    with pytest.raises(ParameterError):
        moments_of_density(step, [(0.0, 1.0), (0.0, 1.0)])
    parts = moments_of_density(step, [(0.0, 0.3), (0.0, 1.0)]) + moments_of_density(step, [(0.3, 1.0), (0.0, 1.0)])
    left, right = box(0.3, [0.3, 1.0]), box(2.8, [0.7, 1.0])
    assert_same(parts, left.moved(np.eye(2), [0.15, 0.5]) + right.moved(np.eye(2), [0.65, 0.5]))


def test_a_hollow_ball_turned_and_shifted_by_quadrature_of_its_shells():
    """A thick shell between radii a and b: K = (4π/15)(b⁵ − a⁵) ρ."""
    a, b, rho = 0.6, 1.0, 3.0
    shell = ball(rho * 4 / 3 * np.pi * b**3, b) - ball(rho * 4 / 3 * np.pi * a**3, a)
    np.testing.assert_allclose(
        shell.second_moment, rho * 4 * np.pi / 15 * (b**5 - a**5) * np.eye(3), rtol=1e-14, atol=0
    )
