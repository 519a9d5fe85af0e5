"""The moving chart on any group: one implementation with SO(3), geodesics, invariants, and independent integrators."""

from __future__ import annotations

import numpy as np
import pytest
from sample_groups import ALL, GROUPS, random_body
from scipy.integrate import solve_ivp

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.groups import (
    GROUP_METHODS,
    SO,
    SU,
    U1,
    GroupMovingChart,
    GroupState,
    Lagrangian,
    MatrixLieGroup,
    casimirs,
    group_moving_chart,
    manakov_integrals,
    mass_matrix,
    momentum_matrix,
    product,
    spatial_momentum,
)
from lie_rigid_body.groups.group_moving_chart import runge_kutta_step
from lie_rigid_body.lie import quaternion
from sampled import sampled

CLOSED = [SO(4), SO(5), SO(6), SU(2), SU(3), product(U1(), SU(2), SU(3))]
TURN_PER_STEP = 2e-3


def body(group: MatrixLieGroup, seed: int = 5) -> tuple[Lagrangian, GroupState, np.ndarray]:
    """A body of the group with second moment (on SO(n)) or random metric, and a start at unit rate."""
    lagrangian, rng = random_body(group, seed)
    moment = np.diag(np.linspace(0.5, 1.0, group.size))
    if group.name.startswith("SO"):
        lagrangian = Lagrangian(group, mass_matrix(moment, group.generators))
    rate = lagrangian.rates(rng.normal(size=group.dimension))
    return lagrangian, GroupState(group.random(rng), rate / np.linalg.norm(rate)), moment


