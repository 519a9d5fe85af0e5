"""The cases by which engines are judged: what is in the file is proved, and what is given of it is the same body."""

from __future__ import annotations

import json
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest

from lie_rigid_body import RigidBody, State
from lie_rigid_body.conformance import CASES
from lie_rigid_body.conformance.cases import FILE
from lie_rigid_body.lie import quaternion

ROWS = {row["name"]: row for row in json.loads(FILE.read_text(encoding="utf-8"))["cases"]}
EACH = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)


def off(computed: np.ndarray, digits: list[str]) -> float:
    """Largest difference of doubles from decimals."""
    with localcontext() as context:
        context.prec = 60
        return float(max(abs(Decimal(x) - Decimal(d)) for x, d in zip(computed.tolist(), digits, strict=True)))


def test_there_are_twelve_and_the_file_has_only_them():
    assert len(CASES) == 12
    assert [case.name for case in CASES] == [*ROWS]


@EACH
def test_the_closed_form_has_the_digits_of_the_file(case):
    truth = ROWS[case.name]["truth"]
    found = case.truth([row["t_s"] for row in truth])
    assert isinstance(found, State)
    assert truth[-1]["t_s"] == case.duration
    speed = np.linalg.norm(case.body_rate)
    for row, q, w in zip(truth, found.attitude_xyzw, found.body_rate, strict=True):
        assert off(q, row["attitude_xyzw"]) < 2e-15
        assert off(w, row["body_rate"]) < 4e-15 * speed


@EACH
def test_the_digits_lie_in_the_proved_enclosure(case):
    flint = pytest.importorskip("flint")
    from lie_rigid_body.proof import enclose

    row = ROWS[case.name]["truth"][-1]
    exponent = 30 - int(np.log2(row["t_s"]))
    t_ns = Fraction(row["t_s"]) * 2**exponent * 10**9
    assert t_ns.denominator == 1
    rate = np.ldexp(case.body_rate, -exponent)  # time is stretched, to whole nanoseconds
    found = enclose(case.inertia, case.attitude_xyzw, rate, int(t_ns), width=1e-42)
    with flint.ctx.workprec(found.bits):
        speed = flint.arb(float(np.linalg.norm(case.body_rate)))
        for ball, digits in zip(found.attitude_xyzw, row["attitude_xyzw"], strict=True):
            assert abs(ball - flint.arb(digits)) < flint.arb("1e-40")
        for ball, digits in zip(found.body_rate, row["body_rate"], strict=True):
            assert abs(ball * 2**exponent - flint.arb(digits)) < speed * flint.arb("1e-40")


@EACH
def test_the_conventions_of_engines_tell_the_same_body(case):
    w, x, y, z = case.inertial_frame_wxyz
    P = quaternion.to_matrix(np.array([x, y, z, w]))
    np.testing.assert_allclose(P @ np.diag(case.principal_moments) @ P.T, case.inertia, atol=2e-15 * case.inertia.max())
    assert np.all(np.diff(case.principal_moments) >= 0)
    assert np.roll(case.attitude_wxyz, -1).tolist() == case.attitude_xyzw.tolist()
    world = quaternion.rotate(case.attitude_xyzw, case.body_rate)
    np.testing.assert_allclose(case.world_rate, world, rtol=0, atol=1e-15 * np.linalg.norm(world))
    RigidBody(case.inertia)


@EACH
def test_a_period_is_a_turn_at_the_largest_rate(case):
    rates = case.truth(np.linspace(0.0, case.duration, 500)).body_rate
    assert case.period == pytest.approx(2 * np.pi / np.linalg.norm(rates, axis=1).max(), rel=0.05)
    assert 8 < case.duration / case.period < 25


def test_a_time_has_one_state_and_times_have_many():
    case = CASES[0]
    assert case.truth(0.0).attitude_xyzw.tolist() == case.attitude_xyzw.tolist()
    assert case.truth(0.25).body_rate.shape == (3,)
    assert case.truth([0.25, 0.5]).body_rate.shape == (2, 3)
    assert case.truth([0.25, 0.5]).body_rate[0].tolist() == pytest.approx(
        case.truth(0.25).body_rate.tolist(), abs=1e-15
    )


def test_they_are_of_many_kinds():
    speeds = [np.linalg.norm(case.body_rate) for case in CASES]
    assert min(speeds) < 0.05
    assert max(speeds) > 100.0
    products = [case for case in CASES if not np.array_equal(case.inertia, np.diag(np.diag(case.inertia)))]
    assert len(products) >= 8
    ratios = [case.principal_moments[0] / case.principal_moments[2] for case in CASES]
    assert min(ratios) < 0.05
    assert max(ratios) > 0.99
