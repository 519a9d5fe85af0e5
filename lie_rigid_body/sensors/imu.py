"""The inertial measurement unit, a gyro and an accelerometer at one point of the body, and what they truly measure."""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import ROUND_CEILING, Context
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import Parameter, Vector, require_at_most
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.motion.harmonics import Harmonics
from lie_rigid_body.sensors.noise import NoiseSource, WhiteNoise, harmonics
from lie_rigid_body.sensors.parameters import (
    Fields,
    Values,
    angle,
    harmonics_parameters,
    not_negative,
    numbers,
    require_band,
    triad_fault_parameters,
    triad_parameters,
    values_of,
)
from lie_rigid_body.sensors.pointing import OrientationModel
from lie_rigid_body.sensors.sensor import (
    Carrier,
    Field,
    FixedFields,
    Instrument,
    Sensor,
    SensorModel,
    Topic,
    VectorMeasurement,
    diagonal,
)
from lie_rigid_body.sensors.signal import Signals
from lie_rigid_body.sensors.triad import Triad, TriadModel

MAX_ROTATION_PER_READING: Final = 3.0
"""Largest turn between two readings of an integrated rate, rad: more than half a turn reads as one the other way."""
_OF_GYRO: Final = (NoiseSource.GYRO_TURN_ON, NoiseSource.GYRO_WALK, NoiseSource.GYRO_WHITE)
_OF_ACCELEROMETER: Final = (
    NoiseSource.ACCELEROMETER_TURN_ON,
    NoiseSource.ACCELEROMETER_WALK,
    NoiseSource.ACCELEROMETER_WHITE,
)
_YZX: Final = np.array([1, 2, 0])
_ZXY: Final = np.array([2, 0, 1])


@short_dataclass
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
    vibration_acceleration, vibration_band : tuple of float, length 3 and 2
        Oscillation of the accelerometer's mount: RMS on each axis, m/s², and frequencies, Hz.
    orientation : OrientationModel or None
        Orientation that it tells; None: it tells none.
    """

    gyro_rate: str
    gyro: TriadModel
    accelerometer: TriadModel
    accelerometer_mode: str
    gravity: float
    lever_arm: Vector
    vibration_acceleration: Vector
    vibration_band: Vector
    orientation: OrientationModel | None = None

    @classmethod
    def parts(cls, sensor: str, values: Values) -> Fields:
        """Fields that have no parameter of their name; see `SensorModel.from_values`."""
        require_at_most("accelerometer_lever_arm", values["accelerometer_lever_arm"], 1e6, "m")
        require_band("vibration_band", values["vibration_band"])
        names = ("gyro_rate", "accelerometer_mode", "gravity", "vibration_acceleration", "vibration_band")
        told = OrientationModel(**values_of(OrientationModel, sensor, values)) if values["imu_orientation"] else None
        return {
            **{name: values[name] for name in names},
            "gyro": TriadModel.from_values("gyro", values),
            "accelerometer": TriadModel.from_values("accelerometer", values),
            "lever_arm": values["accelerometer_lever_arm"],
            "orientation": told,
        }

    @property
    def support(self) -> float:
        """Specific force of what holds the mass centre, along z of the world frame, m/s²; 0 in free fall."""
        return self.gravity if self.accelerometer_mode == "pivot_gravity" else 0.0

    @property
    def vibration(self) -> Harmonics | None:
        """Oscillation of the accelerometer's mount, on its axes, m/s²; None: there is none."""
        if not any(self.vibration_acceleration):
            return None
        return harmonics(self.seed, NoiseSource.VIBRATION, self.vibration_acceleration, self.vibration_band)

    @property
    def measurement_models(self) -> tuple[VectorMeasurement, ...]:
        """The vertical, where something holds the body."""
        if not self.support:
            return ()
        triad = self.accelerometer
        up = (0.0, 0.0, self.support)
        noise = triad.noise_density * math.sqrt(self.rate)
        step = triad.bias_random_walk / math.sqrt(self.rate)
        return (VectorMeasurement(up, noise, triad.turn_on_bias, step, triad.linear_errors),)

    def refusal(self, fastest: float) -> ParameterError | None:
        """The error of a body that may turn by half a turn between two readings of an integrated rate."""
        if self.gyro_rate != "integrated" or fastest <= self.rate * MAX_ROTATION_PER_READING:
            return None
        upwards = Context(prec=3, rounding=ROUND_CEILING)
        lowest = float(upwards.create_decimal_from_float(fastest / MAX_ROTATION_PER_READING))
        return ParameterError(
            "imu_rate",
            f"{self.rate:g} Hz lets the body turn by up to {fastest / self.rate:.3g} rad between readings, more than "
            f"an integrated rate tells ({MAX_ROTATION_PER_READING:g}): give at least {lowest:g} Hz, or gyro_rate "
            "instantaneous",
        )


