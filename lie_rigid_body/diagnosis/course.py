"""Courses: a body that rests and then turns, what perfect sensors read of it, and one thing in the way at most.

A course begins at rest, longer than any shift in time that is tried, so that a late reading is the right one there.
Then the body gathers speed within `RAMP` along the path of its free motion, so that a gyro has no jump, and goes on
freely.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final, Literal

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation import Truth
from lie_rigid_body.evaluation.attitudes import sizes, turns
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs.ensemble import BlindRun
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import BY_NAME, read_parameters
from lie_rigid_body.wording import listed

KINDS: Final = ("integrated", "instantaneous")
"""Kinds of gyro: values of the parameter ``gyro_rate``."""

REST: Final = 1.0
"""Time at rest before the motion, s."""
RAMP: Final = 0.5
"""Time in which the motion gathers speed, s."""
MOVING: Final = 12.0
"""Length of the motion of an ordinary course, s."""
MARGIN: Final = 64
"""Readings before the first and after the last that a filter is given, which a shift in time brings in."""

RATE: Final = 100.0
"""Readings a second, where a scenario tells no rate."""
MOTIONS: Final[tuple[dict[str, object], ...]] = (
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
"""Two motions that turn about every axis by a radian a second and more: `benchmarks/diagnosis.py` prints how far apart
they keep the repairs."""
TINY: Final = 1e-4
"""Error of the sensors where mistakes are looked for, rad/s and share of the vector, beside the turn between two
readings in rad. An unstable filter makes as much of it as of round-off, which no repair mends by chance."""
SMALLEST_TURN: Final = 1e-6
"""Turn between two readings, rad, below which a motion tells nothing."""
_OF_A_MOTION: Final = frozenset(("inertia", "initial_attitude_xyzw", "initial_body_rate"))
_TAKEN: Final = _OF_A_MOTION | {"imu_rate", "magnetometer_rate", "gravity", "magnetic_field"}
"""Parameters of a given scenario that make a course."""
_OWN: Final = frozenset(
    ("rate", "motion", "method", "max_step", "world_frame", "body_frame", "imu_frame", "stamped_twist", "epoch_ns")
) | {"sensor_seed", "sensor_grade", "gyro_rate", "accelerometer_mode"}
"""Parameters of a given scenario that change no course."""
_SET: Final = {"motion": "closed_form", "accelerometer_mode": "pivot_gravity"}
"""Parameters of every course."""

NOISE: Final = {
    "gyro_noise_density": "imu_rate",
    "accelerometer_noise_density": "imu_rate",
    "magnetometer_noise_density": "magnetometer_rate",
}
"""Parameters of the noise of the three sensors, and of their rates."""
Grid = Literal["even", "alternating", "walk"]


@dataclass(frozen=True)
class Course:
    """What a filter is to be run on.

    Attributes
    ----------
    scenario : Scenario
        The motion, the rates and the kind of the gyro.
    moving_s, rest_s : float
        Length of the motion and of the rest before it, s.
    grid : str
        How stamps follow each other: ``even``; ``alternating``, steps of 2/3 and 4/3 in turn; ``walk``, steps at random
        from 2/3 to 4/3.
    gaps_s : tuple of float
        Times at which readings are lost for a second, s.
    off : tuple of (str, tuple of float)
        Sensors, by the names of their readings, and their constant errors, rad/s, m/s² or T.
    seed : int
        Number from which the white noise follows whose densities the scenario tells.
    """

    scenario: Scenario
    moving_s: float = MOVING
    rest_s: float = REST
    grid: Grid = "even"
    gaps_s: tuple[float, ...] = ()
    off: tuple[tuple[str, tuple[float, ...]], ...] = ()
    seed: int = 0

    def of_scenario(self, **parameters: object) -> Course:
        """The course with some parameters of its scenario changed."""
        return replace(self, scenario=Scenario.from_parameters({**self.scenario.parameters(), **parameters}))

    def nearly_perfect(self) -> Course:
        """The course with sensors off by so little that a stable filter errs no more for it."""
        sizes = {"gyro": 1.0, "specific_force": self.number("gravity"), "field": float(np.linalg.norm(self.field))}
        return replace(self, off=tuple((name, (TINY * self.turn * size,) * 3) for name, size in sizes.items()))

    def number(self, name: str) -> float:
        """A parameter of the scenario that is a number."""
        return float(str(self.scenario.parameters()[name]))

    @property
    def kind(self) -> str:
        """Kind of the gyro."""
        return str(self.scenario.parameters()["gyro_rate"])

    @property
    def field(self) -> Array:
        """Magnetic field in the world, T, shape (3,)."""
        return np.array(self.scenario.parameters()["magnetic_field"], dtype=np.float64)

    @property
    def truth(self) -> PathTruth:
        """The true attitude."""
        return PathTruth(self.scenario, self.rest_s)

    @property
    def turn(self) -> float:
        """Mean turn between two readings of the gyro while the body moves, rad."""
        times = np.linspace(self.rest_s, self.rest_s + self.moving_s, 500) * 1e9
        return float(np.mean(sizes(self.truth.states(times.astype(np.int64))[1]))) / self.number("imu_rate")


@dataclass(frozen=True)
class PathTruth(Truth):
    """The attitude of a course at any time, and the body's rate.

    Attributes
    ----------
    scenario : Scenario
    rest_s : float
        Time at rest, s; then the body gathers speed.
    """

    scenario: Scenario
    rest_s: float
    first_ns, last_ns = -(2**62), 2**62

    def at(self, stamps_ns: Integers) -> Array:
        """Attitudes world-from-body, shape (..., 4)."""
        return self.states(stamps_ns)[0]

    def states(self, stamps_ns: Integers) -> tuple[Array, Array]:
        """Attitudes, shape (..., 4), and body rates, rad/s, shape (..., 3)."""
        stamps = np.asarray(stamps_ns, dtype=np.int64)
        attitude, rate = _states(self, stamps.tobytes())
        return attitude.reshape(*stamps.shape, 4), rate.reshape(*stamps.shape, 3)


_motion: Final = lru_cache(maxsize=16)(Scenario.exact_motion)


@lru_cache(maxsize=512)  # fits ask again and again at the same stamps
def _states(truth: PathTruth, stamps_ns: bytes) -> tuple[Array, Array]:
    since = np.frombuffer(stamps_ns, dtype=np.int64) / 1e9 - truth.rest_s
    u = np.clip(since / RAMP, 0.0, 1.0)
    passed = RAMP * u**3 * (1.0 - 0.5 * u) + np.maximum(since - RAMP, 0.0)  # time on the path of the free motion
    speed = u * u * (3.0 - 2.0 * u)
    states = _motion(truth.scenario).at(np.round(passed * 1e9).astype(np.int64))
    return states.attitude_xyzw, states.body_rate * speed[:, np.newaxis]


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings of a course with `MARGIN` more before and after those that a filter is given.

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

    def changed(self, **vectors: Array) -> Readings:
        """The readings of some sensors exchanged."""
        return replace(self, vectors={**self.vectors, **vectors})

    def run(self) -> BlindRun:
        """What a filter is given."""
        imu, magnetometer = self._given(self.t_ns), self._given(self.field_t_ns)
        vectors = {name: array[magnetometer if name == "field" else imu] for name, array in self.vectors.items()}
        return BlindRun.of_readings(self.course.scenario, self.t_ns[imu], vectors, self.field_t_ns[magnetometer])

    def _given(self, stamps_ns: Integers) -> Booleans:
        inside = (stamps_ns >= 0) & (stamps_ns < round((self.course.rest_s + self.course.moving_s) * 1e9))
        for gap_s in self.course.gaps_s:
            inside &= (stamps_ns < round(gap_s * 1e9)) | (stamps_ns >= round((gap_s + 1.0) * 1e9))
        return np.asarray(inside)


@lru_cache(maxsize=16)
def readings(course: Course) -> Readings:
    """What the sensors read in a course."""
    truth, draw = course.truth, np.random.default_rng(course.seed)
    t_ns, field_t_ns = (_stamps(course, course.number(name)) for name in ("imu_rate", "magnetometer_rate"))
    attitude, rate = truth.states(t_ns)
    if course.kind == "integrated":
        before = np.concatenate([[2 * t_ns[0] - t_ns[1]], t_ns[:-1]])
        rate = turns(truth.at(before), attitude) / ((t_ns - before) / 1e9)[:, np.newaxis]
    up = np.array([0.0, 0.0, course.number("gravity")])
    read = {
        "gyro": rate,
        "specific_force": quaternion.rotate(quaternion.conjugate(attitude), up),
        "field": quaternion.rotate(quaternion.conjugate(truth.at(field_t_ns)), course.field),
    }
    for (name, vectors), (density, its_rate) in zip(read.items(), NOISE.items(), strict=True):
        deviation = course.number(density) * course.number(its_rate) ** 0.5
        read[name] = vectors + deviation * draw.standard_normal(vectors.shape)
    for name, error in course.off:
        read[name] = read[name] + error
    return Readings(course, t_ns, field_t_ns, read)


def _stamps(course: Course, rate: float) -> Integers:
    """Stamps with a margin before and after; the first that a filter is given is 0."""
    numbers = np.arange(-MARGIN, int(np.ceil((course.rest_s + course.moving_s) * rate)) + MARGIN)
    steps = numbers.astype(np.float64)
    if course.grid == "alternating":
        steps -= (numbers % 2) / 3.0
    elif course.grid == "walk":
        steps = np.cumsum(1.0 + np.random.default_rng(0).uniform(-1.0, 1.0, len(numbers)) / 3.0)
        steps -= steps[MARGIN]
    return np.round(steps * (1e9 / rate)).astype(np.int64)


def courses_of(given: Mapping[str, object], said: Collection[str] = ()) -> tuple[Course, ...]:
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
        If they give sensors errors, a body that does not turn, or what a course sets itself.
    """
    values = read_parameters(given)
    odd = [
        name
        for name, value in given.items()
        if name not in _TAKEN
        and (_SET.get(name) != value if name in said else name not in _OWN and values[name] != BY_NAME[name].default)
    ]
    if odd:
        raise InputError(
            f"{listed(odd)}: diagnose sets the rest itself, with sensors without errors: give only "
            f"{', '.join(sorted(_TAKEN))}"
        )
    kept: dict[str, object] = {name: values[name] for name in given if name in _TAKEN}
    rates = {name: kept.get(name, RATE) for name in ("imu_rate", "magnetometer_rate")}
    if not all(rates.values()):
        raise InputError(
            f"{listed([name for name in rates if not rates[name]])}: 0: give rates above 0, or leave it out"
        )
    own = {**_SET, "gyro_rate": KINDS[0], **rates}
    motions = [kept] if _OF_A_MOTION & kept.keys() else [{**motion, **kept} for motion in MOTIONS]
    courses = tuple(Course(Scenario.from_parameters({**motion, **own})) for motion in motions)
    if not min(course.turn for course in courses) > SMALLEST_TURN:
        raise InputError("initial_body_rate: the body does not turn, which tells nothing of a filter: let it turn")
    return courses
