"""Two proofs that share no formula agree; and what they say of a double is rounded outward."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest

pytest.importorskip("flint", reason="python-flint is not installed")

from flint import arb, ctx, fmpq
from regimes import REGIMES, motion
from taylor import enclose_by_taylor, taylor_state

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.proof import enclose
from lie_rigid_body.proof.balls import at_least, at_most
from lie_rigid_body.proof.start import Kind, Start
from reference import truth_cases
from sampled import sampled

THIN = 1e-20


@pytest.mark.parametrize("regime", sampled(REGIMES, every=4))
def test_the_exact_solution_meets_the_taylor_series(regime):
    for seed, radians in enumerate([0.3, 6.0]):
        drawn = motion(regime, seed)
        exact = enclose(*drawn, drawn.stamp(radians))
        series = enclose_by_taylor(*drawn, drawn.stamp(radians))
        assert exact.overlaps(series)
        assert max(exact.width, series.width) < THIN


@pytest.mark.parametrize("t_ns", [-3 * 10**9, -(10**9), 0, pytest.param(3 * 10**10, marks=pytest.mark.slow)])
def test_they_meet_before_the_start_and_at_it_and_long_after(t_ns):
    drawn = motion("tensor", 5)
    exact, series = enclose(*drawn, t_ns), enclose_by_taylor(*drawn, t_ns)
    assert exact.overlaps(series)
    assert max(exact.width, series.width) < THIN


def test_the_precision_of_others_changes_nothing():
    drawn = motion("tensor", 4)
    with ctx.workprec(20):
        coarse = enclose(*drawn, 10**9)
    assert (coarse.bits, coarse.attitude_xyzw[0].mid()) == (
        enclose(*drawn, 10**9).bits,
        enclose(*drawn, 10**9).attitude_xyzw[0].mid(),
    )


@pytest.mark.parametrize("bits", [3, 12, 30])
def test_what_a_short_series_leaves_out_is_enclosed(bits):
    drawn = motion("generic", 3)
    t_ns = drawn.stamp(2.0)
    with ctx.workprec(256):
        attitude, rate = taylor_state(Start.of(*drawn), t_ns, bits)
        exact = enclose(*drawn, t_ns)
        assert all(x.contains(y) for x, y in zip(attitude, exact.attitude_xyzw, strict=True))
        assert all(x.contains(y) for x, y in zip(rate, exact.body_rate, strict=True))
    assert at_most(attitude[0].rad()) < 300.0 * 2.0**-bits


def test_a_nanosecond_tells_them_apart():
    drawn = motion("generic", 1)
    assert not enclose(*drawn, 10**9).overlaps(enclose_by_taylor(*drawn, 10**9 + 1))


def test_one_unit_in_the_last_place_of_the_start_tells_them_apart():
    inertia, attitude, rate = motion("generic", 1)
    other = inertia.copy()
    other[0] = np.nextafter(other[0], 2.0)
    assert not enclose(inertia, attitude, rate, 10**9).overlaps(enclose_by_taylor(other, attitude, rate, 10**9))


def test_they_hold_what_many_digits_of_quadrature_gave():
    """The truth of the reference file has 40 digits, the enclosures 24."""
    for case in truth_cases().values():
        for point in case.points[:2]:
            exact = enclose(case.body.inertia, case.start.attitude_xyzw, case.start.body_rate, point.t_ns)
            with ctx.workprec(200):
                cosine = sum(
                    (arb(x) * y for x, y in zip(point.attitude_xyzw, exact.attitude_xyzw, strict=True)), arb(0)
                )
                rates = [abs(arb(x) - y) for x, y in zip(point.body_rate, exact.body_rate, strict=True)]
                assert at_most(abs(1 - abs(cosine))) < 1e-23
                assert at_most(max(rates)) < 1e-23


def test_the_attitude_is_continuous_from_the_start():
    drawn = motion("tensor", 2)
    before = enclose(*drawn, 0)
    for k in range(1, 100):
        after = enclose(*drawn, k * 2 * 10**8)
        assert sum(float(x) * float(y) for x, y in zip(before.attitude_xyzw, after.attitude_xyzw, strict=True)) > 0.5
        before = after


@pytest.mark.parametrize(
    ("regime", "kinds"),
    [
        ("generic", {Kind.ABOUT_SMALLEST, Kind.ABOUT_LARGEST}),
        ("near_separatrix", {Kind.ABOUT_SMALLEST, Kind.ABOUT_LARGEST}),
        ("nearly_spherical", {Kind.ABOUT_SMALLEST, Kind.ABOUT_LARGEST}),
        ("on_separatrix", {Kind.SEPARATRIX}),
        ("symmetric", {Kind.SYMMETRIC}),
        ("steady", {Kind.STEADY}),
    ],
)
def test_the_kind_is_decided_exactly(regime, kinds):
    assert {Start.of(*motion(regime, seed)).kind for seed in range(20)} == kinds


def test_the_last_bit_decides_the_kind():
    on, off = [2.0, 0.3, 1.0], [np.nextafter(2.0, 3.0), 0.3, 1.0]
    inside = [np.nextafter(2.0, 0.0), 0.3, 1.0]
    kinds = [Start.of([3.0, 4.0, 6.0], [0, 0, 0, 1], rate).kind for rate in (on, off, inside)]
    assert kinds == [Kind.SEPARATRIX, Kind.ABOUT_SMALLEST, Kind.ABOUT_LARGEST]


@pytest.mark.parametrize(
    ("inertia", "rate", "t_ns"),
    [
        ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0], 10**9),
        ([1.0, 2.0, 3.0], [5e-324, 1e-310, 0.0], 10**18),
        ([1e-300, 2e-300, 2.5e-300], [1.0, 2.0, 3e-5], 10**15),
        ([1.0, 2.0, 3.0], [1e100, 1e99, 3e100], 10**16),
        ([1e-12, 1.0, 1.0], [1.0, 2.0, 3.0], 10**16),
        ([1.0, 1e-300, 0.0, 2.0, 1e-200, 3.0], [0.0, 1.0, 0.0], 10**11),
        ([1.0, 2.0, 3.0], [0.0, 1.0, 0.1], 10**16),
        ([1.0, 2.0, 3.0], [0.1, 1.0, 0.0], 10**16),
    ],
)
def test_extremes_are_enclosed(inertia, rate, t_ns):
    assert enclose(inertia, [0.5, 0.5, -0.5, 0.5], rate, t_ns).width < THIN


def test_an_error_is_between_its_bounds():
    """Turned about z by an angle of which both half angle functions are rational: tan(θ/4) = 2⁻³⁰ and more."""
    for tangent in (2.0**-40, 2.0**-30, 0.25, 1.0, 3.0):
        truth = enclose([1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 0)
        low, high = truth.attitude_error([0.0, 0.0, tangent, 1.0])
        with ctx.workprec(200):
            angle = 2 * arb(tangent).atan()
        assert low <= at_most(angle)
        assert high >= at_least(angle)
        assert high - low <= 4e-16 * high
        assert truth.attitude_error([0.0, 0.0, -3.0 * tangent, -3.0]) == truth.attitude_error(
            [0.0, 0.0, -tangent, -1.0]
        )


def test_rate_errors_have_bounds_too():
    truth = enclose([1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 2.0], 10**9)
    low, high = truth.rate_error([3.0, 0.0, 6.0])
    assert low <= 5.0 <= high
    assert high - low < 1e-14


def test_what_is_no_attitude_is_infinitely_far():
    truth = enclose([1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0], [0.1, 0.2, 2.0], 10**9)
    for attitude in ([0.0] * 4, [math.nan] * 4, [math.inf, 0.0, 0.0, 0.0]):
        assert truth.attitude_error(attitude) == (math.inf, math.inf)
    assert truth.rate_error([math.nan, 0.0, 0.0]) == (math.inf, math.inf)


def test_doubles_are_rounded_outward():
    with ctx.workprec(200):
        third = arb(fmpq(1, 3))
        assert math.nextafter(at_least(third), 1.0) == at_most(third)
        assert at_least(arb(0.5)) == at_most(arb(0.5)) == 0.5
        assert at_most(arb(2) ** 2000) == math.inf
        assert at_least(arb(2) ** 2000) == np.finfo(float).max
        assert at_most(-(arb(2) ** 2000)) == -np.finfo(float).max
        assert at_most(arb(2) ** -2000) == 5e-324
        assert at_least(arb(2) ** -2000) == 0.0
        assert at_most(arb("nan")) == math.inf


@pytest.mark.parametrize(
    ("inertia", "attitude", "rate", "said"),
    [
        ([1.0, 2.0], [0, 0, 0, 1], [0, 0, 1], "inertia"),
        ([1.0, 2.0, -3.0], [0, 0, 0, 1], [0, 0, 1], "not positive"),
        (np.arange(9.0).reshape(3, 3), [0, 0, 0, 1], [0, 0, 1], "symmetric"),
        ([1.0, 2.0, math.nan], [0, 0, 0, 1], [0, 0, 1], "finite"),
        ([1.0, 2.0, 3.0], [0, 0, 0, 0], [0, 0, 1], "zero quaternion"),
        ([1.0, 2.0, 3.0], [0, 0, 0, 1], [0, 1], "body_rate"),
        ("x", [0, 0, 0, 1], [0, 0, 1], "inertia"),
        ([1.0, 2.0, 3.0], [[0], [0, 0, 1]], [0, 0, 1], "attitude_xyzw"),
        ([1.0, 2.0, 3.0], [0, 0, 0, 1], [0, 0, 1j], "body_rate"),
    ],
)
def test_what_is_no_start_is_refused(inertia, attitude, rate, said):
    with pytest.raises(InputError, match=said):
        enclose(inertia, attitude, rate, 0)


def test_what_is_no_number_is_refused():
    enclosure: Any = enclose
    start = [1.0, 2.0, 3.0], [0, 0, 0, 1], [0.1, 0.2, 0.3]
    truth = enclosure(*start, np.int64(5))
    assert truth.overlaps(enclose(*start, 5))
    calls = [
        *(partial(enclosure, *start, t_ns) for t_ns in ([1.0], 1.5, "x", None, 10**400)),
        *(partial(enclosure, *start, 1, width=width) for width in ("x", [1e-20], None, math.nan)),
        *(partial(truth.attitude_error, given) for given in ("x", [0, 0, 1], [0, 0, 1j, 1], [[0], [0, 0, 1]])),
        *(partial(truth.rate_error, given) for given in ("x", [0, 1], [0, 1j, 1])),
    ]
    for call in calls:
        with pytest.raises(InputError, match=r"^(t_ns|width|attitude_xyzw|body_rate): "):
            call()