class IntegratedRate:
    """The constant rate that takes the attitude of one sample to the attitude of the next.

    ``log(R_(j-1)ᵀ R_j) / (t_j − t_(j-1))``, so that the product of the ``exp(ω_j (t_j − t_(j-1)))`` is the rotation of
    the truth, with no error of integration. The logarithm takes the shorter way round: between two samples the body
    has to turn by less than π.

    Parameters
    ----------
    before_ns : int
        Time of the state one interval before the first sample, ns.
    before : State
        The state at that time, of one instant.
    """

    def __init__(self, before_ns: int, before: State) -> None:
        self._times = np.array([before_ns], dtype=np.int64)
        self._attitudes = before.attitude_xyzw.reshape(1, 4)

    def over(self, stamps_ns: Integers, states: State) -> Array:
        """The rates of the next samples.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        states : State
            Of N instants.

        Returns
        -------
        ndarray, shape (N, 3)
            rad/s.
        """
        times = np.concatenate([self._times, stamps_ns])
        attitudes = np.concatenate([self._attitudes, states.attitude_xyzw])
        intervals = np.diff(times)
        self._times = times[-1:]
        self._attitudes = attitudes[-1:]
        turns = quaternion.log(quaternion.multiply(quaternion.conjugate(attitudes[:-1]), attitudes[1:]))
        return turns / (intervals / 1e9)[:, np.newaxis]


class SpecificForce:
    """Acceleration less gravitation at a point that moves with the body: ω̇×r + ω×(ω×r) + Aᵀ(a + g ẑ).

    The first two terms are the acceleration of the point about the mass centre, whose own is a. The last one is what
    holds the mass centre: nothing in free fall; otherwise the weight upwards, which makes no torque.

    Parameters
    ----------
    carrier : Carrier
    lever_arm : tuple of float, length 3
        r, from the mass centre to the point in the body frame, m.
    support : float
        g where something holds the body, 0 in free fall, m/s², along z of the world frame.
    """

    def __init__(self, carrier: Carrier, lever_arm: Vector, support: float) -> None:
        body = carrier.body
        moments = body.principal_moments
        # (I₂ − I₃)/I₁, each of size 1 at most, as the moments obey the triangle inequality
        self._euler = (moments[_YZX] - moments[_ZXY]) / moments
        self._to_principal = body.principal_axes.T
        self._across = -so3.hat(lever_arm)
        self._principal_across = self._across @ body.principal_axes
        self._has_lever_arm = any(lever_arm)
        self._support = 0.0 if carrier.falls else support
        self._acceleration = carrier.acceleration
        self._angular_acceleration = carrier.angular_acceleration

    def of(self, times_ns: Integers, states: State) -> Array:
        """The specific force in the body frame, m/s², shape (N, 3): exactly 0 at the mass centre in free fall.

        Parameters
        ----------
        times_ns : ndarray of int64, shape (N,)
            Times since the segment's start, ns.
        states : State
            Of N instants.
        """
        rate = states.body_rate
        force = self._of_rotation(times_ns, rate) if self._has_lever_arm else np.zeros_like(rate)
        if self._acceleration is not None:
            moved = self._acceleration(times_ns) + self._support * np.array([0.0, 0.0, 1.0])
            return force + quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), moved)
        if self._support:
            # the world's z axis in the body frame: the last row of the rotation matrix
            x, y, z, w = states.attitude_xyzw.T
            up = 2.0 * np.stack([x * z - y * w, y * z + x * w, 0.5 - (x * x + y * y)], axis=-1)
            force = force + self._support * up
        return force

    def _of_rotation(self, times_ns: Integers, rate: Array) -> Array:
        """Acceleration of the point relative to the mass centre, body frame, m/s²: ω̇×r + ω×(ω×r)."""
        centripetal = np.cross(rate, apply_tensor(self._across, rate))
        if self._angular_acceleration is not None:
            return apply_tensor(self._across, self._angular_acceleration(times_ns)) + centripetal
        # ω̇ in principal axes: ω̇₁ = (I₂ − I₃)/I₁ ω₂ω₃ and cyclically (Landau & Lifshitz §36, 36.5)
        principal = apply_tensor(self._to_principal, rate)
        turning = self._euler * principal.take(_YZX, axis=-1) * principal.take(_ZXY, axis=-1)
        return apply_tensor(self._principal_across, turning) + centripetal


