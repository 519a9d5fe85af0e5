"""The maps between algebra and group against matrix exponentials at 40 digits."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from mpmath import mp
from sample_groups import ALL

from lie_rigid_body.groups import SU, MatrixLieGroup

SCALES = (1e-9, 1e-4, 1e-2, 0.3, 1.0, 2.0, 3.14, 10.0, 40.0)
NAMES = ("SO(2)", "SO(3)", "SO(4)", "SO(5)", "SU(2)", "SU(3)", "U(1)", "se(3)", "Heisenberg", "su(3)")
cases = pytest.mark.parametrize(
    ("group", "scale"), [(ALL[name], scale) for name in NAMES for scale in SCALES], ids=lambda v: getattr(v, "name", v)
)


@pytest.fixture(autouse=True)
def forty_digits():
    with mp.workdps(40):
        yield


def as_mp(matrix: np.ndarray) -> mp.matrix:
    return mp.matrix(matrix.tolist())


def as_numpy(matrix: mp.matrix) -> np.ndarray:
    return np.array(matrix.tolist(), dtype=complex)


def exact_exp(X: np.ndarray) -> mp.matrix:
    return mp.expm(as_mp(X), method="taylor")


@cache
def exact_dexp(group: MatrixLieGroup, scale: float) -> np.ndarray:
    """(d/dt exp(X + tY)) exp(−X) at t = 0, from the corner of the exponential of [[X, Y], [0, X]]."""
    X, Y = (group.hat(v) for v in at_scale(group, scale))
    n = len(X)
    whole = exact_exp(np.block([[X, Y], [np.zeros_like(X), X]]))
    return as_numpy(whole[:n, n:] * exact_exp(-X))


def at_scale(group: MatrixLieGroup, scale: float) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(31)
    x, y = rng.normal(size=(2, group.dimension))
    return x * scale / np.linalg.norm(group.hat(x), ord=2), y


@cases
def test_exp(group, scale):
    x, _ = at_scale(group, scale)
    exact = as_numpy(exact_exp(group.hat(x)))
    limit = 2e-15 * max(1.0, scale) * np.linalg.norm(exact)
    assert np.abs(group.exp(x) - exact).max() <= limit


@cases
def test_dexp(group, scale):
    x, y = at_scale(group, scale)
    exact = exact_dexp(group, scale)
    limit = 4e-15 * max(1.0, scale) * np.linalg.norm(exact)
    assert np.abs(group.hat(group.dexp(x) @ y) - exact).max() <= limit


@cases
def test_dexpinv(group, scale):
    x, y = at_scale(group, scale)
    exact = exact_dexp(group, scale)
    condition = np.linalg.cond(group.dexp(x))
    rate = group.dexpinv(x) @ group.vee(exact if np.iscomplexobj(group.generators) else exact.real)
    assert np.abs(rate - y).max() <= 1e-14 * max(1.0, scale) * condition * np.linalg.norm(y)


@pytest.mark.parametrize("scale", [1e-9, 1e-4, 0.1, 1.0, 3.0])
@pytest.mark.parametrize("name", ["sl(2)", "se(3)", "Heisenberg", "SO(4)", "SU(3)"])
def test_log(name, scale):
    """Of the matrix as stored, in units of what its rounding can do."""
    group = ALL[name]
    x, _ = at_scale(group, scale)
    A = group.exp(x)
    exact = as_numpy(mp.logm(as_mp(A)))
    assert np.abs(group.hat(group.log(A)) - exact).max() <= 4e-15 * np.linalg.cond(A) * max(1.0, scale)


def test_log_of_su3_is_shortest_where_the_principal_one_has_a_trace():
    """Angles 2, 2, 2π − 4 are principal with sum 2π; within the algebra 2, 2, −4 is shortest."""
    group = SU(3)
    V = group.random(np.random.default_rng(32))
    A = V @ np.diag(np.exp([2j, 2.1j, -4.1j])) @ V.conj().T
    np.testing.assert_allclose(group.hat(group.log(A)), V @ np.diag([2j, 2.1j, -4.1j]) @ V.conj().T, rtol=0, atol=2e-14)
