"""A triad of sensitive axes, its errors and its faults, the same for gyro and accelerometer."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.parameters import Vector, require_at_most
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import so3, vectors
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.sensors.fault import AXES, Fault, FaultModel, IntermittentFault, nanoseconds, stream
from lie_rigid_body.sensors.noise import NoiseSource, RandomWalk, WhiteNoise
from lie_rigid_body.sensors.parameters import Values, values_of
from lie_rigid_body.sensors.signal import Converter, Signal


@short_dataclass
class TriadFaults(FaultModel):
    """The faults of a triad.

    Parameters
    ----------
    sensor, seed, window
        See `FaultModel`.
    spike_probability : float
        Probability that a reading has a spike, on one axis.
    spike_size : float
        Size of a spike, unit of the reading; its sign is drawn.
    noise_burst : IntermittentFault or None
        Episodes with more white noise.
    noise_burst_density : float
        Noise density in a burst, unit/√Hz.
    stuck : IntermittentFault or None
        Episodes in which an axis repeats what it read before.
    saturation : IntermittentFault or None
        Episodes in which the readings saturate at a lower level.
    saturation_level : float
        Largest magnitude in an episode of saturation, unit. Readings are multiples of the resolution up to it, within
        round-off.
    temperature_drift : float
        Standard deviation of the change of the bias on each axis, unit.
    temperature_drift_duration : float
        Time in which the bias changes evenly, from the begin of the window on, s.
    """

    spike_probability: float
    spike_size: float
    noise_burst: IntermittentFault | None
    noise_burst_density: float
    stuck: IntermittentFault | None
    saturation: IntermittentFault | None
    saturation_level: float
    temperature_drift: float
    temperature_drift_duration: float

    switches = (
        "spike_probability",
        "noise_burst_interval",
        "stuck_interval",
        "saturation_interval",
        "temperature_drift",
    )
    intermittent_kinds = ("noise_burst", "stuck", "saturation")

    @cached_property
    def drifted(self) -> Array:
        """The whole change of the bias with temperature on each axis, unit, shape (3,)."""
        noise = WhiteNoise(self.seed, stream(self.sensor, "temperature_drift"), self.temperature_drift)
        return noise.draw(0, 1).reshape(3)

    def drift(self, times_ns: Integers) -> Array:
        """Change of the bias with temperature at some times since the segment's start, unit, shape (N, 3)."""
        age = times_ns - self.window.begin_ns
        duration = nanoseconds(self.temperature_drift_duration)
        share = np.clip(age / duration, 0.0, 1.0) if duration else np.where(age >= 0, 1.0, 0.0)
        return share[:, np.newaxis] * self.drifted

    def spikes(self, first: int, times_ns: Integers) -> Array:
        """Spikes in some readings, shape (N, 3), unit; see `TransportFaults.lost` for the arguments."""
        spikes = np.zeros((len(times_ns), 3))
        if self.spike_probability:
            drawn = self.draws("spike").following(first, len(times_ns))
            hit = np.flatnonzero((drawn[:, 0] < self.spike_probability) & self.window.holds(times_ns))
            spikes[hit, axis_of(drawn[hit, 1])] = np.where(drawn[hit, 2] < 0.5, -self.spike_size, self.spike_size)
        return spikes

    def faults(self, begin_ns: int, end_ns: int, first: int, times_ns: Integers) -> Iterator[Fault]:
        """Faults that begin in a stretch of time; see `FaultModel`."""
        start = self.window.begin_ns
        if self.temperature_drift and begin_ns <= start < end_ns:
            end = start + nanoseconds(self.temperature_drift_duration)
            for axis, size in zip(AXES, self.drifted.tolist(), strict=True):
                yield Fault("temperature_drift", self.sensor, axis, start, end, size)
        spikes = self.spikes(first, times_ns)
        for row, column in np.argwhere(spikes).tolist():
            time = int(times_ns[row])
            yield Fault("spike", self.sensor, AXES[column], time, time, float(spikes[row, column]))
        for episodes, size in (
            (self.noise_burst, self.noise_burst_density),
            (self.stuck, None),
            (self.saturation, self.saturation_level),
        ):
            if episodes is not None:
                for number, begin, end in episodes.between(begin_ns, end_ns):
                    axis = AXES[stuck_axes(episodes, np.array([number]))[0]] if episodes is self.stuck else ""
                    yield Fault(episodes.kind, self.sensor, axis, begin, end, size)


