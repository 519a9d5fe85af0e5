"""A triad of sensitive axes and its errors, the same for gyro and accelerometer."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, cast

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.lie import so3
from lie_rigid_body.parameters import Value, Vector, require_at_most, vector
from lie_rigid_body.sensors.noise import BlockBuffer, NoiseSource, RandomWalk, WhiteNoise
from lie_rigid_body.sensors.quantisation import Converter
from lie_rigid_body.sensors.signal import Conditioning, Signal
from lie_rigid_body.sensors.triad_faults import FaultyTriad, TriadFaults
from lie_rigid_body.wording import short_repr

LARGEST_SCALE_FACTOR: Final = 1e6
_WALK: Final = 0.5
"""Roundings of a random walk, as a share of its largest size so far times the square root of the number of its steps:
the sum of so many errors at random, each of the rounding of the sum and of its step's deviate."""
_SKIPPED_AT_ONCE: Final = 65_536
"""Steps of a walk that are drawn at once where its readings are left out."""


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
        start = WhiteNoise(seed, turn_on, model.turn_on_bias).draw(1)[0]
        steps = WhiteNoise(seed, walk, model.bias_random_walk / math.sqrt(rate))
        self._bias = BlockBuffer(RandomWalk(start, steps))
        self._walks = steps.sigma > 0.0
        self._count, self._largest = 0, np.zeros((1, 3))
        self._noise = BlockBuffer(WhiteNoise(seed, white, model.noise_density * math.sqrt(rate)))
        self._converter = model.converter
        self._faults = None if model.faults is None else FaultyTriad(model.faults, rate, model.converter)

    def signals(self, times_ns: Integers, truth: Signal) -> tuple[Signal, Signal]:
        """The next readings before the converter, and the biases in them.

        Parameters
        ----------
        times_ns : ndarray of int64, shape (N,)
            Times since the segment's start, ns.
        truth : Signal
            The true quantity in the body frame, shape (N, 3).

        Returns
        -------
        readings : Signal
            On the sensor's axes, with all faults.
        bias : Signal
            What it adds to them.
        """
        bias = self._next_bias(len(times_ns))
        if self._faults is not None:
            bias = bias.plus(self._faults.drift(times_ns))
        signal = truth.through(self._sensitivity).plus(bias.values, lambda: bias.conditioning().size)
        signal = replace(signal.plus(self._noise.take(len(times_ns))), converter=self._converter)
        return (signal if self._faults is None else self._faults.disturbed(times_ns, signal)), bias

    def _next_bias(self, count: int) -> Signal:
        """The next biases without their drift: a walk of k steps carries √k roundings of its largest size so far."""
        values, largest, number = self._bias.take(count), self._largest, self._count
        self._count += count

        def conditioning() -> Conditioning:
            sizes = np.abs(values)
            if not self._walks:
                return Conditioning(np.stack([sizes, *np.zeros((2, *sizes.shape))]))
            so_far = np.maximum.accumulate(np.concatenate([largest, sizes]), axis=0)[1:]
            steps = np.arange(number, number + count, dtype=np.float64)[:, np.newaxis]
            return Conditioning(np.stack([sizes + _WALK * np.sqrt(steps) * so_far, *np.zeros((2, *sizes.shape))]))

        if self._walks and count:
            self._largest = np.maximum(largest, np.abs(values).max(axis=0))
        return Signal(values, condition=conditioning)

    def skip(self, count: int) -> None:
        """Leave out the next readings; of an axis that is stuck the next ones are then not those of `signals`."""
        self._noise.skip(count)
        if not self._walks:
            self._bias.skip(count)
        for done in range(0, count if self._walks else 0, _SKIPPED_AT_ONCE):
            self._next_bias(min(count - done, _SKIPPED_AT_ONCE))
        if self._faults is not None:
            self._faults.skip(count)
