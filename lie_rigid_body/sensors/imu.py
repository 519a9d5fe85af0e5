"""The inertial measurement unit: a gyro and an accelerometer at one point of the body."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, cast

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.parameters import Value, Vector, require_at_most, vector
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.fault import Faulty
from lie_rigid_body.sensors.gyro_rate import GyroRate, InstantaneousRate, IntegratedRate
from lie_rigid_body.sensors.noise import NoiseSource
from lie_rigid_body.sensors.orientation import Orientation, OrientationModel
from lie_rigid_body.sensors.specific_force import SpecificForce
from lie_rigid_body.sensors.triad import Triad, TriadModel
from lie_rigid_body.wording import short_repr

LONGEST_LEVER_ARM_M: Final = 1e6


@dataclass(frozen=True)
class ImuModel:
    """The model of an IMU, made of its parameters.

    Parameters
    ----------
    rate : float
        Samples per second.
    frame : str
        Name of the sensor's frame: the body's axes but for the misalignments, its origin at the end of the lever arm.
    seed : int
    gyro_rate : str
        ``instantaneous``, or ``integrated`` over the interval that ends at each sample.
    gyro, accelerometer : TriadModel
    accelerometer_mode : str
        ``free_fall``, or ``pivot_gravity``: held at the mass centre.
    gravity : float
        m/s².
    lever_arm : tuple of float, length 3
        From the mass centre to the accelerometer in the body frame, m.
    orientation : OrientationModel or None
        None: it tells none.
    delivery : Delivery or None
    """

    rate: float
    frame: str
    seed: int
    gyro_rate: str
    gyro: TriadModel
    accelerometer: TriadModel
    accelerometer_mode: str
    gravity: float
    lever_arm: Vector
    orientation: OrientationModel | None = None
    delivery: Delivery | None = None

    __repr__ = short_repr

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> ImuModel:
        """The model of the parameters' values, validated.

        Raises
        ------
        ParameterError
        """
        lever_arm = vector(values, "accelerometer_lever_arm")
        require_at_most("accelerometer_lever_arm", lever_arm, LONGEST_LEVER_ARM_M, "m")
        return cls(
            rate=cast(float, values["imu_rate"]),
            frame=cast(str, values["imu_frame"]),
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
        """What may have faults."""
        return (self.delivery, self.gyro.faults, self.accelerometer.faults)

    @property
    def angular_velocity_variance(self) -> float:
        """Variance of an angular velocity on each axis, (rad/s)²; 0 ("unknown") without noise and resolution."""
        return self.gyro.variance(self.rate)

    @property
    def linear_acceleration_variance(self) -> float:
        """Variance of a specific force on each axis, (m/s²)²; 0 ("unknown") without noise and resolution."""
        return self.accelerometer.variance(self.rate)


@dataclass(frozen=True)
class ImuReadings:
    """Readings of an IMU and their true biases, on the sensor's axes.

    Parameters
    ----------
    angular_velocity : ndarray, shape (N, 3)
        rad/s.
    linear_acceleration : ndarray, shape (N, 3)
        Specific force, m/s².
    gyro_bias : ndarray, shape (N, 3)
        The true bias in each angular velocity, rad/s.
    accelerometer_bias : ndarray, shape (N, 3)
        The true bias in each specific force, m/s².
    orientation_xyzw : ndarray, shape (N, 4), or None
        World-from-body, scalar last; None where the IMU tells none.
    """

    angular_velocity: Array
    linear_acceleration: Array
    gyro_bias: Array
    accelerometer_bias: Array
    orientation_xyzw: Array | None = None

    __repr__ = short_repr

    def __len__(self) -> int:
        return len(self.angular_velocity)


class Imu:
    """An IMU: readings in order, the same to the bit in batches of any size.

    Parameters
    ----------
    model : ImuModel
    body : RigidBody
        To which it is fixed.
    before_ns : int
        A time one interval before the first sample, ns; it may be negative.
    before : State
        The body's state at that time. Only an integrated rate looks at them.
    """

    def __init__(self, model: ImuModel, body: RigidBody, before_ns: int, before: State) -> None:
        self._model = model
        self._rate = _rate(model, before_ns, before)
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

    __copy__ = copy.deepcopy  # it goes on by itself

    def measure(self, stamps_ns: Integers, states: State) -> ImuReadings:
        """The next readings.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
            Times of the samples since the segment's start, ns, on the clock of ``before_ns``.
        states : State
            The body's states at those times, of shapes (N, 4) and (N, 3).

        Returns
        -------
        ImuReadings

        Raises
        ------
        InputError
            If the rate is integrated and the stamps do not rise.
        """
        signals, model = self.signals(stamps_ns, states), self._model
        return replace(
            signals,
            angular_velocity=model.gyro.converter.read(signals.angular_velocity),
            linear_acceleration=model.accelerometer.converter.read(signals.linear_acceleration),
        )

    def signals(self, stamps_ns: Integers, states: State) -> ImuReadings:
        """The next readings before the converters; see `measure`."""
        angular_velocity, gyro_bias = self._gyro.signal(stamps_ns, self._rate.over(stamps_ns, states))
        linear_acceleration, accelerometer_bias = self._accelerometer.signal(stamps_ns, self._force.at(states))
        orientation = None if self._orientation is None else self._orientation.measure(states)
        return ImuReadings(angular_velocity, linear_acceleration, gyro_bias, accelerometer_bias, orientation)

    def biases(self, stamps_ns: Integers) -> tuple[Array, Array]:
        """The true biases in the next readings, which are left out: of the gyro and of the accelerometer."""
        return self._gyro.bias(stamps_ns), self._accelerometer.bias(stamps_ns)

    def skip(self, count: int, before_ns: int, before: State) -> None:
        """Leave out the next readings; of an axis that is stuck the next ones are then not those of `measure`.

        Parameters
        ----------
        count : int
        before_ns : int
            Time of the last of them, ns.
        before : State
            The body's state at that time.
        """
        self._rate = _rate(self._model, before_ns, before)
        self._gyro.skip(count)
        self._accelerometer.skip(count)
        if self._orientation is not None:
            self._orientation.skip(count)


def _rate(model: ImuModel, before_ns: int, before: State) -> GyroRate:
    """What the gyro measures from a time, ns, and the state at it on."""
    return IntegratedRate(before_ns, before) if model.gyro_rate == "integrated" else InstantaneousRate()
