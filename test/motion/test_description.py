"""The description of a motion against its states, and against formulas of textbooks in double precision."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.motion.description import describe

TILTED = np.array([0.1, -0.7, 0.3, -0.5]) / math.sqrt(0.84)
UPRIGHT = [0.0, 0.0, 0.0, 1.0]

ASYMMETRIC = {
    "about the largest": ([0.6, 0.8, 1.0], [0.3, 0.5, -1.1]),
    "about the smallest": ([0.6, 0.8, 1.0], [3.0, 0.5, -0.9]),
    "axes out of order": ([1.0, 0.6, 0.8], [-0.9, 3.0, -0.5]),
    "flat": ([0.25, 0.5, 0.75], [1.5, 0.4, 0.8]),
    "flipping": ([1.0, 2.0, 3.0], [0.01, 1.0, 0.01]),
    "flipping, backward": ([1.0, 2.0, 3.0], [-0.01, -1.0, 0.02]),
    "starting in a flip": ([1.0, 2.0, 3.0], [0.5, 0.0, 0.4]),
    "starting between flips": ([0.6, 0.8, 1.0], [0.0, 0.9, 0.7]),
    "products": ([1.0, 0.1, -0.05, 1.4, 0.2, 1.9], [0.4, -1.2, 0.7]),
    "small": ([7.872e-5, 3.3846e-4, 4.1526e-4], [0.2, 12.0, 0.1]),
}
SYMMETRIC = {
    "oblate": ([1.0, 1.0, 1.8], [0.3, 0.5, 1.1]),
    "prolate": ([2.0, 0.5, 2.0], [0.3, 1.5, -0.4]),
}
ON_SEPARATRIX = [3.0, 4.0, 6.0]
PERIODIC = ASYMMETRIC | SYMMETRIC
EVERY_ASYMMETRIC = pytest.mark.parametrize("name", ASYMMETRIC)
EVERY_PERIODIC = pytest.mark.parametrize("name", PERIODIC)


def made(name: str) -> tuple[RigidBody, State, Any]:
    """A body, a start, and the circulation of its motion."""
    inertia, rate = PERIODIC[name]
    body, start = RigidBody(inertia), State(TILTED, rate)
    return body, start, describe(body, start).circulation


def described(inertia: list[float], rate: list[float]) -> Any:
    return describe(RigidBody(inertia), State(UPRIGHT, rate))


def states_at(body: RigidBody, start: State, seconds: np.ndarray) -> State:
    return ClosedForm(body, start).at(np.round(seconds * 1e9).astype(np.int64))


def angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1))


@EVERY_PERIODIC
def test_period_and_parameter_are_those_of_the_textbook(name: str):
    """Landau, Lifshitz, Mechanics, eqs. 37.9-37.12, with the first and third moments exchanged where needed."""
    body, start, circulation = made(name)
    first, second, third = (float(moment) for moment in body.principal_moments)
    double_energy = 2.0 * float(body.kinetic_energy(start))
    square = float(np.sum(body.body_momentum(start) ** 2))
    if square < double_energy * second:
        first, third = third, first
    m = (second - first) * (double_energy * third - square) / ((third - second) * (square - double_energy * first))
    slowness = math.sqrt(first * second * third / ((third - second) * (square - double_energy * first)))
    # the textbook's differences lose digits near the separatrix
    assert circulation.separatrix_distance == pytest.approx(1.0 - m, abs=1e-14)
    assert circulation.period_s == pytest.approx(4.0 * slowness * ellipk(m), rel=1e-10)


@EVERY_PERIODIC
def test_after_a_period_the_attitude_has_advanced_about_the_momentum(name: str):
    body, start, circulation = made(name)
    later = states_at(body, start, np.array([circulation.period_s]))
    np.testing.assert_allclose(later.body_rate[0], start.body_rate, atol=1e-7 * np.abs(start.body_rate).max())
    momentum = body.angular_momentum(start)
    turn = Rotation.from_rotvec(circulation.advance_per_period_rad * momentum / np.linalg.norm(momentum))
    difference = (turn * Rotation.from_quat(start.attitude_xyzw)).inv() * Rotation.from_quat(later.attitude_xyzw[0])
    # half a nanosecond of rotation
    assert difference.magnitude() < 1e-9 * np.linalg.norm(start.body_rate) + 1e-14


@EVERY_PERIODIC
def test_the_axis_circles_the_momentum_at_the_mean_rate_and_between_the_tilts(name: str):
    body, start, circulation = made(name)
    seconds = np.linspace(0.0, 3.0 * circulation.period_s, 12_001)
    states = states_at(body, start, seconds)
    axis = Rotation.from_quat(states.attitude_xyzw).apply(circulation.axis)
    momentum = body.angular_momentum(start)
    up = momentum / np.linalg.norm(momentum)
    across = np.cross(up, axis[0]) / np.linalg.norm(np.cross(up, axis[0]))
    azimuth = np.unwrap(np.arctan2(axis @ across, axis @ np.cross(across, up)))
    grown = azimuth[-1] - azimuth[0]
    assert grown == pytest.approx(3.0 * circulation.advance_per_period_rad, rel=1e-8)
    assert grown / seconds[-1] == pytest.approx(circulation.precession_rate_rad_s, rel=1e-8)
    tilts = angles(axis, up)
    assert tilts.min() == pytest.approx(circulation.tilt_min_rad, abs=1e-5)
    assert tilts.max() == pytest.approx(circulation.tilt_max_rad, abs=1e-5)


@EVERY_ASYMMETRIC
def test_flips_are_the_sign_changes_of_the_intermediate_body_rate(name: str):
    body, start, circulation = made(name)
    flips = circulation.flips
    # from just after the start, which may itself be a flip
    seconds = np.linspace(1e-6, 3.0, 30_001) * circulation.period_s
    states = states_at(body, start, seconds)
    middle = states.body_rate @ body.principal_axes[:, 1]
    k = np.flatnonzero(np.sign(middle[:-1]) != np.sign(middle[1:]))
    found = seconds[k] + (seconds[k + 1] - seconds[k]) * middle[k] / (middle[k] - middle[k + 1])
    expected = flips.first_s + flips.interval_s * np.arange(len(found))
    np.testing.assert_allclose(found, expected, atol=1e-6 * circulation.period_s)
    assert flips.interval_s == 0.5 * circulation.period_s
    away = angles(body.body_momentum(states), body.principal_axes[:, 1])
    nearest = np.minimum(away, math.pi - away).min()
    assert nearest == pytest.approx(flips.nearest_angle_rad, abs=1e-5)
    assert flips.sudden == (nearest < math.radians(30.0) and circulation.separatrix_distance < 0.01)


@pytest.mark.parametrize("middle", [1.0000001, 1.001])
def test_even_circling_of_a_nearly_symmetric_top_is_no_flip(middle: float):
    assert described([1.0, middle, 1.8], [0.01, 1.0, 0.01]).circulation.flips.sudden is False


@EVERY_PERIODIC
def test_the_regime_names_the_axis_that_is_circled(name: str):
    body, start, circulation = made(name)
    regime = describe(body, start).regime
    index = {"about_smallest": 0, "about_largest": 2}[regime]
    assert abs(np.dot(body.principal_axes[:, index], circulation.axis)) == pytest.approx(1.0, abs=1e-14)
    along = states_at(body, start, np.linspace(0.0, circulation.period_s, 999)).body_rate @ circulation.axis
    assert along.min() > 0.0


@pytest.mark.parametrize("name", SYMMETRIC)
def test_a_symmetric_top_is_told_twice_alike(name: str):
    body, start, circulation = made(name)
    top: Any = describe(body, start).symmetric_top
    assert circulation.flips is None
    assert circulation.separatrix_distance == 1.0
    assert circulation.period_s == pytest.approx(2.0 * math.pi / abs(top.body_precession_rate_rad_s), rel=1e-14)
    assert circulation.precession_rate_rad_s == pytest.approx(top.space_precession_rate_rad_s, rel=1e-14)
    assert circulation.tilt_min_rad == circulation.tilt_max_rad == pytest.approx(top.tilt_rad, rel=1e-14)


def test_equal_moments_have_no_flips_even_where_tilting_the_body_rounded_them_apart():
    turn = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
    tilted = turn @ np.diag([1.0, 1.0, 1.8]) @ turn.T
    rate = [0.3, 0.5, 1.1]
    exactly = described([1.0, 1.0, 1.8], rate).circulation
    rounded: Any = describe(RigidBody(0.5 * (tilted + tilted.T)), State(UPRIGHT, turn @ rate))
    assert rounded.kind == "oblate"
    assert rounded.circulation.flips is None
    assert rounded.circulation.period_s == pytest.approx(exactly.period_s, rel=1e-13)
    assert rounded.circulation.precession_rate_rad_s == pytest.approx(exactly.precession_rate_rad_s, rel=1e-13)


def test_a_slower_disturbance_delays_the_flips_by_the_growth_rate():
    """Ten times nearer to the axis, each flip comes 2 ln 10/λ later."""
    near, nearer = (described([1.0, 2.0, 3.0], [size, 1.0, size]) for size in (1e-200, 1e-201))
    growth = near.axes[1].spin.growth_rate_1_s
    assert growth == pytest.approx(1.0 / math.sqrt(3.0))
    delay = nearer.circulation.flips.interval_s - near.circulation.flips.interval_s
    assert delay == pytest.approx(2.0 * math.log(10.0) / growth, rel=1e-11)
    assert 0.0 < near.circulation.flips.first_s < near.circulation.period_s < math.inf


@pytest.mark.parametrize(("rate", "flips"), [([2.0, 3.0, 1.0], False), ([-2.0, 3.0, 1.0], True)])
def test_exactly_on_the_separatrix(rate: list[float], flips: bool):
    description, body = described(ON_SEPARATRIX, rate), RigidBody(ON_SEPARATRIX)
    circulation = description.circulation
    first = circulation.flips.first_s
    assert description.regime == "separatrix"
    assert circulation.separatrix_distance == circulation.flips.nearest_angle_rad == 0.0
    assert circulation.period_s == circulation.advance_per_period_rad == circulation.flips.interval_s == math.inf
    assert circulation.precession_rate_rad_s == pytest.approx(description.axes[1].spin.spin_rate_rad_s, rel=1e-15)
    assert math.isfinite(first) == flips
    start = State(UPRIGHT, rate)
    middle = states_at(body, start, np.linspace(0.0, 20.0, 20_001)).body_rate[:, 1]
    changes = np.flatnonzero(np.sign(middle[:-1]) != np.sign(middle[1:])) * 1e-3
    assert changes == pytest.approx([first] if flips else [], abs=1.1e-3)
    # what is left of the rate about axis 3 fades as fast as a disturbance would grow
    left = states_at(body, start, np.array([10.0, 15.0])).body_rate[:, 2]
    assert math.log(left[0] / left[1]) / 5.0 == pytest.approx(description.axes[1].spin.growth_rate_1_s, rel=1e-9)


def test_next_to_the_separatrix_the_sides_are_told_apart():
    sides = [described(ON_SEPARATRIX, [2.0 * side, 3.0, 1.0]).regime for side in (1.0 + 1e-15, 1.0, 1.0 - 1e-15)]
    assert sides == ["about_smallest", "separatrix", "about_largest"]


def test_at_rest():
    description = described([1.0, 2.0, 3.0], [0.0, 0.0, 0.0])
    assert description.regime == "rest"
    assert description.circulation is None
    assert description.steady is None
    assert description.kinetic_energy_j == description.angular_momentum_kg_m2_s == 0.0
    assert [axis.spin.spin_rate_rad_s for axis in description.axes] == [1.0, 1.0, 1.0]


@pytest.mark.parametrize(
    ("inertia", "rate", "principal", "verdict"),
    [
        ([1.0, 2.0, 3.0], [-2.0, 0.0, 0.0], (0,), "stable"),
        ([1.0, 2.0, 3.0], [0.0, 1.0, 0.0], (1,), "unstable"),
        ([1.0, 2.0, 3.0], [0.0, 0.0, 1e-300], (2,), "stable"),
        ([1.0, 1.0, 1.8], [0.3, 0.4, 0.0], (0, 1), "neutral"),
        ([0.2, 1.0, 1.0], [5.0, 0.0, 0.0], (0,), "stable"),
        ([2.0, 2.0, 2.0], [0.3, -0.8, 1.1], (0, 1, 2), "neutral"),
        ([2.0, 1.0, 0.0, 2.0, 0.0, 2.5], [0.5, -0.5, 0.0], (0,), "stable"),
    ],
)
def test_steady_rotations(inertia: list[float], rate: list[float], principal: tuple[int, ...], verdict: str):
    description = described(inertia, rate)
    assert description.regime == "steady"
    assert description.circulation is None
    steady = description.steady
    assert steady.principal == principal
    assert description.axes[principal[0]].spin.verdict == verdict
    assert steady.turn_s == pytest.approx(2.0 * math.pi / math.hypot(*rate))
    np.testing.assert_allclose(steady.axis, np.array(rate) / math.hypot(*rate), atol=1e-15)


@EVERY_PERIODIC
def test_conserved_quantities_and_axes(name: str):
    body, start, _ = made(name)
    description = describe(body, start)
    later = states_at(body, start, np.array([7.7]))
    assert description.kinetic_energy_j == pytest.approx(float(body.kinetic_energy(later)[0]), rel=1e-14)
    np.testing.assert_allclose(description.world_momentum_kg_m2_s, body.angular_momentum(later)[0], rtol=1e-12)
    assert description.angular_momentum_kg_m2_s == pytest.approx(math.hypot(*description.world_momentum_kg_m2_s))
    for component in description.conserved_body_momenta:
        along = float(body.body_momentum(later)[0] @ component.direction)
        assert along == pytest.approx(component.momentum_kg_m2_s, rel=1e-14)
    for axis in description.axes:
        direction = np.array(axis.direction)
        np.testing.assert_allclose(body.inertia @ direction, axis.moment_kg_m2 * direction, atol=1e-14)
        spin = description.angular_momentum_kg_m2_s / axis.moment_kg_m2
        assert axis.spin.spin_rate_rad_s == pytest.approx(spin)
