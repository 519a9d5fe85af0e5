"""The body and its state: accepted forms of inertia, refusals, principal axes, and what the motion conserves."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lie_rigid_body import ParameterError, RigidBody, State
from lie_rigid_body.lie import so3

# semi-axes of an ellipsoid give every physical set of moments
semi_axes = st.tuples(*[st.floats(0.01, 10.0)] * 3)
turns = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


def ellipsoid_moments(axes):
    a, b, c = (x * x for x in axes)
    return np.array([b + c, a + c, a + b])


def test_the_three_forms_agree():
    moments, six = RigidBody([1.0, 2.0, 3.0]), RigidBody([1.0, 0.0, 0.0, 2.0, 0.0, 3.0])
    full = RigidBody(np.diag([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(moments.inertia, six.inertia)
    np.testing.assert_array_equal(moments.inertia, full.inertia)
    products = RigidBody([1.0, 0.1, -0.05, 1.4, 0.2, 1.9])
    np.testing.assert_array_equal(products.inertia, [[1.0, 0.1, -0.05], [0.1, 1.4, 0.2], [-0.05, 0.2, 1.9]])


@given(semi_axes, turns)
def test_principal_axes_diagonalise_the_tensor(axes, turn):
    rotation = so3.exp(turn)
    tensor = rotation @ np.diag(ellipsoid_moments(axes)) @ rotation.T
    body = RigidBody((tensor + tensor.T) / 2)
    scale = body.principal_moments[2]
    assert np.linalg.det(body.principal_axes) == pytest.approx(1.0)
    np.testing.assert_allclose(np.sort(ellipsoid_moments(axes)), body.principal_moments, rtol=0, atol=1e-14 * scale)
    rebuilt = body.principal_axes @ np.diag(body.principal_moments) @ body.principal_axes.T
    np.testing.assert_allclose(rebuilt, body.inertia, rtol=0, atol=1e-14 * scale)


def test_angular_acceleration_obeys_eulers_equations():
    """In principal axes ω̇₁ = (I₂ − I₃)/I₁ ω₂ω₃ and cyclically."""
    rate = np.array([[0.3, -0.2, 0.5], [1.0, 2.0, -3.0]])
    states = State(np.tile([0.0, 0.0, 0.0, 1.0], (2, 1)), rate)
    expected = np.array([-1.0 / 1.0, 2.0 / 2.0, -1.0 / 3.0]) * rate[:, [1, 2, 0]] * rate[:, [2, 0, 1]]
    np.testing.assert_allclose(RigidBody([1.0, 2.0, 3.0]).angular_acceleration(states), expected, rtol=1e-15)


def test_diagonal_moments_are_kept_exactly_in_any_order():
    for order in ([0.3, 0.1, 0.25], [3.0, 1.0, 2.5], [2.0, 2.0, 1.0]):
        body = RigidBody(order)
        np.testing.assert_array_equal(body.principal_moments, np.sort(order))
        np.testing.assert_array_equal(
            body.principal_axes @ np.diag(np.sort(order)) @ body.principal_axes.T, np.diag(order)
        )
        assert np.linalg.det(body.principal_axes) == 1.0


@given(semi_axes, st.sampled_from([0.0, 1.0]), turns)
def test_a_rotated_tensor_is_accepted_in_spite_of_its_round_off(axes, third, turn):
    moments, rotation = ellipsoid_moments([axes[0], axes[1], third * axes[2]]), so3.exp(turn)
    tensor = rotation @ np.diag(moments) @ rotation.T
    body = RigidBody(tensor)
    np.testing.assert_array_equal(body.inertia, body.inertia.T)
    np.testing.assert_allclose(body.inertia, tensor, rtol=0, atol=4 * np.spacing(moments.max()))


def test_a_tensor_is_symmetric_to_eight_units_in_the_last_place():
    def tensor(ulps):
        return np.diag([1.0, 2.0, 2.5]) + np.array([[0, ulps, 0], [0, 0, 0], [0, 0, 0]]) * np.spacing(2.5)

    assert RigidBody(tensor(8)).inertia[1, 0] == RigidBody(tensor(8)).inertia[0, 1] == 4 * np.spacing(2.5)
    with pytest.raises(ParameterError):
        RigidBody(tensor(9))


@pytest.mark.parametrize(
    ("moments", "digits"),
    [
        ([0.0833333, 0.0833333, 0.166667], "6"),
        ([0.345, 0.653, 1.0], "3"),
        ([1.0, 1.0, 2.1], ""),
        ([2.0, 1.0, 2 / 3], ""),
    ],
)
def test_a_broken_triangle_inequality_tells_by_how_much_and_what_would_do(moments, digits):
    with pytest.raises(ParameterError) as caught:
        RigidBody(moments)
    small, middle, large = sorted(moments)
    told = re.findall(r"by ([\d.e-]+)(?:, .*? (\d+) digits)?.*: .* at most ([\d.e-]+);", str(caught.value))
    assert float(told[0][0]) == pytest.approx(large - middle - small, rel=1e-2)
    assert told[0][1] == digits
    RigidBody([small, middle, float(told[0][2])])


@given(semi_axes, turns, turns)
def test_energy_and_momentum_are_what_the_definitions_say(axes, turn, rate):
    body = RigidBody(ellipsoid_moments(axes))
    state = State(np.array([*np.sin(0.5) * np.array([0.6, 0.0, 0.8]), np.cos(0.5)]), rate)
    momentum = so3.exp([0.6, 0.0, 0.8]) @ body.inertia @ np.array(rate)
    scale = body.principal_moments[2] * 10
    np.testing.assert_allclose(body.angular_momentum(state), momentum, rtol=0, atol=1e-15 * scale)
    energy = 0.5 * np.array(rate) @ body.inertia @ np.array(rate)
    np.testing.assert_allclose(body.kinetic_energy(state), energy, rtol=1e-14, atol=1e-300)


def test_quantities_are_batched():
    body = RigidBody([1.0, 2.0, 3.0])
    states = State(np.tile([0, 0, 0, 1.0], (5, 1)), np.arange(15.0).reshape(5, 3))
    assert body.kinetic_energy(states).shape == (5,)
    assert body.angular_momentum(states).shape == (5, 3)
    np.testing.assert_array_equal(body.angular_momentum(states)[3], body.angular_momentum(states[3]))


def test_nearly_unit_quaternions_are_normalised_and_nothing_else_is_touched():
    state = State([0, 0, 0, 1.0000009], [1, 2, 3])
    np.testing.assert_array_equal(state.attitude_xyzw, [0, 0, 0, 1])
    np.testing.assert_array_equal(state.body_rate, [1, 2, 3])


def test_a_state_is_immutable_and_does_not_alias_its_arguments():
    rate = np.array([1.0, 2.0, 3.0])
    state = State([0, 0, 0, 1], rate)
    rate[0] = 9.0
    assert state.body_rate[0] == 1.0
    with pytest.raises(ValueError):
        state.body_rate[0] = 5.0
    with pytest.raises(AttributeError):
        state.body_rate = rate


def test_a_body_keeps_the_inertia_that_its_moments_are_of():
    body = RigidBody([1, 2, 3])
    for name in ("inertia", "inverse_inertia", "principal_moments", "principal_axes"):
        with pytest.raises(AttributeError):
            setattr(body, name, np.eye(3))
    assert body.principal_moments.tolist() == [1.0, 2.0, 3.0]
