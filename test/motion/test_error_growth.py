"""Errors of the momentum grow along a motion as differences of the closed form do."""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.motion.description import describe
from lie_rigid_body.motion.error_growth import ErrorGrowth, PathFrame

MOTIONS = {
    "asymmetric": ([0.6, 0.8, 1.0], [3.0, 0.5, -0.9]),
    "near the separatrix": ([1.0, 2.0, 3.0], [0.01, 1.0, 0.01]),
    "symmetric": ([1.0, 1.0, 1.8], [0.4, 0.3, 2.0]),
    "products": ([1.4, -0.173205, 0.45, 1.2, -0.086603, 1.6], [1.0, 0.7, -0.4]),
}
ATTITUDE = [0.1, -0.7, 0.3, -0.5]
FASTEST = 6.0
"""No body rate is larger, rad/s."""
NODES = 257
CHANGE = 1e-7
"""Change of the momentum, relative to its norm."""


def growth_of(name: str) -> tuple[RigidBody, State, np.ndarray, ErrorGrowth]:
    """The growth over a period, and the states at its nodes with their times in ns."""
    inertia, rate = MOTIONS[name]
    body, start = RigidBody(inertia), State(np.array(ATTITUDE) / np.linalg.norm(ATTITUDE), rate)
    circulation = describe(body, start).circulation
    assert circulation is not None
    t_ns = np.linspace(0.0, 0.5e9 * circulation.period_s, NODES).astype(np.int64)
    states = ClosedForm(body, start).at(t_ns)
    return body, states, t_ns, ErrorGrowth.of(body, np.asarray(1e-9 * t_ns, dtype=np.float64), states, FASTEST)


def measured(body: RigidBody, state: State, change: np.ndarray, t_ns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Turn, rad, and change of the body rate, rad/s, at these times, for a unit change of the momentum's direction."""
    size = float(so3.norm(body.body_momentum(state)))
    moved = [
        ClosedForm(body, State(state.attitude_xyzw, state.body_rate + sign * CHANGE * size * changed)).at(t_ns)
        for sign in (0.5, -0.5)
        for changed in [body.inverse_inertia @ change]
    ]
    turn = quaternion.multiply(moved[0].attitude_xyzw, quaternion.conjugate(moved[1].attitude_xyzw))
    turned = so3.norm(quaternion.log(turn)) / CHANGE
    return turned, so3.norm(moved[0].body_rate - moved[1].body_rate) / CHANGE


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("node", [0, 60, 128, 200])
@pytest.mark.parametrize("axis", range(3))
def test_an_error_made_at_any_time_grows_by_its_bound_at_most(name: str, node: int, axis: int) -> None:
    """Over three periods; and its largest size is not far below the bound."""
    body, states, t_ns, growth = growth_of(name)
    later = np.unique(np.concatenate([t_ns + k * t_ns[-1] for k in range(3)]))[node:]
    found = measured(body, states[node], growth.frame.axes[axis, node], later - later[0])
    local = np.zeros((3, NODES))
    local[axis, node] = (NODES - 1) / growth.times[-1]
    after, first = later > later[0], (later > later[0]) & (later <= t_ns[-1])
    for errors, values in zip((growth.attitude(local), growth.rate(local)), found, strict=True):
        bound = errors(1e-9 * later)
        assert np.all(values[after] <= 1.01 * bound[after] + 1e-6)
        assert bound[first].max() < 4.0 * values[first].max() + 1e-6


def test_independent_errors_add_up_by_their_squares() -> None:
    _, _, _, growth = growth_of("asymmetric")
    one = np.zeros((3, NODES))
    one[1, 40] = 1.0
    two = one.copy()
    two[2, 90] = 1.0
    each = [growth.rate(local, 2)(growth.times[-1:])[0] for local in (one, two - one, two)]
    assert each[2] <= np.hypot(each[0], each[1]) * (1 + 1e-12)
    assert each[2] >= max(each[:2])


def spherical_growth() -> tuple[float, ErrorGrowth]:
    """The largest rate and the growth over 20 s."""
    body, start = RigidBody([2.0, 2.0, 2.0]), State([0.0, 0.0, 0.0, 1.0], [0.3, -0.8, 1.1])
    times = np.linspace(0.0, 20.0, NODES)
    states = ClosedForm(body, start).at((1e9 * times).astype(np.int64))
    return float(so3.norm(start.body_rate)), ErrorGrowth.of(body, times, states, 2.0)


def test_a_spherical_body_keeps_its_errors() -> None:
    speed, growth = spherical_growth()
    local = np.zeros((3, NODES))
    local[1:, 0] = (NODES - 1) / 20.0
    assert growth.rate(local)(growth.times)[1:] == pytest.approx(2.0 * speed, rel=1e-6)


@pytest.mark.parametrize(("power", "sum_of"), [(1, lambda t: t), (2, np.sqrt)])
def test_errors_add_up_over_many_periods(power, sum_of) -> None:
    """Errors c of 1 a second, that neither grow nor fade."""
    speed, growth = spherical_growth()
    local = np.concatenate([np.ones((1, NODES)), np.zeros((2, NODES))])
    t = np.array([5.0, 20.0, 60.0, 2000.0])
    assert growth.rate(local, power)(t) == pytest.approx(speed * sum_of(t), rel=0.02)


@pytest.mark.parametrize("name", MOTIONS)
def test_the_frame_is_orthonormal_and_right_handed(name: str) -> None:
    body, states, _, _ = growth_of(name)
    axes = PathFrame.of(body, states, FASTEST).axes
    assert np.einsum("inv,jnv->nij", axes, axes) == pytest.approx(np.tile(np.eye(3), (NODES, 1, 1)), abs=1e-9)
    assert np.cross(axes[0], axes[1]) == pytest.approx(axes[2], abs=1e-9)
