"""Mass, centre and second moment in n dimensions: what they are of points, and how they move, turn and add up."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from lie_rigid_body import ParameterError, RigidBody
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import (
    MassMoments,
    ball,
    disc,
    moments_of_points,
    rotated_second_moment,
    second_moment_about,
)
from random_masses import assert_same, dimensions, direct_sum, random_points, rotation_of, seeds

UNIT = np.eye(3)


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


@pytest.mark.parametrize(
    ("build", "name"),
    [
        (lambda: MassMoments(0.0, np.zeros(2), np.eye(2)), "mass"),
        (lambda: MassMoments(1.0, np.zeros(2), UNIT), "centre"),
        (lambda: MassMoments(1.0, np.zeros(3), np.diag([1, 1, -0.5])), "second moment"),
        (lambda: ball(1.0, 1.0) + ball(1.0, 1.0, 4), "body"),
        (lambda: ball(1.0, 1.0) - ball(1.0, 1.0), "mass"),
        (lambda: ball(2.0, 1.0) - ball(1.0, 3.0), "second moment"),
        (lambda: ball(1.0, 1.0).rotated(2 * UNIT), "rotation"),
        (lambda: ball(1.0, 1.0).rotated(np.eye(2)), "rotation"),
        (lambda: ball(1.0, 1.0).moved(UNIT, [1.0]), "translation"),
        (lambda: ball(1.0, 1.0).about([1.0]), "origin"),
    ],
)
def test_impossible_moments_are_refused(build, name):
    with pytest.raises(ParameterError) as caught:
        build()
    assert caught.value.name == name


def test_moments_are_read_only_and_do_not_alias_their_arguments():
    centre, central = np.zeros(2), np.eye(2)
    body = MassMoments(1.0, centre, central)
    centre[0] = central[0, 0] = 5.0
    assert body.centre[0] == 0.0
    assert body.central_second_moment[0, 0] == 1.0
    for array in (body.centre, body.central_second_moment):
        with pytest.raises(ValueError):
            array[0] = 1.0
