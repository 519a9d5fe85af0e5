"""Model of a magnetometer: readings of the world's magnetic field in the body frame, with iron errors, noise, range."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import Vector, require_at_most
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.sensors.fault import AXES, Fault, FaultModel, IntermittentFault
from lie_rigid_body.sensors.noise import NoiseSource, WhiteNoise
from lie_rigid_body.sensors.parameters import (
    Fields,
    Values,
    episode_parameters,
    not_negative,
    numbers,
    triad_fault_parameters,
)
from lie_rigid_body.sensors.sensor import (
    Field,
    FixedFields,
    Instrument,
    Sensor,
    SensorModel,
    Topic,
    VectorMeasurement,
    diagonal,
)
from lie_rigid_body.sensors.signal import Converter, Signal, Signals
from lie_rigid_body.sensors.triad import TriadFaultInjector, TriadFaults, linear_errors

MAX_FIELD_T: Final = 1e3
"""Largest magnitude of a component of the field or of the hard iron, T."""
_KIND: Final = "magnetic_disturbance"


@short_dataclass
class MagneticDisturbance(FaultModel):
    """A field that comes and goes: something of iron comes by, or a current flows for a while.

    It is of the world, its size times (1 − s²)², with s from −1 to 1 over an episode.

    Parameters
    ----------
    sensor, seed, window
        See `FaultModel`.
    episodes : IntermittentFault
    size : float
        Magnitude at its height, T; the direction in the world is drawn evenly over the sphere.
    """

    episodes: IntermittentFault
    size: float

    @classmethod
    def from_values(cls, sensor: str, values: Values) -> MagneticDisturbance | None:
        """Make the disturbance of the parameters; None if there is none. See `FaultModel.from_values`."""
        episodes = IntermittentFault.from_values(values, sensor, _KIND, _KIND)
        size = values[f"{_KIND}_size"]
        return None if episodes is None else cls(sensor, episodes.seed, episodes.window, episodes, size)

    def field(self, times_ns: Integers) -> Array:
        """The field in the world at some times since the segment's start, shape (N, 3), T."""
        numbers = self.episodes.at(times_ns)
        inside = np.flatnonzero(numbers >= 0)
        field = np.zeros((len(times_ns), 3))
        age = times_ns[inside] - self.episodes.begins_ns(numbers[inside])
        s = 2.0 * age / self.episodes.duration_ns - 1.0
        bump = 1.0 - s * s
        field[inside] = (bump * bump)[:, np.newaxis] * self._heights(numbers[inside])
        return field

    def _heights(self, numbers: Integers) -> Array:
        """The field at the height of each episode, shape (N, 3), T."""
        from scipy.special import ndtri  # slow to import: not before there is a disturbance

        # the direction of three normal deviates is uniform on the sphere
        x, y, z = ndtri(self.episodes.draws(numbers)[:, 1:]).T
        return np.asarray(self.size * np.stack([x, y, z], axis=-1) / np.sqrt(x * x + y * y + z * z)[:, np.newaxis])

    def faults(self, begin_ns: int, end_ns: int, first: int, times_ns: Integers) -> Iterator[Fault]:
        """Faults that begin in a stretch of time, one for each axis of the world; see `FaultModel`."""
        for number, begin, end in self.episodes.between(begin_ns, end_ns):
            for axis, size in zip(AXES, self._heights(np.array([number]))[0].tolist(), strict=True):
                yield Fault(_KIND, self.sensor, axis, begin, end, size)


@short_dataclass
class MagnetometerModel(SensorModel):
    """The model of a magnetometer in the field B of the world, at the attitude A.

    ::

        y_k = saturate(quantise(C Aᵀ B + h + n_k)),   n_k = N √f ν_k

    with f the sample rate and each ν independent and standard normal. Soft iron distorts the field before the sensor
    meets it, and hard iron adds its own; noise, range and resolution are the sensor's.

    Parameters
    ----------
    rate, seed, delivery
        As of `SensorModel`.
    field : tuple of float, length 3
        B, in the world frame, T.
    noise_density : float
        N, T/√Hz.
    hard_iron : tuple of float, length 3
        h, in the body frame, T.
    soft_iron : tuple of float, length 9
        C, row by row.
    converter : Converter
    disturbance : MagneticDisturbance or None
        Added to B.
    faults : TriadFaults or None
        Of its axes; see `TriadModel`.
    """

    field: Vector
    noise_density: float
    hard_iron: Vector
    soft_iron: Vector
    converter: Converter
    disturbance: MagneticDisturbance | None = None
    faults: TriadFaults | None = None

    @classmethod
    def parts(cls, sensor: str, values: Values) -> Fields:
        """Fields that have no parameter of their name; see `SensorModel.from_values`."""
        require_at_most("magnetic_field", values["magnetic_field"], MAX_FIELD_T, "T")
        require_at_most("magnetometer_hard_iron", values["magnetometer_hard_iron"], MAX_FIELD_T, "T")
        require_at_most("magnetometer_soft_iron", values["magnetometer_soft_iron"], 1e6, "")
        return {
            "field": values["magnetic_field"],
            "converter": Converter.from_values(sensor, values),
            "disturbance": MagneticDisturbance.from_values(sensor, values),
            "faults": TriadFaults.from_values(sensor, values),
        }

    @property
    def variance(self) -> float:
        """Variance of a reading on each axis, T²; 0 ("unknown") without noise and resolution."""
        return self.noise_density * self.noise_density * self.rate + self.converter.variance

    @property
    def measurement_models(self) -> tuple[VectorMeasurement, ...]:
        """The magnetic field, if there is one. An estimator is granted to know how large the iron's errors may be."""
        noise = self.noise_density * math.sqrt(self.rate)
        hard = max(map(abs, self.hard_iron))
        soft = np.abs(np.array(self.soft_iron).reshape(3, 3) - np.eye(3)).max()
        return (VectorMeasurement(self.field, noise, hard, 0.0, linear_errors(matrix=soft)),) if any(self.field) else ()


