"""The definition of a run: everything that determines its samples, frozen, and validated once."""

from __future__ import annotations

import copy
import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Context
from functools import partial, wraps
from typing import Final, TypeVar, cast

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Booleans, Integers, plain
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.parameters import NS, Given, Value, Vector, require_frame_name
from lie_rigid_body.foundation.wording import call_repr, numerals, shown
from lie_rigid_body.lie.vectors import norm
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion import METHODS, ClosedForm, Motion, MovingChart
from lie_rigid_body.motion.closed_form.kicked import KickedClosedForm
from lie_rigid_body.motion.harmonics import Harmonics
from lie_rigid_body.motion.kicked_steps import KickedSteps
from lie_rigid_body.motion.kicks import Kicks
from lie_rigid_body.motion.path import Knots, PathTranslation, PosePath
from lie_rigid_body.motion.time_steps import MAX_STEPS, steps_between
from lie_rigid_body.motion.translation import Fall, Sway, Translation, UniformAndMore, ramp_s
from lie_rigid_body.scenario.parameter_table import BY_NAME, OWN, read_parameters
from lie_rigid_body.sensors import GRADE, SENSORS, Sensors, frame_parameters, without_effect
from lie_rigid_body.sensors.noise import NoiseSource, harmonics
from lie_rigid_body.sensors.parameters import require_band
from lie_rigid_body.sensors.sensor import Carrier

MAX_ROTATION_PER_STEP: Final = 1.0
"""Largest rotation angle of a Runge–Kutta step, rad: the Taylor expansion of a larger step means nothing. The
Moser–Veselov steppers limit their steps themselves."""

MIN_STEP: Final = 1e-9
"""Smallest step that a refusal advises, s."""

MAX_KICKS_PER_SAMPLE: Final = 100_000
"""Largest mean number of kicks from one sample to the next: they take minutes."""
_STEPS_OF_A_KICK: Final = 64
"""Number of steps of the moving chart that take as long as a kick, about 1 ms."""
_OF_MECHANICS: Final = (
    "inertia",
    "initial_attitude_xyzw",
    "initial_body_rate",
    "kicks",
    "kick_period",
    "translation",
    "initial_position",
    "initial_velocity",
)
"""Parameters that a path takes the place of."""
_OF_THE_MOTION: Final = tuple(parameter.name for parameter in OWN if parameter.scope == "scenario")

_Result = TypeVar("_Result")


def _computed_once(method: Callable[[Scenario], _Result]) -> Callable[[Scenario], _Result]:
    """A method that computes at its first call, and keeps, what a frozen scenario determines."""
    key = f"_{method.__name__}"

    @wraps(method)
    def kept(self: Scenario) -> _Result:
        if key not in vars(self):
            object.__setattr__(self, key, method(self))
        return cast(_Result, vars(self)[key])

    return kept