def axis_of(drawn: Array) -> Integers:
    """The axis, from 0 to 2, of each number that is uniform between 0 and 1."""
    return (3.0 * drawn).astype(np.int64)


def stuck_axes(stuck: IntermittentFault, numbers: Integers) -> Integers:
    """The axis, from 0 to 2, that is stuck in each of some episodes."""
    return axis_of(stuck.draws(np.maximum(numbers, 0))[:, 1])


def linear_errors(*, scale: float = 0.0, misalignment: float = 0.0, matrix: float = 0.0) -> Array:
    """Matrices L_i of the errors of three axes: a reading of x has the error Σ θ_i L_i x, to first order.

    The θ_i are constants of a sensor, one for each matrix, in units of their standard deviations.

    Parameters
    ----------
    scale, misalignment : float
        Standard deviation of each scale factor, and of each component of the rotation vector of the mounting, rad.
    matrix : float
        Standard deviation of each entry of a matrix, such as that of soft iron.

    Returns
    -------
    ndarray, shape (c, 3, 3)
        Those whose standard deviation is not 0.
    """
    axes = np.eye(3)
    entries = np.eye(9).reshape(9, 3, 3)
    sizes = ((scale, axes[:, :, np.newaxis] * axes[:, np.newaxis]), (misalignment, so3.hat(axes)), (matrix, entries))
    return np.concatenate([size * kind for size, kind in sizes if size] or [np.zeros((0, 3, 3))])


class TriadFaultInjector:
    """The faults of three axes at work, on readings in order.

    Parameters
    ----------
    model : TriadFaults
    rate : float
        Readings per second.
    converter : Converter
        What makes readings of the signal.
    """

    def __init__(self, model: TriadFaults, rate: float, converter: Converter) -> None:
        self._model = model
        self._converter = converter
        sigma = model.noise_burst_density * math.sqrt(rate)
        self._burst = WhiteNoise(model.seed, stream(model.sensor, "noise_burst", 1), sigma)
        self._last: Array | None = None

    def disturbed(self, first: int, times_ns: Integers, signal: Array) -> Array:
        """The signal of readings with bursts, spikes, saturation and what is stuck, shape (N, 3)."""
        model = self._model
        count = len(times_ns)
        if model.noise_burst is not None:
            inside = model.noise_burst.at(times_ns)[:, np.newaxis] >= 0
            signal = signal + np.where(inside, self._burst.draw(first, count), 0.0)
        signal = signal + model.spikes(first, times_ns)
        if model.saturation is not None:
            inside = model.saturation.at(times_ns)[:, np.newaxis] >= 0
            signal = np.where(inside, self._converter.limited(signal, model.saturation_level), signal)
        return signal if model.stuck is None or not count else self._held(model.stuck, times_ns, signal)

    def _held(self, stuck: IntermittentFault, times_ns: Integers, signal: Array) -> Array:
        """The signal that repeats, on a stuck axis, that of the reading before: so whatever the converter."""
        before = signal[:1] if self._last is None else self._last
        numbers = stuck.at(times_ns)
        axes = stuck_axes(stuck, numbers)
        rows = np.repeat(np.arange(len(times_ns))[:, np.newaxis], 3, axis=1)
        for number in np.unique(numbers[numbers >= 0]):
            inside = np.flatnonzero(numbers == number)
            axis = axes[inside[0]]
            rows[inside, axis] = rows[inside[0] - 1, axis] if inside[0] else -1
        held = np.take_along_axis(np.concatenate([before, signal]), rows + 1, axis=0)
        self._last = held[-1:].copy()
        return held


