from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.lie import quaternion, so3, vectors

TILTED = [0.1, -0.7, 0.3, -0.5]
SECOND = 1_000_000_000

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


def assert_same(a: State, b: State, tolerance: float) -> None:
    """Equal states, the quaternions' signs included."""
    np.testing.assert_allclose(a.attitude_xyzw, b.attitude_xyzw, rtol=0.0, atol=tolerance)
    scale = max(float(np.abs(b.body_rate).max()), 1e-300)
    np.testing.assert_allclose(a.body_rate / scale, b.body_rate / scale, rtol=0.0, atol=2.0 * tolerance)


@EVERY_MOTION
def test_the_motion_begins_at_the_start(name: str):
    _, start, motion = made(name)
    assert_same(motion.at(0), start, 5e-16)


@EVERY_MOTION
def test_a_batch_has_the_bits_of_its_rows(name: str):
    _, _, motion = made(name)
    times = np.random.default_rng(3).integers(-(10**16), 10**16, size=9000)
    whole = motion.at(times)
    pieces = [slice(i, i + n) for n in range(1, 18) for i in (0, 501)] + [
        slice(7, 1007),
        slice(3, 8999),
        slice(0, 9000, 7),
    ]
    for piece in pieces:
        part = motion.at(times[piece])
        np.testing.assert_array_equal(part.attitude_xyzw, whole.attitude_xyzw[piece])
        np.testing.assert_array_equal(part.body_rate, whole.body_rate[piece])
    for i in (0, 17, 8999):
        one = motion.at(int(times[i]))
        assert one.attitude_xyzw.shape == (4,)
        np.testing.assert_array_equal(one.attitude_xyzw, whole.attitude_xyzw[i])
        np.testing.assert_array_equal(one.body_rate, whole.body_rate[i])


def test_no_times_give_no_states():
    states = made("flipping")[2].at([])
    assert states.attitude_xyzw.shape == (0, 4)
    assert states.body_rate.shape == (0, 3)


