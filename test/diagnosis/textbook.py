"""Attitude filters as in textbooks, written for these tests, and mistakes to be put into them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import cos, sin, sqrt
from types import SimpleNamespace
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
Change = Callable[[Array], Array]
Quaternion = tuple[float, float, float, float]
Vector = tuple[float, float, float]


def product(p: Quaternion, q: Quaternion) -> Quaternion:
    a, b, c, w = p
    x, y, z, v = q
    return (
        w * x + a * v + b * z - c * y,
        w * y - a * z + b * v + c * x,
        w * z + a * y - b * x + c * v,
        w * v - a * x - b * y - c * z,
    )


def exponential(v: Vector) -> Quaternion:
    angle = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    s = sin(0.5 * angle) / angle if angle > 1e-12 else 0.5
    return v[0] * s, v[1] * s, v[2] * s, cos(0.5 * angle)


def cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def to_body(q: Quaternion, v: Vector) -> Vector:
    x, y, z, _ = product(product((-q[0], -q[1], -q[2], q[3]), (*v, 0.0)), q)
    return x, y, z


def unit(v: Sequence[float]) -> Vector:
    x, y, z = v
    size = sqrt(x * x + y * y + z * z) or 1.0
    return x / size, y / size, z / size


def frames(first: Array, second: Array) -> Array:
    across = np.cross(first, second)
    axes = np.stack([first, across, np.cross(first, across)], axis=-1)
    return axes / np.linalg.norm(axes, axis=-2, keepdims=True)


def triad(run: Any) -> Array:
    """The attitude that each pair of readings tells (TRIAD)."""
    from scipy.spatial.transform import Rotation

    world = frames(np.array([0.0, 0.0, 1.0]), np.array(run.scenario.parameters()["magnetic_field"]))
    body = frames(run.imu.specific_force, run.magnetometer.field)
    return Rotation.from_matrix(world @ np.swapaxes(body, -1, -2)).as_quat()


def mahony(
    run: Any,
    kp: float = 2.0,
    ki: float = 0.2,
    *,
    nominal: float | None = None,
    signs: Vector = (1.0, 1.0, 1.0),
    begin: Quaternion | None = None,
) -> Array:
    """Mahony's filter with the gyro's step first; it begins with TRIAD, unless an attitude is given.

    The signs of its corrections, by the accelerometer, by the magnetometer and of the bias, can be wrong.
    """
    field = unit(run.scenario.parameters()["magnetic_field"])
    q: Quaternion = begin or tuple(triad(run)[0].tolist())
    steps = np.diff(run.imu.t_ns, prepend=2 * run.imu.t_ns[0] - run.imu.t_ns[1]) / 1e9
    bx = by = bz = 0.0
    out = []
    readings = (steps, run.imu.gyro, run.imu.specific_force, run.magnetometer.field)
    for dt, gyro, force, magnetic in zip(*(each.tolist() for each in readings), strict=True):
        dt = nominal or dt
        q = product(q, exponential(((gyro[0] - bx) * dt, (gyro[1] - by) * dt, (gyro[2] - bz) * dt)))
        e, f = cross(unit(force), to_body(q, (0.0, 0.0, 1.0))), cross(unit(magnetic), to_body(q, field))
        ex, ey, ez = (signs[0] * a + signs[1] * b for a, b in zip(e, f, strict=True))
        bias = signs[2] * ki * dt
        bx, by, bz = bx - bias * ex, by - bias * ey, bz - bias * ez
        q = product(q, exponential((kp * ex * dt, kp * ey * dt, kp * ez * dt)))
        size = sqrt(sum(x * x for x in q))
        q = (q[0] / size, q[1] / size, q[2] / size, q[3] / size)
        out.append(q)
    return np.array(out)


def as_it_is(vectors: Array) -> Array:
    return vectors


def late(samples: int) -> Change:
    return lambda vectors: np.concatenate([vectors[:1]] * samples + [vectors[:-samples]])


def sooner(vectors: Array) -> Array:
    """Readings a sample before their time, as a filter takes them that compares them with the attitude before."""
    return np.concatenate([vectors[1:], vectors[-1:]])


def changed(run: Any, gyro: Change = as_it_is, force: Change = as_it_is, field: Change = as_it_is) -> Any:
    """A run whose readings a filter mistakes, as if its own code did it."""
    imu = SimpleNamespace(t_ns=run.imu.t_ns, gyro=gyro(run.imu.gyro), specific_force=force(run.imu.specific_force))
    magnetometer = SimpleNamespace(t_ns=run.magnetometer.t_ns, field=field(run.magnetometer.field))
    return SimpleNamespace(imu=imu, magnetometer=magnetometer, scenario=run.scenario)


def right(run: Any) -> Array:
    return mahony(run)


def both_ways(run: Any) -> Array:
    """Mean of Mahony's filter and of the same one backward in time: a smoother, the truth where sensors are perfect."""
    # backward, the mean rate over the time before a reading is that over the time after it
    gyro = -np.roll(run.imu.gyro, -1, axis=0)[::-1]
    imu = SimpleNamespace(t_ns=-run.imu.t_ns[::-1], gyro=gyro, specific_force=run.imu.specific_force[::-1])
    field = SimpleNamespace(field=run.magnetometer.field[::-1])
    ahead, back = mahony(run), mahony(SimpleNamespace(imu=imu, magnetometer=field, scenario=run.scenario))[::-1]
    total = ahead + np.sign(np.sum(ahead * back, axis=1, keepdims=True)) * back
    return np.asarray(total / np.linalg.norm(total, axis=1, keepdims=True))


