"""Courses: a body that rests and then turns, the readings of perfect sensors, and at most one disturbance.

A course begins with a rest in which the filter settles; its answers to these readings are dropped. A second at rest
follows, longer than any shift in time that is tried, so that a shifted reading is right there. Then the body gathers
speed within `RAMP` along the path of its free motion, so that the gyro's readings do not jump. After that the motion is
free. A free course has neither a rest nor a ramp.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final, cast

import numpy as np

from lie_rigid_body.evaluation.attitudes import Truth, relative_rotations
from lie_rigid_body.evaluation.causes import UP
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS, Given, Vector
from lie_rigid_body.lie import quaternion
from lie_rigid_body.lie.vectors import norm
from lie_rigid_body.runs.ensemble import BlindRun
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import read_parameters
from lie_rigid_body.sensors.noise import NoiseSource, harmonics

GYRO_KINDS: Final = ("integrated", "instantaneous")
"""Kinds of gyro: values of the parameter ``gyro_rate``."""

REST: Final = 1.0
"""Time at rest before the motion, s."""
RAMP: Final = 0.5
"""Time in which the motion gathers speed, s."""
MOVING: Final = 12.0
"""Length of the motion of an ordinary course, s."""
TURN: Final = 2.0
"""Time in which a body is turned from one heading to the next, s."""
HOLD: Final = 30.0
"""Time for which it is held at each, s."""
SWAY: Final = (2.0, 2.0, 2.0)
"""RMS of the acceleration of a carried body on each axis, m/s²."""
SWAY_BAND: Final = (0.3, 2.0)
"""Its lowest and highest frequency, Hz."""
LEVER_ARM: Final = (0.1, -0.1, 0.1)
"""Place of the accelerometer of a carried body from its mass centre, m."""
MARGIN: Final = 64
"""Number of extra readings before and after those that a filter is given, which a repair may shift in."""

RATE: Final = 100.0
"""Readings a second, where a scenario tells no rate."""
COURSE_MOTIONS: Final = (
    {
        "inertia": [1.0, 2.0, 3.0],
        "initial_attitude_xyzw": [0.1, -0.2, 0.3, 0.9273618495495704],
        "initial_body_rate": [0.9, -0.7, 1.1],
    },
    {
        "inertia": [1.0, 1.6, 2.2],
        "initial_attitude_xyzw": [-0.5, 0.3, 0.1, 0.806225774829855],
        "initial_body_rate": [-0.8, 1.2, 0.9],
    },
)
"""Two motions that turn about every axis by a radian a second and more. `benchmarks/diagnosis.py` prints how well they
tell the repairs apart."""
TINY: Final = 1e-4
"""Constant error of nearly perfect sensors, as a multiple of the mean turn between two readings in rad: rad/s of the
gyro, a share of the vector of others. An unstable filter amplifies such errors, as it does round-off, so that no repair
looks right by chance."""
MIN_STEP_TURN: Final = 1e-6
"""Turn between two readings, rad, below which a motion tells nothing."""
_TAKEN: Final = {*COURSE_MOTIONS[0], "imu_rate", "magnetometer_rate", "gravity", "magnetic_field"}
"""Parameters that a course takes from a given scenario."""
_OWN: Final = {"motion": "closed_form", "accelerometer_mode": "pivot_gravity", "gyro_rate": GYRO_KINDS[0]}
"""Parameters that every course sets itself; the kind of the gyro is that of an ordinary course."""

NOISE: Final = {
    "gyro_noise_density": "imu_rate",
    "accelerometer_noise_density": "imu_rate",
    "magnetometer_noise_density": "magnetometer_rate",
}
"""Parameters of the noise of the three sensors, and of their rates."""


@dataclass(frozen=True)
class Course(Truth):
    """A course: the motion, the sensors and the disturbance with which a filter is run; it tells the true attitude.

    Attributes
    ----------
    scenario : Scenario
        The motion, the rates and the kind of the gyro.
    moving_s, rest_s : float
        Length of the motion and of the rest before it, s.
    settle_s : float
        Length of the first rest, in which the filter settles, s.
    ramp_s : float
        Time in which the motion gathers speed, s.
    grid : str
        How stamps follow each other: ``even``; ``alternating``, steps of 2/3 and 4/3 in turn; ``walk``, steps at random
        from 2/3 to 4/3.
    gaps_s : tuple of float
        Times at which readings are lost for a second, s.
    off : tuple of (str, tuple of float)
        Sensors, by the names of their readings, and their constant errors, rad/s, m/s² or T.
    seed : int
        Number from which the white noise follows whose densities the scenario tells.
    is_rounded : bool
        Whether matrices of attitudes are rounded to whole numbers: those of the rotations of a cube are exact.
    is_carried : bool
        Whether the mass centre sways as the body moves, and the accelerometer is at the end of `LEVER_ARM`.
    """

    scenario: Scenario
    moving_s: float = MOVING
    rest_s: float = REST
    settle_s: float = 0.0
    ramp_s: float = RAMP
    grid: str = "even"
    gaps_s: Vector = ()
    off: tuple[tuple[str, Vector], ...] = ()
    seed: int = 0
    is_rounded: bool = False
    is_carried: bool = False
    first_ns = -(2**62)
    last_ns = 2**62

    def at(self, stamps_ns: Integers) -> Array:
        """Attitudes world-from-body, shape (..., 4)."""
        return self.states(stamps_ns)[0]

    def states(self, stamps_ns: Integers) -> tuple[Array, Array]:
        """Attitudes, shape (..., 4), and body rates, rad/s, shape (..., 3)."""
        stamps = np.asarray(stamps_ns, dtype=np.int64)
        attitude, rate = _states(self.scenario, self.settle_s + self.rest_s, self.ramp_s, stamps.tobytes())
        return attitude.reshape(*stamps.shape, 4), rate.reshape(*stamps.shape, 3)

    @property
    def begin_ns(self) -> int:
        """First stamp whose answer counts, ns."""
        return round(1e9 * self.settle_s)

    @property
    def counted_s(self) -> float:
        """Length of the part whose answers count, s."""
        return self.rest_s + self.moving_s

    @property
    def updates(self) -> int:
        """Number of readings of the IMU."""
        return round((self.settle_s + self.counted_s) * self.rate)

    @property
    def rate(self) -> float:
        """Readings of the gyro a second."""
        return float(self.parameter("imu_rate"))

    def free(self) -> Course:
        """The motion of the course without a rest: that of a free body from the first stamp on."""
        return replace(self, rest_s=0.0, settle_s=0.0, ramp_s=0.0)

    def of_scenario(self, **parameters: object) -> Course:
        """The course with some parameters of its scenario changed."""
        return replace(self, scenario=Scenario.from_parameters({**self.scenario.parameters(), **parameters}))

    def nearly_perfect(self) -> Course:
        """The course with sensor errors so small that a stable filter has no larger error."""
        sizes = {"gyro": 1.0, "specific_force": self.parameter("gravity"), "field": float(np.linalg.norm(self.field))}
        return replace(self, off=tuple((name, (TINY * self.turn * size,) * 3) for name, size in sizes.items()))

    def parameter(self, name: str) -> Any:
        """A parameter of the scenario."""
        return self.scenario.value(name)

    def in_body(self, attitude_xyzw: Array, vector: Array) -> Array:
        """A vector of the world on the axes of the body at some attitudes, shape (N, 3)."""
        if not self.is_rounded:
            return quaternion.rotate(quaternion.conjugate(attitude_xyzw), vector)
        return vector @ np.rint(quaternion.to_matrix(attitude_xyzw)) + 0.0  # which makes -0.0 a zero

    def specific_force(self, stamps_ns: Integers) -> Array:
        """Specific force on the axes of the body, m/s², shape (N, 3)."""
        attitude, rate = self.states(stamps_ns)
        weight = self.in_body(attitude, self.parameter("gravity") * UP)
        if not self.is_carried:
            return weight
        passed, pace, change = _own_time(stamps_ns / 1e9 - self.settle_s - self.rest_s, self.ramp_s)
        sway = harmonics(0, NoiseSource.SWAY, SWAY, SWAY_BAND).at(np.round(passed * 1e9).astype(np.int64))
        acceleration = sway.acceleration * pace[:, np.newaxis] ** 2 + sway.velocity * change[:, np.newaxis]
        earlier, later = (self.states(stamps_ns + step)[1] for step in (-NS // 2000, NS // 2000))
        of_rotation = np.cross(1000.0 * (later - earlier), LEVER_ARM) + np.cross(rate, np.cross(rate, LEVER_ARM))
        return weight + of_rotation + self.in_body(attitude, acceleration)

    @property
    def field(self) -> Array:
        """Magnetic field in the world, T, shape (3,)."""
        return np.array(self.parameter("magnetic_field"))

    @property
    def turn(self) -> float:
        """Mean turn between two readings of the gyro while the body moves, rad."""
        times = (self.settle_s + self.rest_s + np.linspace(0.0, self.moving_s, 500)) * 1e9
        return float(np.mean(norm(self.states(times.astype(np.int64))[1])) / self.rate)


@dataclass(frozen=True)
class Headings(Course):
    """A body that is turned about the vertical from one of eight headings to the next, and held at each."""

    moving_s: float = 8.0 * (TURN + HOLD)

    def states(self, stamps_ns: Integers) -> tuple[Array, Array]:
        """Attitudes, shape (..., 4), and body rates, rad/s, shape (..., 3)."""
        since = np.asarray(stamps_ns) / 1e9 - self.settle_s - self.rest_s
        place = np.maximum(since, 0.0) / (TURN + HOLD)
        whole, u = np.floor(place), np.minimum((place % 1.0) * (TURN + HOLD) / TURN, 1.0)
        angle = 0.25 * np.pi * (whole + u * u * (3.0 - 2.0 * u))
        start = self.scenario.start().attitude_xyzw
        rate = 0.25 * np.pi * 6.0 * u * (1.0 - u) / TURN
        attitude = quaternion.multiply(quaternion.exp(angle[..., np.newaxis] * UP), start)
        return attitude, rate[..., np.newaxis] * quaternion.rotate(quaternion.conjugate(start), UP)


@lru_cache(maxsize=128)  # fits ask again and again at the same stamps
def _states(scenario: Scenario, rest_s: float, ramp_s: float, stamps_ns: bytes) -> tuple[Array, Array]:
    since = np.frombuffer(stamps_ns, dtype=np.int64) / 1e9 - rest_s
    motion = scenario.exact_motion()
    if not ramp_s:
        states = motion.at(np.round(since * 1e9).astype(np.int64))
        return states.attitude_xyzw, states.body_rate
    passed, speed, _ = _own_time(since, ramp_s)
    times, place = np.unique(np.round(passed * 1e9).astype(np.int64), return_inverse=True)  # a rest is one time
    states = motion.at(times)[place]
    return states.attitude_xyzw, states.body_rate * speed[:, np.newaxis]


def _own_time(since_s: Array, ramp_s: float) -> tuple[Array, Array, Array]:
    """Time on the path of the free motion at times since it begins, s, and its first two derivatives."""
    if not ramp_s:
        return since_s, np.ones_like(since_s), np.zeros_like(since_s)
    u = np.clip(since_s / ramp_s, 0.0, 1.0)
    passed = ramp_s * u**3 * (1.0 - 0.5 * u) + np.maximum(since_s - ramp_s, 0.0)
    return passed, u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / ramp_s


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings of a course, with `MARGIN` extra ones before and after those that a filter is given.

    Attributes
    ----------
    course : Course
    t_ns, field_t_ns : ndarray of int64
        Stamps of the IMU and of the magnetometer, ns.
    vectors : mapping of str to ndarray
        ``gyro``, ``specific_force`` and ``field``, a row for each stamp.
    """

    course: Course
    t_ns: Integers
    field_t_ns: Integers
    vectors: Mapping[str, Array]

    def changed(self, change: Callable[[Array], Array], *names: str) -> Readings:
        """The readings, with some vectors changed."""
        return replace(self, vectors={**self.vectors, **{name: change(self.vectors[name]) for name in names}})

    def run(self) -> BlindRun:
        """Run that a filter is given: the readings without the margin and the gaps."""
        imu = self._given(self.t_ns)
        magnetometer = self._given(self.field_t_ns)
        vectors = {name: array[magnetometer if name == "field" else imu] for name, array in self.vectors.items()}
        return BlindRun.of_readings(self.course.scenario, self.t_ns[imu], vectors, self.field_t_ns[magnetometer])

    def _given(self, stamps_ns: Integers) -> Booleans:
        seconds = (stamps_ns - self.course.begin_ns) / 1e9
        lost = [(seconds >= gap_s) & (seconds < gap_s + 1.0) for gap_s in self.course.gaps_s]
        return (stamps_ns >= 0) & (seconds < self.course.counted_s) & ~np.any(lost, axis=0)


