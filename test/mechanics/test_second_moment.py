"""The second moment in three dimensions and the usual inertia that it gives; and what is no second moment."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given

from lie_rigid_body import ParameterError, RigidBody
from lie_rigid_body.groups import mass_matrix
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import (
    ball,
    box,
    cylinder,
    disc,
    ellipsoid,
    inertia_from_second_moment,
    moments_of_points,
    rod,
    rotated_second_moment,
    second_moment_about,
    second_moment_from_inertia,
)
from random_masses import random_points, seeds

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


@pytest.mark.parametrize(
    ("build", "name"),
    [
        (lambda: second_moment_about(UNIT, 1.0, [2.0, 0, 0], [0, 0, 0]), "second moment about the centre of mass"),
        (lambda: second_moment_about(UNIT, 1.0, [0.0, 0], [0, 0]), "centre"),
        (lambda: rotated_second_moment(UNIT, 1.001 * UNIT), "rotation"),
        (lambda: inertia_from_second_moment(np.eye(4)), "second moment"),
        (lambda: second_moment_from_inertia(np.diag([1, 1, 2.1])), "second moment ½ tr(I) 1 − I of the inertia"),
        (lambda: second_moment_from_inertia(np.eye(2)), "inertia"),
        (lambda: RigidBody.from_second_moment(np.diag([1, 1, -1])), "second moment"),
        (lambda: inertia_from_second_moment(1e308 * np.eye(3)), "second moment"),
        (lambda: rotated_second_moment(1e308 * np.ones((3, 3)), UNIT), "second moment"),
        (lambda: rotated_second_moment(UNIT, 1e160 * UNIT), "rotation"),
        (lambda: second_moment_from_inertia(np.diag([1e308, 2, 3])), "second moment ½ tr(I) 1 − I of the inertia"),
        (lambda: rod(1.0, 1e308), "second moment"),
    ],
)
def test_impossible_second_moments_are_refused(build, name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ParameterError) as caught:
            build()
    assert caught.value.name == name


def test_a_rod_has_moments_and_is_no_rigid_body():
    with pytest.raises(ParameterError):
        RigidBody.from_second_moment(rod(1.0, 1.0).second_moment)
