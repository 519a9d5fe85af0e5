"""A triad of sensitive axes and its errors, the same for gyro and accelerometer."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, cast

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.parameters import Value, Vector, require_at_most, vector
from lie_rigid_body.sensors.noise import BlockBuffer, NoiseSource, RandomWalk, WhiteNoise
from lie_rigid_body.sensors.quantisation import Converter
from lie_rigid_body.sensors.triad_faults import FaultyTriad, TriadFaults
from lie_rigid_body.wording import short_repr

LARGEST_SCALE_FACTOR: Final = 1e6


@dataclass(frozen=True)
class TriadModel:
    """The model of a triad that measures the true quantity x, given in the body frame.

    ::

        y_k = saturate(quantise(S R(μ)ᵀ x_k + b_k + n_k))
        b_(k+1) = b_k + K √(1/f) ν_k,   b_0 = σ₀ ν,   n_k = N √f ν_k

    with f the sample rate and each ν independent and standard normal. The order is the signal's own: the mounting R(μ)
    decides what lies along the sensitive axes, the elements scale it by S, bias and noise add in units of the output,
    as data sheets give them, then the converter counts in steps up to its range. So neither mounting nor scale changes
    the noise, and no reading leaves the range.

    Parameters
    ----------
    noise_density : float
        N, unit/√Hz: the Allan deviation of the white noise is N/√τ (IEEE Std 952).
    bias_random_walk : float
        K, unit/s/√Hz: the Allan deviation of the walk is K √(τ/3) (IEEE Std 952).
    turn_on_bias : float
        σ₀, standard deviation on each axis, unit.
    scale_factor : tuple of float, length 3
        Diagonal of S.
    misalignment : tuple of float, length 3
        μ, the rotation vector whose rotation takes the body's axes to the sensitive axes, rad, in the body frame.
    converter : Converter
    faults : TriadFaults or None
        Their drift is part of b; bursts and spikes are added, and saturate, before the converter.
    """

    noise_density: float
    bias_random_walk: float
    turn_on_bias: float
    scale_factor: Vector
    misalignment: Vector
    converter: Converter
    faults: TriadFaults | None = None

    __repr__ = short_repr

    @classmethod
    def from_values(cls, sensor: str, values: Mapping[str, Value]) -> TriadModel:
        """The model of the parameters whose names begin with ``sensor``, validated.

        Raises
        ------
        ParameterError
        """
        number = {key: cast(float, values[f"{sensor}_{key}"]) for key in _NUMBERS}
        converter = Converter(number.pop("resolution"), number.pop("range"))
        converter.validate(sensor)
        scale, turn = vector(values, f"{sensor}_scale_factor"), vector(values, f"{sensor}_misalignment")
        require_at_most(f"{sensor}_scale_factor", scale, LARGEST_SCALE_FACTOR, "")
        _require_rotation_vector(f"{sensor}_misalignment", turn)
        faults = TriadFaults.from_values(sensor, values)
        return cls(**number, scale_factor=scale, misalignment=turn, converter=converter, faults=faults)

    @property
    def sensitivity(self) -> Array:
        """S R(μ)ᵀ, which takes body components of the truth to the sensor's axes; shape (3, 3)."""
        return np.asarray(np.array(self.scale_factor)[:, np.newaxis] * so3.exp(self.misalignment).T)

    def variance(self, rate: float) -> float:
        """Variance of one reading on each axis at ``rate`` samples per second: white noise and rounding, unit²."""
        return self.noise_density * self.noise_density * rate + self.converter.variance


_NUMBERS: Final = ("noise_density", "bias_random_walk", "turn_on_bias", "resolution", "range")


def _require_rotation_vector(name: str, turn: Vector) -> None:
    angle = float(so3.norm(turn))
    if angle > math.pi:
        raise ParameterError(
            name, f"{list(turn)} turns by {angle:g} rad, more than pi: give the rotation vector of the shorter way"
        )


class Triad:
    """A triad: readings in order.

    Parameters
    ----------
    model : TriadModel
    rate : float
        Samples per second.
    seed : int
    turn_on, walk, white : NoiseSource
        Of its bias at the start, of its bias' steps and of its white noise.
    """

    def __init__(
        self, model: TriadModel, rate: float, seed: int, *, turn_on: NoiseSource, walk: NoiseSource, white: NoiseSource
    ) -> None:
        self._sensitivity = model.sensitivity
        self._converter = model.converter
        start = WhiteNoise(seed, turn_on, model.turn_on_bias).draw(1)[0]
        steps = WhiteNoise(seed, walk, model.bias_random_walk / math.sqrt(rate))
        self._bias = BlockBuffer(RandomWalk(start, steps))
        self._noise = BlockBuffer(WhiteNoise(seed, white, model.noise_density * math.sqrt(rate)))
        self._faults = None if model.faults is None else FaultyTriad(model.faults, rate, model.converter)

    def read(self, times_ns: Integers, truth: Array) -> tuple[Array, Array]:
        """The next readings.

        Parameters
        ----------
        times_ns : ndarray of int64, shape (N,)
            Times since the segment's start, ns.
        truth : ndarray, shape (N, 3)
            In the body frame.

        Returns
        -------
        readings : ndarray, shape (N, 3)
            On the sensor's axes.
        bias : ndarray, shape (N, 3)
            What it adds to them.
        """
        signal, bias = self.signal(times_ns, truth)
        return self._converter.read(signal), bias

    def signal(self, times_ns: Integers, truth: Array) -> tuple[Array, Array]:
        """The same before the converter, with all faults: one that repeats a signal repeats its reading."""
        bias = self._with_drift(times_ns, self._bias.take(len(truth)))
        signal = apply_tensor(self._sensitivity, truth) + bias + self._noise.take(len(truth))
        return signal if self._faults is None else self._faults.disturbed(times_ns, signal), bias

    def bias(self, times_ns: Integers) -> Array:
        """The biases in the next readings, which are left out, shape (N, 3)."""
        self._noise.skip(len(times_ns))
        return self._with_drift(times_ns, self._bias.take(len(times_ns)))

    def _with_drift(self, times_ns: Integers, bias: Array) -> Array:
        return bias if self._faults is None else bias + self._faults.bias(times_ns)

    def skip(self, count: int) -> None:
        """Leave out the next readings; of an axis that is stuck the next ones are then not those of `read`."""
        self._noise.skip(count)
        self._bias.skip(count)
        if self._faults is not None:
            self._faults.skip(count)
