"""The moving chart on any group: one implementation with SO(3), geodesics, invariants, and independent integrators."""

from __future__ import annotations

import numpy as np
import pytest
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
    rotation_casimirs,
    spatial_momentum,
    unitary_casimirs,
)
from lie_rigid_body.groups.group_moving_chart import runge_kutta_step
from lie_rigid_body.lie import quaternion
from sampled import sampled

GROUPS = {"SO(4)": SO(4), "SO(5)": SO(5), "SO(6)": SO(6), "SU(2)": SU(2), "SU(3)": SU(3)}
TURN_PER_STEP = 2e-3


def body(group: MatrixLieGroup, seed: int = 5) -> tuple[Lagrangian, GroupState, np.ndarray]:
    """A body of the group with random second moment (on SO(n)) or metric, and a start at unit rate."""
    rng = np.random.default_rng(seed)
    moment = np.diag(np.linspace(0.5, 1.0, group.size))
    if group.name.startswith("SO"):
        metric = mass_matrix(moment, group.generators)
    else:
        metric = np.diag(np.linspace(1.0, 2.0, group.dimension))
    lagrangian = Lagrangian(group, metric)
    rate = lagrangian.rates(rng.normal(size=group.dimension))
    return lagrangian, GroupState(group.random(rng), rate / np.linalg.norm(rate)), moment


def drifts(lagrangian: Lagrangian, states: GroupState, moment: np.ndarray) -> dict[str, float]:
    """How far each quantity that must not change has gone from its start, relative to its size.

    For the spatial momentum, a vector, the norm of its change over its norm. All others are scalars, each relative to
    itself; but those that may vanish, the Pfaffian and the cubic trace, to the greatest value that they have for a
    momentum of this size.
    """
    group, p = lagrangian.group, lagrangian.momenta(states.rate)
    matrix = momentum_matrix(group, p)
    found = {
        "energy": scalar_drift(lagrangian.value(states.rate)),
        "spatial momentum": vector_drift(spatial_momentum(group, states.element, p)),
    }
    casimirs, names = named_casimirs(group, matrix)
    greatest = greatest_values(group.size, float(np.linalg.norm(matrix[0])))
    found |= {n: scalar_drift(c, greatest.get(n)) for n, c in zip(names, casimirs.T, strict=True)}
    if group.name.startswith("SO"):
        integrals = manakov_integrals(matrix, moment)
        found |= {f"Manakov's integral {i + 1}": scalar_drift(c) for i, c in enumerate(integrals.T)}
    return found


