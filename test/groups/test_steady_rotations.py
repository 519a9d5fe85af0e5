"""Steady rotations: the axes of a top, coordinate planes in n dimensions, and motions that bear the verdicts out."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from sample_groups import (
    ALL,
    COMPACT,
    GROUPS,
    ROTATIONS,
    diagonal_body,
    random_body,
    random_metric,
)
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from lie_rigid_body.groups import (
    SO,
    U1,
    Lagrangian,
    Stability,
    linearisation,
    steady_axes,
    steady_rotation,
)
from lie_rigid_body.mechanics.top import SpinStability

MOMENTS = {3: [0.3, 0.5, 0.9], 4: [0.3, 0.5, 0.9, 1.4], 5: [0.2, 1.1, 0.5, 0.8, 1.7], 6: [0.2, 1.1, 0.5, 0.8, 1.7, 2.5]}


def plane_rate(group, i, j, speed):
    """The rate of a rotation that turns axis i into axis j."""
    turn = np.zeros((group.size, group.size))
    turn[j, i], turn[i, j] = speed, -speed
    return group.vee(turn)


def test_the_three_axes_of_a_top():
    """Euler's small oscillations: λ² = −ω² (I₃ − I₁)(I₃ − I₂)/(I₁I₂) about the third axis, and so on round."""
    moments, speed = np.array([1.0, 2.0, 3.0]), 0.7
    body = Lagrangian(SO(3), np.diag(moments))
    verdicts = []
    for axis in range(3):
        i, j, k = np.roll([0, 1, 2], -axis)
        square = -(speed**2) * (moments[i] - moments[j]) * (moments[i] - moments[k]) / (moments[j] * moments[k])
        steady = steady_rotation(body, speed * np.eye(3)[axis])
        verdicts.append(steady.stability)
        np.testing.assert_allclose(steady.eigenvalues**2, [square, square], rtol=1e-13)
        assert steady.growth_rate == pytest.approx(np.sqrt(max(square, 0.0)), abs=1e-14)
        np.testing.assert_allclose(steady.frequencies, [np.sqrt(-square)] if square < 0.0 else [], rtol=1e-13)
    assert verdicts == [Stability.STABLE, Stability.UNSTABLE, Stability.STABLE]


def plane_squares(k, i, j):
    """Squares of the eigenvalues about the plane ij at unit speed, one for each other axis, from Ṗ = [P, Ω] by hand."""
    return np.array([-(k[i] - x) * (k[j] - x) / ((k[i] + x) * (k[j] + x)) for m, x in enumerate(k) if m not in (i, j)])


def plane_verdict(k, i, j):
    """Unstable if an axis lies between the two; energy extremal if all others lie on one side; else bounded.

    Bounded in the linearised motion: its eigenvalues are imaginary, and those of one pair of axes differ from others.
    """
    others = [x for m, x in enumerate(k) if m not in (i, j)]
    low, high = sorted((k[i], k[j]))
    if any(low < x < high for x in others):
        return Stability.UNSTABLE
    one_side = all(x < low for x in others) or all(x > high for x in others)
    return Stability.STABLE if one_side else Stability.LINEARLY_STABLE


