"""φ and the logarithm of matrices against mpmath, on both sides of where the logarithm's formula changes."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body.groups import exponential

GENERATOR = np.array([[0.0, -0.5, 0.3], [0.5, 0.0, -0.2], [-0.3, 0.2, 0.0]])


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(60):
        yield


def worst(found: np.ndarray, truth) -> float:
    return float(max(abs(mpf(float(x)) - truth[index]) for index, x in np.ndenumerate(found)))


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-9, 1e-3, 0.3, 1.0, 2.0, 4.0, 6.0])
def test_the_functions_of_small_matrices_are_right(size: float):
    z = GENERATOR * (size / np.abs(GENERATOR).sum(axis=0).max())
    power, e, phi = mp.eye(3), mp.zeros(3), mp.zeros(3)
    for k in range(80):
        e, phi = e + power / mp.factorial(k), phi + power / mp.factorial(k + 1)
        power = power * mp.matrix(z.tolist())
    assert worst(exponential.exp(z), e) < 4e-15
    assert worst(exponential.phi(z), phi) < 4e-15
    assert worst(exponential.phi_inverse(z), phi**-1) < 8e-15


@pytest.mark.parametrize("size", [*(0.5 * (1.0 + side) for side in (-1e-9, 0.0, 3e-16, 1e-9)), 1e-9, 1e-3, 0.9])
@pytest.mark.parametrize("direction", [GENERATOR, np.diag([-1.0, 0.0, 0.0]), np.ones((3, 3))])
def test_the_logarithm_of_matrices_is_right_where_its_series_ends(direction: np.ndarray, size: float):
    """The series converges the slowest where a matrix shrinks one direction alone."""
    a = np.eye(3) + size / np.linalg.norm(direction) * direction
    found = exponential.batched_log(a[np.newaxis], exponential.principal_log)[0]
    assert worst(found, mp.logm(mp.matrix(a.tolist()))) < 4e-15 * size
