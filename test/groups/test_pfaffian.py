"""The Pfaffian against its definition, and matrices that have neither it nor Casimirs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups import pfaffian, rotation_casimirs, unitary_casimirs

seeds = st.integers(0, 2**32 - 1)
TURN = np.array([[0.0, -2.0], [2.0, 0.0]])


def expanded(p):
    """Pf by expansion along the first row, from its definition."""
    n = len(p)
    if n == 0:
        return 1.0
    rest = range(1, n)
    without = {j: [i for i in rest if i != j] for j in rest}
    return sum((-1) ** (j - 1) * p[0, j] * expanded(p[np.ix_(without[j], without[j])]) for j in rest)


@given(seeds, st.integers(0, 4))
def test_pfaffian_is_its_expansion_and_the_root_of_the_determinant(seed, half):
    rng = np.random.default_rng(seed)
    x = rng.integers(-3, 4, size=(3, 2 * half, 2 * half)).astype(float)
    p = x - np.swapaxes(x, 1, 2)
    expected = [expanded(q) for q in p]
    scale = 1.0 + np.prod(np.linalg.norm(p, axis=-1), axis=-1) ** 0.5
    np.testing.assert_allclose((pfaffian(p) - expected) / scale, 0.0, atol=1e-12)
    np.testing.assert_allclose((pfaffian(p) ** 2 - np.linalg.det(p)) / scale**2, 0.0, atol=1e-12)


@given(seeds)
def test_pfaffian_under_a_change_of_basis(seed):
    """Pf(B P Bᵀ) = det B · Pf P: an odd exchange of axes changes its sign, so it is no invariant of O(n)."""
    rng = np.random.default_rng(seed)
    x, b = rng.normal(size=(2, 6, 6))
    p = x - x.T
    expected = np.linalg.det(b) * pfaffian(p)
    changed = b @ p @ b.T
    assert pfaffian((changed - changed.T) / 2) == pytest.approx(
        expected, abs=1e-10 * np.linalg.norm(b) ** 6 * np.linalg.norm(p) ** 3
    )


def test_pfaffian_needs_no_pivot_on_the_way_and_none_at_all_for_odd_n():
    swapped = np.zeros((4, 4))
    swapped[0, 2], swapped[2, 0], swapped[1, 3], swapped[3, 1] = 2.0, -2.0, 3.0, -3.0
    assert pfaffian(swapped) == -6.0
    assert pfaffian(np.zeros((4, 4))) == 0.0
    assert pfaffian(np.array([[0.0, 7.0], [-7.0, 0.0]])) == 7.0
    np.testing.assert_array_equal(
        pfaffian(np.triu(np.ones((2, 3, 3)), 1) - np.tril(np.ones((2, 3, 3)), -1)), [0.0, 0.0]
    )
    np.testing.assert_array_equal(pfaffian(np.zeros((2, 0, 0))), [1.0, 1.0])
    assert pfaffian(np.zeros((0, 4, 4))).shape == (0,)


def test_what_is_not_square_is_refused():
    for function in (pfaffian, rotation_casimirs, unitary_casimirs):
        for wrong in (np.zeros((2, 3)), np.zeros(3)):
            with pytest.raises(InputError, match=r"P: shape .* is not \(\.\.\., n, n\): give square matrices"):
                function(wrong)


@pytest.mark.parametrize(
    ("matrix", "said"),
    [
        (TURN + 1e-13 * np.eye(2), r"P \+ Pᵀ reaches 2e-13, the limit is 2\.84e-14: give an antisymmetric"),
        (np.stack([1e9 * TURN, np.eye(2)]), r"P \+ Pᵀ reaches 2, "),
        (TURN * np.nan, "P: nan is not finite"),
        (TURN + 0j, "P: complex numbers: give a real"),
        ([["a", "b"], ["c", "d"]], "P: type <U1 is not numbers"),
        ([[0.0, 1.0], [0.0]], "P: rows of unequal length"),
    ],
)
def test_no_pfaffian_and_no_casimirs_of_what_is_not_antisymmetric(matrix, said):
    for function in (pfaffian, rotation_casimirs):
        with pytest.raises(InputError, match=said):
            function(matrix)


@pytest.mark.parametrize(
    ("matrix", "said"),
    [
        (np.diag([1j, -1j]) + 1e-12 * np.eye(2), r"P \+ P† reaches 2e-12, the limit is .*: give an anti-Hermitian"),
        (np.diag([1.0, -1.0]), r"P \+ P† reaches 2"),
        (np.full((2, 2), np.inf), "inf is not finite"),
        ([["a", "b"], ["c", "d"]], "P: type <U1 is not numbers"),
    ],
)
def test_no_casimirs_of_what_is_not_antihermitian(matrix, said):
    with pytest.raises(InputError, match=said):
        unitary_casimirs(matrix)