class Magnetometer(Instrument):
    """A magnetometer at work: the field on the body's axes, which are the sensor's, T.

    Parameters
    ----------
    model : MagnetometerModel
    carrier : Carrier, optional
        What it is fixed to, at which it does not look.
    """

    def __init__(self, model: MagnetometerModel, carrier: object = None) -> None:
        self._model = model
        self._soft_iron = np.array(model.soft_iron).reshape(3, 3)
        self._noise = WhiteNoise(
            model.seed, NoiseSource.MAGNETOMETER_WHITE, model.noise_density * math.sqrt(model.rate)
        )
        self._faulty = None if model.faults is None else TriadFaultInjector(model.faults, model.rate, model.converter)

    def signals(self, times_ns: Integers, states: State, first: int) -> Signals:
        """Readings before the converter; see `Instrument.measure`."""
        model = self._model
        count = len(times_ns)
        world_field = np.broadcast_to(model.field, (count, 3))
        if model.disturbance is not None:
            world_field = world_field + model.disturbance.field(times_ns)
        field = quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), world_field)
        distorted = apply_tensor(self._soft_iron, field) + np.array(model.hard_iron)
        signal = distorted + self._noise.draw(first, count)
        if model.faults is not None and self._faulty is not None:
            signal = self._faulty.disturbed(first, times_ns, signal + model.faults.drift(times_ns))
        return {"field": Signal(signal, model.converter)}


def _fixed(model: MagnetometerModel) -> FixedFields:
    return {"magnetic_field_covariance": diagonal(model.variance)}


_CENTRAL_EUROPE: Final = (1.5e-6, 21.0e-6, -43.5e-6)
"""Magnetic field in Central Europe: east, north and up, T."""
MAGNETOMETER: Final = Sensor(
    "magnetometer",
    "magnetometer",
    MagnetometerModel,
    Magnetometer,
    (
        Topic(
            "imu/mag",
            "sensor_msgs/msg/MagneticField",
            "magnetometer frame and covariances",
            (Field("field", "magnetic_field", "T", "magnetometer"),),
            "imu_frame",
            _fixed,
        ),
    ),
    parameters=(
        not_negative("magnetometer_rate", "Samples of the magnetometer per second, from 1e-6; 0: no magnetometer."),
        numbers(
            "magnetic_field",
            _CENTRAL_EUROPE,
            "Magnetic field in the world frame, T; the default is east, north, up.",
        ),
        not_negative("magnetometer_noise_density", "Magnetometer: white noise, T/√Hz; 0: none."),
        numbers(
            "magnetometer_hard_iron",
            (0.0, 0.0, 0.0),
            "Magnetometer: field of the body's own magnets in the body frame, T.",
        ),
        numbers(
            "magnetometer_soft_iron",
            (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
            "Magnetometer: matrix of the body's soft iron, row by row.",
        ),
        not_negative("magnetometer_resolution", "Magnetometer: step of its readings, T; 0: continuous."),
        not_negative("magnetometer_range", "Magnetometer: largest size of a reading on each axis, T; 0: no limit."),
    ),
    streams={"magnetometer": 4},
    faults=(
        *triad_fault_parameters("magnetometer", "T", 1e-4, 1e-6, 20e-6),
        *episode_parameters("magnetic_disturbance", "Magnetic disturbance, a field that passes", 5.0),
        not_negative(
            "magnetic_disturbance_size", "Magnetic disturbance: its size at its height, in a direction drawn, T.", 20e-6
        ),
    ),
)
"""The magnetometer in the table of sensors."""
