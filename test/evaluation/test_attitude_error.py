"""Total, heading and inclination error: the definition, in 50 digits, and its laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp
from scipy.spatial.transform import Rotation

import lie_rigid_body
from lie_rigid_body.evaluation import attitude_error
from lie_rigid_body.evaluation.attitudes import angles, error_vectors
from lie_rigid_body.lie import quaternion

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
SIZES = [*np.logspace(-150, -1, 60), *np.linspace(0.2, 3.1, 12), *(np.pi - np.logspace(-15, -2, 14)), np.pi]
AXES = np.array([[1, 0, 0], [0, 0, 1], [0.6, -0.8, 0], [0.36, 0.48, -0.8], [1e-9, 1, 1e-5], [1e-7, 0, 1]])

components = st.floats(-1.0, 1.0)
rotations = (
    st.tuples(components, components, components, components)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(quaternion.normalize)
)
angle = st.floats(-np.pi, np.pi)


def definition(error_xyzw):
    """BROAD's arccos and arctan in 50 digits."""
    x, y, z, w = (mp.mpf(v) for v in error_xyzw)
    n = mp.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / n, y / n, z / n, w / n
    heading = 2 * mp.atan(abs(z / w)) if w else (mp.pi if z else mp.mpf(0))
    return 2 * mp.acos(abs(w)), heading, 2 * mp.acos(min(mp.sqrt(w * w + z * z), mp.mpf(1)))


@pytest.mark.parametrize("axis", AXES / np.linalg.norm(AXES, axis=-1)[:, np.newaxis])
def test_angles_are_the_definition_to_fifteen_digits_from_0_to_pi(axis):
    errors = quaternion.exp(np.outer(SIZES, axis))
    with mp.workdps(400):
        wanted = np.array([[float(a) for a in definition(e)] for e in errors])
    np.testing.assert_allclose(np.stack(angles(errors), axis=-1), wanted, rtol=1e-15, atol=1e-190)


def test_a_turn_about_the_vertical_is_all_heading_and_a_tilt_all_inclination():
    turned, tilted = quaternion.exp([[0.0, 0.0, -0.3], [0.3, 0.4, 0.0]])
    truth = quaternion.normalize([0.3, -0.2, 0.5, 0.7])
    np.testing.assert_allclose(attitude_error(quaternion.multiply(turned, truth), truth), [0.3, 0.3, 0.0], atol=1e-15)
    np.testing.assert_allclose(attitude_error(quaternion.multiply(tilted, truth), truth), [0.5, 0.0, 0.5], atol=1e-15)


def test_half_a_turn_of_inclination_has_no_heading_whatever_its_round_off():
    rng = np.random.default_rng(1)
    truth, azimuth = quaternion.normalize(rng.normal(size=(1000, 4))), rng.uniform(-np.pi, np.pi, 1000)
    flip = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(1000), np.zeros(1000)], axis=-1)
    error = attitude_error(quaternion.multiply(flip, truth), truth)
    np.testing.assert_array_equal(error.heading, 0.0)
    np.testing.assert_allclose([error.total, error.inclination], np.pi, rtol=0, atol=1e-14)
    # a heading is there as soon as it is more than round-off
    near = quaternion.normalize([1.0, 0.0, 3e-14, 3e-14])
    assert attitude_error(quaternion.multiply(near, truth), truth).heading == pytest.approx(np.pi / 2, abs=0.2)


def test_bits_do_not_depend_on_what_lies_beside_in_memory():
    """As NumPy 1.26 makes them for arrays with strides, on processors with AVX-512."""
    rng = np.random.default_rng(1)
    for count in range(1, 401):
        errors = quaternion.exp(rng.normal(scale=1e-3, size=(count, 3)))
        seen = {np.stack([*angles(errors), *np.moveaxis(quaternion.log(errors), -1, 0)]).tobytes() for _ in range(5)}
        assert len(seen) == 1, f"{count} errors have {len(seen)} sets of angles"


@given(rotations, rotations)
def test_total_is_scipys_and_inclination_the_angle_between_the_verticals(p, q):
    total, _, inclination = attitude_error(p, q)
    P, Q = Rotation.from_quat(p), Rotation.from_quat(q)
    assert total == pytest.approx((P * Q.inv()).magnitude(), abs=1e-14)
    up = [0.0, 0.0, 1.0]
    a, b = P.inv().apply(up), Q.inv().apply(up)
    assert inclination == pytest.approx(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b), abs=1e-14)


@given(rotations, rotations)
def test_cosines_of_the_half_angles_multiply(p, q):
    total, heading, inclination = attitude_error(p, q)
    assert np.cos(total / 2) == pytest.approx(np.cos(heading / 2) * np.cos(inclination / 2), abs=1e-15)
    assert max(heading, inclination) <= total + 1e-15


@given(rotations, rotations, angle, rotations)
def test_turning_the_world_about_up_or_both_bodies_alike_changes_nothing(p, q, yaw, body):
    turn = quaternion.exp([0.0, 0.0, yaw])
    same = [quaternion.multiply(quaternion.multiply(turn, r), body) for r in (p, q)]
    # near half a turn of inclination the heading is the angle of a short vector
    if attitude_error(p, q).inclination < 3.1:
        np.testing.assert_allclose(attitude_error(*same), attitude_error(p, q), rtol=0, atol=2e-13)


@given(rotations, rotations)
def test_estimate_and_truth_may_change_places_and_signs_do_not_matter(p, q):
    np.testing.assert_allclose(attitude_error(q, p), attitude_error(p, q), rtol=0, atol=1e-15)
    np.testing.assert_array_equal(attitude_error(-p, q), attitude_error(p, q))


def test_norm_does_not_matter():
    p, q = quaternion.normalize([[0.1, 0.2, 0.3, 0.4], [0.3, 0.2, -0.3, 0.4]])
    np.testing.assert_allclose(attitude_error(1e-9 * p, 7.0 * q), attitude_error(p, q), rtol=1e-15)


def test_vectors_on_the_worlds_and_on_the_bodys_axes_are_one_vector():
    rng = np.random.default_rng(3)
    p, q = quaternion.normalize(rng.normal(size=(2, 30, 4)))
    np.testing.assert_allclose(
        quaternion.rotate(q, error_vectors(p, q, "body")), error_vectors(p, q), rtol=0, atol=1e-13
    )


def test_one_truth_serves_many_estimates_and_it_is_public():
    assert lie_rigid_body.attitude_error is attitude_error
    assert attitude_error(np.tile(IDENTITY, (5, 1)), IDENTITY).heading.shape == (5,)
