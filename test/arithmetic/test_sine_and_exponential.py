"""The closed form's own sines and exponentials against mpmath, and their bits on floats and on arrays."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.arithmetic.elementary import exponential, sine_cosine
from lie_rigid_body.arithmetic.numbers import at_most, power_of_two, sqrt

RANDOM = np.random.default_rng(8)


def beside(points: np.ndarray) -> np.ndarray:
    """The points, and what lies a few doubles and more to both sides of them."""
    steps = np.concatenate([[0.0], np.geomspace(1e-17, 1e-3, 15)])
    near = [points, np.nextafter(points, -9.0), np.nextafter(points, 9.0)]
    return np.concatenate([*near, *(points + s for s in steps), *(points - s for s in steps)])


# the quarters and, between them, the switches from one to the next
EIGHTHS = np.arange(-4, 5) / 8.0
TINY = np.concatenate([np.geomspace(1e-300, 1e-3, 300), -np.geomspace(5e-324, 1e-3, 40), [0.0]])
TURNS = np.concatenate([RANDOM.uniform(-0.5, 0.5, 2000), np.clip(beside(EIGHTHS), -0.5, 0.5), TINY])
# half a double of the turns, to either side, and none
RESTS: np.ndarray = np.spacing(TURNS) * RANDOM.choice([-0.5, 0.0, 0.5, 0.3], len(TURNS))


def sizes() -> np.ndarray:
    """From 0 to where nothing is left, and beside the switches at odd multiples of ½ ln 2."""
    switches = (np.arange(1, 2160, 53) + 0.0) * (0.5 * math.log(2.0))
    found = np.concatenate([RANDOM.uniform(0.0, 2.0, 800), RANDOM.uniform(0.0, 745.0, 800), beside(switches), TINY])
    return found[found >= 0.0]


def pairs(hi: np.ndarray, lo: np.ndarray) -> list[DoubleDouble]:
    return [(h, r) for h, r in zip(hi.tolist(), lo.tolist(), strict=True)]


def test_sine_and_cosine_are_right_to_a_unit_in_the_last_place():
    s, c = sine_cosine((TURNS, RESTS))
    with mp.workdps(60):
        for turns, *found in zip(pairs(TURNS, RESTS), np.ravel(s).tolist(), np.ravel(c).tolist(), strict=True):
            angle = 2 * (mpf(turns[0]) + mpf(turns[1]))
            for value, truth in zip(found, (mp.sinpi(angle), mp.cospi(angle)), strict=True):
                assert abs(mpf(value) - truth) <= 2.0**-53 * max(abs(truth), mpf(2) ** -1000) * mpf("1.07"), turns


def test_sine_and_cosine_of_whole_quarters_are_exact():
    quarters = np.arange(-2, 3)
    s, c = sine_cosine((quarters / 4.0, np.zeros(5)))
    np.testing.assert_array_equal(s, [0.0, -1.0, 0.0, 1.0, 0.0])
    np.testing.assert_array_equal(c, [-1.0, 0.0, 1.0, 0.0, -1.0])


@pytest.mark.long
def test_the_exponential_is_right_to_a_unit_in_the_last_place():
    x = sizes()
    decay, fall = exponential(x)
    # below 2⁻¹⁰²² doubles are farther apart
    share, least = 1.6 * 2.0**-53, mpf(2) ** -1073
    with mp.workdps(60):
        for size, d, f in zip(x.tolist(), np.ravel(decay).tolist(), np.ravel(fall).tolist(), strict=True):
            exp, expm1 = mp.exp(-mpf(size)), mp.expm1(-mpf(size))
            assert abs(mpf(d) - exp) <= share * exp + least, size
            assert abs(mpf(f) - expm1) <= share * -expm1 + least, size


@pytest.mark.parametrize("size", [750.0, 801.0, 1e10, 1e300, math.inf])
def test_the_exponential_vanishes_far_away(size: float):
    assert exponential(size) == (0.0, -1.0)
    np.testing.assert_array_equal(exponential(np.array([size])), [[0.0], [-1.0]])


@pytest.mark.parametrize("k", [-1022, -1021, -512, -53, -1, 0])
def test_powers_of_two_are_exact(k: int):
    assert power_of_two(float(k)) == 2.0**k
    assert power_of_two(np.array([float(k)])) == [2.0**k]


def test_whole_numbers_are_numbers_of_one_time():
    """Whatever Python or NumPy calls them, they are no arrays."""
    four: Any
    for four in (4, 4.0, np.float64(4.0), np.int64(4)):
        assert (type(sqrt(four)), sqrt(four), power_of_two(-four)) == (float, 2.0, 0.0625)
        assert not isinstance(at_most(four, 3.0), np.ndarray)


def sines(x: np.ndarray, rest: np.ndarray, out: Any) -> None:
    for i in range(len(x)):
        out[0, i], out[1, i] = sine_cosine((x[i], rest[i]))


def exponentials(x: np.ndarray, _: np.ndarray, out: Any) -> None:
    for i in range(len(x)):
        out[0, i], out[1, i] = exponential(x[i])


def on_floats(loop: Callable[..., None], x: np.ndarray, rest: np.ndarray) -> np.ndarray:
    out = np.empty((2, len(x)))
    loop(x.tolist(), rest.tolist(), out)
    return out


def test_floats_and_arrays_give_the_same_bits():
    np.testing.assert_array_equal(on_floats(sines, TURNS, RESTS), sine_cosine((TURNS, RESTS)))
    x = sizes()
    np.testing.assert_array_equal(on_floats(exponentials, x, x), exponential(x))


MOTION = """
import hashlib
from decimal import Context, ROUND_UP, setcontext
context = Context(prec=2, Emax=9, Emin=-9, rounding=ROUND_UP, clamp=1)
for signal in context.traps:
    context.traps[signal] = True
if {is_own}:
    setcontext(context)
import numpy as np
from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
body, start = RigidBody([1.0, 2.0, 3.0]), State([0.0, 0.0, 0.0, 1.0], [0.01, 1.0, 0.01])
for motion in (ClosedForm(body, start), MovingChart(body, start)):
    print(hashlib.sha256(motion.at(np.arange(0, 20 * 10**9, 10**7)).attitude_xyzw.tobytes()).hexdigest())
"""


def test_the_decimal_context_of_whoever_imports_the_package_changes_no_bit() -> None:
    usual, own = (
        subprocess.run(
            [sys.executable, "-c", MOTION.replace("{is_own}", word)], capture_output=True, text=True, check=True
        )
        for word in ("False", "True")
    )
    assert usual.stdout == own.stdout != ""
