from __future__ import annotations

from decimal import Decimal

import pytest
from mpmath import mp, mpf

from lie_rigid_body.arithmetic.decimals import PI, working_precision
from lie_rigid_body.motion.closed_form.elliptic_integrals import complete_first, mean_third, symmetric_first

TOLERANCE = mpf("1e-60")
M1 = ["1", "0.75", "0.5", "0.1", "1e-5", "1e-12", "1e-30", "1e-100", "1e-600"]


@pytest.fixture(autouse=True)
def _precision():
    with working_precision(64), mp.workdps(80):
        yield


def as_mp(x: Decimal) -> mpf:
    return mpf(str(x))


def assert_close(value: Decimal, truth: mpf, loss: mpf = 1) -> None:
    assert abs(as_mp(value) - truth) <= TOLERANCE * loss * abs(truth)


def test_pi():
    with mp.workdps(120):
        assert abs(as_mp(PI) - mp.pi) < mpf("1e-90")


@pytest.mark.parametrize(
    "xyz",
    [
        ("0", "1", "2"),
        ("1", "1", "1"),
        ("0", "1e-300", "1"),
        ("1e-40", "1e-20", "3"),
        ("0.5", "0.7", "1"),
        ("1", "1e40", "7"),
    ],
)
def test_symmetric_first_kind(xyz: tuple[str, str, str]):
    assert_close(symmetric_first(*map(Decimal, xyz)), mp.elliprf(*map(mpf, xyz)))


@pytest.mark.parametrize("m1", M1)
def test_complete_first_kind(m1: str):
    assert_close(complete_first(Decimal(m1)), mp.pi / (2 * mp.agm(1, mp.sqrt(mpf(m1)))))


@pytest.mark.parametrize("m1", M1[:7])
@pytest.mark.parametrize("fraction", ["1", "0.3", "1e-4", "1e-20"])
def test_mean_of_the_third_kind(m1: str, fraction: str):
    n1 = Decimal(fraction) * Decimal(m1)
    with mp.workdps(150):
        n, m = 1 - as_mp(n1), 1 - mpf(m1)
        truth = (1 - n) * mp.ellippi(n, m) / mp.ellipk(m)
    assert_close(mean_third(n1, Decimal(m1)), truth, 1 / mp.sqrt(mpf(fraction)))
