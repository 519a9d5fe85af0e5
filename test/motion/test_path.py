"""A path through poses, against closed-form motions, SciPy's own spline and differences of the path itself."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, RotationSpline

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.path import MAX_KNOTS, Knots, PathTranslation, PosePath

Z = np.array([0.0, 0.0, 1.0])
Y = np.array([0.0, 1.0, 0.0])


def tilting(t_s: Array) -> tuple[Array, Array, Array]:
    """Attitude Rz(α) Ry(β), body rate and angular acceleration of α = 2 sin t + 3 t, β = cos 2t, by hand."""
    alpha, beta = 2.0 * np.sin(t_s) + 3.0 * t_s, np.cos(2.0 * t_s)
    attitude = quaternion.multiply(quaternion.exp(alpha[:, None] * Z), quaternion.exp(beta[:, None] * Y))
    # Ry(β)ᵀ ẑ = (−sin β, 0, cos β)
    up = np.stack([-np.sin(beta), 0.0 * beta, np.cos(beta)], axis=-1)
    up_rate = np.stack([-np.cos(beta), 0.0 * beta, -np.sin(beta)], axis=-1)
    turn, tilt = 2.0 * np.cos(t_s) + 3.0, -2.0 * np.sin(2.0 * t_s)
    rate = turn[:, None] * up + tilt[:, None] * Y
    change = -2.0 * np.sin(t_s)[:, None] * up + (turn * tilt)[:, None] * up_rate - 4.0 * np.cos(2.0 * t_s)[:, None] * Y
    return attitude, rate, change


def carried(t_s: Array) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration of three harmonics."""
    phase = t_s[:, None] * [1.0, 2.0, 3.0] + [0.1, 0.2, 0.3]
    return np.sin(phase), np.cos(phase) * [1.0, 2.0, 3.0], -np.sin(phase) * [1.0, 4.0, 9.0]


def path_of(step_s: float, span_s: float = 6.0) -> PosePath:
    t_ns = np.arange(0, round(span_s * 1e9) + 1, round(step_s * 1e9))
    return PosePath(Knots(t_ns, carried(t_ns / 1e9)[0], tilting(t_ns / 1e9)[0]).averaged(0))


def rough(count: int, largest_deg: float, seed: int) -> Knots:
    """Knots at uneven times, with rotations of up to so many degrees from one to the next."""
    draw = np.random.default_rng(seed)
    t_ns = np.cumsum(draw.integers(1_000_000, 90_000_000, count))
    steps = Rotation.from_rotvec(
        (lambda v: v / np.linalg.norm(v, axis=1)[:, None] * np.radians(draw.uniform(0.0, largest_deg, count))[:, None])(
            draw.standard_normal((count, 3))
        )
    )
    attitude = [Rotation.identity()]
    for step in steps[1:]:
        attitude.append(attitude[-1] * step)
    xyzw = np.array([each.as_quat() for each in attitude])
    return Knots(t_ns - t_ns[0], draw.standard_normal((count, 3)), xyzw).averaged(0)


def angle(p: Array, q: Array) -> float:
    return float(np.linalg.norm(quaternion.log(quaternion.multiply(quaternion.conjugate(p), q)), axis=-1).max())


def inner(path: PosePath, share: float = 0.3, count: int = 400) -> Integers:
    """Times off the ends of a path, where the ends' conditions tell no more."""
    return np.linspace(share * path.last_ns, (1.0 - share) * path.last_ns, count).astype(np.int64)


def test_it_goes_through_its_knots_with_their_signs() -> None:
    for knots in (path_of(0.1).knots, rough(60, 169.0, 1)):
        path = PosePath(knots)
        assert np.abs(path.at(knots.t_ns).attitude_xyzw - knots.attitude_xyzw).max() < 2e-15
        assert np.abs(path.mass_centre(knots.t_ns).position - knots.position).max() < 4e-15


