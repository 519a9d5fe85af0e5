"""Laws of the closed form where no enclosure looks: bits of batches, extremes, and any motion that hypothesis finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_motions import AXIS_TURNS, RATES, difference, fastest, growth

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.lie import quaternion, so3, vectors

TILTED = [0.1, -0.7, 0.3, -0.5]

MOTIONS = {
    "about the largest": ([0.6, 0.8, 1.0], [0.3, 0.5, -1.1]),
    "about the smallest": ([0.6, 0.8, 1.0], [3.0, 0.5, -0.9]),
    "flipping": ([1.0, 2.0, 3.0], [1e-3, 1.0, 1e-3]),
    "flipping slowly": ([1.0, 2.0, 3.0], [1e-12, 1.0, -1e-12]),
    "separatrix": ([3.0, 4.0, 6.0], [-2.0, 3.0, 1.0]),
    "oblate": ([1.0, 1.0, 1.8], [0.3, 0.5, 1.1]),
    "prolate": ([2.0, 0.5, 2.0], [0.3, 1.5, -0.4]),
    "nearly prolate": ([0.5, 1.7, 1.7 + 1e-9], [1e-9, 0.7, 0.3]),
    "products": ([1.0, 0.1, -0.05, 1.4, 0.2, 1.9], [0.4, -1.2, 0.7]),
    "spherical": ([2.0, 2.0, 2.0], [0.3, 0.5, 1.1]),
    "rest": ([0.6, 0.8, 1.0], [0.0, 0.0, 0.0]),
}
EVERY_MOTION = pytest.mark.parametrize("name", MOTIONS)


def made(name: str) -> tuple[RigidBody, State, ClosedForm]:
    inertia, rate = MOTIONS[name]
    body, start = RigidBody(inertia), State(quaternion.normalize(TILTED), rate)
    return body, start, ClosedForm(body, start)


@EVERY_MOTION
def test_a_batch_has_the_bits_of_its_rows(name: str):
    _, _, motion = made(name)
    times = np.random.default_rng(3).integers(-(10**16), 10**16, size=9000)
    whole = motion.at(times)
    pieces = [slice(i, i + n) for n in range(18) for i in (0, 501)]
    for piece in (*pieces, slice(7, 1007), slice(3, 8999), slice(0, 9000, 7)):
        part = motion.at(times[piece])
        np.testing.assert_array_equal(part.attitude_xyzw, whole.attitude_xyzw[piece])
        np.testing.assert_array_equal(part.body_rate, whole.body_rate[piece])
    for i in (0, 17, 8999):
        one = motion.at(int(times[i]))
        assert one.attitude_xyzw.shape == (4,)
        np.testing.assert_array_equal(one.attitude_xyzw, whole.attitude_xyzw[i])
        np.testing.assert_array_equal(one.body_rate, whole.body_rate[i])


MOMENTS = st.tuples(*[st.floats(0.5, 1.0)] * 3)
STAMPS = st.integers(-(10**16), 10**16)


@given(MOMENTS, RATES, STAMPS, st.integers(-300, 300))
def test_going_on_from_any_state_on_the_way_is_the_same_motion(moments, rate, s: int, hundredths: int):
    """Motion by s and then t is motion by s + t, but for what the rounding of the state on the way becomes."""
    body, start = RigidBody(list(moments)), State(quaternion.normalize(TILTED), list(rate))
    t, motion = hundredths * 10_000_000, ClosedForm(body, start)
    onward, whole = ClosedForm(body, motion.at(s)).at(t), motion.at(s + t)
    speed = fastest(body, start)
    bound = 4e-15 * (1.0 + growth(speed * abs(t) * 1e-9))
    assert np.abs(onward.body_rate - whole.body_rate).max() <= bound * speed
    assert np.abs(onward.attitude_xyzw - whole.attitude_xyzw).max() <= bound


@given(MOMENTS, RATES, STAMPS, AXIS_TURNS, st.integers(-60, 60), st.integers(-3, 3))
def test_time_axes_and_units_do_not_matter_to_any_motion(moments, rate, t_ns: int, turn, power: int, scale: int):
    body, start = RigidBody(list(moments)), State(quaternion.normalize(TILTED), list(rate))
    states = ClosedForm(body, start).at(8 * t_ns)
    mirrored = ClosedForm(body, State(start.attitude_xyzw, -start.body_rate)).at(-8 * t_ns)
    assert difference(State.trusted(mirrored.attitude_xyzw, -mirrored.body_rate), states) <= 4e-15
    heavy = ClosedForm(RigidBody(body.inertia * 2.0**power), start).at(8 * t_ns)
    assert difference(heavy, states) <= 4e-15
    faster = State(start.attitude_xyzw, start.body_rate * 2.0**scale)
    seen = ClosedForm(body, faster).at(8 * t_ns // 2**scale if scale >= 0 else 8 * t_ns * 2**-scale)
    assert difference(State.trusted(seen.attitude_xyzw, seen.body_rate / 2.0**scale), states) <= 4e-15
    matrix = np.rint(so3.exp(quaternion.log(turn)))
    attitude = quaternion.multiply(start.attitude_xyzw, quaternion.conjugate(turn))
    other = ClosedForm(RigidBody(matrix @ body.inertia @ matrix.T), State(attitude, matrix @ start.body_rate))
    named = other.at(8 * t_ns)
    back = State.trusted(quaternion.multiply(named.attitude_xyzw, turn), named.body_rate @ matrix)
    assert difference(back, states) <= 4e-15


@pytest.mark.parametrize("power", [60, 500, 1000, 1018])
def test_on_the_separatrix_the_fastest_rate_is_no_harder_than_another(power: int):
    """Within a nanosecond it is over: the rate is along the middle axis, and as large as energy demands."""
    rate = np.array([-2.0, 3.0, 1.0]) * 2.0**power
    motion = ClosedForm(RigidBody([3.0, 4.0, 6.0]), State([0, 0, 0, 1], rate))
    expected = [0.0, -np.sqrt((12.0 + 36.0 + 6.0) / 4.0), 0.0]
    for t_ns in ([1, 10**18, 2**63 - 1], np.arange(10**18, 10**18 + 40)):
        states = motion.at(t_ns)
        np.testing.assert_allclose(np.abs(states.body_rate * 2.0**-power), np.abs([expected] * len(t_ns)), rtol=1e-15)
        assert np.abs(quaternion.norm(states.attitude_xyzw) - 1.0).max() <= 4e-16


@given(MOMENTS, st.tuples(*[st.floats(-3.0, 3.0)] * 3), st.integers(-(2**63), 2**63 - 1))
def test_any_motion_keeps_its_momentum_energy_and_norm(moments, rate, t_ns: int):
    body, start = RigidBody(list(moments)), State(quaternion.normalize(TILTED), list(rate))
    state = ClosedForm(body, start).at(t_ns)
    momentum, energy = body.angular_momentum(start), body.kinetic_energy(start)
    assert np.abs(quaternion.norm(state.attitude_xyzw) - 1.0) <= 4e-16
    assert np.abs(body.angular_momentum(state) - momentum).max() <= 4e-15 * vectors.norm(momentum)
    assert np.abs(body.kinetic_energy(state) - energy) <= 4e-15 * energy


@pytest.mark.parametrize("rate", [[1.0, 1.0, 1e-163], [1.0, -1.0, 1e-200], [-1.0, 1.0, 1e-300], [1.0, 1e-163, 1.0]])
@pytest.mark.parametrize("product", [5e-324, 1e-315, 1e-300])
def test_where_the_smallest_numbers_set_moments_apart_the_spin_is_steady(rate: list[float], product: float):
    """Circling about one of two moments: sines and cosines of the libration are all but 0, both of them."""
    start, t_ns = State(quaternion.normalize(TILTED), rate), [0, 1, 5, 10**9, -(10**17)]
    body = RigidBody([1.0, 0.0, product, 0.5, 0.0, 1.0] if rate[2] == 1.0 else [1.0, product, 0.0, 1.0, 0.0, 0.5])
    steady = ClosedForm(RigidBody([1.0, 1.0, 1.0]), start)
    assert difference(ClosedForm(body, start).at(t_ns), steady.at(t_ns)) <= 4e-15
