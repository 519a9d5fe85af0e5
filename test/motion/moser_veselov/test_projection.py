"""Projections onto the invariants, with many digits, on both sides of where they leave the energy alone."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body import RigidBody, State
from lie_rigid_body.motion.moser_veselov import MoserVeselovIntegrator, loop

BODY = RigidBody([1.0, 2.0, 3.0])
ANGLES = [0.3, 1e-2, 1e-4, 1e-8, 1e-12, 1e-16, 1e-30, 1e-100, 1e-124, 1e-127, 0.0]
"""rad, between momentum and rate beside an axis; `MIN_SQUARED_GRADIENT` lies between two of them."""

EVERY_ANGLE = pytest.mark.parametrize("angle", ANGLES)
EVERY_AXIS = pytest.mark.parametrize("axis", range(3))
OFF = 1e-17
"""What round-off does to a component between two projections."""


def exact(pair) -> mpf:
    return mpf(pair[0]) + mpf(pair[1])


def rate_beside(axis: int, size: float) -> np.ndarray:
    """A spin about an axis, and rates of this size across it."""
    rate = np.array([size, -0.7 * size, 0.4 * size])
    rate[axis] = 1.3
    return rate


def sine(rate: np.ndarray) -> float:
    momentum = BODY.inertia @ rate
    return float(np.linalg.norm(np.cross(rate, momentum)) / np.linalg.norm(rate) / np.linalg.norm(momentum))


def made(angle: float, axis: int):
    """Momentum and attitude of a start, and the constants of its motion, all in double-double."""
    rate = rate_beside(axis, 1e-3 * angle / sine(rate_beside(axis, 1e-3)))
    start = State(np.array([0.1, -0.7, 0.3, -0.5]) / np.sqrt(0.84), rate)
    integrator = MoserVeselovIntegrator(BODY, start, 20)
    return integrator.start.momentum, integrator.start.attitude, integrator.constants


def moved(pair, by: float):
    value = Decimal(pair[0]) + Decimal(pair[1]) + Decimal(by)
    hi = float(value)
    return hi, float(value - Decimal(hi))


def energy(n, constants) -> mpf:
    """2H − e₂."""
    e12, _, e23 = constants.differences
    return exact(e12) * exact(n[0]) ** 2 - exact(e23) * exact(n[2]) ** 2


def nearby(n):
    """Momenta as round-off leaves them: each component off by a little of itself, and never by less than 1e-300."""
    for signs in ((1, 1, 1), (1, -1, 1), (-1, 1, 1), (1, 1, -1)):
        yield tuple(moved(c, s * OFF * max(abs(c[0]), 1e-283)) for c, s in zip(n, signs, strict=True))


@EVERY_AXIS
@EVERY_ANGLE
def test_length_and_energy_are_restored(angle: float, axis: int):
    """The length always, the energy where it is not the length's, from the nearest axis to round-off of itself.

    Components across the axis keep 1e-16 of themselves: about the middle axis they grow to a flip, with their errors.
    """
    n, _, constants = made(angle, axis)
    with mp.workdps(60):
        for off in nearby(n):
            found = loop.project_momentum(off, constants)
            assert abs(sum(exact(c) ** 2 for c in found) - 1) < 1e-31
            across = max(abs(c[0]) for i, c in enumerate(n) if i != axis)
            allowed = (2e-31 if angle > 1e-125 else 4.0 * OFF) * mpf(across) ** 2 + mpf("1e-599")
            if axis == 1:
                assert abs(energy(found, constants) - energy(n, constants)) <= allowed
            else:
                assert abs(energy(found, constants) - exact(constants.energy)) <= 1e-31 + allowed
            for i in {0, 1, 2} - {axis}:
                assert abs(exact(found[i]) - exact(n[i])) <= 1e-16 * abs(exact(n[i])) + 1e-299


@EVERY_AXIS
@EVERY_ANGLE
def test_the_spatial_momentum_and_the_norm_are_restored(angle: float, axis: int):
    n, q, constants = made(angle, axis)
    world = constants.world_momentum
    off = tuple(moved(c, s * OFF) for c, s in zip(q, (1, -1, 1, 1), strict=True))
    with mp.workdps(60):
        alone = loop.project_attitude(q, n, world)
        assert max(abs(exact(a) - exact(b)) for a, b in zip(alone, q, strict=True)) < 1e-31
        x, y, z, w = (exact(c) for c in loop.project_attitude(off, n, world))
        assert abs(x * x + y * y + z * z + w * w - 1) < 1e-31
        v, u = [x, y, z], [exact(c) for c in n]
        t = [2 * (v[i - 2] * u[i - 1] - v[i - 1] * u[i - 2]) for i in range(3)]
        turned = [u[i] + w * t[i] + v[i - 2] * t[i - 1] - v[i - 1] * t[i - 2] for i in range(3)]
        assert max(abs(a - exact(b)) for a, b in zip(turned, world, strict=True)) < 2e-31
