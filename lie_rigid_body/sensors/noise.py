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

from enum import IntEnum, unique
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arrays import Array, Integers

BLOCK: Final = 256
"""Vectors drawn at once when fewer are wanted: to draw one costs almost as much as to draw all of them."""
_WORDS_PER_COUNT: Final = 4
"""Random words that Philox 4×64 makes of one value of its counter."""
_SKIPPED_AT_ONCE: Final = 65_536
"""Vectors of a walk that are drawn together where they are left out, which bounds the memory."""
_HIGHEST_BIT: Final = np.uint64(2**63)
"""Bit of the sign of a double. In a random word it is clear where the uniform number is below ½."""
_ONE: Final = np.float64(1.0).view(np.uint64)
"""Bits of the double 1."""


@unique
class NoiseSource(IntEnum):
    """The sources of noise. The numbers are part of the keys: one that changed would change every recording.

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


class RandomVectors(Protocol):
    """A sequence of random vectors."""

    def draw(self, count: int) -> Array:
        """The next ``count`` vectors, shape (count, 3)."""
        ...

    def skip(self, count: int) -> None:
        """Leave out the next ``count`` vectors."""
        ...


class WhiteNoise:
    """Independent normal vectors of mean 0.

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
        self._key = np.array([seed, source], dtype=np.uint64)
        self._words = np.random.Philox(key=self._key)
        self._taken = 0
        self._sigma = sigma

    def draw(self, count: int) -> Array:
        """The next ``count`` vectors, shape (count, 3)."""
        self._taken += 3 * count
        return self._normal(self._words.random_raw(3 * count)).reshape(count, 3)

    @property
    def sigma(self) -> float:
        """Standard deviation on each axis."""
        return self._sigma

    def skip(self, count: int) -> None:
        """Leave out the next ``count`` vectors. The time that this takes does not depend on ``count``."""
        self._taken += 3 * count
        blocks, rest = divmod(self._taken, _WORDS_PER_COUNT)
        self._words = np.random.Philox(counter=blocks, key=self._key)
        self._words.random_raw(rest)

    def _normal(self, words: NDArray[np.uint64]) -> Array:
        if self._sigma == 0.0:
            return (~words & _HIGHEST_BIT).view(np.float64)  # the zeros have the signs of deviates
        from scipy.special import ndtri  # slow to import: not before there is noise

        numbers = uniform(words)
        return np.multiply(self._sigma, ndtri(numbers, out=numbers), out=numbers)


def uniform(words: NDArray[np.uint64]) -> Array:
    """Numbers (2j + 1) 2⁻⁵³: the midpoints of 2⁵² equal cells, which never are 0 or 1, and lie evenly about ½."""
    numbers = (words >> np.uint64(12) | _ONE).view(np.float64)  # 1 + 2⁻⁵² j
    return np.subtract(numbers, 1.0 - 2.0**-53, out=numbers)


class Draws:
    """Uniform numbers between 0 and 1, four for each whole number from 0 on, in whatever order they are asked for.

    Parameters
    ----------
    seed : int
        Seed from 0 to 2⁶⁴ − 1.
    source : int
    """

    def __init__(self, seed: int, source: int) -> None:
        self._key = np.array([seed, source], dtype=np.uint64)

    def following(self, first: int, count: int) -> Array:
        """Numbers that belong to ``count`` whole numbers from ``first`` on, shape (count, 4)."""
        words = np.random.Philox(counter=first, key=self._key).random_raw(4 * count)
        return uniform(words).reshape(count, 4)

    def of(self, numbers: Integers) -> Array:
        """Numbers that belong to some whole numbers, shape (N, 4)."""
        if not len(numbers):
            return np.empty((0, 4))
        low, high = int(numbers.min()), int(numbers.max())
        if high - low < 4 * len(numbers) + BLOCK:
            return self.following(low, high - low + 1)[numbers - low]
        return np.concatenate([self.following(int(number), 1) for number in numbers])


class RandomWalk:
    """A random walk: a start value plus the cumulative sum of white noise.

    Parameters
    ----------
    start : ndarray, shape (3,)
    steps : WhiteNoise
    """

    def __init__(self, start: Array, steps: WhiteNoise) -> None:
        self._next = start[np.newaxis]
        self._steps = steps

    def draw(self, count: int) -> Array:
        """The next ``count`` vectors, shape (count, 3)."""
        # accumulate adds one step after the other, so that where a block begins changes no bit
        path = np.add.accumulate(np.concatenate([self._next, self._steps.draw(count)]), axis=0)
        self._next = path[count:]
        return path[:count]

    def skip(self, count: int) -> None:
        """Leave out the next ``count`` vectors. Steps have to be drawn for it, unless all of them are 0."""
        if self._steps.sigma == 0.0:
            few = min(count, BLOCK)  # after so many zeros of either sign, their sum is +0
            self.draw(few)
            self._steps.skip(count - few)
            return
        for done in range(0, count, _SKIPPED_AT_ONCE):
            self.draw(min(count - done, _SKIPPED_AT_ONCE))


class BlockBuffer:
    """A buffer of random vectors, drawn in blocks and taken in any number.

    Parameters
    ----------
    vectors : RandomVectors
    """

    def __init__(self, vectors: RandomVectors) -> None:
        self._vectors = vectors
        self._ready = np.empty((0, 3))

    def take(self, count: int) -> Array:
        """The next ``count`` vectors, shape (count, 3)."""
        missing = count - len(self._ready)
        if missing > 0:
            self._ready = np.concatenate([self._ready, self._vectors.draw(max(missing, BLOCK))])
        taken, self._ready = self._ready[:count], self._ready[count:]
        return taken

    def skip(self, count: int) -> None:
        """Leave out the next ``count`` vectors."""
        drawn = min(count, len(self._ready))
        self._ready = self._ready[drawn:]
        if count > drawn:
            self._vectors.skip(count - drawn)
