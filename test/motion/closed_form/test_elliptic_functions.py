from __future__ import annotations

from decimal import Decimal

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body.arithmetic.decimals import PI, working_precision
from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.motion.closed_form.decimal_constants import Periods, Polhode, imaginary_theta, real_theta
from lie_rigid_body.motion.closed_form.jacobi import (
    EllipticValues,
    ImaginaryTheta,
    RealTheta,
    imaginary_values,
    real_values,
)

# up to K, but not beyond it by round-off, where the reference's amplitude would fold back
FRACTIONS = np.concatenate(
    [-np.geomspace(1e-12, 1.0 - 1e-14, 7), [0.0], np.geomspace(1e-9, 0.9, 6), 1.0 - np.geomspace(1e-9, 0.3, 4)]
)
CIRCULAR = ["1", "0.999999999999", "0.9", "0.7", "0.5"]
HYPERBOLIC = ["0.4999", "0.3", "0.1", "1e-2", "1e-5", "1e-8", "1e-12", "1e-16", "1e-20", "1e-25", "1e-30"]
CHARACTERISTICS = ["1e-12", "0.5", "3", "1e12"]


def periods(m1: str, characteristic: str) -> Periods:
    zero, m = Decimal(0), 1 - Decimal(m1)
    ratio = Decimal(characteristic) / m if m else Decimal(1)
    polhode = Polhode(
        amplitudes=(zero, zero, zero),
        momentum=zero,
        m=m,
        m1=Decimal(m1),
        speed=zero,
        characteristic=Decimal(characteristic) if m else zero,
        ratio=ratio,
        start=zero,
    )
    return Periods.of(polhode)


def sampled(m1: str, characteristic: str = "0.5"):
    """The functions at the fractions of their quarter period, and the exact u of each sample."""
    with working_precision(64):
        p = periods(m1, characteristic)
        scale = PI / (2 * (p.real if m1 in CIRCULAR else p.imaginary))
        if m1 in CIRCULAR:
            turns = 0.25 * FRACTIONS
            return circular(real_theta(p), turns), [2 * mpf(str(PI)) * x / mpf(str(scale)) for x in turns.tolist()]
        phase = FRACTIONS * float(scale * p.real)
        return hyperbolic(imaginary_theta(p), phase), [mpf(x) / mpf(str(scale)) for x in phase.tolist()]


def drift_of(m1: str, characteristic: str) -> np.ndarray:
    with working_precision(64):
        p = periods(m1, characteristic)
        return imaginary_theta(p).drift * (FRACTIONS * float(PI / (2 * p.imaginary) * p.real))


def circular(theta: RealTheta, turns: np.ndarray) -> EllipticValues:
    sine, cosine = sine_cosine((turns, np.zeros_like(turns)))
    return real_values(theta.quotients, sine, cosine)


def hyperbolic(theta: ImaginaryTheta, phase: np.ndarray) -> EllipticValues:
    return imaginary_values(theta.quotients, (phase, np.zeros_like(phase)))


@pytest.mark.parametrize("m1", CIRCULAR + HYPERBOLIC)
def test_jacobi_functions(m1: str):
    with mp.workdps(80):
        m = 1 - mpf(m1)
        values, us = sampled(m1)
        for kind, found in (("sn", values.sn), ("cn", values.cn), ("dn", values.dn)):
            truth = [mp.ellipfun(kind, u, m=m) for u in us]
            assert max(abs(mpf(v) - t) for v, t in zip(found.tolist(), truth, strict=True)) < 7e-16


@pytest.mark.parametrize("m1", CIRCULAR + HYPERBOLIC)
def test_the_sine_amplitude_is_relatively_accurate_near_zero(m1: str):
    with mp.workdps(80):
        values, us = sampled(m1)
        for u, sn in zip(us, values.sn.tolist(), strict=True):
            truth = mp.ellipfun("sn", u, m=1 - mpf(m1)) if u else mpf(0)
            assert abs(mpf(sn) - truth) <= 1e-15 * abs(truth)


@pytest.mark.parametrize("characteristic", CHARACTERISTICS)
@pytest.mark.parametrize("m1", ["0.999999999999", "0.7", "0.5", "0.3", "1e-5", "1e-12", "1e-25"])
def test_the_libration_is_the_periodic_part_of_the_third_kind(m1: str, characteristic: str):
    with mp.workdps(70):
        m, nu = 1 - mpf(m1), -mpf(characteristic)
        values, us = sampled(m1, characteristic)
        drift = np.zeros(len(us)) if m1 in CIRCULAR else drift_of(m1, characteristic)
        factor = mp.sqrt((1 - nu) * (m - nu) / -nu)
        complete, quarter = mp.ellippi(nu, m), mp.ellipk(m)
        for i in [*range(0, len(us), 3), len(us) - 1]:  # many digits take their time
            u = us[i]
            amplitude = mp.asin(mp.ellipfun("sn", u, m=m))
            truth = factor * (mp.ellippi(nu, amplitude, m) - complete * u / quarter) + mp.pi * u / (2 * quarter)
            angle = np.arctan2(values.sine[i], values.cosine[i]) + drift[i]
            assert abs(mpf(float(angle)) - truth) < 1e-15


def test_a_circle_and_the_separatrix_are_elementary():
    values, us = sampled("1")
    u = np.array([float(x) for x in us])
    np.testing.assert_allclose(values.sn, np.sin(u), rtol=0, atol=5e-16)
    np.testing.assert_allclose(values.cn, np.cos(u), rtol=0, atol=5e-16)
    np.testing.assert_array_equal(values.dn, 1.0)
    with working_precision(64):
        theta = imaginary_theta(periods("0", "0.5"))
    assert theta.quotients.nome == 0.0
    u = np.linspace(-800.0, 800.0, 4001)
    values = hyperbolic(theta, u)
    np.testing.assert_allclose(values.sn, np.tanh(u), rtol=0, atol=5e-16)
    np.testing.assert_allclose(values.cn, 1.0 / np.cosh(np.clip(u, -700, 700)), rtol=0, atol=5e-16)
    np.testing.assert_array_equal(values.cn, values.dn)