def test_a_steady_rotation_and_a_cubic_position_are_exact() -> None:
    t_ns = np.array([0, 10, 25, 32, 50, 61]) * 10_000_000
    rate = np.array([1.0, -2.0, 0.5])
    cubic = np.polynomial.Polynomial([0.3, -1.0, 2.0, 4.0])
    positions = np.stack([cubic(t_ns / 1e9), Z[2] * t_ns / 1e9, 0.0 * t_ns], axis=-1)
    path = PosePath(Knots(t_ns, positions, quaternion.exp(t_ns[:, None] / 1e9 * rate)))
    times = np.arange(0, 610_000_000, 7_654_321)
    assert np.abs(path.at(times).body_rate - rate).max() < 1e-13
    assert np.abs(path.angular_acceleration(times)).max() < 1e-11
    centre = PathTranslation(path).at(times)
    assert np.abs(centre.velocity[:, 0] - cubic.deriv()(times / 1e9)).max() < 1e-12
    assert np.abs(centre.acceleration[:, 0] - cubic.deriv(2)(times / 1e9)).max() < 1e-10


def errors(step_s: float) -> Array:
    """Largest errors of attitude, body rate, angular acceleration, position, velocity and acceleration."""
    path = path_of(step_s)
    times = inner(path)
    attitude, rate, change = tilting(times / 1e9)
    centre = path.mass_centre(times)
    told = (path.at(times).body_rate, path.angular_acceleration(times), *(centre.position, centre.velocity))
    pairs = zip((*told, centre.acceleration), (rate, change, *carried(times / 1e9)), strict=True)
    return np.array([angle(attitude, path.at(times).attitude_xyzw), *(np.abs(a - b).max() for a, b in pairs)])


def test_it_tends_to_the_motion_whose_poses_it_is_given() -> None:
    coarse, fine = errors(0.1), errors(0.05)
    assert (np.log2(coarse / fine) > [3.7, 2.7, 1.7, 3.7, 2.7, 1.7]).all()
    assert (fine < [1e-4, 5e-3, 0.3, 1e-5, 3e-4, 0.02]).all()


@pytest.mark.parametrize("knots", [path_of(0.1).knots, rough(40, 120.0, 2)], ids=["smooth", "rough"])
def test_rates_and_accelerations_are_derivatives_within_each_piece(knots: Knots) -> None:
    path = PosePath(knots)
    middle = knots.t_ns[:-1] + np.diff(knots.t_ns) // 2
    h = 200_000
    taps = {k: path.at(middle + k * h) for k in (-2, -1, 1, 2)}
    there = path.at(middle).attitude_xyzw
    turns = {
        k: quaternion.log(quaternion.multiply(quaternion.conjugate(there), s.attitude_xyzw)) for k, s in taps.items()
    }
    fourth = lambda f: (8.0 * (f[1] - f[-1]) - (f[2] - f[-2])) / (12e-9 * h)  # noqa: E731
    rate, change = path.at(middle).body_rate, path.angular_acceleration(middle)
    assert np.abs(fourth(turns) - rate).max() < 1e-8 * np.abs(rate).max()
    assert np.abs(fourth({k: s.body_rate for k, s in taps.items()}) - change).max() < 1e-6 * np.abs(change).max()
    centres = {k: path.mass_centre(middle + k * h) for k in taps}
    centre = path.mass_centre(middle)
    speed = fourth({k: c.position for k, c in centres.items()})
    assert np.abs(speed - centre.velocity).max() < 1e-9 * np.abs(centre.velocity).max()
    force = fourth({k: c.velocity for k, c in centres.items()})
    assert np.abs(force - centre.acceleration).max() < 1e-8 * np.abs(centre.acceleration).max()