@lru_cache(maxsize=16)
def readings(course: Course) -> Readings:
    """Readings of the sensors in a course, with the margin."""
    draw = np.random.default_rng(course.seed)
    t_ns, field_t_ns = (_stamps(course, course.parameter(name)) for name in ("imu_rate", "magnetometer_rate"))
    attitude, rate = course.states(t_ns)
    if course.parameter("gyro_rate") == "integrated":
        before = np.concatenate([[2 * t_ns[0] - t_ns[1]], t_ns[:-1]])
        rate = relative_rotations(course.at(before), attitude) / ((t_ns - before) / 1e9)[:, np.newaxis]
    read = {
        "gyro": rate,
        "specific_force": course.specific_force(t_ns),
        "field": course.in_body(course.at(field_t_ns), course.field),
    }
    for (name, vectors), (density, its_rate) in zip(read.items(), NOISE.items(), strict=True):
        deviation = course.parameter(density) * course.parameter(its_rate) ** 0.5
        read[name] = vectors + deviation * draw.standard_normal(vectors.shape) + dict(course.off).get(name, 0.0)
    return Readings(course, t_ns, field_t_ns, read)


def _stamps(course: Course, rate: float) -> Integers:
    """Stamps with a margin before and after; the first that a filter is given is 0."""
    numbers = np.arange(-MARGIN, np.ceil((course.settle_s + course.counted_s) * rate) + MARGIN)
    walk = np.cumsum(1.0 + np.random.default_rng(0).uniform(-1.0, 1.0, len(numbers)) / 3.0)
    grids: dict[str, Array] = {
        "even": numbers,
        "alternating": numbers - (numbers % 2) / 3.0,
        "walk": walk - walk[MARGIN],
    }
    return np.round(grids[course.grid] * (1e9 / rate)).astype(np.int64)