def scalar_first(run: Any) -> Array:
    return np.roll(triad(run), 1, axis=1)


def upside_down(run: Any) -> Array:
    return triad(changed(run, force=lambda v: -v))


def two_mistakes(run: Any) -> Array:
    return triad(changed(run, force=lambda v: v[:, [1, 0, 2]], field=lambda v: v * [1.0, 1.0, -1.0]))


def begins_upside_down(run: Any) -> Array:
    """Two mistakes in what only the first attitude is made of; half a turn is left, whatever repairs the second."""
    return mahony(changed(run, force=lambda v: -v, field=lambda v: v[:, [1, 0, 2]]), kp=0.0, ki=0.0)


def late_and_inverted(run: Any) -> Array:
    """The readings of the magnetometer five samples late, and the inverse of the attitude."""
    return mahony(changed(run, field=late(5))) * [-1.0, -1.0, -1.0, 1.0]


def raises(run: Any) -> Array:
    raise ZeroDivisionError("of the filter")


def of_wrong_shape(run: Any) -> Array:
    return triad(run)[:, :3]


def not_a_number(run: Any) -> Array:
    attitude = triad(run)
    attitude[7:] = np.nan
    return attitude


def hangs(run: Any) -> Array:
    while True:
        pass


def interrupts(run: Any) -> Array:
    raise KeyboardInterrupt("of the filter")


def stops(run: Any) -> Array:
    raise BaseException


def first_reading(run: Any) -> Any:
    return run.imu.t_ns[:1], [[0.0, 0.0, 0.0, 1.0]]


def changes_its_run(run: Any) -> Array:
    object.__setattr__(run, "imu", None)
    return np.tile([0.0, 0.0, 0.0, 1.0], (10, 1))


def changes_its_estimate(run: Any) -> Any:
    from lie_rigid_body import Estimate

    found = Estimate(triad(run), run.imu.t_ns)
    object.__setattr__(found, "attitude_xyzw", "nothing")
    return found


def spoils_its_process(run: Any) -> Array:
    import sys

    sys.path.clear()
    del sys.modules["numpy"]
    return np.tile([0.0, 0.0, 0.0, 1.0], (len(run.imu.t_ns), 1))