@dataclass(frozen=True, init=False)
class Scenario:
    """A body, its start and the way it is sampled, validated as a whole.

    Attributes carry the names, types and units of the parameters (see ``PARAMETERS``); those of the sensors are kept
    together, and as the models that they make.

    Parameters
    ----------
    **parameters
        Parameters by their public names; the rest are at their defaults.

    Raises
    ------
    ParameterError
        Naming the parameter, its value, its limit and the remedy.
    """

    inertia: Vector
    initial_attitude_xyzw: Vector
    initial_body_rate: Vector
    rate: float
    motion: str
    method: str
    max_step: float
    kicks: Vector
    kick_period: float
    translation: str
    initial_position: Vector
    initial_velocity: Vector
    sway_acceleration: Vector
    sway_band: Vector
    sway_seed: int
    path_file: str
    path_interval: float
    path_knots: Vector
    world_frame: str
    body_frame: str
    stamped_twist: bool
    epoch_ns: int
    sensors: Sensors
    sensor_parameters: tuple[tuple[str, Value], ...]

    def __init__(self, /, **parameters: object) -> None:
        values = read_parameters({name: plain(value) for name, value in parameters.items()})
        of_sensors = {name: values[name] for name in SENSORS.parameters}
        of_motion = {name: values[name] for name in _OF_THE_MOTION}
        sensors = Sensors.from_values(of_sensors)
        vars(self).update(of_motion, sensors=sensors, sensor_parameters=tuple(of_sensors.items()))
        self._validate()

    @classmethod
    def from_parameters(cls, given: Given | None = None) -> Scenario:
        """Make the scenario of a mapping of parameters, with values as a YAML file or a ROS parameter gives them.

        Raises
        ------
        InputError
            If they are no mapping, or `Scenario` refuses one.
        """
        if not isinstance(given, Mapping | None):
            raise InputError(f"parameters {shown(given)} are no mapping: give for example {{'rate': 100.0}}")
        return cls(**{str(name): value for name, value in (given or {}).items()})

    def resampled(self, **values: object) -> Scenario:
        """Sample the same motion and sensors at another ``rate``, Hz, or from another stamp, ``epoch_ns``, ns.

        Each is read as the parameter of its name; whether the motion can take the steps is not validated.
        """
        new = copy.copy(self)
        for name, value in values.items():
            object.__setattr__(new, name, BY_NAME[name].read(plain(value)))
        return new

    def __repr__(self) -> str:
        """The call that makes it: the parameters that are not at their defaults, which may be shortened."""
        given = {name: value for name, value in self.parameters().items() if value != BY_NAME[name].default}
        return call_repr(self, {k: list(v) if isinstance(v, tuple) else v for k, v in given.items()})

    def parameters(self) -> dict[str, Value]:
        """Names and values of the parameters, in the order of the table.

        They are those of the motion, those of each sensor that is on and of all sensors, and of others what is not at
        its default. The gravity is one of the motion where the body is thrown.
        """
        off = self.sensors.off_parameters if self.has_sensors else set(SENSORS.parameters)
        of_sensors = {
            name: value
            for name, value in self.sensor_parameters
            if name not in off or value != SENSORS.parameters[name].default
        }
        of_fall = {"gravity": self.value("gravity")} if self.translation == "thrown" else {}
        return {**{name: getattr(self, name) for name in _OF_THE_MOTION}, **of_fall, **of_sensors}

    def value(self, parameter: str) -> Value:
        """Value of a parameter, of a sensor that is off as well."""
        of_sensors = dict(self.sensor_parameters)
        return of_sensors[parameter] if parameter in of_sensors else cast(Value, getattr(self, parameter))

    @property
    def has_sensors(self) -> bool:
        """Whether any sensor is on."""
        return bool(self.sensors.on)

    @property
    def without_effect(self) -> list[str]:
        """Sentences, without their full stops, about parameters of what is off."""
        unused = {
            "there are no kicks": (not self.kicks, ("kick_period",)),
            "translation is not carried": (
                self.translation != "carried",
                ("sway_acceleration", "sway_band", "sway_seed"),
            ),
            "translation is none": (self.translation == "none", ("initial_velocity",)),
            "motion is not path": (self.motion != "path", ("path_file", "path_interval", "path_knots")),
        }
        return [
            *(
                f"{name} has no effect, as {why}: give what switches it on"
                for why, (is_unused, names) in unused.items()
                for name in names
                if is_unused and getattr(self, name) != BY_NAME[name].default
            ),
            *without_effect(self._used_sensor_parameters()),
        ]

    def _used_sensor_parameters(self) -> Given:
        """Values of the parameters of sensors; the gravity at its default where a thrown body uses it."""
        values = dict(self.sensor_parameters)
        if self.translation == "thrown":
            values["gravity"] = SENSORS.parameters["gravity"].default
        return values

    @property
    def sensor_grade(self) -> str:
        """The grade of the sensors, whose errors single parameters may override."""
        return str(self.value(GRADE))

    @_computed_once
    def body(self) -> RigidBody:
        """The body of this scenario."""
        return RigidBody(self.inertia)

    @_computed_once
    def start(self) -> State:
        """State at the start: attitude and body rate."""
        if path := self.path():
            return path.at(0)
        try:
            return State(self.initial_attitude_xyzw, self.initial_body_rate)
        except ParameterError as error:
            raise ParameterError(f"initial_{error.name}", error.message) from None

    @_computed_once
    def kick_schedule(self) -> Kicks:
        """The kicks, by their times in ns."""
        return Kicks.of(self.kicks, self.kick_period)

    @_computed_once
    def path(self) -> PosePath | None:
        """The path that is followed; None of a motion by the laws of mechanics."""
        return PosePath(Knots.of(self.path_knots)) if self.motion == "path" else None

    @_computed_once
    def exact_motion(self) -> Motion:
        """The exact solution from the start, at times before it as well, whatever the motion that is asked for.

        Of a path it is the rotation along it.
        """
        if path := self.path():
            return path
        if self.kicks:
            return KickedClosedForm(self.kick_schedule(), self.body(), self.start())
        return ClosedForm(self.body(), self.start())

    def make_motion(self) -> Motion:
        """A new motion from the start."""
        return copy.copy(self._moving_chart() if self.motion == "moving_chart" else self.exact_motion())

    @_computed_once
    def _moving_chart(self) -> Motion:
        free = partial(MovingChart, self.body(), method=self.method, max_step=self.max_step)
        return KickedSteps(self.kick_schedule(), self.start(), free) if self.kicks else free(self.start())

    @_computed_once
    def sway(self) -> Harmonics | None:
        """Acceleration of the carried mass centre; None where it is not carried, or does not sway."""
        if self.translation != "carried" or not any(self.sway_acceleration):
            return None
        return harmonics(self.sway_seed, NoiseSource.SWAY, self.sway_acceleration, self.sway_band)

    @property
    def moves(self) -> bool:
        """Whether the mass centre moves."""
        return self.translation != "none" or self.motion == "path"

    @_computed_once
    def mass_centre(self) -> Translation:
        """Motion of the mass centre."""
        if path := self.path():
            return PathTranslation(path)
        if sway := self.sway():
            moves_first = any(self.initial_body_rate)
            further: Translation = Sway(sway, self.kick_schedule(), moves_first, ramp_s(self.sway_band))
        else:
            further = Fall(cast(float, self.value("gravity")) if self.translation == "thrown" else 0.0)
        return UniformAndMore(self.initial_position, self.initial_velocity if self.moves else (0.0, 0.0, 0.0), further)

    def carrier(self) -> Carrier:
        """Carrier of the sensors: the body, and its acceleration."""
        path = self.path()
        acceleration = self._acceleration if path or self.sway() else None
        turning = path.angular_acceleration if path else None
        return Carrier(self.body(), acceleration, turning, falls=self.translation == "thrown")

    def _acceleration(self, t_ns: Integers) -> Array:
        return self.mass_centre().at(t_ns).acceleration

    def __getstate__(self) -> dict[str, object]:
        """The fields alone: a copy computes the rest anew."""
        return {name: value for name, value in vars(self).items() if name in self.__dataclass_fields__}

    @_computed_once
    def rate_bound(self) -> float:
        """Bound Ω of the body rate along the motion, rad/s, from ½ I₁|ω|² ≤ H and I₁|ω| ≤ |L|, whichever is tighter.

        Of a path it is that of its pieces.
        """
        if path := self.path():
            return path.rate_bound
        with np.errstate(over="ignore"):
            return float(_rate_bounds(self.body(), self.arc_starts()).max())

    def arc_starts(self) -> State:
        """States of K + 1 instants: the start, and the rates after K kicks, all at the attitude of the start."""
        rates = np.concatenate([[self.initial_body_rate], self.kick_schedule().body_rate])
        return State.trusted(np.tile(self.start().attitude_xyzw, (len(rates), 1)), rates)

    @property
    def rates(self) -> list[float]:
        """Rates of the truth and of the sensors, samples per second."""
        return [self.rate, *(sensor.rate for sensor in self.sensors.on.values())]

    def steps_per_sample(self, rate: float | None = None) -> int:
        """Steps of the moving chart from one sample to the next; 1 of other motions.

        Parameters
        ----------
        rate : float, optional
            Samples per second, by default those of the truth.
        """
        if self.motion != "moving_chart":
            return 1
        return steps_between(1.0 / (rate or self.rate), self.longest_step)

    def batch_size(self, at_most: int, steps: int, rate: float | None = None) -> int:
        """Number of samples to compute at once, at least 1.

        Parameters
        ----------
        at_most : int
            The most samples.
        steps : int
            The most steps of the moving chart, if one sample does not take more. A kick counts as some.
        rate : float, optional
            Samples per second, by default those of the truth or of the fastest sensor.
        """
        rate = rate or max(self.rates)
        of_kicks = int(_STEPS_OF_A_KICK * self.kick_schedule().per_second / rate)
        return max(1, min(at_most, steps // (self.steps_per_sample(rate) + of_kicks)))

    @property
    def longest_step(self) -> float:
        """Longest step of the moving chart, s; infinite for a body at rest, whose step is the interval."""
        return METHODS[self.method].longest_step(self.max_step, self.rate_bound())

    @property
    def last_ns(self) -> int:
        """Time at which the motion ends, ns since the start: of the last pose of a path, else beyond all times."""
        path = self.path()
        return path.last_ns if path else 2**64 - 1

    def require_until(self, last_ns: int) -> None:
        """Refuse a time, ns since the start, at which the motion has ended.

        Raises
        ------
        ParameterError
        """
        if last_ns > self.last_ns:
            raise ParameterError(
                "duration",
                f"{(last_ns + 1) / NS:.15g} s is longer than the path, which ends {self.last_ns / NS:.15g} s after its "
                "first pose: give that time at most",
            )

    def _validate(self) -> None:
        for name in ("world_frame", "body_frame"):
            require_frame_name(name, getattr(self, name))
        self._require_distinct_frames()
        require_band("sway_band", self.sway_band)
        with np.errstate(all="ignore"):  # what goes wrong is said below
            body = self.body()
            self._require_path_alone()
            self.start()
            _require_normal(body, self.arc_starts())
        kicks = self.kick_schedule().per_second / min(self.rates)
        if kicks > MAX_KICKS_PER_SAMPLE:
            raise ParameterError(
                "kick_period",
                f"{self.kick_period:g} s makes {kicks:.3g} kicks between two samples, more than "
                f"{MAX_KICKS_PER_SAMPLE}: give a longer one, or higher rates",
            )
        fastest = self.rate_bound()
        if self.motion == "moving_chart":
            self._require_possible_steps(fastest)
        for model in self.sensors.on.values():
            if error := model.refusal(fastest):
                raise error

    def _require_distinct_frames(self) -> None:
        """Refuse a world that turns with the body: tf2 takes no frame that is its own parent."""
        of_sensors = frame_parameters() if self.has_sensors else ()
        for name in sorted({"body_frame", *of_sensors} - {"world_frame"}):
            if self.value(name) == self.world_frame:
                raise ParameterError(name, f"{shown(self.world_frame)} is the world_frame as well: give another name")

    def _require_path_alone(self) -> None:
        """Refuse a path without knots, and what a path determines itself."""
        if self.motion != "path":
            return
        for name in _OF_MECHANICS:
            value = getattr(self, name)
            if value != BY_NAME[name].default:
                told = shown(np.array(value).tolist())
                raise ParameterError(name, f"{told} is given beside motion path, which has its own: leave it out")
        if not self.path_knots:
            read = f"{shown(self.path_file)} is read by commands and by simulate: give path_knots here"
            raise ParameterError(
                "path_file", read if self.path_file else "motion path has no poses: give a file of them"
            )
        self.path()

    def _require_possible_steps(self, fastest: float) -> None:
        """Refuse steps of the moving chart that are too large for its method, or too many between two samples."""
        slowest = min(self.rates)
        step = min(self.longest_step, 1.0 / slowest)
        if fastest * step > MAX_ROTATION_PER_STEP:
            raise ParameterError(
                "max_step",
                f"{step:g} s lets the body turn by up to {fastest * step:.3g} rad in one step, more than "
                f"{MAX_ROTATION_PER_STEP:g}: {_shorter(MAX_ROTATION_PER_STEP / fastest)}use closed_form",
            )
        steps = self.steps_per_sample(slowest)
        if steps > MAX_STEPS:
            raise ParameterError(
                "max_step" if self.longest_step == self.max_step else "initial_body_rate",
                f"at up to {fastest:.3g} rad/s {self.method} takes {steps:.3g} steps of {step:.3g} s between samples, "
                f"more than {MAX_STEPS:g}: give longer steps, a lower body rate, or use closed_form",
            )


def _shorter(longest: float) -> str:
    """The remedy for too long a step, if there is one: rounded down, so that it is not refused itself."""
    step = float(Context(prec=3, rounding=ROUND_FLOOR).create_decimal_from_float(longest))
    return f"give at most {step:g} s, or " if step >= MIN_STEP else ""


def _rate_bounds(body: RigidBody, starts: State) -> Array:
    """Bounds of the body rate along the free motions from N states, rad/s, shape (N,)."""
    smallest = float(body.principal_moments[0])
    by_energy = np.sqrt(2.0 * body.kinetic_energy(starts) / smallest)
    by_momentum = norm(body.body_momentum(starts)) / smallest
    bounds = np.minimum(by_energy, by_momentum)
    lost = starts.body_rate.any(axis=1) & ~((bounds > 0.0) & np.isfinite(bounds))
    if lost.any():  # quotients overflow, or the energy underflows
        sizes = norm(starts.body_rate[lost])
        unit = State.trusted(starts.attitude_xyzw[lost], starts.body_rate[lost] / sizes[:, np.newaxis])
        bounds[lost] = sizes * np.sqrt(2.0 * body.kinetic_energy(unit)) / math.sqrt(smallest)
    return bounds


def _require_normal(body: RigidBody, starts: State) -> None:
    """Refuse what is out of the range of double precision; an energy may be so small that it is 0."""
    if not (_are_normal(body.principal_moments).all() and _are_normal(1.0 / body.principal_moments).all()):
        raise ParameterError(
            "inertia",
            f"principal moments {numerals(body.principal_moments)}, or their inverses, are beyond double precision: "
            "give moments between 1e-300 and 1e300 kg m²",
        )
    energies = body.kinetic_energy(starts)
    momenta = norm(body.body_momentum(starts))
    impossible = np.flatnonzero([~(_are_normal(values) | (values == 0.0)) for values in (energies, momenta)])
    if impossible.size:
        first = impossible.min() % len(energies)
        raise ParameterError(
            "kicks" if first else "initial_body_rate",
            f"{numerals(starts.body_rate[first])} rad/s gives an energy of {energies[first]:g} J and a momentum of "
            f"{momenta[first]:g} kg m²/s, beyond double precision: give an ordinary rate, or zeros",
        )


def _are_normal(values: Array) -> Booleans:
    """Which positive numbers are normal in double precision: finite, and not so small that they lose digits."""
    return np.isfinite(values) & (values >= sys.float_info.min)
