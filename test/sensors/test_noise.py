"""The noise: words and deviates as an independent generator makes them, white, and the same in batches of any size."""

from __future__ import annotations

from itertools import islice

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_noise import normal, philox, words

from lie_rigid_body.sensors.noise import NoiseSource, RandomWalk, WhiteNoise, uniform

COUNT = 100_000
FIVE_SIGMA = 5.0 / np.sqrt(COUNT)
# digits of pi, as in the known answers of the generator's authors
PI_COUNTER = (0x243F6A8885A308D3, 0x13198A2E03707344, 0xA4093822299F31D0, 0x082EFA98EC4E6C89)
PI_KEY = (0x452821E638D01377, 0xBE5466CF34E90C6C)


def white(source: NoiseSource = NoiseSource.GYRO_WHITE, seed: int = 3, sigma: float = 1.0) -> WhiteNoise:
    return WhiteNoise(seed, source, sigma)


@pytest.mark.parametrize(
    ("counter", "key", "answer"),
    [
        ((0,) * 4, (0, 0), "16554d9eca36314c db20fe9d672d0fdc d7e772cee186176b 7e68b68aec7ba23b"),
        ((2**64 - 1,) * 4, (2**64 - 1,) * 2, "87b092c3013fe90b 438c3c67be8d0224 9cc7d7c69cd777b6 a09caebf594f0ba0"),
        (PI_COUNTER, PI_KEY, "a528f45403e61d95 38c72dbd566e9788 a5a1610e72fd18b5 57bd43b5e52b7fe6"),
    ],
)
def test_the_reference_gives_the_known_answers(counter: tuple[int, ...], key: tuple[int, int], answer: str) -> None:
    assert " ".join(f"{word:016x}" for word in philox(counter, key)) == answer


FIRST_WORDS = "7b6cc7b1862cc5f2 b960f2ea4b3f8d9f 0cdd72e015deb1a6 50edb0d22a6a6fd5 ae45891bf7ab4df3"


def test_the_first_words_are_these_for_ever() -> None:
    """Written out, so that what is recorded today can be recorded again: other words would break every seed."""
    assert " ".join(f"{word:016x}" for word in islice(words(7, NoiseSource.GYRO_WHITE), 5)) == FIRST_WORDS
    raw = np.random.Philox(key=np.array([7, NoiseSource.GYRO_WHITE], dtype=np.uint64)).random_raw(5)
    assert " ".join(f"{word:016x}" for word in raw.tolist()) == FIRST_WORDS


def test_source_numbers_are_these_for_ever() -> None:
    names = [
        *("GYRO_TURN_ON", "GYRO_WALK", "GYRO_WHITE"),
        *("ACCELEROMETER_TURN_ON", "ACCELEROMETER_WALK", "ACCELEROMETER_WHITE"),
        *("MAGNETOMETER_WHITE", "ORIENTATION_WHITE", "ATTITUDE_SENSOR_WHITE", "SUN_SENSOR_WHITE"),
        *("SWAY", "VIBRATION", "KICKS"),
    ]
    assert [(source.name, int(source)) for source in NoiseSource] == [*zip(names, range(1, 14), strict=True)]


@pytest.mark.parametrize("seed", [0, 1, 7, 2**63 - 1])
@pytest.mark.parametrize("source", NoiseSource)
def test_deviates_are_the_inverse_normal_of_the_words(seed: int, source: NoiseSource) -> None:
    drawn = white(source, seed).draw(0, 6).ravel()
    for ours, word in zip(drawn.tolist(), words(seed, source), strict=False):
        assert abs(mpmath.mpf(ours) - normal(word)) < 2e-15 * max(1.0, abs(ours))


def test_uniform_numbers_are_exact_and_never_reach_the_ends() -> None:
    ends = uniform(np.array([0, 2**64 - 1, 2**63, 2**63 - 1], dtype=np.uint64))
    assert ends.tolist() == [2.0**-53, 1.0 - 2.0**-53, 0.5 + 2.0**-53, 0.5 - 2.0**-53]


@given(st.lists(st.tuples(st.integers(0, 70), st.integers(0, 700)), max_size=6), st.sampled_from([0.0, 0.01]))
def test_batches_of_any_size_give_the_same_bits_wherever_they_begin(parts: list[tuple[int, int]], sigma: float) -> None:
    start = np.array([0.1, -3.0, 1e9])
    noise, walk, at = white(sigma=sigma), RandomWalk(start, white(sigma=sigma)), 0
    vectors = white(sigma=sigma).draw(0, 5000)
    values = RandomWalk(start, white(sigma=sigma)).values(0, 5000)
    for left_out, count in parts:
        rows = slice(at + left_out, at + left_out + count)
        assert noise.draw(rows.start, count).tobytes() == vectors[rows].tobytes()
        assert walk.values(at, left_out + count).tobytes() == values[at : rows.stop].tobytes()
        at = rows.stop
    assert noise.draw(7, 3).tobytes() == vectors[7:10].tobytes()  # also once more


def test_a_walk_adds_one_step_after_the_other() -> None:
    steps = white(sigma=0.3).draw(0, 1000).tolist()
    at = [0.1, 0.2, 0.3]
    path = []
    for step in steps:
        path.append(at)
        at = [a + s for a, s in zip(at, step, strict=True)]
    assert RandomWalk(np.array([0.1, 0.2, 0.3]), white(sigma=0.3)).values(0, 1000).tolist() == path


def test_axes_sources_and_seeds_are_independent() -> None:
    columns = [white(source, seed).draw(0, COUNT) for source in NoiseSource for seed in (0, 1, 2**62)]
    correlation = np.atleast_2d(np.corrcoef(np.concatenate(columns, axis=1), rowvar=False))
    assert np.abs(correlation - np.eye(len(correlation))).max() < 1.2 * FIVE_SIGMA  # the largest of 1953 numbers
    squares = np.atleast_2d(np.corrcoef(np.concatenate(columns, axis=1) ** 2, rowvar=False))
    assert np.abs(squares - np.eye(len(squares))).max() < 1.2 * FIVE_SIGMA
