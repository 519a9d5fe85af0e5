"""Sums of harmonics, and their derivatives, at any time of 64-bit nanoseconds, to the same bits on every machine.

Frequencies are multiples of 2⁻²⁰ Hz, so that a phase at a whole nanosecond is a whole number of 1/(2²⁰ 10⁹) turns, and
is reduced in integers. Near a time, the sum is its own Taylor polynomial about the nearest node of an even grid. A node
costs as much as the sines of all harmonics, a time near it one polynomial.
"""

from __future__ import annotations

import math
from functools import reduce
from typing import Final

import numpy as np

from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import NS, Vector
from lie_rigid_body.motion.mass_centre import MassCentre

HARMONICS: Final = 16
"""Number of harmonics on each axis."""
STEPS_PER_HZ: Final = 2**20
"""Frequencies are whole numbers of 1/2²⁰ Hz."""
_TURN: Final = STEPS_PER_HZ * NS
"""A turn in the unit of phases, 1/(2²⁰ 10⁹) turns."""
_ORDER: Final = 16
"""Order of the polynomials: within ½ rad of a node the next term of the second derivative is below 2e-17."""
_SPAN: Final = 0.5
"""Largest phase, rad, from a node to a time near it."""
_AT_ONCE: Final = 1024
"""Number of samples whose polynomials are evaluated at once."""
_RADIANS: Final = 2.0 * math.pi


class Harmonics:
    """Sixteen cosines on each of three axes, as an acceleration, with the velocity and the position that belong to it.

    Parameters
    ----------
    rms : sequence of float, length 3
        Root mean square of the acceleration on each axis, m/s².
    band : sequence of float, length 2
        Lowest and highest frequency, Hz.
    numbers : ndarray, shape (3, 2, 16)
        Uniform numbers between 0 and 1: those of the frequencies and those of the phases.

    Attributes
    ----------
    frequency_hz, amplitude, phase : ndarray, shape (3, 16)
        Hz, m/s² and rad: the acceleration is the sum of amplitude cos(2π frequency t + phase).
    """

    def __init__(self, rms: Vector, band: Vector, numbers: Array) -> None:
        low, high = band
        steps = np.rint(STEPS_PER_HZ * (low + (high - low) * numbers[:, 0]))
        least = math.ceil(STEPS_PER_HZ * low)
        most = max(least, math.floor(STEPS_PER_HZ * high))
        self._steps = np.clip(steps, least, most).astype(np.int64)
        self.frequency_hz = self._steps / STEPS_PER_HZ
        self.amplitude = np.repeat(np.array(rms)[:, np.newaxis], HARMONICS, axis=1) * math.sqrt(2.0 / HARMONICS)
        self._turns = numbers[:, 1]
        self.phase = _RADIANS * self._turns
        for array in (self.frequency_hz, self.amplitude, self.phase):
            array.setflags(write=False)
        fastest = _RADIANS * float(self.frequency_hz.max()) / NS
        # a power of two, ns, of at most 1 rad of the fastest
        self._spacing = 2 ** max(0, math.floor(math.log2(2.0 * _SPAN / fastest)))
        self._coefficients = _coefficients(self.amplitude, _RADIANS * self.frequency_hz)

    def at(self, t_ns: Integers, beyond_ns: Array | float = 0.0) -> MassCentre:
        """The position, m, velocity, m/s, and acceleration, m/s², at N times of the harmonics.

        Parameters
        ----------
        t_ns : ndarray of int64, shape (N,)
            Whole nanoseconds.
        beyond_ns : float or ndarray, shape (N,), optional
            What the times are later, ns.
        """
        whole = np.floor(beyond_ns)
        t_ns = t_ns + whole.astype(np.int64)
        nodes = (t_ns + self._spacing // 2) // self._spacing
        seconds = ((t_ns - nodes * self._spacing) + (beyond_ns - whole)) * 1e-9
        nodes, places = np.unique(nodes, return_inverse=True)
        return _evaluate(self._polynomials(nodes * self._spacing), places, seconds)

    def _polynomials(self, nodes_ns: Integers) -> Array:
        """Coefficients of the position's Taylor polynomials about M times, by rising powers, shape (17, 3, M)."""
        # the phase in whole units, reduced modulo a turn: the wrapped products differ by what is small, and so exactly
        turns = np.rint(self._steps * (nodes_ns[:, np.newaxis, np.newaxis] / _TURN)).astype(np.int64)
        units = self._steps * nodes_ns[:, np.newaxis, np.newaxis] - turns * _TURN
        phases = units / _TURN + self._turns
        sine, cosine = sine_cosine((phases - np.rint(phases), np.zeros_like(phases)))
        derivatives = (cosine, -sine, -cosine, sine)
        terms = (scale * derivatives[power % 4] for power, scale in enumerate(self._coefficients))
        # one term after the other: libraries differ in the order of their sums
        return np.stack([reduce(np.add, each.T) for each in terms])


def _coefficients(amplitude: Array, angular_frequency: Array) -> list[Array]:
    """Factors of the derivatives of the cosine in the position's Taylor polynomial: −a ω^(n−2) / n!."""
    scales = [-amplitude / angular_frequency**2]
    for power in range(1, _ORDER + 1):
        scales.append(scales[-1] * angular_frequency / power)
    return scales


def _evaluate(polynomials: Array, places: Integers, seconds: Array) -> MassCentre:
    """Polynomials and their first two derivatives by Horner's scheme; some samples at once, as caches are small."""
    found = np.empty((3, len(places), 3))
    for begin in range(0, len(places), _AT_ONCE):
        some = slice(begin, begin + _AT_ONCE)
        *lower, value = polynomials.take(places[some], axis=2)
        rate = np.zeros_like(value)
        half = np.zeros_like(value)
        x = seconds[some]
        for coefficient in reversed(lower):
            half *= x
            half += rate
            rate *= x
            rate += value
            value *= x
            value += coefficient
        found[:, some] = value.T, rate.T, 2.0 * half.T
    return MassCentre(*found)