@pytest.mark.parametrize(
    ("group", "steps", "bound"),
    [
        *((group, 150, 1e-13) for group in CLOSED),
        *((ALL[name], 150, 1e-10) for name in ("sl(2)", "se(3)")),
        *(pytest.param(group, 10_000, 2e-13, marks=pytest.mark.slow) for group in CLOSED),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_invariants_hold(group: MatrixLieGroup, steps: int, bound: float):
    """Energy, Casimirs and Manakov's integrals, each relative to itself, and the spatial momentum as a vector."""
    lagrangian, start, moment = body(group)
    times = np.arange(51) * (steps // 50) * round(TURN_PER_STEP * 1e9)
    states = GroupMovingChart(lagrangian, start, max_step=TURN_PER_STEP).at(times)
    p = lagrangian.momenta(states.rate)
    assert np.ptp(p, axis=0).max() > 1e-2
    kept = [lagrangian.value(states.rate)[:, np.newaxis]]
    if group in CLOSED:
        kept.append(casimirs(group, p))
    if group.name.startswith("SO"):
        kept.append(manakov_integrals(momentum_matrix(group, p), moment))
    values = np.hstack(kept)
    assert np.all(np.abs(values - values[0]).max(axis=0) < bound * np.abs(values[0]))
    spatial = spatial_momentum(group, states.element, p)
    assert np.linalg.norm(spatial - spatial[0], axis=1).max() < bound * np.linalg.norm(spatial[0])


@pytest.mark.parametrize("inertia", [[0.6, 0.8, 1.0], [1.0, 0.1, -0.05, 1.4, 0.2, 1.9]])
def test_so3_is_the_rotation_chart_written_generically(inertia):
    rigid = RigidBody(inertia)
    start = State([0.5, -0.5, 0.5, 0.5], [3.0, 0.5, -0.9])
    times = np.arange(0, 2_000_000_000, 50_000_000)
    rotations = MovingChart(rigid, start, method="rkmk4", max_step=0.01).at(times)
    general = GroupMovingChart(
        Lagrangian(SO(3), rigid.inertia),
        GroupState(quaternion.to_matrix(start.attitude_xyzw), start.body_rate),
        max_step=0.01,
    ).at(times)
    np.testing.assert_allclose(general.rate, rotations.body_rate, rtol=0, atol=2e-14)
    np.testing.assert_allclose(general.element, quaternion.to_matrix(rotations.attitude_xyzw), rtol=0, atol=2e-14)


@pytest.mark.parametrize("method", GROUP_METHODS)
def test_order_on_so4_against_scipy(method):
    """The reference integrates the matrix and the momentum as plain numbers, at 1e-13."""
    lagrangian, start, _ = body(SO(4))
    group = lagrangian.group

    def rhs(_, y):
        element, rate = y[:16].reshape(4, 4), y[16:]
        return np.concatenate([(element @ group.hat(rate)).ravel(), lagrangian.acceleration(rate)])

    y0 = np.concatenate([start.element.ravel(), start.rate])
    exact = solve_ivp(rhs, (0.0, 1.0), y0, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    steps = np.array([2.0**-k for k in range(3, 7)])
    ends = [GroupMovingChart(lagrangian, start, method=method, max_step=h).at(10**9) for h in steps]
    errors = [np.abs(end.element.ravel() - exact[:16]).max() for end in ends]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(slope - GROUP_METHODS[method].order) < 0.3


@pytest.mark.parametrize("group", [SO(4), SU(3), product(SU(2), U1())], ids=lambda g: g.name)
def test_a_round_metric_gives_geodesics(group):
    """M ∝ 1: A(t) = A₀ exp(tω), whatever the step."""
    rng = np.random.default_rng(11)
    start = GroupState(group.random(rng), 0.3 * rng.normal(size=group.dimension))
    state = GroupMovingChart(Lagrangian(group, 2.5 * group.trace_metric), start, max_step=0.25).at(3_000_000_000)
    np.testing.assert_allclose(state.rate, start.rate, rtol=0, atol=1e-14)
    np.testing.assert_allclose(state.element, start.element @ group.exp(3.0 * start.rate), rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("generators", "rate"),
    [
        ([np.diag([1j, np.sqrt(2.0) * 1j])], [1.0]),
        (SU(3).generators, [1.0, 0, 0, 0, 0, 0, 0, 2.0]),
        (SO(3).generators, [np.pi, 0.0, 0.0]),
    ],
    ids=["torus", "SU(3)", "SO(3)"],
)
def test_groups_from_generators_go_round_without_a_seam(generators, rate):
    """Far beyond the reach of the principal logarithm, which such a group knows its elements by."""
    group = MatrixLieGroup.from_generators(generators)
    start = GroupState(group.identity, np.array(rate))
    times = np.arange(0, 9_000_000_000, 500_000_000)
    found = GroupMovingChart(Lagrangian(group, np.eye(group.dimension)), start, max_step=0.1).at(times)
    exact = np.array([group.exp(1e-9 * t * start.rate) for t in times])
    np.testing.assert_allclose(found.element, exact, rtol=0, atol=1e-11)


def test_translations_may_be_of_any_length():
    """They do not turn, so that the series of the chart ends: even turning, and a velocity that stands in space."""
    group = GROUPS["SE2"]
    start = GroupState(group.identity, np.array([0.3, 1e3, -2e3]))
    end = GroupMovingChart(Lagrangian(group, np.diag([1.0, 2.0, 2.0])), start, max_step=0.01).at(10**9).element
    np.testing.assert_allclose(end[:2, 2], [1e3, -2e3], rtol=1e-9)
    np.testing.assert_allclose(end[:2, :2], SO(2).exp([0.3]), atol=1e-9)


@pytest.mark.long
def test_a_motion_goes_on_from_an_element_that_is_not_recognised():
    group = MatrixLieGroup.from_generators([np.diag([1j, np.sqrt(2.0) * 1j])], name="torus")
    lagrangian, rate = Lagrangian(group, np.array([[1.0]])), np.array([1.0])
    half = GroupMovingChart(lagrangian, GroupState(group.identity, rate), max_step=0.01).at(4_000_000_000)
    assert not group.contains(half.element)
    end = GroupMovingChart(lagrangian, half, max_step=0.01).at(4_000_000_000)
    np.testing.assert_allclose(end.element, group.exp(8.0 * rate), rtol=0, atol=1e-12)


@pytest.mark.parametrize("calls", sampled([25, 1, 77], every=3))
def test_an_exception_amid_a_motion_changes_nothing_of_it(monkeypatch: pytest.MonkeyPatch, calls: int) -> None:
    """A signal may raise one anywhere, as an interrupted notebook goes on with the object."""
    lagrangian = Lagrangian(SO(4), np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))
    start = GroupState(np.eye(4), np.array([0.3, -0.2, 0.5, 0.1, 0.4, -0.6]))
    stamps, begun = np.arange(0, 10**9, 10**8), list[float]()

    def interrupted(tableau, field, point, h):
        begun.append(h)
        if len(begun) == calls:
            raise KeyboardInterrupt
        return runge_kutta_step(tableau, field, point, h)

    expected = GroupMovingChart(lagrangian, start, max_step=0.01).at(stamps)
    motion = GroupMovingChart(lagrangian, start, max_step=0.01)
    monkeypatch.setattr(group_moving_chart, "runge_kutta_step", interrupted)
    with pytest.raises(KeyboardInterrupt):
        motion.at(stamps)
    rest = stamps[stamps >= int(repr(motion).split("reached_ns=")[1].rstrip(")"))]
    np.testing.assert_array_equal(motion.at(rest).element, expected.element[-len(rest) :])


def test_so4_splits_into_two_tops():
    """so(4) = so(3) ⊕ so(3): where M respects the halves, each turns as a rigid body of its own."""
    group = ALL["so(4)"]
    inertias, rates = [[0.6, 0.8, 1.0], [1.0, 1.7, 1.3]], [[0.9, 0.4, -0.3], [-0.2, 0.7, 0.5]]
    start, times = GroupState(group.identity, np.ravel(rates)), np.arange(0, 1_000_000_000, 100_000_000)
    found = GroupMovingChart(Lagrangian(group, np.diag(np.ravel(inertias))), start, max_step=0.005).at(times).rate
    for half, inertia, rate in zip(np.split(found, 2, axis=1), inertias, rates, strict=True):
        top = ClosedForm(RigidBody(inertia), State([0, 0, 0, 1], rate)).at(times).body_rate
        np.testing.assert_allclose(half, top, rtol=0, atol=1e-11)


def test_su2_is_the_double_cover_of_so3():
    """The same metric on SU(2) and SO(3) gives the same rates, and a full turn of one is −1 on the other."""
    rate = np.array([3.0, 0.5, -0.9])
    top = Lagrangian(SU(2), np.diag([0.6, 0.8, 1.0]))
    su2 = GroupMovingChart(top, GroupState(SU(2).identity, rate)).at(500_000_000)
    exact = ClosedForm(RigidBody([0.6, 0.8, 1.0]), State([0, 0, 0, 1], rate)).at(500_000_000)
    np.testing.assert_allclose(su2.rate, exact.body_rate, rtol=0, atol=1e-12)
    axis = GroupState(SU(2).identity, np.array([0.0, 0.0, 2.0 * np.pi]))
    turned = GroupMovingChart(Lagrangian(SU(2), np.eye(3)), axis, max_step=0.01).at(10**9)
    np.testing.assert_allclose(turned.element, -np.eye(2), rtol=0, atol=1e-12)


def test_calls_continue_one_another():
    lagrangian, start, _ = body(SO(4))
    times = np.arange(0, 210_000_000, 7_000_000)
    whole = GroupMovingChart(lagrangian, start, max_step=0.003).at(times)
    chart = GroupMovingChart(lagrangian, start, max_step=0.003)
    parts = [chart.at(times[:13]), chart.at(times[13:])]
    np.testing.assert_array_equal(whole.element, np.concatenate([p.element for p in parts]))
    assert GroupMovingChart(lagrangian, start).at(0).element.shape == (4, 4)