@pytest.mark.parametrize("n", MOMENTS)
def test_rotations_in_coordinate_planes(n):
    group, k, speed = ROTATIONS[n], MOMENTS[n], 1.3
    body = diagonal_body(group, k)
    seen = set()
    for i, j in combinations(range(n), 2):
        steady = steady_rotation(body, plane_rate(group, i, j, speed))
        expected = np.repeat(speed**2 * plane_squares(k, i, j), 2)
        np.testing.assert_allclose(np.sort((steady.eigenvalues**2).real), np.sort(expected), rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose((steady.eigenvalues**2).imag, 0.0, atol=1e-11)
        assert steady.stability is plane_verdict(k, i, j), (i, j)
        seen.add(steady.stability)
    assert seen >= {Stability.STABLE, Stability.UNSTABLE}
    assert (Stability.LINEARLY_STABLE in seen) == (n > 3)


def departure(body, rate, push, time):
    """The largest distance of the momentum from a steady one that a push leads to, relative to the push."""
    start = body.momenta(np.array(rate))
    motion = solve_ivp(
        lambda _, p: body.momentum_rate(body.rates(p)),
        (0.0, time),
        start + push,
        method="DOP853",
        rtol=1e-11,
        atol=1e-14,
    )
    return np.max(np.linalg.norm(motion.y.T - start, axis=1)) / np.linalg.norm(push)


def test_motions_bear_the_verdicts_out():
    group, rng = ROTATIONS[4], np.random.default_rng(41)
    body = diagonal_body(group, MOMENTS[4])
    for i, j in combinations(range(4), 2):
        rate = plane_rate(group, i, j, 2.0)
        steady = steady_rotation(body, rate)
        push = 1e-6 * rng.normal(size=6)
        if steady.stability is Stability.UNSTABLE:
            time = 9.0 / steady.growth_rate
            assert 1e2 < departure(body, rate, push, time) < 1e5
        else:
            assert departure(body, rate, push, 60.0) < 20.0


@pytest.mark.parametrize("group", [*COMPACT.values(), ALL["sl(2)"]], ids=lambda group: group.name)
def test_axes_are_steady_for_any_body(group):
    body, _ = random_body(group, 42)
    axes = steady_axes(body)
    assert axes.shape == (group.dimension, group.dimension)
    np.testing.assert_allclose(body.momentum_rate(3.0 * axes), 0.0, atol=1e-12)
    if group.name == "sl(2)":
        return
    np.testing.assert_allclose(axes @ axes.T, np.eye(group.dimension), atol=1e-13)
    for axis in axes:
        steady = steady_rotation(body, axis)
        # rotations about the axes of most and of least energy are stable: the energy is extremal on the orbit
        np.testing.assert_allclose(np.sort(steady.eigenvalues.real), np.sort(-steady.eigenvalues.real), atol=1e-6)
    assert steady_rotation(body, axes[0]).stability is Stability.STABLE
    assert steady_rotation(body, axes[-1]).stability is Stability.STABLE


@pytest.mark.parametrize("name", ["SO3", "SO4", "SU3"])
def test_the_linearisation_is_the_derivative_of_eulers_equations(name):
    body, rng = random_body(COMPACT[name], 43)
    w, push = rng.normal(size=(2, body.group.dimension))
    # the equations are quadratic, so that a central difference is exact for any step
    moved = body.momentum_rate(w + body.rates(push)) - body.momentum_rate(w - body.rates(push))
    np.testing.assert_allclose(linearisation(body, w) @ push, moved / 2, atol=1e-12)


def test_a_symmetric_top_about_its_equator_is_marginal():
    """The rotation axis drifts along the equator in proportion to time: no exponential growth, no extremum."""
    top = Lagrangian(SO(3), np.diag([1.0, 1.0, 2.0]))
    assert steady_rotation(top, [0.6, 0.8, 0.0]).stability is Stability.MARGINAL
    assert steady_rotation(top, [0.0, 0.0, 1.0]).stability is Stability.STABLE


def test_a_sphere_is_linearly_stable():
    """All rotations are steady, so that a push neither grows nor returns."""
    for turn in ([0.0, 0.0, 1.0], [0.6, 0.8, 0.0], [0.1, -0.7, 0.3]):
        for body in (Lagrangian(SO(3), 0.3 * np.eye(3)), Lagrangian(SO(3), turned(np.full(3, 0.3)))):
            steady = steady_rotation(body, turn)
            assert steady.stability is Stability.LINEARLY_STABLE
            np.testing.assert_allclose(steady.eigenvalues, 0.0, atol=1e-15)


def turned(moments):
    """An inertia in a tilted frame, rounded."""
    a = Rotation.from_rotvec([0.3, -0.9, 0.5]).as_matrix()
    m = a @ np.diag(moments) @ a.T
    return (m + m.T) / 2


@pytest.mark.parametrize("gap", np.logspace(-13, -1, 13))
@pytest.mark.parametrize(
    ("moments", "parted"), [([1, 1, 2], [0, 1, 0]), ([0.2, 1, 1], [0, 0, 1]), ([1, 1, 1], [0, 1, 2])]
)
def test_nearly_equal_moments_get_one_verdict_on_all_axes(gap, moments, parted):
    """That of `SpinStability`, to the percent: what parts two moments on one axis parts them on the others."""
    inertia = np.array(moments) + gap * np.array(parted)
    body = Lagrangian(SO(3), np.diag(inertia))
    for axis in range(3):
        spin, steady = SpinStability.of(inertia, axis, 0.7), steady_rotation(body, 0.7 * np.eye(3)[axis])
        assert steady.stability.value == spin.verdict
        assert steady.growth_rate == pytest.approx(spin.growth_rate_1_s, rel=0.01, abs=1e-7)


@pytest.mark.parametrize("moments", [[1.0, 1.0, 2.0, 3.0], [1.0, 2.0, 2.0, 3.0], [1.0, 1.0, 2.0, 2.0]])
def test_equal_second_moments_in_four_dimensions(moments):
    """The linearised motion over a long time, as a matrix exponential: bounded, or growing like t, or faster."""
    group = ROTATIONS[4]
    body = diagonal_body(group, moments)
    for i, j in combinations(range(4), 2):
        rate = plane_rate(group, i, j, 1.0)
        p = body.momenta(rate)
        orbit = np.linalg.svd(np.einsum("cad,d->ac", group.structure_constants, p))
        tangent = orbit[0][:, orbit[1] > 1e-12]
        linear = tangent.T @ linearisation(body, rate) @ tangent
        grown = [np.abs(expm(time * linear)).max() for time in np.linspace(900.0, 1000.0, 7)]
        verdict = steady_rotation(body, rate).stability
        if verdict is Stability.MARGINAL:
            assert 20.0 < max(grown) < 2e3
        elif verdict is Stability.UNSTABLE:
            assert max(grown) > 1e6
        else:
            assert max(grown) < 10.0


def test_the_verdict_has_no_unit():
    for unit, speed in ((1e-9, 1e6), (1e9, 1e-6)):
        body = Lagrangian(SO(3), unit * np.diag([1.0, 2.0, 3.0]))
        verdicts = [steady_rotation(body, speed * e).stability for e in np.eye(3)]
        assert verdicts == [Stability.STABLE, Stability.UNSTABLE, Stability.STABLE]


def test_rest_and_the_circle_are_stable():
    assert steady_rotation(Lagrangian(U1(), np.array([[2.0]])), [3.0]).stability is Stability.STABLE
    at_rest = steady_rotation(Lagrangian(SO(3), np.diag([1.0, 2.0, 3.0])), np.zeros(3))
    assert (at_rest.stability, at_rest.growth_rate, len(at_rest.eigenvalues)) == (Stability.STABLE, 0.0, 0)


def test_a_momentum_whose_orbit_has_fewer_dimensions_than_those_nearby():
    """On the affine group of the line p₂ grows or decays at the rate ω₁. Heisenberg's p₃ turns the others."""
    line = Lagrangian(GROUPS["affine line"], np.eye(2))
    shear = Lagrangian(ALL["Heisenberg"], np.eye(3))
    for body, rate, verdict in (
        (line, [1.0, 0.0], Stability.UNSTABLE),
        (line, [-1.0, 0.0], Stability.STABLE),
        (shear, [1.0, 0.0, 0.0], Stability.MARGINAL),
        (shear, [0.0, 0.0, 1.0], Stability.STABLE),
    ):
        found = steady_rotation(body, rate)
        assert found.stability is verdict
        whole = np.linalg.eigvals(linearisation(body, np.array(rate)))
        np.testing.assert_allclose(found.growth_rate, whole.real.max(), atol=1e-12)
        grown = max(departure(body, rate, e, 8.0) for e in 1e-6 * np.eye(len(rate)))
        assert (grown > 3.0) == (verdict in (Stability.UNSTABLE, Stability.MARGINAL))


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-10, 5e-10])
@pytest.mark.parametrize("seed", range(5))
def test_a_momentum_that_is_as_steady_as_asked_for_does_not_tell_its_orbit(seed, off):
    """The rate is solved for, so that other components of the momentum are a last bit off 0, or more."""
    rng = np.random.default_rng(seed)
    for group, p, verdict in (
        (GROUPS["affine line"], [-1.0, 0.0], Stability.STABLE),
        (GROUPS["SE2"], [1.0, 0.0, 0.0], Stability.STABLE),
        (ALL["Heisenberg"], [0.3, 0.4, 0.0], Stability.MARGINAL),
    ):
        metric = random_metric(rng, len(p))
        rate = np.linalg.solve(metric, p + off * rng.uniform(-0.5, 0.5, len(p)))
        assert steady_rotation(Lagrangian(group, metric), rate).stability is verdict
