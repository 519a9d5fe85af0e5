"""Laws of the rotation group: axioms, homomorphisms, duality of the Jacobians, batching."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.lie import quaternion, so3

components = st.floats(-3.0, 3.0)
vectors = st.tuples(components, components, components).map(np.array)


@given(vectors, vectors)
def test_hat_is_the_cross_product_and_vee_its_inverse(v, x):
    np.testing.assert_allclose(so3.hat(v) @ x, np.cross(v, x), rtol=0, atol=1e-14)
    np.testing.assert_array_equal(so3.vee(so3.hat(v)), v)


def test_generators_obey_the_algebra_with_plus_epsilon():
    t = so3.hat(np.eye(3))
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.testing.assert_array_equal(t[a] @ t[b] - t[b] @ t[a], t[c])


@given(vectors, vectors)
def test_group_axioms(v, w):
    p, q = quaternion.exp(v), quaternion.exp(w)
    np.testing.assert_allclose(quaternion.multiply(p, quaternion.conjugate(p)), [0, 0, 0, 1], rtol=0, atol=1e-15)
    product = so3.exp(v) @ so3.exp(w)
    np.testing.assert_allclose(quaternion.to_matrix(quaternion.multiply(p, q)), product, rtol=0, atol=8e-15)
    np.testing.assert_allclose(product @ product.T, np.eye(3), rtol=0, atol=8e-15)


@given(vectors, vectors)
def test_rotation_agrees_with_scipy(v, x):
    rotation = Rotation.from_rotvec(v)
    np.testing.assert_allclose(so3.exp(v), rotation.as_matrix(), rtol=0, atol=8e-15)
    np.testing.assert_allclose(quaternion.rotate(quaternion.exp(v), x), rotation.apply(x), rtol=0, atol=2e-14)
    np.testing.assert_allclose(so3.log(so3.exp(v)), rotation.as_rotvec(), rtol=0, atol=1e-13)


@given(vectors)
def test_jacobians_are_dual_and_inverse(v):
    left, right = so3.left_jacobian(v), so3.right_jacobian(v)
    np.testing.assert_allclose(left, so3.exp(v) @ right, rtol=0, atol=1e-14)
    np.testing.assert_allclose(left, right.T, rtol=0, atol=1e-15)
    np.testing.assert_allclose(left @ so3.left_jacobian_inverse(v), np.eye(3), rtol=0, atol=1e-12)


@given(vectors, vectors)
def test_left_jacobian_is_the_derivative_of_exp(v, w):
    """exp(v + εw) exp(v)⁻¹ = exp(ε J w) + O(ε²), by a central difference."""
    eps = 1e-5
    ahead, behind = so3.exp(v + eps * w), so3.exp(v - eps * w)
    derivative = so3.vee((ahead - behind) / (2 * eps) @ so3.exp(v).T)
    np.testing.assert_allclose(so3.left_jacobian(v) @ w, derivative, rtol=0, atol=2e-8)


@pytest.mark.parametrize("size", [1e-308, 1e-160, 1e-150, 1e8, 1e150, 1e160, 1e307])
def test_exp_is_that_of_quaternions_at_any_angle(size):
    """Squares of such vectors overflow or underflow."""
    v = size * np.array([0.3, -1.1, 0.7])
    exact = quaternion.to_matrix(quaternion.exp(v))
    np.testing.assert_allclose(so3.exp(v), exact, rtol=0, atol=1e-15)
    np.testing.assert_allclose(so3.vee(so3.exp(v)), so3.vee(exact), rtol=1e-14, atol=0)


def test_full_turn_is_minus_one_on_the_cover():
    np.testing.assert_allclose(quaternion.exp([0, 0, 2 * np.pi]), [0, 0, 0, -1], rtol=0, atol=3e-16)


def test_a_batch_gives_the_bits_of_its_rows():
    rng = np.random.default_rng(7)
    v = rng.normal(size=(37, 3))
    q = quaternion.exp(v)
    for function, argument in (
        (quaternion.exp, v),
        (so3.left_jacobian, v),
        (quaternion.log, q),
        (quaternion.to_matrix, q),
    ):
        rows = np.stack([function(row) for row in argument])
        np.testing.assert_array_equal(function(argument), rows)
    assert so3.exp(v.reshape(37, 1, 3)).shape == (37, 1, 3, 3)


@pytest.mark.parametrize(
    ("function", "name"),
    [
        *((f, "rotation vectors") for f in (so3.hat, so3.exp, so3.left_jacobian, quaternion.exp)),
        (quaternion.log, "quaternions"),
        (so3.vee, "rotation matrices"),
    ],
)
@pytest.mark.parametrize("given", [np.zeros(5), "x", {}, [10**400]], ids=range(4))
def test_a_wrong_shape_is_refused(function, name, given):
    with pytest.raises(ParameterError) as caught:
        function(given)
    assert caught.value.name == name


def test_importing_the_room_does_not_wait_for_scipy():
    said = "import sys, lie_rigid_body.lie; sys.exit('scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", said], check=False).returncode == 0


@pytest.mark.parametrize("count", [1, 2, 7])
def test_a_running_product_is_that_of_one_after_the_other(count):
    q = quaternion.exp(np.random.default_rng(count).normal(size=(count, 3)))
    expected = [q[0]]
    for each in q[1:]:
        expected.append(quaternion.multiply(expected[-1], each))
    np.testing.assert_allclose(quaternion.running_product(q), expected, rtol=0, atol=1e-14)