@EVERY_MOTION
@pytest.mark.parametrize("begin", [0, -(10**16), 10**16])
def test_the_attitude_is_a_continuous_path_that_the_rate_drives(name: str, begin: int):
    """Each sample follows from the one before by half the rate at the middle, on the double cover."""
    _, _, motion = made(name)
    step = 10_000_000
    times = begin + step * np.arange(6001)
    states, middle = motion.at(times), motion.at(times[:-1] + step // 2)
    predicted = quaternion.multiply(states.attitude_xyzw[:-1], quaternion.exp(middle.body_rate * (step * 1e-9)))
    speed = float(np.abs(middle.body_rate).max())
    assert np.abs(predicted - states.attitude_xyzw[1:]).max() <= 0.1 * (speed * step * 1e-9) ** 3 + 2e-15


@EVERY_MOTION
def test_momentum_energy_and_norm_are_kept(name: str):
    body, start, motion = made(name)
    states = motion.at(np.random.default_rng(4).integers(-(10**18), 10**18, size=5000))
    momentum, energy = body.angular_momentum(start), body.kinetic_energy(start)
    assert np.abs(body.angular_momentum(states) - momentum).max() <= 3e-15 * np.linalg.norm(momentum)
    assert np.abs(body.kinetic_energy(states) - energy).max() <= 3e-15 * energy
    assert np.abs(quaternion.norm(states.attitude_xyzw) - 1.0).max() <= 4e-16


@EVERY_MOTION
@pytest.mark.parametrize(("s", "t"), [(3, 4), (-2, 9), (5, -5), (8, -3)])
def test_going_on_from_a_state_on_the_way_is_the_same_motion(name: str, s: int, t: int):
    body, _, motion = made(name)
    onward = ClosedForm(body, motion.at(s * SECOND)).at(t * SECOND)
    # the state on the way is rounded, and an unstable motion lets that grow
    assert_same(onward, motion.at((s + t) * SECOND), 5e-13)


@EVERY_MOTION
def test_reversing_the_rate_reverses_time(name: str):
    body, start, motion = made(name)
    times = np.array([1, 77, 10**9, 123456789012, 10**15 + 1])
    forward, mirrored = motion.at(times), ClosedForm(body, State(start.attitude_xyzw, -start.body_rate)).at(-times)
    assert_same(State.trusted(mirrored.attitude_xyzw, -mirrored.body_rate), forward, 2e-15)


@EVERY_MOTION
@pytest.mark.parametrize(
    "turn", [[0.5, 0.5, 0.5, 0.5], [0.5, 0.5, 0.5, -0.5], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
)
def test_the_naming_of_the_body_axes_does_not_matter(name: str, turn: list[float]):
    """A body frame turned by r sees M and ω turned, and the attitude gets r from the right."""
    body, start, motion = made(name)
    matrix = np.rint(so3.exp(quaternion.log(turn)))
    turned = ClosedForm(
        RigidBody(matrix @ body.inertia @ matrix.T),
        State(quaternion.multiply(start.attitude_xyzw, quaternion.conjugate(turn)), start.body_rate @ matrix.T),
    )
    times = np.array([0, 10**9, -(10**12), 10**16])
    seen, states = turned.at(times), motion.at(times)
    back = State.trusted(quaternion.multiply(seen.attitude_xyzw, turn), seen.body_rate @ matrix)
    assert_same(back, states, 2e-15)


@EVERY_MOTION
@pytest.mark.parametrize("power", [-40, 40])
def test_the_unit_of_inertia_does_not_matter(name: str, power: int):
    body, start, motion = made(name)
    times = np.array([10**9, -(10**12), 10**16])
    assert_same(ClosedForm(RigidBody(body.inertia * 2.0**power), start).at(times), motion.at(times), 1e-15)


@EVERY_MOTION
def test_the_unit_of_time_does_not_matter(name: str):
    body, start, motion = made(name)
    times = np.array([10**9, -(10**12), 10**15])
    slow = ClosedForm(body, State(start.attitude_xyzw, start.body_rate / 8.0)).at(8 * times)
    assert_same(State.trusted(slow.attitude_xyzw, slow.body_rate * 8.0), motion.at(times), 1e-15)


MOMENTS = st.tuples(*[st.floats(0.5, 1.0)] * 3)
COMPONENTS = st.tuples(*[st.floats(-3.0, 3.0).filter(lambda x: x == 0.0 or abs(x) > 1e-3)] * 3)
STAMPS = st.integers(-(10**16), 10**16)
ORDERS = st.sampled_from([[0.5, 0.5, 0.5, 0.5], [0.5, 0.5, 0.5, -0.5], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])


@given(MOMENTS, COMPONENTS, STAMPS, st.integers(-300, 300))
def test_going_on_from_any_state_on_the_way_is_the_same_motion(moments, rate, s: int, hundredths: int):
    """Motion by s and then t is motion by s + t, but for what the rounding of the state on the way becomes.

    A change of ω by ε at the start makes at most ε exp(Λt) after t, as ω′ = f(ω) with |∂f/∂ω| ≤ Λ = 2|ω|max
    (each |Iᵢ − Iⱼ|/Iₖ is at most 1), and turns the attitude by no more than ∫ε exp(Λt)dt.
    """
    body, start = RigidBody(list(moments)), State(quaternion.normalize(TILTED), list(rate))
    t, motion = hundredths * SECOND // 100, ClosedForm(body, start)
    onward, whole = ClosedForm(body, motion.at(s)).at(t), motion.at(s + t)
    fastest = float(np.sqrt(2.0 * body.kinetic_energy(start) / body.principal_moments[0]))
    growth = np.exp(2.0 * fastest * abs(t) * 1e-9)
    bound = 4e-15 * (1.0 + growth)
    assert np.abs(onward.body_rate - whole.body_rate).max() <= bound * fastest
    assert np.abs(onward.attitude_xyzw - whole.attitude_xyzw).max() <= bound


@given(MOMENTS, COMPONENTS, STAMPS, ORDERS, st.integers(-60, 60), st.integers(-3, 3))
def test_time_axes_and_units_do_not_matter_to_any_motion(moments, rate, t_ns: int, turn, power: int, scale: int):
    body, start = RigidBody(list(moments)), State(quaternion.normalize(TILTED), list(rate))
    states = ClosedForm(body, start).at(8 * t_ns)
    mirrored = ClosedForm(body, State(start.attitude_xyzw, -start.body_rate)).at(-8 * t_ns)
    assert_same(State.trusted(mirrored.attitude_xyzw, -mirrored.body_rate), states, 2e-15)
    heavy = ClosedForm(RigidBody(body.inertia * 2.0**power), start).at(8 * t_ns)
    assert_same(heavy, states, 2e-15)
    faster = State(start.attitude_xyzw, start.body_rate * 2.0**scale)
    seen = ClosedForm(body, faster).at(8 * t_ns // 2**scale if scale >= 0 else 8 * t_ns * 2**-scale)
    assert_same(State.trusted(seen.attitude_xyzw, seen.body_rate / 2.0**scale), states, 2e-15)
    matrix = np.rint(so3.exp(quaternion.log(turn)))
    attitude = quaternion.multiply(start.attitude_xyzw, quaternion.conjugate(turn))
    named = ClosedForm(RigidBody(matrix @ body.inertia @ matrix.T), State(attitude, matrix @ start.body_rate)).at(
        8 * t_ns
    )
    assert_same(State.trusted(quaternion.multiply(named.attitude_xyzw, turn), named.body_rate @ matrix), states, 2e-15)


def test_a_world_turned_beforehand_turns_every_attitude():
    body, start, motion = made("products")
    world = quaternion.normalize([0.3, 0.2, -0.9, 0.1])
    turned = ClosedForm(body, State(quaternion.multiply(world, start.attitude_xyzw), start.body_rate))
    times = np.array([0, 10**9, -(10**12), 10**16])
    seen = turned.at(times)
    expected = State.trusted(quaternion.multiply(world, motion.at(times).attitude_xyzw), motion.at(times).body_rate)
    assert_same(seen, expected, 2e-15)


def test_beyond_the_separatrix_by_one_ulp_the_motion_is_the_same_until_it_parts():
    inertia = RigidBody([3.0, 4.0, 6.0])
    on, inside, outside = (
        ClosedForm(inertia, State([0, 0, 0, 1], [x, 3.0, 1.0]))
        for x in (2.0, np.nextafter(2.0, 1), np.nextafter(2.0, 3))
    )
    times = np.arange(5) * SECOND
    assert_same(inside.at(times), on.at(times), 1e-13)
    assert_same(outside.at(times), on.at(times), 1e-13)
    # inside, the momentum circulates about axis 3, and ω₁ changes sign; outside about axis 1, and ω₃ does
    times = np.arange(400) * SECOND // 4
    assert inside.at(times).body_rate[:, 2].min() > 0.0 > -1.0 > inside.at(times).body_rate[:, 0].min()
    assert outside.at(times).body_rate[:, 0].min() > 0.0 > -1.0 > outside.at(times).body_rate[:, 2].min()
    # on the separatrix it stays at the middle axis for ever
    np.testing.assert_array_equal(on.at(10**18).body_rate[[0, 2]], 0.0)


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


@given(
    st.tuples(*[st.floats(0.5, 1.0)] * 3),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.integers(-(2**63), 2**63 - 1),
)
def test_any_motion_is_finite_and_keeps_its_momentum(moments, rate, t_ns: int):
    body, start = RigidBody(list(moments)), State(quaternion.normalize(TILTED), list(rate))
    state = ClosedForm(body, start).at(t_ns)
    momentum = body.angular_momentum(start)
    assert np.isfinite(state.attitude_xyzw).all()
    assert np.abs(body.angular_momentum(state) - momentum).max() <= 4e-15 * vectors.norm(momentum)


@pytest.mark.parametrize("rate", [[1.0, 1.0, 1e-163], [1.0, -1.0, 1e-200], [-1.0, 1.0, 1e-300], [1.0, 1e-163, 1.0]])
@pytest.mark.parametrize("product", [5e-324, 1e-315, 1e-300])
def test_where_the_smallest_numbers_set_moments_apart_the_spin_is_steady(rate: list[float], product: float):
    """Circling about one of two moments: sines and cosines of the libration are all but 0, both of them."""
    start, t_ns = State(quaternion.normalize(TILTED), rate), [0, 1, 5, 10**9, -(10**17)]
    if rate[2] == 1.0:
        body = RigidBody([1.0, 0.0, product, 0.5, 0.0, 1.0])
    else:
        body = RigidBody([1.0, product, 0.0, 1.0, 0.0, 0.5])
    steady = ClosedForm(RigidBody([1.0, 1.0, 1.0]), start)
    assert_same(ClosedForm(body, start).at(t_ns), steady.at(t_ns), 2e-15)


def mean_rate_and_period(moments: list[mpf], rate: list[mpf]):
    """Period of ω and growth of ψ over it by quadrature of Euler's equations, for circulation about axis 3."""
    (a, b, c), (x, y, z) = moments, rate
    energy = a * x * x + b * y * y + c * z * z
    square = (a * x) ** 2 + (b * y) ** 2 + (c * z) ** 2
    w1 = mp.sqrt((energy * c - square) / (a * (c - a)))
    w2 = mp.sqrt((energy * c - square) / (b * (c - b)))
    length = mp.sqrt(square)

    def course(angle):
        """dt/dφ along ω₁ = w1 cos φ, ω₂ = w2 sin φ, and ω₃."""
        w3 = mp.sqrt((energy - a * (w1 * mp.cos(angle)) ** 2 - b * (w2 * mp.sin(angle)) ** 2) / c)
        return b * w2 / ((c - a) * w1 * w3), w3

    def growth(angle):
        slope, w3 = course(angle)
        return slope * (energy / length + w3) / (1 + c * w3 / length)

    quarter = [mp.mpf(0), mp.pi / 8, mp.pi / 4, 3 * mp.pi / 8, mp.pi / 2]
    return 4 * mp.quad(lambda f: course(f)[0], quarter), 4 * mp.quad(growth, quarter)


@pytest.mark.parametrize(
    ("inertia", "rate"),
    [
        ([0.6, 0.8, 1.0], [0.3, 0.5, 1.1]),
        ([1.0, 2.0, 3.0], [0.5, 1.0, 0.4]),
        ([1.0, 1.0 + 1e-9, 1.7], [0.5, 0.7, 1e-3]),
        ([0.6, 0.8, 1.0], [1e-30, 2e-30, 1.0]),
    ],
)
def test_after_many_periods_the_body_has_turned_by_as_many_growths(inertia: list[float], rate: list[float]):
    """The state a number of whole periods later, by quadrature of many digits, up to 2⁶² ns."""
    body, start = RigidBody(inertia), State(quaternion.normalize(TILTED), rate)
    with mp.workdps(95 if min(map(abs, rate)) < 1e-9 else 60):
        period, growth = mean_rate_and_period([mpf(x) for x in inertia], [mpf(x) for x in rate])
        most = int(mpf(2) ** 62 / (period * 10**9))
        for count in (1, 1000, most // 77, most):
            t_ns = int(mp.nint(count * period * 10**9))
            state = ClosedForm(body, start).at(t_ns)
            # back to the exact end of the period by less than a nanosecond of nearly steady rotation
            rest = float(mpf(t_ns) / 10**9 - count * period)
            half = mp.fmod(count * growth / 2, 2 * mp.pi)
            axis = body.angular_momentum(start)
            turn = np.append(axis / np.linalg.norm(axis) * float(mp.sin(half)), float(mp.cos(half)))
            whole = quaternion.multiply(turn, start.attitude_xyzw)
            expected = quaternion.multiply(whole, quaternion.exp(start.body_rate * rest))
            np.testing.assert_allclose(state.attitude_xyzw, expected, rtol=0.0, atol=3e-15)
