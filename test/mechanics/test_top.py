"""Kinds of tops, the momenta that their symmetry conserves, and the stability of their spins."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.groups import SO
from lie_rigid_body.groups.symmetries import conserved_momenta
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics.top import (
    SpinStability,
    SymmetricTop,
    conserved_body_axes,
    is_flat,
    kind_of_top,
    symmetry_axis,
)

TILT = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
KINDS = {
    "asymmetric": ([1.0, 2.0, 2.5], None),
    "oblate": ([1.0, 1.0, 1.8], 2),
    "prolate": ([0.2, 1.0, 1.0], 0),
    "spherical": ([0.7, 0.7, 0.7], None),
}

MOMENTS = [[1.0, 2.0, 3.0], [0.6, 0.8, 1.0], [7.872e-5, 3.3846e-4, 4.1526e-4], [1.0, 1.0, 1.8], [0.2, 1.0, 1.0]]


def turned(moments: list[float]) -> RigidBody:
    matrix = TILT @ np.diag(moments) @ TILT.T
    return RigidBody(0.5 * (matrix + matrix.T))


@pytest.mark.parametrize("kind", KINDS)
def test_the_kind_does_not_depend_on_the_order_of_the_axes_or_their_tilt(kind: str):
    moments, axis = KINDS[kind]
    for body in (RigidBody(moments), RigidBody(moments[::-1]), RigidBody(np.roll(moments, 1)), turned(moments)):
        assert kind_of_top(body) == kind
        assert symmetry_axis(body) == axis


def test_moments_that_differ_by_more_than_round_off_differ():
    assert kind_of_top(RigidBody([1.0, 1.0 + 1e-14, 1.8])) == "asymmetric"
    assert kind_of_top(RigidBody([1.0, 1.0 + 2e-16, 1.8])) == "oblate"
    assert kind_of_top(RigidBody([1.0, 1e-14, 0.0, 1.0, 0.0, 1.8])) == "asymmetric"


def test_flat_bodies():
    assert is_flat(RigidBody([1.0, 2.0, 3.0]))
    assert is_flat(turned([0.1, 0.2, 0.3]))
    assert not is_flat(RigidBody([1.0, 2.0, 2.999]))


@pytest.mark.parametrize("kind", KINDS)
def test_conserved_axes_are_those_about_which_the_inertia_can_be_turned(kind: str):
    body = turned(KINDS[kind][0])
    axes = conserved_body_axes(body)
    change = [so3.hat(e) @ body.inertia - body.inertia @ so3.hat(e) for e in np.eye(3)]
    singular = np.linalg.svd(np.reshape(change, (3, 9)))[1]
    assert len(axes) == np.count_nonzero(singular < 1e-12)
    np.testing.assert_allclose(axes @ axes.T, np.eye(len(axes)), atol=1e-14)
    assert all(np.abs(so3.hat(a) @ body.inertia - body.inertia @ so3.hat(a)).max() < 1e-14 for a in axes)


@pytest.mark.parametrize("kind", KINDS)
def test_they_are_what_the_condition_for_any_group_gives(kind: str):
    body = turned(KINDS[kind][0])
    axes, directions = conserved_body_axes(body), conserved_momenta(SO(3), body.inertia)
    np.testing.assert_allclose(axes.T @ axes, directions.T @ directions, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_the_body_momentum_along_them_is_constant(kind: str):
    body, start = turned(KINDS[kind][0]), State([0.0, 0.0, 0.0, 1.0], [0.4, -0.9, 1.3])
    along = body.body_momentum(ClosedForm(body, start).at(np.arange(0, 10**10, 10**8))) @ conserved_body_axes(body).T
    assert np.ptp(along, axis=0).max(initial=0.0) < 1e-14


@pytest.mark.parametrize("moments", [[1.0, 1.0, 1.8], [0.2, 1.0, 1.0], [1.0, 0.3, 1.0], [1.0, 1.0, 2.0]])
@pytest.mark.parametrize("rate", [[0.4, 0.1, 2.0], [-3.0, -0.5, -0.2], [0.3, 4.0, 0.0]])
def test_a_symmetric_top_makes_two_uniform_rotations(moments: list[float], rate: list[float]):
    body, start = RigidBody(moments), State([0.1, -0.7, 0.1, 0.7], rate)
    top = SymmetricTop.of(body, start)
    assert top is not None
    k = moments.index(max(moments, key=lambda moment: moments.count(moment) == 1))
    axis = np.eye(3)[k]
    seconds = np.linspace(0.0, 3.0, 7)
    states = ClosedForm(body, start).at(np.round(seconds * 1e9).astype(np.int64))
    attitudes = Rotation.from_quat(states.attitude_xyzw).as_matrix()
    momentum = body.angular_momentum(start)
    momentum /= np.linalg.norm(momentum)
    for t, attitude, omega in zip(seconds, attitudes, states.body_rate, strict=True):
        turned_rate = so3.exp(top.body_precession_rate_rad_s * t * axis) @ start.body_rate
        np.testing.assert_allclose(omega, turned_rate, atol=1e-13)
        circled = so3.exp(top.space_precession_rate_rad_s * t * momentum) @ attitudes[0] @ axis
        np.testing.assert_allclose(attitude @ axis, circled, atol=1e-13)
        assert angle(attitude @ axis, momentum) == pytest.approx(top.tilt_rad, abs=1e-7)
        assert angle(omega, axis) == pytest.approx(top.rate_to_axis_rad, abs=1e-7)
        assert angle(attitude @ omega, momentum) == pytest.approx(top.rate_to_momentum_rad, abs=1e-7)
    assert top.axial_rate_rad_s == rate[k]
    assert math.hypot(top.axial_rate_rad_s, top.transverse_rate_rad_s) == pytest.approx(math.hypot(*rate))


def angle(a: np.ndarray, b: np.ndarray) -> float:
    """Between the lines along two vectors."""
    return math.acos(min(1.0, abs(float(a @ b)) / float(np.linalg.norm(a) * np.linalg.norm(b))))


@pytest.mark.parametrize("moments", [[1.0, 2.0, 3.0], [1.0, 1.0, 1.0]])
def test_no_other_body_is_a_symmetric_top(moments: list[float]):
    assert SymmetricTop.of(RigidBody(moments), State([0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 3.0])) is None


def eigenvalues(moments: list[float], axis: int, spin_rate: float) -> np.ndarray:
    """Of δ ↦ M⁻¹(Mδ × ω + Mω × δ)."""
    M, omega = np.diag(moments), spin_rate * np.eye(3)[axis]
    return np.linalg.eigvals(np.linalg.inv(M) @ (so3.hat(M @ omega) - so3.hat(omega) @ M))


@pytest.mark.parametrize("moments", [*MOMENTS, [2.0, 2.0, 2.0]])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("spin_rate", [1.0, 12.0])
def test_rates_are_the_eigenvalues(moments: list[float], axis: int, spin_rate: float):
    spin, values = SpinStability.of(moments, axis, spin_rate), eigenvalues(moments, axis, spin_rate)
    # a double eigenvalue 0 is found to the square root of round-off
    assert spin.growth_rate_1_s == pytest.approx(values.real.max(), rel=1e-12, abs=1e-7 * spin_rate)
    assert spin.wobble_rate_rad_s == pytest.approx(np.abs(values.imag).max(), rel=1e-12, abs=1e-7 * spin_rate)


@pytest.mark.parametrize("moments", MOMENTS[:3])
def test_the_intermediate_axis_alone_is_unstable(moments: list[float]):
    verdicts = [SpinStability.of(moments, i, 1.0).verdict for i in range(3)]
    assert verdicts == ["stable", "unstable", "stable"]
    small, middle, large = moments
    growth = 5.0 * math.sqrt((middle - small) * (large - middle) / (small * large))
    assert SpinStability.of(moments, 1, 5.0).growth_rate_1_s == pytest.approx(growth, rel=1e-13)


def test_equal_moments_are_neutral():
    assert [SpinStability.of([1.0, 1.0, 1.8], i, 1.0).verdict for i in range(3)] == ["neutral", "neutral", "stable"]
    assert [SpinStability.of([0.2, 1.0, 1.0], i, 1.0).verdict for i in range(3)] == ["stable", "neutral", "neutral"]
    assert [SpinStability.of([2.0, 2.0, 2.0], i, 1.0).verdict for i in range(3)] == ["neutral"] * 3


def test_a_stability_of_no_spin_has_no_rates():
    assert SpinStability.of([1.0, 2.0, 3.0], 1, 0.0) == SpinStability("unstable", 0.0, 0.0, 0.0)