def test_rates_and_accelerations_are_continuous() -> None:
    path = PosePath(rough(60, 60.0, 3))
    knots = path.knots.t_ns[1:-1]
    before, after = path.mass_centre(knots - 1), path.mass_centre(knots)
    change = np.abs(path.angular_acceleration(knots))
    assert np.abs(path.at(knots - 1).body_rate - path.at(knots).body_rate).max() < 2e-9 * change.max()
    assert np.abs(before.velocity - after.velocity).max() < 2e-9 * np.abs(after.acceleration).max()
    assert np.abs(path.angular_acceleration(knots - 1) - path.angular_acceleration(knots)).max() < 1e-5 * change.max()
    jump = np.abs(before.acceleration - after.acceleration).max()
    assert jump < 1e-5 * np.abs(after.acceleration).max()


def test_it_is_the_spline_of_scipy() -> None:
    knots = rough(50, 150.0, 4)
    seconds = knots.t_ns / 1e9
    theirs = RotationSpline(seconds, Rotation.from_quat(knots.attitude_xyzw))
    times = np.arange(0, knots.t_ns[-1], 1_234_567)
    ours = PosePath(knots).at(times)
    assert angle(theirs(times / 1e9).as_quat(), ours.attitude_xyzw) < 1e-11
    assert np.abs(theirs(times / 1e9, 1) - ours.body_rate).max() < 1e-9 * np.abs(ours.body_rate).max()


def test_signs_go_on_through_whole_turns() -> None:
    path = path_of(0.2)
    q = path.at(np.arange(0, path.last_ns, 1_000_000)).attitude_xyzw
    assert (np.einsum("ij,ij->i", q[1:], q[:-1]) > 0.999).all()
    assert np.abs(np.linalg.norm(q, axis=1) - 1.0).max() < 5e-16
    assert q[:, 3].min() < -0.8  # more than a whole turn


def test_rates_go_on_beyond_both_ends() -> None:
    knots = path_of(0.1).knots
    path = PosePath(Knots(knots.t_ns + 50, knots.position, knots.attitude_xyzw))
    for edge, beyond in ((50, np.array([-3_000_000_000, 0, 49])), (path.last_ns, path.last_ns + np.array([1, 10**9]))):
        at, states = path.at(edge), path.at(beyond)
        seconds = (beyond - edge)[:, None] / 1e9
        assert (states.body_rate == at.body_rate).all()
        goal = quaternion.multiply(at.attitude_xyzw, quaternion.exp(seconds * at.body_rate))
        assert np.abs(states.attitude_xyzw - goal).max() < 1e-15
        centre, own = path.mass_centre(beyond), path.mass_centre(np.array([edge]))
        assert np.abs(centre.position - own.position - seconds * own.velocity).max() < 1e-14
        assert not centre.acceleration.any()
        assert not path.angular_acceleration(beyond).any()


@pytest.mark.parametrize("largest_deg", [5.0, 60.0, 169.0])
def test_no_rate_is_beyond_the_bound(largest_deg: float) -> None:
    path = PosePath(rough(300, largest_deg, 5))
    fastest = np.linalg.norm(path.at(np.arange(0, path.last_ns, 100_000)).body_rate, axis=1).max()
    assert fastest <= path.rate_bound < 2.5 * fastest
    smooth = path_of(0.05)
    assert smooth.rate_bound < 1.02 * np.linalg.norm(tilting(inner(smooth, 0.0) / 1e9)[1], axis=1).max()


def test_rms_of_the_acceleration_is_that_of_the_path() -> None:
    path = path_of(0.05)
    middles = np.arange(500_000, path.last_ns, 1_000_000)
    sampled = np.sqrt((path.mass_centre(middles).acceleration ** 2).sum(axis=1).mean())
    assert path.rms_acceleration() == pytest.approx(sampled, rel=1e-5)