def named_casimirs(group: MatrixLieGroup, matrix: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """The Casimirs, one on each column, and what each is called."""
    n = group.size
    if group.name.startswith("SU"):
        return unitary_casimirs(matrix), [f"trace {k}" for k in range(2, n + 1)]
    return rotation_casimirs(matrix), [f"trace {k}" for k in range(2, n, 2)] + ["Pfaffian"] * (n % 2 == 0)


def greatest_values(n: int, size: float) -> dict[str, float]:
    """The greatest values of invariants that may vanish, for n × n momenta of this Frobenius norm.

    Pf is the product of the n/2 frequencies, whose squares sum to size²/2: greatest where all are equal. The cubic
    trace sums n cubes of numbers that sum to 0 and whose squares sum to size²: greatest where all but one are equal.
    """
    cubic = (n - 2) / np.sqrt(n * (n - 1)) * size**3
    return {"Pfaffian": (size / np.sqrt(n)) ** (n / 2), "trace 3": float(cubic)}


def vector_drift(values: np.ndarray) -> float:
    """Largest norm of the change of a vector, shape (samples, d), over its norm."""
    return float(np.linalg.norm(values - values[0], axis=-1).max() / np.linalg.norm(values[0]))


def scalar_drift(values: np.ndarray, scale: float | None = None) -> float:
    """Largest change of a scalar, shape (samples,), over its size or that of a scale."""
    return float(np.abs(values - values[0]).max() / abs(values[0] if scale is None else scale))


def run(name: str, steps: int, samples: int = 50) -> dict[str, float]:
    lagrangian, start, moment = body(GROUPS[name])
    step_ns = round(TURN_PER_STEP * 1e9)
    times = np.arange(samples + 1) * (steps // samples) * step_ns
    states = GroupMovingChart(lagrangian, start, max_step=TURN_PER_STEP).at(times)
    return drifts(lagrangian, states, moment)


@pytest.mark.parametrize("name", GROUPS)
def test_invariants_hold(name):
    for key, change in run(name, steps=150).items():
        assert change < 1e-13, key


@pytest.mark.slow
@pytest.mark.parametrize("name", GROUPS)
def test_invariants_hold_over_a_hundred_thousand_steps(name):
    for key, change in run(name, steps=100_000).items():
        assert change < 1e-12, key


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


def test_a_group_that_is_not_compact_keeps_its_spatial_momentum():
    group = MatrixLieGroup.from_generators([[[1, 0], [0, -1]], [[0, 1], [0, 0]], [[0, 0], [1, 0]]], name="SL(2)")
    lagrangian = Lagrangian(group, np.diag([1.0, 2.0, 3.0]))
    start = GroupState(group.identity, np.array([0.5, 0.8, -0.3]))
    states = GroupMovingChart(lagrangian, start, max_step=0.002).at(np.arange(0, 1_500_000_000, 100_000_000))
    spatial = spatial_momentum(group, states.element, lagrangian.momenta(states.rate))
    assert vector_drift(spatial) < 1e-10


def test_a_motion_on_a_product_keeps_the_casimirs_of_each_factor():
    """U(1)×SU(2)×SU(3) with a metric that couples all three: charge, isospin and two of colour, energy, A P A⁻¹."""
    group, rng = product(U1(), SU(2), SU(3)), np.random.default_rng(12)
    mixed = rng.normal(size=(12, 12))
    lagrangian = Lagrangian(group, np.eye(12) + 0.05 * mixed @ mixed.T)
    start = GroupState(group.random(rng), rng.normal(size=12) / 4)
    states = GroupMovingChart(lagrangian, start, max_step=2e-3).at(np.arange(0, 480_000_000, 80_000_000))
    p = lagrangian.momenta(states.rate)
    assert np.ptp(p, axis=0)[1:].min() > 1e-3
    values = casimirs(group, p)
    assert values.shape == (6, 4)
    for name, value in zip(("charge", "isospin", "colour 2", "colour 3"), values.T, strict=True):
        assert scalar_drift(value, 1.0) < 1e-12, name
    assert scalar_drift(lagrangian.value(states.rate)) < 1e-12
    assert vector_drift(spatial_momentum(group, states.element, p)) < 1e-12


def test_translations_may_be_of_any_length():
    """They do not turn, so that the series of the chart ends."""
    x, y = np.zeros((2, 3, 3))
    x[0, 2] = y[1, 2] = 1.0
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    group = MatrixLieGroup.from_generators([turn, x, y], name="SE(2)")
    start = GroupState(group.identity, np.array([0.3, 1e3, -2e3]))
    end = GroupMovingChart(Lagrangian(group, np.diag([1.0, 2.0, 2.0])), start, max_step=0.01).at(10**9)
    # the velocity stands still in space, the body turns evenly
    np.testing.assert_allclose(end.element[:2, 2], [1e3, -2e3], rtol=1e-9)
    np.testing.assert_allclose(
        end.element[:2, :2], [[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]], atol=1e-9
    )


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
    group = SO(4)
    halves, brackets = _halves(group)
    inertias = [np.array([0.6, 0.8, 1.0]), np.array([1.0, 1.7, 1.3])]
    metric = sum(half.T @ np.diag(inertia) @ half for half, inertia in zip(halves, inertias, strict=True))
    rates = [np.array([0.9, 0.4, -0.3]), np.array([-0.2, 0.7, 0.5])]
    start = GroupState(group.identity, sum(half.T @ rate for half, rate in zip(halves, rates, strict=True)))
    times = np.arange(0, 1_000_000_000, 100_000_000)
    found = GroupMovingChart(Lagrangian(group, metric), start, max_step=0.005).at(times).rate
    for half, bracket, inertia, rate in zip(halves, brackets, inertias, rates, strict=True):
        # with [S, S'] = b S'' in place of S'', the half moves as a top of rates b ω
        top = ClosedForm(RigidBody(inertia), State([0, 0, 0, 1], bracket * rate)).at(times).body_rate / bracket
        np.testing.assert_allclose(found @ half.T, top, rtol=0, atol=1e-11)


def _halves(group: MatrixLieGroup) -> tuple[list[np.ndarray], list[float]]:
    """Orthonormal bases of the two ideals of so(4), by rows in the coordinates of the group, and their brackets."""
    e = np.eye(4)
    plane = {(i, j): np.outer(e[i], e[j]) - np.outer(e[j], e[i]) for i in range(4) for j in range(4)}
    halves, brackets = [], []
    for sign in (1, -1):
        basis = [plane[2, 1] + sign * plane[3, 0], plane[0, 2] + sign * plane[3, 1], plane[1, 0] + sign * plane[3, 2]]
        rows = np.array([group.vee(matrix) for matrix in basis]) / np.sqrt(2.0)
        commutator = group.vee(group.hat(rows[0]) @ group.hat(rows[1]) - group.hat(rows[1]) @ group.hat(rows[0]))
        np.testing.assert_allclose(np.abs(commutator @ rows[2]), np.linalg.norm(commutator), rtol=1e-14)
        halves.append(rows)
        brackets.append(float(commutator @ rows[2]))
    return halves, brackets


def test_su2_is_the_double_cover_of_so3():
    """The same metric on SU(2) and SO(3) gives the same rates, and a full turn of one is −1 on the other."""
    metric = np.diag([0.6, 0.8, 1.0])
    rate = np.array([3.0, 0.5, -0.9])
    su2 = GroupMovingChart(Lagrangian(SU(2), metric), GroupState(SU(2).identity, rate)).at(500_000_000)
    top = ClosedForm(RigidBody([0.6, 0.8, 1.0]), State([0, 0, 0, 1], rate)).at(500_000_000)
    np.testing.assert_allclose(su2.rate, top.body_rate, rtol=0, atol=1e-12)
    axis = np.array([0.0, 0.0, 2.0 * np.pi])
    turned = GroupMovingChart(Lagrangian(SU(2), np.eye(3)), GroupState(SU(2).identity, axis), max_step=0.01).at(10**9)
    np.testing.assert_allclose(turned.element, -np.eye(2), rtol=0, atol=1e-12)


def test_calls_continue_one_another():
    lagrangian, start, _ = body(SO(4))
    times = np.arange(0, 210_000_000, 7_000_000)
    whole = GroupMovingChart(lagrangian, start, max_step=0.003).at(times)
    chart = GroupMovingChart(lagrangian, start, max_step=0.003)
    parts = [chart.at(times[:13]), chart.at(times[13:])]
    np.testing.assert_array_equal(whole.element, np.concatenate([p.element for p in parts]))
    assert GroupMovingChart(lagrangian, start).at(0).element.shape == (4, 4)
