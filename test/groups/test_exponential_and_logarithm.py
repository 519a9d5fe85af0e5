"""The exponential, its derivative and the logarithm, of matrices and on groups, against mpmath."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from mpmath import mp, mpf
from sample_groups import ALL

from lie_rigid_body.groups import SU, MatrixLieGroup, exponential

flint = pytest.importorskip("flint", reason="python-flint is not installed")
GENERATOR = np.array([[0.0, -0.5, 0.3], [0.5, 0.0, -0.2], [-0.3, 0.2, 0.0]])


@pytest.fixture(autouse=True)
def many_digits():
    with flint.ctx.workdps(40), mp.workdps(60):
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


SCALES = (1e-9, 1e-4, 1e-2, 0.3, 1.0, 2.0, 3.14, 10.0, 40.0)
NAMES = ("SO(2)", "SO(3)", "SO(4)", "SO(5)", "SU(2)", "SU(3)", "U(1)", "se(3)", "Heisenberg", "su(3)")
groups = pytest.mark.parametrize("group", [ALL[name] for name in NAMES], ids=NAMES)


def block(matrix, i: int, j: int, n: int):
    """The block of n rows that begins in row i and column j."""
    return flint.acb_mat([[matrix[i + k, j + m] for m in range(n)] for k in range(n)])


def as_numpy(matrix) -> np.ndarray:
    entries = matrix.entries()
    assert all(entry.rad() < 1e-25 for entry in entries)
    return np.array([complex(entry) for entry in entries]).reshape(matrix.nrows(), -1)


@cache
def exact(group: MatrixLieGroup, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """exp(X), and (d/dt exp(X + tY)) exp(−X) at t = 0: from the corner of the exponential of [[X, Y], [0, X]]."""
    X, Y = (group.hat(v) for v in at_scale(group, scale))
    n = len(X)
    whole = flint.acb_mat(np.block([[X, Y], [np.zeros_like(X), X]]).tolist()).exp()
    return as_numpy(block(whole, 0, 0, n)), as_numpy(block(whole, 0, n, n) * flint.acb_mat((-X).tolist()).exp())


def at_scale(group: MatrixLieGroup, scale: float) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(31)
    x, y = rng.normal(size=(2, group.dimension))
    return x * scale / np.linalg.norm(group.hat(x), ord=2), y


@groups
@pytest.mark.parametrize("scale", SCALES)
def test_exp_and_dexp(group, scale):
    x, y = at_scale(group, scale)
    element, rate = exact(group, scale)
    limit = 2e-15 * max(1.0, scale)
    assert np.abs(group.exp(x) - element).max() <= limit * np.linalg.norm(element)
    assert np.abs(group.hat(group.dexp(x) @ y) - rate).max() <= 2.0 * limit * np.linalg.norm(rate)


@pytest.mark.parametrize("scale", [1e-9, 1e-4, 0.1, 1.0, 3.0])
@pytest.mark.parametrize("name", ["sl(2)", "se(3)", "Heisenberg", "SO(4)", "SU(3)"])
def test_log(name, scale):
    """Of the matrix as stored, in units of what its rounding can do."""
    group = ALL[name]
    x, _ = at_scale(group, scale)
    A = group.exp(x)
    truth = np.array(mp.logm(mp.matrix(A.tolist())).tolist(), dtype=complex)
    assert np.abs(group.hat(group.log(A)) - truth).max() <= 4e-15 * np.linalg.cond(A) * max(1.0, scale)


@pytest.mark.parametrize("gap", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("name", ["so(4)", "su(3)"])
def test_log_loses_no_more_digits_before_a_half_turn_than_it_must(name, gap):
    """The rounding of an element turns the plane of an eigenvalue pair that is nearly double by 1/gap of itself."""
    group = ALL[name]
    x, _ = at_scale(group, np.pi - gap)
    A, _ = exact(group, np.pi - gap)
    found = group.log(A if np.iscomplexobj(group.generators) else A.real)
    assert np.abs(group.hat(found - x)).max() <= 4e-15 / gap


def test_log_of_su3_is_shortest_where_the_principal_one_has_a_trace():
    """Angles 2, 2, 2π − 4 are principal with sum 2π; within the algebra 2, 2, −4 is shortest.

    Eigenvectors of angles that differ by 0.1 are known to ten times the round-off, and turn by it what differs by 6.1.
    """
    group = SU(3)
    V = group.random(np.random.default_rng(32))
    A = V @ np.diag(np.exp([2j, 2.1j, -4.1j])) @ V.conj().T
    np.testing.assert_allclose(group.hat(group.log(A)), V @ np.diag([2j, 2.1j, -4.1j]) @ V.conj().T, rtol=0, atol=4e-14)