def test_poses_are_averaged_over_intervals() -> None:
    t_ns = np.array([0, 10, 20, 31, 40, 100, 129, 130]) * 1_000_000
    attitude = Rotation.random(8, 6).as_quat()
    position = np.arange(24.0).reshape(8, 3)
    knots = Knots(t_ns, position, attitude).averaged(30_000_000)
    groups = [[0, 1, 2], [3, 4], [5, 6], [7]]
    assert knots.t_ns.tolist() == [10_000_000, 35_500_000, 114_500_000, 130_000_000]
    assert np.abs(knots.position - [position[group].mean(axis=0) for group in groups]).max() < 1e-14
    means = [Rotation.from_quat(attitude[group]).mean().as_quat() for group in groups]
    assert angle(np.array(means), knots.attitude_xyzw) < 1e-7  # of 1e-15 in the cosine
    dots = np.einsum("ij,ij->i", knots.attitude_xyzw[1:], knots.attitude_xyzw[:-1])
    assert (dots >= 0.0).all()


def test_without_an_interval_each_pose_is_a_knot() -> None:
    knots = rough(30, 90.0, 7)
    flipped = knots._replace(attitude_xyzw=knots.attitude_xyzw * np.where(np.arange(30) % 3 == 1, -1.0, 1.0)[:, None])
    ours = flipped.averaged(0)
    assert (ours.t_ns == knots.t_ns).all()
    assert (ours.position == knots.position).all()
    assert np.abs(ours.attitude_xyzw - knots.attitude_xyzw).max() < 5e-16


def test_numbers_tell_the_knots_to_the_bit() -> None:
    draw = np.random.default_rng(8)
    t_ns = np.unique(draw.integers(0, 10**15, 1000))
    knots = rough(len(t_ns), 90.0, 8)._replace(t_ns=t_ns)
    again = Knots.of([float(repr(number)) for number in knots.numbers()])
    assert all((ours == theirs).all() for ours, theirs in zip(knots, again, strict=True))


def test_batches_have_the_same_bits() -> None:
    path = PosePath(rough(40, 90.0, 9))
    times = np.arange(-(10**8), path.last_ns + 10**8, 9_876_543)
    whole, centre, change = path.at(times), path.mass_centre(times), path.angular_acceleration(times)
    for i, time in enumerate(times):
        one = times[i : i + 1]
        assert (path.at(int(time)).attitude_xyzw == whole.attitude_xyzw[i]).all()
        assert (path.at(one).body_rate == whole.body_rate[i]).all()
        assert (path.angular_acceleration(one) == change[i]).all()
        for name in ("position", "velocity", "acceleration"):
            assert (getattr(path.mass_centre(one), name)[0] == getattr(centre, name)[i]).all()
    assert deepcopy(path) is path


STILL = np.tile([0.0, 0.0, 0.0, 1.0], (5, 1))
TIMES = np.arange(5) * 10**8


@pytest.mark.parametrize(
    ("t_ns", "attitude", "told"),
    [
        (TIMES[:3], STILL[:3], "3 knots"),
        (np.arange(MAX_KNOTS + 1), np.tile(STILL[:1], (MAX_KNOTS + 1, 1)), f"{MAX_KNOTS + 1} knots"),
        (TIMES * [1, 1, 0, 1, 1], STILL, "knot 3"),
        (TIMES * [1, 1, 1, 1, 0.75], STILL, "knot 5"),
        (TIMES, STILL * [[1], [1], [1.00001], [1], [1]], "knot 3"),
        (
            TIMES,
            quaternion.exp(np.radians([0.0, 10.0, 181.0, 300.0, 420.0])[:, None] * Z),
            "knot 3, at 0.2 s, is turned",
        ),
    ],
)
def test_no_path_goes_through_these(t_ns: Array, attitude: Array, told: str) -> None:
    with pytest.raises(ParameterError, match=told) as refused:
        PosePath(Knots(t_ns.astype(np.int64), np.zeros((len(t_ns), 3)), attitude))
    assert refused.value.name == "path_knots"
    assert "give" in str(refused.value)
