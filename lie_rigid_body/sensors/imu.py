"""The inertial measurement unit: a gyro and an accelerometer at one point of the body."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from decimal import ROUND_CEILING, Context
from typing import Final, cast

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.parameters import Parameter, Value, Vector, require_at_most, vector
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.fault import Faulty
from lie_rigid_body.sensors.gyro_rate import IntegratedRate
from lie_rigid_body.sensors.noise import NoiseSource
from lie_rigid_body.sensors.orientation import Orientation, OrientationModel
from lie_rigid_body.sensors.parameters import angle, not_negative, numbers, triad_fault_parameters, triad_parameters
from lie_rigid_body.sensors.sensor import (
    Carrier,
    Field,
    Instrument,
    Sensor,
    SensorModel,
    Topic,
    VectorAid,
    diagonal,
)
from lie_rigid_body.sensors.signal import Conditioning, Signal
from lie_rigid_body.sensors.specific_force import SpecificForce
from lie_rigid_body.sensors.triad import Triad, TriadModel
from lie_rigid_body.wording import short_repr

LONGEST_LEVER_ARM_M: Final = 1e6
"""Largest component of the lever arm, m."""
LARGEST_TURN_PER_READING: Final = 3.0
"""Largest turn between two readings of an integrated rate, rad: more than half a turn reads as one the other way."""


@dataclass(frozen=True)
class ImuModel(SensorModel):
    """The model of an IMU. Its frame has the body's axes, but for the misalignments, at the end of the lever arm.

    Parameters
    ----------
    rate, seed, delivery
        As of `SensorModel`.
    gyro_rate : str
        ``instantaneous``, or ``integrated`` over the interval that ends at each sample.
    gyro, accelerometer : TriadModel
    accelerometer_mode : str
        ``free_fall``, or ``pivot_gravity``: held at the mass centre.
    gravity : float
        Standard gravity, m/s².
    lever_arm : tuple of float, length 3
        From the mass centre to the accelerometer in the body frame, m.
    orientation : OrientationModel or None
        Orientation that it tells; None: it tells none.
    """

    gyro_rate: str
    gyro: TriadModel
    accelerometer: TriadModel
    accelerometer_mode: str
    gravity: float
    lever_arm: Vector
    orientation: OrientationModel | None = None

    __repr__ = short_repr

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> ImuModel:
        """Make the model of the parameters' values, and validate it.

        Raises
        ------
        ParameterError
        """
        lever_arm = vector(values, "accelerometer_lever_arm")
        require_at_most("accelerometer_lever_arm", lever_arm, LONGEST_LEVER_ARM_M, "m")
        return cls(
            rate=cast(float, values["imu_rate"]),
            seed=cast(int, values["sensor_seed"]),
            gyro_rate=cast(str, values["gyro_rate"]),
            gyro=TriadModel.from_values("gyro", values),
            accelerometer=TriadModel.from_values("accelerometer", values),
            accelerometer_mode=cast(str, values["accelerometer_mode"]),
            gravity=cast(float, values["gravity"]),
            lever_arm=lever_arm,
            orientation=OrientationModel.from_values(values),
            delivery=Delivery.from_values("imu", values),
        )

    @property
    def support(self) -> float:
        """Specific force of what holds the mass centre, along z of the world frame, m/s²; 0 in free fall."""
        return self.gravity if self.accelerometer_mode == "pivot_gravity" else 0.0

    @property
    def faulty(self) -> tuple[Faulty | None, ...]:
        """Delivery, gyro and accelerometer, which can have faults."""
        return (self.delivery, self.gyro.faults, self.accelerometer.faults)

    @property
    def aids(self) -> tuple[VectorAid, ...]:
        """The vertical, where something holds the body."""
        if not self.support:
            return ()
        triad, up = self.accelerometer, (0.0, 0.0, self.support)
        noise, step = triad.noise_density * math.sqrt(self.rate), triad.bias_random_walk / math.sqrt(self.rate)
        return (VectorAid(up, noise, triad.turn_on_bias, step),)

    def refusal(self, fastest: float) -> ParameterError | None:
        """The error of a body that may turn by half a turn between two readings of an integrated rate."""
        if self.gyro_rate != "integrated" or fastest <= self.rate * LARGEST_TURN_PER_READING:
            return None
        upwards = Context(prec=3, rounding=ROUND_CEILING)
        lowest = float(upwards.create_decimal_from_float(fastest / LARGEST_TURN_PER_READING))
        return ParameterError(
            "imu_rate",
            f"{self.rate:g} Hz lets the body turn by up to {fastest / self.rate:.3g} rad between readings, more than "
            f"an integrated rate tells ({LARGEST_TURN_PER_READING:g}): give at least {lowest:g} Hz, or gyro_rate "
            "instantaneous",
        )


class Imu(Instrument):
    """An IMU at work: the readings of gyro and accelerometer, their true biases, and the orientation if it tells one.

    Parameters
    ----------
    model : ImuModel
    body : RigidBody
        The body to which it is fixed.
    before_ns : int
        A time one interval before the first sample, ns; it may be negative.
    before : State
        The body's state at that time. Only an integrated rate looks at them.
    """

    def __init__(self, model: ImuModel, body: RigidBody, before_ns: int, before: State) -> None:
        self._model = model
        self._integrated = _integrated(model, before_ns, before)
        self._force = SpecificForce(body, model.lever_arm, model.support)
        self._gyro = Triad(
            model.gyro,
            model.rate,
            model.seed,
            turn_on=NoiseSource.GYRO_TURN_ON,
            walk=NoiseSource.GYRO_WALK,
            white=NoiseSource.GYRO_WHITE,
        )
        self._accelerometer = Triad(
            model.accelerometer,
            model.rate,
            model.seed,
            turn_on=NoiseSource.ACCELEROMETER_TURN_ON,
            walk=NoiseSource.ACCELEROMETER_WALK,
            white=NoiseSource.ACCELEROMETER_WHITE,
        )
        self._orientation = None if model.orientation is None else Orientation(model.orientation, model.seed)

    def signals(self, times_ns: Integers, states: State) -> dict[str, Signal]:
        """The next readings before their converters; see `Instrument.measure`."""
        rates = states.body_rate if self._integrated is None else self._integrated.over(times_ns, states)
        rate = Signal(rates, condition=lambda: self._rate_conditioning(states))
        gyro, gyro_bias = self._gyro.signals(times_ns, rate)
        force, force_bias = self._accelerometer.signals(times_ns, self._force.signal(states))
        signals = {
            "gyro": gyro,
            "specific_force": force,
            "gyro_bias": gyro_bias,
            "accelerometer_bias": force_bias,
        }
        if self._orientation is not None:
            signals["orientation_xyzw"] = self._orientation.signal(states)
        return signals

    def _rate_conditioning(self, states: State) -> Conditioning:
        """How far the true rates may differ; an integrated one is the difference of two attitudes over the interval."""
        speed, rate = so3.norm(states.body_rate), self._model.rate
        if self._model.gyro_rate != "integrated":
            return Conditioning.of(speed, per_rate=1.0)
        return Conditioning.of(speed + rate, per_rate=1.0, span=1.0 / rate)

    @property
    def walks(self) -> bool:
        """Whether the bias of gyro or accelerometer walks."""
        return bool(self._model.gyro.bias_random_walk or self._model.accelerometer.bias_random_walk)

    def repeated(
        self, number: int, elapsed_ns: Callable[[int], int], number_before: Callable[[int], int]
    ) -> Iterator[int]:
        """Readings that an axis that is stuck repeats; see `Instrument.repeated`."""
        for faults in (self._model.gyro.faults, self._model.accelerometer.faults):
            if faults is not None:
                yield from faults.repeated(number, elapsed_ns, number_before)

    def skip(self, count: int, before_ns: int, before: State) -> None:
        """Leave out the next readings; see `Instrument.skip`."""
        self._integrated = _integrated(self._model, before_ns, before)
        self._gyro.skip(count)
        self._accelerometer.skip(count)
        if self._orientation is not None:
            self._orientation.skip(count)


def _integrated(model: ImuModel, before_ns: int, before: State) -> IntegratedRate | None:
    """Mean rates from a time, ns, on, at which the body has a state; None of a gyro that measures the rate itself."""
    return IntegratedRate(before_ns, before) if model.gyro_rate == "integrated" else None


def _made(model: ImuModel, carrier: Carrier, before_ns: int) -> Imu:
    # an instantaneous rate does not look at the state before, to which no integrator goes
    before = carrier.exact_motion().at(before_ns) if model.gyro_rate == "integrated" else carrier.start()
    return Imu(model, carrier.body(), before_ns, before)


def _fixed_of_bias(model: ImuModel) -> dict[str, tuple[float, ...]]:
    return _UNORIENTED


def _fixed(model: ImuModel) -> dict[str, tuple[float, ...]]:
    """Fields that are the same in all messages of readings (REP-145)."""
    return {
        **_UNORIENTED,
        **({} if model.orientation is None else {"orientation_covariance": model.orientation.covariance}),
        "angular_velocity_covariance": diagonal(model.gyro.variance(model.rate)),
        "linear_acceleration_covariance": diagonal(model.accelerometer.variance(model.rate)),
    }


_UNORIENTED: Final[dict[str, tuple[float, ...]]] = {
    "orientation": (0.0, 0.0, 0.0, 1.0),
    "orientation_covariance": (-1.0, *[0.0] * 8),
}
"""An orientation that is not given (REP-145)."""
_MESSAGE: Final = "sensor_msgs/msg/Imu"
IMU: Final = Sensor(
    "imu",
    "IMU",
    ImuModel,
    _made,
    (
        Topic(
            "imu/data_raw",
            _MESSAGE,
            "IMU frame and covariances",
            (
                Field("orientation_xyzw", "orientation", "", "IMU orientation", "orientation_covariance"),
                Field("gyro", "angular_velocity", "rad/s", "gyro"),
                Field("specific_force", "linear_acceleration", "m/s²", "accelerometer"),
            ),
            "imu_frame",
            _fixed,
        ),
        Topic(
            "imu/bias",
            _MESSAGE,
            "IMU bias frame and covariances",
            (
                Field("gyro_bias", "angular_velocity", "rad/s", "gyro bias"),
                Field("accelerometer_bias", "linear_acceleration", "m/s²", "accelerometer bias"),
            ),
            "imu_frame",
            _fixed_of_bias,
        ),
    ),
    told=(
        not_negative("imu_rate", "Samples of the IMU per second, from 1e-6; 0: no IMU."),
        Parameter(
            "gyro_rate",
            "string",
            "instantaneous",
            "Gyro: the rate at the instant of a sample, or integrated: the mean turn over the interval that ends "
            "there.",
            choices=("instantaneous", "integrated"),
        ),
        *triad_parameters("gyro", "rad/s"),
        Parameter(
            "accelerometer_mode",
            "string",
            "free_fall",
            "Accelerometer: free_fall reads no gravity, pivot_gravity that of a body held at its mass centre.",
            choices=("free_fall", "pivot_gravity"),
        ),
        not_negative("gravity", "Standard gravity, against z of the world frame, m/s².", default=9.80665, maximum=1e6),
        numbers(
            "accelerometer_lever_arm",
            (0.0, 0.0, 0.0),
            "From the mass centre to the accelerometer in the body frame, m.",
        ),
        *triad_parameters("accelerometer", "m/s²"),
    ),
    parameters=(
        Parameter("imu_orientation", "bool", False, "Whether the IMU tells its orientation, as an AHRS does."),
        angle("imu_inclination_noise", "Its standard deviation about each horizontal axis, rad."),
        angle("imu_heading_noise", "Its standard deviation about the vertical, rad."),
    ),
    faults=(
        *triad_fault_parameters("gyro", "rad/s", 1.0, 0.01, 0.5),
        *triad_fault_parameters("accelerometer", "m/s²", 10.0, 0.1, 5.0),
    ),
    parts=("gyro", "accelerometer"),
    prefixes=("imu_", "gyro_", "accelerometer_"),
    switches={"imu_orientation": ("imu_inclination_", "imu_heading_")},
)
"""The IMU in the table of sensors."""
