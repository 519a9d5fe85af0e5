"""Model of a magnetometer: readings of the world's magnetic field in the body frame, with iron errors, noise, range."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final, cast

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.parameters import Value, Vector, require_at_most, vector
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.fault import Faulty
from lie_rigid_body.sensors.magnetic_disturbance import MagneticDisturbance
from lie_rigid_body.sensors.noise import BlockBuffer, NoiseSource, WhiteNoise
from lie_rigid_body.sensors.parameters import episode_parameters, not_negative, numbers, triad_fault_parameters
from lie_rigid_body.sensors.quantisation import Converter
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
from lie_rigid_body.sensors.signal import Signal
from lie_rigid_body.sensors.triad_faults import FaultyTriad, TriadFaults
from lie_rigid_body.wording import short_repr

STRONGEST_FIELD_T: Final = 1e3
"""Largest magnitude of a component of the field or of the hard iron, T."""
LARGEST_SOFT_IRON: Final = 1e6
"""Largest magnitude of an entry of the soft-iron matrix."""


@dataclass(frozen=True)
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

    __repr__ = short_repr

    @classmethod
    def from_values(cls, values: Mapping[str, Value]) -> MagnetometerModel:
        """Build the model from parameter values.

        Raises
        ------
        ParameterError
            If a value is invalid.
        """
        number = {key: cast(float, values[f"magnetometer_{key}"]) for key in _NUMBERS}
        converter = Converter(number["resolution"], number["range"])
        converter.validate("magnetometer")
        field, hard_iron = vector(values, "magnetic_field"), vector(values, "magnetometer_hard_iron")
        soft_iron = vector(values, "magnetometer_soft_iron")
        require_at_most("magnetic_field", field, STRONGEST_FIELD_T, "T")
        require_at_most("magnetometer_hard_iron", hard_iron, STRONGEST_FIELD_T, "T")
        require_at_most("magnetometer_soft_iron", soft_iron, LARGEST_SOFT_IRON, "")
        return cls(
            rate=number["rate"],
            seed=cast(int, values["sensor_seed"]),
            field=field,
            noise_density=number["noise_density"],
            hard_iron=hard_iron,
            soft_iron=soft_iron,
            converter=converter,
            delivery=Delivery.from_values("magnetometer", values),
            disturbance=MagneticDisturbance.from_values(values),
            faults=TriadFaults.from_values("magnetometer", values),
        )

    @property
    def faulty(self) -> tuple[Faulty | None, ...]:
        """Delivery, surroundings and axes, which can have faults."""
        return (self.delivery, self.disturbance, self.faults)

    @property
    def variance(self) -> float:
        """Variance of a reading on each axis, T²; 0 ("unknown") without noise and resolution."""
        return self.noise_density * self.noise_density * self.rate + self.converter.variance

    @property
    def aids(self) -> tuple[VectorAid, ...]:
        """The magnetic field, if there is one. Who knows the size of the hard iron is granted that."""
        noise, iron = self.noise_density * math.sqrt(self.rate), max(map(abs, self.hard_iron))
        return (VectorAid(self.field, noise, iron),) if any(self.field) else ()


_NUMBERS: Final = ("rate", "noise_density", "resolution", "range")


class Magnetometer(Instrument):
    """A magnetometer at work: the field on the body's axes, which are the sensor's, T.

    Parameters
    ----------
    model : MagnetometerModel
    """

    def __init__(self, model: MagnetometerModel) -> None:
        self._field = np.array(model.field)
        self._soft_iron = np.array(model.soft_iron).reshape(3, 3)
        self._hard_iron = np.array(model.hard_iron)
        self._converter = model.converter
        self._noise = BlockBuffer(
            WhiteNoise(model.seed, NoiseSource.MAGNETOMETER_WHITE, model.noise_density * math.sqrt(model.rate))
        )
        self._disturbance = model.disturbance
        self._faults = None if model.faults is None else FaultyTriad(model.faults, model.rate, model.converter)

    def signals(self, times_ns: Integers, states: State) -> dict[str, Signal]:
        """The next readings before the converter; see `Instrument.measure`."""
        world_field = np.broadcast_to(self._field, (len(times_ns), 3))
        if self._disturbance is not None:
            world_field = world_field + self._disturbance.field(times_ns)
        field = quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), world_field)
        signal = Signal(field, self._converter).through(self._soft_iron).plus(self._hard_iron)
        signal = signal.plus(self._noise.take(len(field)))
        if self._faults is not None:
            signal = self._faults.disturbed(times_ns, signal.plus(self._faults.drift(times_ns)))
        return {"field": signal}

    def skip(self, count: int, before_ns: int, before: State) -> None:
        """Leave out the next readings; see `Instrument.skip`."""
        self._noise.skip(count)
        if self._faults is not None:
            self._faults.skip(count)

    def repeated(
        self, number: int, elapsed_ns: Callable[[int], int], number_before: Callable[[int], int]
    ) -> Iterator[int]:
        """Readings that an axis that is stuck repeats; see `Instrument.repeated`."""
        return iter(()) if self._faults is None else self._faults.model.repeated(number, elapsed_ns, number_before)


def _made(model: MagnetometerModel, carrier: Carrier, before_ns: int) -> Magnetometer:
    return Magnetometer(model)


def _fixed(model: MagnetometerModel) -> dict[str, tuple[float, ...]]:
    return {"magnetic_field_covariance": diagonal(model.variance)}


_CENTRAL_EUROPE: Final = (1.5e-6, 21.0e-6, -43.5e-6)
"""Magnetic field in Central Europe: east, north and up, T."""
MAGNETOMETER: Final = Sensor(
    "magnetometer",
    "magnetometer",
    MagnetometerModel,
    _made,
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
    told=(
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
    faults=(
        *triad_fault_parameters("magnetometer", "T", 1e-4, 1e-6, 20e-6),
        *episode_parameters("magnetic_disturbance", "Magnetic disturbance, a field that passes", 5.0),
        not_negative(
            "magnetic_disturbance_size", "Magnetic disturbance: its size at its height, in a direction drawn, T.", 20e-6
        ),
    ),
    prefixes=("magnetometer_", "magnetic_disturbance_"),
)
"""The magnetometer in the table of sensors."""