@short_dataclass
class TriadModel:
    """The model of a triad that measures the true quantity x, given in the body frame.

    ::

        y_k = saturate(quantise(S R(μ)ᵀ x_k + b_k + n_k))
        b_(k+1) = b_k + K √(1/f) ν_k,   b_0 = σ₀ ν,   n_k = N √f ν_k

    with f the sample rate and each ν independent and standard normal. The order is the signal's own. The mounting R(μ)
    decides what lies along the sensitive axes, the elements scale it by S, bias and noise add in units of the output,
    as data sheets give them. Then the converter counts in steps up to its range. So neither mounting nor scale changes
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

    @classmethod
    def from_values(cls, sensor: str, values: Values) -> TriadModel:
        """The model of the parameters whose names begin with ``sensor``, validated.

        Raises
        ------
        ParameterError
        """
        found = cls(
            **values_of(cls, sensor, values),
            converter=Converter.from_values(sensor, values),
            faults=TriadFaults.from_values(sensor, values),
        )
        require_at_most(f"{sensor}_scale_factor", found.scale_factor, 1e6, "")
        angle = vectors.norm(found.misalignment)
        if angle > math.pi:
            raise ParameterError(
                f"{sensor}_misalignment",
                f"{list(found.misalignment)} turns by {angle:g} rad, more than pi: give the rotation vector of the "
                "shorter way",
            )
        return found

    @property
    def sensitivity(self) -> Array:
        """S R(μ)ᵀ, which takes body components of the truth to the sensor's axes; shape (3, 3)."""
        return np.array(self.scale_factor)[:, np.newaxis] * so3.exp(self.misalignment).T

    @property
    def linear_errors(self) -> Array:
        """Errors of scale and mounting that no estimator knows, as large as the largest that is declared."""
        scale = np.abs(np.subtract(self.scale_factor, 1.0)).max()
        return linear_errors(scale=scale, misalignment=max(map(abs, self.misalignment)))

    def variance(self, rate: float) -> float:
        """Variance of one reading on each axis at ``rate`` samples per second: white noise and rounding, unit²."""
        return self.noise_density * self.noise_density * rate + self.converter.variance


class Triad:
    """A triad: readings in order.

    Parameters
    ----------
    model : TriadModel
    rate : float
        Samples per second.
    seed : int
    turn_on, walk, white : NoiseSource
        Of its bias at the start, its bias' steps and its white noise.
    """

    def __init__(
        self,
        model: TriadModel,
        rate: float,
        seed: int,
        turn_on: NoiseSource,
        walk: NoiseSource,
        white: NoiseSource,
    ) -> None:
        start = WhiteNoise(seed, turn_on, model.turn_on_bias).draw(0, 1)[0]
        self._bias = RandomWalk(start, WhiteNoise(seed, walk, model.bias_random_walk / math.sqrt(rate)))
        self._noise = WhiteNoise(seed, white, model.noise_density * math.sqrt(rate))
        self._model = model
        self._sensitivity = model.sensitivity
        self._faulty = None if model.faults is None else TriadFaultInjector(model.faults, rate, model.converter)

    def signals(self, first: int, times_ns: Integers, truth: Array, interval: float = 0.0) -> tuple[Signal, Signal]:
        """Readings before the converter, and the biases in them; see `Instrument.signals`.

        Parameters
        ----------
        first : int
        times_ns : ndarray of int64, shape (N,)
        truth : ndarray, shape (N, 3)
            The true quantity in the body frame.
        interval : float, optional
            Time over which it is a mean, s.

        Returns
        -------
        readings : Signal
            On the sensor's axes, with all faults.
        bias : Signal
            What it adds to them.
        """
        bias = self._bias.values(first, len(times_ns))
        if self._model.faults is not None:
            bias = bias + self._model.faults.drift(times_ns)
        signal = apply_tensor(self._sensitivity, truth) + bias + self._noise.draw(first, len(times_ns))
        if self._faulty is not None:
            signal = self._faulty.disturbed(first, times_ns, signal)
        return Signal(signal, self._model.converter, interval), Signal(bias)