def courses_of(given: Given, said: Collection[str] = ()) -> tuple[Course, ...]:
    """The ordinary courses, with an integrated gyro.

    Parameters
    ----------
    given : mapping of str to object
        Parameters of a scenario. Those of a motion choose another one than the two of this module.
    said : collection of str, optional
        Names of those that were given one by one, of which none may be without effect.

    Raises
    ------
    InputError
        If they give a body that turns no more than `MIN_STEP_TURN` between two readings of a sensor, or one by one
        what a course sets itself, as errors of sensors.
    """
    kept = {name: value for name, value in read_parameters(given).items() if name in _TAKEN & given.keys()}
    odd = [name for name in said if name not in _TAKEN]
    if odd:
        raise InputError(
            f"{', '.join(odd)}: diagnose sets the rest itself, with sensors without errors: give only "
            f"{', '.join(sorted(_TAKEN))}"
        )
    rates = {name: kept.get(name, RATE) for name in ("imu_rate", "magnetometer_rate")}
    if not all(rates.values()):
        raise InputError(
            f"{', '.join(name for name in rates if not rates[name])}: 0: give rates above 0, or leave it out"
        )
    motions = [kept] if COURSE_MOTIONS[0].keys() & kept else [{**motion, **kept} for motion in COURSE_MOTIONS]
    courses = tuple(Course(Scenario.from_parameters({**motion, **_OWN, **rates})) for motion in motions)
    fastest = max(rates, key=courses[0].parameter)
    share = courses[0].parameter("imu_rate") / courses[0].parameter(fastest)
    if not min(course.turn for course in courses) * share > MIN_STEP_TURN:
        raise InputError(
            f"initial_body_rate, {fastest}: the body turns by {MIN_STEP_TURN:g} rad or less between two readings, "
            "which tells nothing of a filter: let it turn faster, or read it less often"
        )
    return courses


def noise_of(given: Given) -> dict[str, float] | None:
    """Densities of the noise that parameters give, by a grade of sensors or one by one; None where they give none.

    Raises
    ------
    InputError
        If there is no such grade, or a density is none.
    """
    said = {name: given[name] for name in (*NOISE, "sensor_grade") if name in given}
    if not said:
        return None
    read = read_parameters(said)
    return {name: cast("float", read[name]) for name in NOISE}