class _Endless:
    def __len__(self) -> int:
        return 10**18

    def __getitem__(self, place: int) -> list[float]:
        return [0.0, 0.0, 0.0, 1.0]


def endless(run: Any) -> Any:
    return _Endless()


class _Unreadable:
    @property
    def attitude_xyzw(self) -> Array:
        raise LookupError("where it is read")


def unreadable(run: Any) -> Any:
    return _Unreadable()


def dies(run: Any) -> Array:
    import os

    os._exit(3)


def forks(run: Any) -> Array:
    import os
    import time

    if not os.fork():
        time.sleep(3600)
    os._exit(3)


def peeks(run: Any) -> Array:
    return run.attitude().at(run.imu.t_ns)


def from_afar(run: Any) -> Array:
    """A right filter that begins at the identity, and takes most of a minute to come from there."""
    return mahony(run, kp=1.0, ki=0.1, begin=(0.0, 0.0, 0.0, 1.0))


def without_a_magnetometer(run: Any) -> Array:
    """A right filter of gyro and accelerometer, which begins with any heading."""
    north = changed(run, field=lambda field: np.tile([1.0, 0.2, 0.1], (len(field), 1)))
    return mahony(north, signs=(1.0, 0.0, 1.0), ki=0.0)


def stuck(run: Any) -> Array:
    attitude = triad(run)
    attitude[:] = attitude[0]
    return attitude


def averages_the_gyro(run: Any) -> Array:
    """Mahony's filter that takes the mean of the gyro's first two seconds for its bias."""
    first = run.imu.gyro[run.imu.t_ns < 2_000_000_000]
    return mahony(changed(run, gyro=lambda v: v - first.mean(axis=0)), ki=0.0)


def triad_with_covariance(run: Any) -> Any:
    """TRIAD with the covariance that the noise of its two vectors makes, about the axes of the world."""
    from lie_rigid_body import Estimate

    given = run.scenario.parameters()
    gravity, field = given["gravity"], np.array(given["magnetic_field"])
    level = np.hypot(field[0], field[1])
    x, y = field[:2] / level
    # small turns about x, y, z of the noise of the force, n, and of the field, m, on the world's axes: the force is
    # vertical, tilts are n × z / g; then the field is in its plane, (m + tilt × field) · (-y, x, 0) + turn level = 0
    of_force = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]) / gravity
    of_force[2] = field[2] / level * (y * of_force[1] + x * of_force[0])
    of_field = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [y, -x, 0.0]]) / level
    force, magnetic = (
        given[f"{sensor}_noise_density"] * given[f"{rate}_rate"] ** 0.5
        for sensor, rate in (("accelerometer", "imu"), ("magnetometer", "magnetometer"))
    )
    covariance = force**2 * of_force @ of_force.T + magnetic**2 * of_field @ of_field.T
    return Estimate(triad(run), covariance=covariance)


def triad_with_deviations(run: Any) -> Any:
    """The same with the square root of the covariance, as of a standard deviation that is given for a variance."""
    from dataclasses import replace

    estimate = triad_with_covariance(run)
    values, vectors = np.linalg.eigh(estimate.covariance)
    scaled = vectors * np.sqrt(values.clip(0.0))[:, np.newaxis]
    return replace(estimate, covariance=scaled @ np.swapaxes(vectors, 1, 2))


def triad_for_the_body(run: Any) -> Any:
    """The same about the axes of the world, which it says are those of the body."""
    from dataclasses import replace

    return replace(triad_with_covariance(run), covariance_axes="body")


def by_known_sizes(run: Any, units: Sequence[float] = (1.0, 1.0)) -> tuple[Array, Array, Array, Array]:
    """Up and the field, and what is read of them over their known sizes, times what a filter takes the units for."""
    field, up = np.array(run.scenario.parameters()["magnetic_field"]), np.array([0.0, 0.0, 1.0])
    size = np.linalg.norm(field)
    return up, field / size, units[0] * run.imu.specific_force / 9.80665, units[1] * run.magnetometer.field / size


