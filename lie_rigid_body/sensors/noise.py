"""Reproducible noise: for each source a sequence of random vectors that depends on the seed alone.

Each source has a counter-based generator of its own, Philox 4×64 with 10 rounds, under the key (seed, source). So no
source moves another, whichever are in use and in whatever order they are read. A normal deviate is the inverse of the
normal distribution at one uniform number, made of one raw word. Nothing is rejected, so sample k always has the words
3k, 3k + 1 and 3k + 2, however many are drawn at once. Raw words are the same in every version of NumPy, while its own
normal deviates may change (NEP 19).

References
----------
J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC'11 (2011).
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import Vector
from lie_rigid_body.motion.harmonics import HARMONICS, Harmonics

_FEW: Final = 256
"""Largest number of random numbers that are drawn and not used; beyond it the counter of the generator is set."""
_WORDS_PER_COUNT: Final = 4
"""Random words that Philox 4×64 makes of one value of its counter."""
_ONE: Final = np.float64(1.0).view(np.uint64)
"""Bits of the double 1."""


class NoiseSource(IntEnum):
    """The sources of noise. The numbers are part of the keys: a new one comes last, or every recording would change.

    Sources of faults have numbers above 255; see `fault.stream`.
    """

    GYRO_TURN_ON = 1
    GYRO_WALK = 2
    GYRO_WHITE = 3
    ACCELEROMETER_TURN_ON = 4
    ACCELEROMETER_WALK = 5
    ACCELEROMETER_WHITE = 6
    MAGNETOMETER_WHITE = 7
    ORIENTATION_WHITE = 8
    ATTITUDE_SENSOR_WHITE = 9
    SUN_SENSOR_WHITE = 10
    SWAY = 11
    VIBRATION = 12
    KICKS = 13


class Draws:
    """Uniform numbers between 0 and 1, so many for each whole number from 0 on, in whatever order they are asked for.

    Parameters
    ----------
    seed : int
        Seed from 0 to 2⁶⁴ − 1.
    source : int
        A `NoiseSource`, or the stream of a fault.
    width : int, optional
        How many belong to each whole number.
    """

    def __init__(self, seed: int, source: int, width: int = _WORDS_PER_COUNT) -> None:
        self._key = np.array([seed, source], dtype=np.uint64)
        self._width = width
        self._words = np.random.Philox(key=self._key)
        self._taken = 0

    def following(self, first: int, count: int) -> Array:
        """Numbers that belong to ``count`` whole numbers from ``first`` on, shape (count, width)."""
        begin = self._width * first
        if begin != self._taken:  # to set a generator to a place takes as long as to draw 1000 words
            blocks, rest = divmod(begin, _WORDS_PER_COUNT)
            self._words = np.random.Philox(counter=blocks, key=self._key)
            self._words.random_raw(rest)
        self._taken = begin + self._width * count
        return uniform(self._words.random_raw(self._width * count)).reshape(count, self._width)

    def of(self, numbers: Integers) -> Array:
        """Numbers that belong to some whole numbers, shape (N, width)."""
        if not len(numbers):
            return np.empty((0, self._width))
        low = int(numbers.min())
        high = int(numbers.max())
        if high - low < 4 * len(numbers) + _FEW:
            return self.following(low, high - low + 1)[numbers - low]
        return np.concatenate([self.following(int(number), 1) for number in numbers])


def uniform(words: NDArray[np.uint64]) -> Array:
    """Numbers (2j + 1) 2⁻⁵³: the midpoints of 2⁵² equal cells, which never are 0 or 1, and lie evenly about ½."""
    numbers = (words >> np.uint64(12) | _ONE).view(np.float64)  # 1 + 2⁻⁵² j
    return np.subtract(numbers, 1.0 - 2.0**-53, out=numbers)


def harmonics(seed: int, source: NoiseSource, rms: Vector, band: Vector) -> Harmonics:
    """Draw the frequencies and phases of a sum of harmonics; see `Harmonics`."""
    numbers = Draws(seed, source, width=2 * HARMONICS).following(0, 3)
    return Harmonics(rms, band, numbers.reshape(3, 2, HARMONICS))


class WhiteNoise:
    """Independent normal vectors of mean 0, one for each whole number from 0 on.

    Parameters
    ----------
    seed : int
        Seed from 0 to 2⁶⁴ − 1.
    source : int
        A `NoiseSource`, or the stream of a fault.
    sigma : float
        Standard deviation on each axis.
    """

    def __init__(self, seed: int, source: int, sigma: float) -> None:
        self.sigma = sigma
        self._draws = Draws(seed, source, width=3)

    def draw(self, first: int, count: int) -> Array:
        """The vectors of ``count`` whole numbers from ``first`` on, shape (count, 3)."""
        if self.sigma == 0.0:
            return np.zeros((count, 3))
        from scipy.special import ndtri  # slow to import: not before there is noise

        numbers = self._draws.following(first, count)
        return np.multiply(self.sigma, ndtri(numbers, out=numbers), out=numbers)


class RandomWalk:
    """A random walk: a start value plus the cumulative sum of white noise.

    Parameters
    ----------
    start : ndarray, shape (3,)
    steps : WhiteNoise
    """

    def __init__(self, start: Array, steps: WhiteNoise) -> None:
        self._steps = steps
        self._next = start[np.newaxis]

    def values(self, first: int, count: int) -> Array:
        """The values from number ``first`` on, shape (count, 3); it follows the last one of the call before."""
        steps = self._steps.draw(first, count)
        # accumulate adds one step after the other, so that where a block begins changes no bit
        path = np.add.accumulate(np.concatenate([self._next, steps]), axis=0)
        self._next = path[count:]
        return path[:count]