class Imu(Instrument):
    """An IMU at work: the readings of gyro and accelerometer, their true biases, and the orientation if it tells one.

    Parameters
    ----------
    model : ImuModel
    carrier : Carrier
        What it is fixed to.
    """

    def __init__(self, model: ImuModel, carrier: Carrier) -> None:
        self._model = model
        self._integrates = model.gyro_rate == "integrated"
        self._force = SpecificForce(carrier, model.lever_arm, model.support)
        self._vibration = model.vibration
        self._gyro = Triad(model.gyro, model.rate, model.seed, *_OF_GYRO)
        self._accelerometer = Triad(model.accelerometer, model.rate, model.seed, *_OF_ACCELEROMETER)
        self._turn = WhiteNoise(model.seed, NoiseSource.ORIENTATION_WHITE, 1.0)

    def begin_after(self, before_ns: int, state: Callable[[], State]) -> None:
        """Begin with the reading one interval after a time; see `Instrument.begin_after`."""
        if self._integrates:
            self._rate = IntegratedRate(before_ns, state())

    def signals(self, times_ns: Integers, states: State, first: int) -> Signals:
        """Readings before their converters; see `Instrument.measure`."""
        rate = self._rate.over(times_ns, states) if self._integrates else states.body_rate
        interval = 1.0 / self._model.rate if self._integrates else 0.0
        gyro, gyro_bias = self._gyro.signals(first, times_ns, rate, interval)
        true_force = self._force.of(times_ns, states)
        if self._vibration is not None:
            true_force = true_force + self._vibration.at(times_ns).acceleration
        force, force_bias = self._accelerometer.signals(first, times_ns, true_force)
        told = self._model.orientation
        return {
            "gyro": gyro,
            "specific_force": force,
            "gyro_bias": gyro_bias,
            "accelerometer_bias": force_bias,
            **({} if told is None else {"orientation_xyzw": told.signal(states, self._turn, first)}),
        }


def _fixed(model: ImuModel) -> FixedFields:
    """Fields that are the same in all messages of readings (REP-145)."""
    return {
        **_UNORIENTED,
        **({} if model.orientation is None else {"orientation_covariance": model.orientation.covariance}),
        "angular_velocity_covariance": diagonal(model.gyro.variance(model.rate)),
        "linear_acceleration_covariance": diagonal(model.accelerometer.variance(model.rate)),
    }


def _fixed_of_bias(model: ImuModel) -> FixedFields:
    return _UNORIENTED


_UNORIENTED: Final = {
    "orientation": (0.0, 0.0, 0.0, 1.0),
    "orientation_covariance": (-1.0, *[0.0] * 8),
}
"""An orientation that is not given (REP-145)."""
_MESSAGE: Final = "sensor_msgs/msg/Imu"
IMU_SENSOR: Final = Sensor(
    "imu",
    "IMU",
    ImuModel,
    Imu,
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
    parameters=(
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
            "pivot_gravity",
            "Accelerometer: pivot_gravity reads that of a body held at its mass centre, free_fall none.",
            choices=("pivot_gravity", "free_fall"),
        ),
        not_negative("gravity", "Standard gravity, against z of the world frame, m/s².", default=9.80665, maximum=1e6),
        numbers(
            "accelerometer_lever_arm",
            (0.0, 0.0, 0.0),
            "From the mass centre to the accelerometer in the body frame, m.",
        ),
        *harmonics_parameters(
            "vibration", "an oscillation of the accelerometer's mount along each of its axes", (40.0, 200.0)
        ),
        *triad_parameters("accelerometer", "m/s²"),
        Parameter("imu_orientation", "bool", False, "Whether the IMU tells its orientation, as an AHRS does."),
        angle("imu_inclination_noise", "Its standard deviation about each horizontal axis, rad."),
        angle("imu_heading_noise", "Its standard deviation about the vertical, rad."),
    ),
    streams={"imu": 1, "gyro": 2, "accelerometer": 3},
    faults=(
        *triad_fault_parameters("gyro", "rad/s", 1.0, 0.01, 0.5),
        *triad_fault_parameters("accelerometer", "m/s²", 10.0, 0.1, 5.0),
    ),
    switches={"imu_orientation": ("imu_inclination_", "imu_heading_")},
)
"""The IMU in the table of sensors."""
