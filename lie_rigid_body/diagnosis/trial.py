"""Trials: a body that rests and then turns, what perfect sensors read of it, and one thing in the way at most.

A trial begins at rest, longer than any shift in time that is tried, so that a late reading is the right one there. Then
the body gathers speed within `RAMP` along the path of its free motion, so that a gyro has no jump, and goes on freely.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.attitudes import sizes, turns
from lie_rigid_body.evaluation.truth import Truth
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs.blind import BlindRun
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import BY_NAME, read_parameters
from lie_rigid_body.wording import listed

Vector = tuple[float, float, float]

INTEGRATED: Final = "integrated"
INSTANTANEOUS: Final = "instantaneous"
KINDS: Final = (INTEGRATED, INSTANTANEOUS)
"""Kinds of gyro: the parameter ``gyro_rate``."""

REST: Final = 1.0
"""Time at rest before the motion, s."""
RAMP: Final = 0.5
"""Time in which the motion gathers speed, s."""
MOVING: Final = 12.0
"""Length of the motion of an ordinary trial, s."""
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
SLOW: Final = 0.05
"""Factor of the rates in a slow motion."""
SMALLEST_TURN: Final = 1e-6
"""Turn between two readings, rad, below which a motion tells nothing."""
_OF_A_MOTION: Final = frozenset(("inertia", "initial_attitude_xyzw", "initial_body_rate"))
_TAKEN: Final = _OF_A_MOTION | {"imu_rate", "magnetometer_rate", "gravity", "magnetic_field"}
"""Parameters of a given scenario that make a trial."""
_OWN: Final = frozenset(
    ("rate", "motion", "method", "max_step", "world_frame", "body_frame", "imu_frame", "stamped_twist", "epoch_ns")
) | {"sensor_seed", "sensor_grade", "gyro_rate", "accelerometer_mode"}
"""Parameters of a given scenario that change no trial."""

EVEN: Final = "even"
ALTERNATING: Final = "alternating"
WALK: Final = "walk"


@dataclass(frozen=True)
class SensorErrors:
    """Errors of the sensors in a trial.

    Attributes
    ----------
    gyro, specific_force, field : tuple of float
        Constant errors in the units of the readings, rad/s, m/s² and T.
    noise : tuple of float
        Standard deviations of white noise of the three sensors in these units.
    seed : int
        Number from which the noise follows.
    """

    gyro: Vector = (0.0, 0.0, 0.0)
    specific_force: Vector = (0.0, 0.0, 0.0)
    field: Vector = (0.0, 0.0, 0.0)
    noise: Vector = (0.0, 0.0, 0.0)
    seed: int = 0


@dataclass(frozen=True)
class Trial:
    """One run of a filter to be.

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
    errors : SensorErrors
    """

    scenario: Scenario
    moving_s: float = MOVING
    rest_s: float = REST
    grid: str = EVEN
    gaps_s: tuple[float, ...] = ()
    errors: SensorErrors = field(default_factory=SensorErrors)

    def of_kind(self, kind: str) -> Trial:
        """The trial with a kind of gyro."""
        return self.with_parameters(gyro_rate=kind)

    def with_parameters(self, **parameters: object) -> Trial:
        """The trial with some parameters of its scenario changed."""
        return replace(self, scenario=Scenario.from_parameters({**self.scenario.parameters(), **parameters}))

    @property
    def turn(self) -> float:
        """Mean turn between two readings of the gyro while the body moves, rad."""
        truth = PathTruth(self.scenario, 0.0)
        rates = truth.states(np.linspace(0, self.moving_s * 1e9, 500).astype(np.int64))[1]
        return float(np.mean(sizes(rates))) * self.step_s

    @property
    def step_s(self) -> float:
        """Time between two readings of the IMU, s."""
        return 1.0 / float(str(self.scenario.parameters()["imu_rate"]))

    def readings(self) -> TrialReadings:
        """What the sensors read."""
        return _readings(self)


class PathTruth(Truth):
    """The attitude of a trial at any time, and the body's rate.

    Parameters
    ----------
    scenario : Scenario
    rest_s : float
        Time at rest, s; then the body gathers speed.
    """

    def __init__(self, scenario: Scenario, rest_s: float) -> None:
        self.first_ns, self.last_ns = -(2**62), 2**62
        self._motion, self._rest_s = scenario.exact_motion(), rest_s

    def _on_path(self, stamps_ns: Integers) -> tuple[Integers, Array]:
        """Time on the path of the free motion, ns, and how fast it passes."""
        since = stamps_ns / 1e9 - self._rest_s
        u = np.clip(since / RAMP, 0.0, 1.0)
        passed = RAMP * u**3 * (1.0 - 0.5 * u) + np.maximum(since - RAMP, 0.0)
        return np.round(passed * 1e9).astype(np.int64), u * u * (3.0 - 2.0 * u)

    def at(self, stamps_ns: Integers) -> Array:
        """Attitudes world-from-body, shape (..., 4)."""
        return self.states(stamps_ns)[0]

    def states(self, stamps_ns: Integers) -> tuple[Array, Array]:
        """Attitudes, shape (..., 4), and body rates, rad/s, shape (..., 3)."""
        times, speed = self._on_path(np.asarray(stamps_ns))
        states = self._motion.at(times.ravel())
        rate = states.body_rate.reshape(*times.shape, 3)
        return states.attitude_xyzw.reshape(*times.shape, 4), rate * speed[..., np.newaxis]


@dataclass(frozen=True, eq=False)
class TrialReadings:
    """Readings of a trial with `MARGIN` more before and after those that a filter is given.

    Attributes
    ----------
    trial : Trial
    t_ns, field_t_ns : ndarray of int64
        Stamps of the IMU and of the magnetometer, ns; the latter is empty without one.
    vectors : mapping of str to ndarray
        ``gyro``, ``specific_force`` and ``field``, of as many rows.
    """

    trial: Trial
    t_ns: Integers
    field_t_ns: Integers
    vectors: Mapping[str, Array]

    @cached_property
    def truth(self) -> Truth:
        """The true attitude."""
        return PathTruth(self.trial.scenario, self.trial.rest_s)

    def changed(self, **vectors: Array) -> TrialReadings:
        """The readings of some sensors exchanged."""
        return replace(self, vectors={**self.vectors, **vectors})

    def run(self) -> BlindRun:
        """What a filter is given."""
        imu, magnetometer = self._given(self.t_ns), self._given(self.field_t_ns)
        vectors = {name: array[magnetometer if name == "field" else imu] for name, array in self.vectors.items()}
        field_t_ns = self.field_t_ns[magnetometer] if len(self.field_t_ns) else None
        return BlindRun.of_readings(self.trial.scenario, self.t_ns[imu], vectors, field_t_ns)

    def _given(self, stamps_ns: Integers) -> Booleans:
        inside = (stamps_ns >= 0) & (stamps_ns < round((self.trial.rest_s + self.trial.moving_s) * 1e9))
        for gap_s in self.trial.gaps_s:
            inside &= (stamps_ns < round(gap_s * 1e9)) | (stamps_ns >= round((gap_s + 1.0) * 1e9))
        return np.asarray(inside)


@lru_cache(maxsize=16)
def _readings(trial: Trial) -> TrialReadings:
    parameters = trial.scenario.parameters()
    truth = PathTruth(trial.scenario, trial.rest_s)
    t_ns = _stamps(trial, float(str(parameters["imu_rate"])))
    attitude, rate = truth.states(t_ns)
    if parameters["gyro_rate"] == INTEGRATED:
        before = np.concatenate([[2 * t_ns[0] - t_ns[1]], t_ns[:-1]])
        steps_s = (t_ns - before) / 1e9
        rate = turns(truth.at(before), attitude) / steps_s[:, np.newaxis]
    magnetometer_rate = float(str(parameters.get("magnetometer_rate", 0.0)))
    field_t_ns = _stamps(trial, magnetometer_rate) if magnetometer_rate else np.empty(0, dtype=np.int64)
    up = np.array([0.0, 0.0, float(str(parameters["gravity"]))])
    exact = {
        "gyro": rate,
        "specific_force": quaternion.rotate(quaternion.conjugate(attitude), up),
        "field": quaternion.rotate(quaternion.conjugate(truth.at(field_t_ns)), parameters["magnetic_field"]),
    }
    errors, draw = trial.errors, np.random.default_rng(trial.errors.seed)
    read = {
        name: exact[name] + getattr(errors, name) + deviation * draw.standard_normal(exact[name].shape)
        for name, deviation in zip(exact, errors.noise, strict=True)
    }
    return TrialReadings(trial, t_ns, field_t_ns, read)


def _stamps(trial: Trial, rate: float) -> Integers:
    """Stamps with a margin before and after; the first that a filter is given is 0."""
    count = int(np.ceil((trial.rest_s + trial.moving_s) * rate)) + MARGIN
    numbers = np.arange(-MARGIN, count)
    if trial.grid == EVEN:
        steps = numbers.astype(np.float64)
    elif trial.grid == ALTERNATING:
        steps = numbers - (numbers % 2) / 3.0
    else:
        steps = np.cumsum(1.0 + np.random.default_rng(0).uniform(-1.0, 1.0, len(numbers)) / 3.0)
        steps -= steps[MARGIN]
    return np.round(steps * (1e9 / rate)).astype(np.int64)


def trials_of(given: Mapping[str, object]) -> tuple[Trial, ...]:
    """The ordinary trials, with an integrated gyro.

    Parameters
    ----------
    given : mapping of str to object
        Parameters of a scenario. Those of a motion choose another one than the two of this module.

    Raises
    ------
    InputError
        If they give sensors errors, or a body that does not turn.
    """
    values = read_parameters(given)
    odd = [name for name in given if name not in _TAKEN | _OWN and values[name] != BY_NAME[name].default]
    if odd:
        raise InputError(
            f"{listed(odd)}: mistakes are looked for with an IMU and a magnetometer without errors: give only the "
            "motion, the rates and the fields"
        )
    kept: dict[str, object] = {name: values[name] for name in given if name in _TAKEN}
    motions = [kept] if _OF_A_MOTION & kept.keys() else [{**motion, **kept} for motion in MOTIONS]
    trials = tuple(Trial(_perfect(motion)) for motion in motions)
    if not min(trial.turn for trial in trials) > SMALLEST_TURN:
        raise InputError("initial_body_rate: the body does not turn, which tells nothing of a filter: let it turn")
    return trials


def _perfect(motion: Mapping[str, object]) -> Scenario:
    given = dict(motion)
    for name in ("imu_rate", "magnetometer_rate"):
        given[name] = given.get(name) or RATE
    return Scenario.from_parameters(
        {**given, "motion": "closed_form", "gyro_rate": INTEGRATED, "accelerometer_mode": "pivot_gravity"}
    )
