"""Philox 4×64 with 10 rounds in plain integers, and what this package makes of its words: the referee of the noise."""

from __future__ import annotations

from collections.abc import Iterator

import mpmath

MASK = 2**64 - 1
MULTIPLIERS = (0xD2E7470EE14C6C93, 0xCA5A826395121157)
WEYL = (0x9E3779B97F4A7C15, 0xBB67AE8584CAA73B)


def philox(counter: tuple[int, ...], key: tuple[int, int]) -> tuple[int, int, int, int]:
    """Salmon et al., SC'11, sec. 3.3."""
    c0, c1, c2, c3 = counter
    k0, k1 = key
    for _ in range(10):
        high0, low0 = divmod(MULTIPLIERS[0] * c0, 2**64)
        high1, low1 = divmod(MULTIPLIERS[1] * c2, 2**64)
        c0, c1, c2, c3 = high1 ^ c1 ^ k0, low1, high0 ^ c3 ^ k1, low0
        k0, k1 = (k0 + WEYL[0]) & MASK, (k1 + WEYL[1]) & MASK
    return c0, c1, c2, c3


def words(seed: int, source: int) -> Iterator[int]:
    """The words of a source: NumPy counts up before it draws, so the first counter is 1."""
    counter = 0
    while True:
        counter += 1
        yield from philox((counter, 0, 0, 0), (seed, source))


def normal(word: int) -> mpmath.mpf:
    """The normal deviate of a word: where the distribution reaches (2j + 1) 2⁻⁵³, j being the upper 52 bits."""
    with mpmath.workdps(40):
        probability = mpmath.mpf(2 * (word >> 12) + 1) / 2**53
        return mpmath.sqrt(2) * mpmath.erfinv(2 * probability - 1)