def proportional(
    run: Any, gain: float = 2.0, signs: Sequence[float] = (1.0, 1.0), step: float = 1.0, **given: Sequence[float]
) -> Array:
    """Mahony's correction without a bias, of vectors that are not divided by their norms but by known sizes.

    The signs are those of its corrections by the accelerometer and by the magnetometer.
    """
    up, field, *vectors = by_known_sizes(run, **given)
    q: Quaternion = tuple(triad(run)[0].tolist())
    rate, out = 0.01 * step * gain, []
    for gyro, force, magnetic in zip(run.imu.gyro.tolist(), *(each.tolist() for each in vectors), strict=True):
        q = product(q, exponential((0.01 * gyro[0], 0.01 * gyro[1], 0.01 * gyro[2])))
        e, f = cross(force, to_body(q, tuple(up))), cross(magnetic, to_body(q, tuple(field)))
        x, y, z = (rate * (signs[0] * a + signs[1] * b) for a, b in zip(e, f, strict=True))
        q = product(q, exponential((x, y, z)))
        size = sqrt(sum(x * x for x in q))
        q = (q[0] / size, q[1] / size, q[2] / size, q[3] / size)
        out.append(q)
    return np.array(out)


def kalman(
    run: Any,
    signs: Sequence[float] = (1.0, 1.0),
    *,
    predicted: bool = False,
    step: float = 1.0,
    **given: Sequence[float],
) -> Array:
    """A Kalman filter of the attitude, whose Jacobians of the accelerometer and of the magnetometer have these signs.

    It divides vectors by their known sizes, and makes its Jacobians of what is read or of what is predicted.
    """
    up, field, *vectors = by_known_sizes(run, **given)
    q, P, out = triad(run)[0], 1e-2 * np.eye(3), []
    for gyro, force, magnetic in zip(run.imu.gyro, *vectors, strict=True):
        q = np.array(product(tuple(q.tolist()), exponential(tuple((0.01 * gyro).tolist()))))
        expected = [np.array(to_body(tuple(q.tolist()), tuple(v))) for v in (up, field)]
        Phi = np.eye(3) - 0.01 * hat(gyro)
        P = Phi @ P @ Phi.T + 1e-7 * np.eye(3)
        first, second = expected if predicted else (force, magnetic)
        H = np.concatenate([signs[0] * hat(first), signs[1] * hat(second)])
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + 1e-4 * np.eye(6))
        turn = step * K @ np.concatenate([force - expected[0], magnetic - expected[1]])
        q = np.array(product(tuple(q.tolist()), exponential(tuple(turn.tolist()))))
        q, P = q / np.linalg.norm(q), P - K @ H @ P
        out.append(q)
    return np.array(out)


def with_wrong_jacobian(run: Any) -> Array:
    """A Kalman filter whose Jacobian of the magnetometer has the wrong sign.

    With exact readings it follows until round-off has grown; with tiny ones of the field it goes on without them.
    """
    return kalman(run, signs=(1.0, -1.0))


def hat(v: Array) -> Array:
    """Matrix of the cross product with a vector from the left."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def corrects_the_wrong_way(run: Any) -> Array:
    """Mahony's filter that turns away from the accelerometer, which shows only where it errs."""
    return mahony(run, signs=(-1.0, 1.0, 1.0))


def corrects_before_the_step(run: Any) -> Array:
    """Mahony's filter that compares readings with the attitude before, and turns away from the magnetometer."""
    ahead = changed(run, force=sooner, field=sooner)
    return mahony(ahead, signs=(1.0, -1.0, 1.0))


def bias_of_wrong_sign(run: Any) -> Array:
    return mahony(run, signs=(1.0, 1.0, -1.0))
