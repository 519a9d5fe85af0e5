"""Model of a magnetometer: readings of the world's magnetic field in the body frame, with iron errors, noise, range."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, cast

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.parameters import Value, Vector, require_at_most, vector
from lie_rigid_body.sensors.delivery import Delivery
from lie_rigid_body.sensors.fault import Faulty
from lie_rigid_body.sensors.magnetic_disturbance import MagneticDisturbance
from lie_rigid_body.sensors.noise import BlockBuffer, NoiseSource, WhiteNoise
from lie_rigid_body.sensors.quantisation import Converter
from lie_rigid_body.sensors.triad_faults import FaultyTriad, TriadFaults
from lie_rigid_body.wording import short_repr

STRONGEST_FIELD_T: Final = 1e3
"""Largest magnitude of a component of the field or of the hard iron, T."""
LARGEST_SOFT_IRON: Final = 1e6
"""Largest magnitude of an entry of the soft-iron matrix."""


@dataclass(frozen=True)
class MagnetometerModel:
    """The model of a magnetometer in the field B of the world, at the attitude A.

    ::

        y_k = saturate(quantise(C Aᵀ B + h + n_k)),   n_k = N √f ν_k

    with f the sample rate and each ν independent and standard normal. Soft iron distorts the field before the sensor
    meets it, and hard iron adds its own; noise, range and resolution are the sensor's.

    Parameters
    ----------
    rate : float
        Samples per second.
    frame : str
        Name of the sensor's frame.
    seed : int
        Of the noise.
    field : tuple of float, length 3
        B, in the world frame, T.
    noise_density : float
        N, T/√Hz.
    hard_iron : tuple of float, length 3
        h, in the body frame, T.
    soft_iron : tuple of float, length 9
        C, row by row.
    converter : Converter
    delivery : Delivery or None
    disturbance : MagneticDisturbance or None
        Added to B.
    faults : TriadFaults or None
        Of its axes; see `TriadModel`.
    """

    rate: float
    frame: str
    seed: int
    field: Vector
    noise_density: float
    hard_iron: Vector
    soft_iron: Vector
    converter: Converter
    delivery: Delivery | None = None
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
            number["rate"],
            cast(str, values["imu_frame"]),
            cast(int, values["sensor_seed"]),
            field,
            number["noise_density"],
            hard_iron,
            soft_iron,
            converter,
            Delivery.from_values("magnetometer", values),
            MagneticDisturbance.from_values(values),
            TriadFaults.from_values("magnetometer", values),
        )

    @property
    def faulty(self) -> tuple[Faulty | None, ...]:
        """What may have faults."""
        return (self.delivery, self.disturbance, self.faults)

    @property
    def variance(self) -> float:
        """Variance of a reading on each axis, T²; 0 ("unknown") without noise and resolution."""
        return self.noise_density * self.noise_density * self.rate + self.converter.variance


_NUMBERS: Final = ("rate", "noise_density", "resolution", "range")


class Magnetometer:
    """A magnetometer: readings in order, the same to the bit in batches of any size.

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

    __copy__ = copy.deepcopy  # it goes on by itself

    def measure(self, times_ns: Integers, states: State) -> Array:
        """The next readings.

        Parameters
        ----------
        times_ns : ndarray of int64, shape (N,)
            Times since the segment's start, ns.
        states : State
            The body's states, of shapes (N, 4) and (N, 3).

        Returns
        -------
        ndarray, shape (N, 3)
            T, on the body axes, which are the sensor's.
        """
        return self._converter.read(self.signal(times_ns, states))

    def signal(self, times_ns: Integers, states: State) -> Array:
        """The next readings before the converter; see `measure`."""
        world_field = self._field
        if self._disturbance is not None:
            world_field = world_field + self._disturbance.field(times_ns)
        field = quaternion.rotate(quaternion.conjugate(states.attitude_xyzw), world_field)
        distorted = apply_tensor(self._soft_iron, field) + self._hard_iron
        signal = np.asarray(distorted + self._noise.take(len(field)))
        if self._faults is None:
            return signal
        return self._faults.disturbed(times_ns, signal + self._faults.bias(times_ns))

    def skip(self, count: int) -> None:
        """Leave out the next readings; of an axis that is stuck the next ones are then not those of `measure`."""
        self._noise.skip(count)
        if self._faults is not None:
            self._faults.skip(count)
