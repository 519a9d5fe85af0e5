"""The exponential and the logarithm of matrices against mpmath, on both sides of where their formulas change."""

from __future__ import annotations

import numpy as np
import pytest
from mpmath import mp, mpf

from lie_rigid_body.groups import exponential


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(60):
        yield


def beside(limit: float) -> list[float]:
    return [limit * (1.0 + side) for side in (-1e-9, -2e-16, 0.0, 3e-16, 1e-9)]


GENERATOR = np.array([[0.0, -0.5, 0.3], [0.5, 0.0, -0.2], [-0.3, 0.2, 0.0]])


@pytest.mark.parametrize("size", [*beside(exponential.REACH), *beside(2.0 * exponential.REACH), 1e-9, 0.0])
def test_the_exponential_of_matrices_is_right_where_halving_begins(size: float):
    z = GENERATOR * (size / np.abs(GENERATOR).sum(axis=0).max())
    exact = mp.matrix(z.tolist())
    power, e, phi = mp.eye(3), mp.zeros(3), mp.zeros(3)
    for k in range(80):
        e, phi = e + power / mp.factorial(k), phi + power / mp.factorial(k + 1)
        power = power * exact
    for found, truth in (
        (exponential.exp(z), e),
        (exponential.phi(z), phi),
        (exponential.phi_inverse(z), phi**-1),
    ):
        assert max(abs(mpf(float(found[i, j])) - truth[i, j]) for i in range(3) for j in range(3)) < 4e-15


@pytest.mark.parametrize("size", [*beside(exponential.LOGARITHM_RADIUS), 1e-9, 1e-3, 0.9])
@pytest.mark.parametrize("direction", [GENERATOR, np.diag([-1.0, 0.0, 0.0]), np.ones((3, 3))])
def test_the_logarithm_of_matrices_is_right_where_its_series_ends(direction: np.ndarray, size: float):
    """The series converges the slowest where a matrix shrinks one direction alone."""
    a = np.eye(3) + size / np.linalg.norm(direction) * direction
    truth = mp.logm(mp.matrix(a.tolist()))
    batched = exponential.batched_log(a[np.newaxis], exponential.principal_log)[0]
    for found in (batched, exponential.principal_log(a)):
        assert max(abs(mpf(float(found[i, j])) - truth[i, j]) for i in range(3) for j in range(3)) < 4e-15 * size
