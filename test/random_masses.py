"""Random masses, and the plainest formulas of their moments, for the tests of moments in n dimensions."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.stats import special_ortho_group

dimensions = st.integers(2, 6)
seeds = st.integers(0, 2**32 - 1)


def rotation_of(n, rng):
    return special_ortho_group.rvs(n, random_state=rng)


def random_points(n, rng, count=12):
    return rng.normal(size=(count, n)) + 3.0 * rng.normal(size=n), rng.uniform(0.1, 2.0, count)


def direct_sum(points, masses):
    """K by the definition, one point and one entry at a time."""
    n = points.shape[1]
    return np.array(
        [[sum(m * x[i] * x[j] for x, m in zip(points, masses, strict=True)) for j in range(n)] for i in range(n)]
    )


def plane_generators(n):
    """Generators of SO(n), one for each coordinate plane i < j."""
    T = np.zeros((n * (n - 1) // 2, n, n))
    for a, (i, j) in enumerate(combinations(range(n), 2)):
        T[a, i, j], T[a, j, i] = -1.0, 1.0
    return T


def assert_same(one, other, tolerance=1e-13):
    size = np.abs(other.second_moment).max()
    assert one.mass == pytest.approx(other.mass, rel=tolerance)
    np.testing.assert_allclose(one.centre, other.centre, rtol=0, atol=tolerance * np.sqrt(size / other.mass))
    np.testing.assert_allclose(one.second_moment, other.second_moment, rtol=0, atol=tolerance * size)
