"""Laws of the double cover SU(2) → SO(3)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.groups import SU, double_cover
from lie_rigid_body.lie import quaternion, so3

PAULI = np.array([[[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]])
AXIS = np.array([2.0, -3.0, 6.0]) / 7.0

components = st.floats(-4.0, 4.0)
vectors = st.tuples(components, components, components).map(np.array)


def turning(turns: float, count: int = 33) -> np.ndarray:
    """Rotations about one axis, from 0 to a number of turns."""
    return np.array([so3.exp(angle * AXIS) for angle in np.linspace(0.0, 2 * np.pi * turns, count)])


@given(vectors, vectors)
def test_the_map_is_a_homomorphism_with_kernel_plus_minus_one(v, w):
    U, V = SU(2).exp(v), SU(2).exp(w)
    product = double_cover.rotation(U) @ double_cover.rotation(V)
    np.testing.assert_allclose(double_cover.rotation(U @ V), product, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(double_cover.rotation(-U), double_cover.rotation(U))


@given(vectors)
def test_the_rotation_is_that_of_the_pauli_matrices(v):
    """Rⁱʲ = ½ tr(σⁱ U σʲ U†), and equally the adjoint representation of SU(2)."""
    U = SU(2).exp(v)
    turned = U @ PAULI @ U.conj().T
    traces = 0.5 * np.einsum("iab,jba->ij", PAULI, turned).real
    np.testing.assert_allclose(double_cover.rotation(U), traces, rtol=0, atol=1e-14)
    np.testing.assert_allclose(double_cover.rotation(U), SU(2).Ad(U), rtol=0, atol=1e-14)


@given(vectors, vectors)
def test_quaternions_are_elements_of_su2(v, w):
    p, q = quaternion.exp(v), quaternion.exp(w)
    P, Q = double_cover.from_quaternion(p), double_cover.from_quaternion(q)
    np.testing.assert_allclose(P, SU(2).exp(v), rtol=0, atol=4e-15)
    np.testing.assert_allclose(P @ Q, double_cover.from_quaternion(quaternion.multiply(p, q)), rtol=0, atol=4e-15)
    np.testing.assert_array_equal(double_cover.to_quaternion(P), p)
    np.testing.assert_array_equal(double_cover.from_quaternion(quaternion.conjugate(p)), P.conj().T)
    np.testing.assert_array_equal(double_cover.rotation(P), quaternion.to_matrix(p))


@given(vectors)
def test_a_rotation_has_two_opposite_preimages(v):
    R = so3.exp(v)
    first, second = double_cover.preimages(R)
    np.testing.assert_array_equal(first, -second)
    np.testing.assert_allclose(double_cover.rotation(first), R, rtol=0, atol=4e-15)
    U = SU(2).exp(v)
    assert min(np.abs(first - U).max(), np.abs(second - U).max()) <= 4e-15
    assert np.trace(first).real >= 0.0


@pytest.mark.parametrize(("turns", "end"), [(0.0, 1.0), (1.0, -1.0), (2.0, 1.0), (3.0, -1.0), (-1.0, -1.0)])
def test_the_lift_of_a_closed_path_closes_after_two_turns(turns, end):
    lifted = double_cover.lift(turning(turns))
    np.testing.assert_allclose(lifted[0], np.eye(2), rtol=0, atol=0)
    np.testing.assert_allclose(lifted[-1], end * np.eye(2), rtol=0, atol=1e-14)


def test_the_lift_covers_its_path_without_jumps():
    path = turning(5.3, 200)
    lifted = double_cover.lift(path)
    angles = np.linspace(0.0, 2 * np.pi * 5.3, 200)
    np.testing.assert_allclose(double_cover.rotation(lifted), path, rtol=0, atol=4e-15)
    np.testing.assert_allclose(lifted, SU(2).exp(angles[:, np.newaxis] * AXIS), rtol=0, atol=2e-14)


def test_steps_of_a_path_are_at_most_a_quarter_turn():
    with pytest.raises(InputError):
        double_cover.lift(turning(1.0, 4))
    assert len(double_cover.lift(turning(1.0, 5))) == 5


def test_a_batch_gives_its_rows():
    v = np.random.default_rng(61).normal(size=(4, 5, 3))
    q, R = quaternion.exp(v), so3.exp(v)
    U = double_cover.from_quaternion(q)
    assert U.shape == (4, 5, 2, 2)
    np.testing.assert_array_equal(U[2, 3], double_cover.from_quaternion(q[2, 3]))
    np.testing.assert_array_equal(double_cover.to_quaternion(U)[2, 3], q[2, 3])
    np.testing.assert_array_equal(double_cover.rotation(U)[2, 3], double_cover.rotation(U[2, 3]))
    np.testing.assert_array_equal(double_cover.preimages(R)[1][2, 3], double_cover.preimages(R[2, 3])[1])
