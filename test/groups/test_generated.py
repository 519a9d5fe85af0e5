"""Groups from generators: what is found about them, and what is refused."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
import pytest
from sample_groups import GENERATED, heisenberg, se3, sl2, so4_split, unit

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.groups import SO, SU, MatrixLieGroup

from_generators = MatrixLieGroup.from_generators


def test_so4_splits_into_two_commuting_copies_of_so3():
    epsilon = SO(3).structure_constants
    expected = np.zeros((6, 6, 6))
    expected[:3, :3, :3] = expected[3:, 3:, 3:] = epsilon
    np.testing.assert_allclose(from_generators(so4_split()).structure_constants, expected, rtol=0, atol=1e-15)


def test_the_example_of_its_docstring_makes_rigid_motions():
    shown = str(inspect.getdoc(from_generators)).partition("Examples\n")[2]
    names: dict[str, Any] = {"np": np, "SO": SO, "MatrixLieGroup": MatrixLieGroup}
    exec("\n".join(line.strip() for line in shown.splitlines() if line.startswith("    ")), names)
    assert names["group"].name == "SE(3)"
    np.testing.assert_array_equal(names["group"].generators, se3())


def test_sl2_and_heisenberg_have_their_textbook_brackets():
    f = np.zeros((3, 3, 3))
    f[0, 1, 1], f[0, 2, 2], f[1, 2, 0] = 2.0, -2.0, 1.0
    np.testing.assert_array_equal(from_generators(sl2()).structure_constants, f - f.transpose(1, 0, 2))
    f = np.zeros((3, 3, 3))
    f[0, 1, 2] = 1.0
    np.testing.assert_array_equal(from_generators(heisenberg()).structure_constants, f - f.transpose(1, 0, 2))


def test_structure_constants_do_not_depend_on_how_badly_generators_are_scaled():
    scales = np.array([1e-6, 1.0, 1e5])
    oblique = np.einsum("ab,bij->aij", np.array([[1.0, 0.2, 0.3], [0.5, 1.0, -0.7], [-0.4, 0.6, 1.0]]), sl2())
    found = from_generators(oblique * scales[:, np.newaxis, np.newaxis]).structure_constants
    plain = from_generators(oblique).structure_constants
    back = found * scales / (scales[:, np.newaxis, np.newaxis] * scales[:, np.newaxis])
    np.testing.assert_allclose(back, plain, rtol=0, atol=2e-15 * np.abs(plain).max())


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 2e-7])
def test_nearly_parallel_generators_keep_their_digits(gap):
    T = so4_split()
    T[1] = T[0] + gap * T[1]
    f = from_generators(T).structure_constants
    np.testing.assert_allclose(f[0, 1, 2], gap, rtol=1e-14 / gap)
    back = np.einsum("abc,cij->abij", f, T)
    product = np.einsum("aij,bjk->abik", T, T)
    np.testing.assert_allclose(back, product - product.transpose(1, 0, 2, 3), rtol=0, atol=1e-9)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_generated_and_named_groups_agree(n):
    for named in (SO(n), SU(n)):
        found = from_generators(named.generators, name="again")
        x = 0.4 * np.random.default_rng(51).normal(size=named.dimension)
        np.testing.assert_allclose(found.structure_constants, named.structure_constants, rtol=0, atol=1e-15)
        np.testing.assert_allclose(found.exp(x), named.exp(x), rtol=0, atol=1e-15)
        np.testing.assert_allclose(found.log(named.exp(x)), x, rtol=0, atol=1e-14)


def test_rigid_motions_are_recognised_by_their_logarithm():
    group = from_generators(se3(), name="SE(3)")
    motion = np.eye(4)
    motion[:3] = np.c_[SO(3).exp([0.3, -2.0, 1.0]), [5.0, -3.0, 100.0]]
    assert group.contains(motion)
    np.testing.assert_allclose(group.exp(group.log(motion)), motion, rtol=0, atol=1e-11)
    assert not group.contains(np.diag([1.0, 1.0, 1.0, 2.0]))
    assert not group.contains(np.diag([-1.0, -1.0, 1.0, 1.0]))
    assert not group.contains(np.zeros((4, 4)))
    assert not group.contains(np.full((4, 4), np.inf))


def test_positive_numbers_have_the_logarithm_of_a_calculator():
    group = from_generators([[[1.0]]], name="dilations")
    numbers = np.concatenate([np.logspace(-300, 300, 61), np.linspace(0.05, 2.0, 79)])
    logs = group.log(numbers[:, np.newaxis, np.newaxis])[:, 0]
    np.testing.assert_allclose(logs, np.log(numbers), rtol=2e-15, atol=1e-15)


def test_closure_is_asked_for_over_the_reals():
    pauli = np.array([[[0, 1], [1, 0]], [[0, -1j], [1j, 0]], [[1, 0], [0, -1]]])
    with pytest.raises(InputError):
        from_generators(pauli)
    assert from_generators(np.concatenate([pauli, 1j * pauli]), name="SL(2, C)").dimension == 6


def torus() -> MatrixLieGroup:
    """One turn that winds about two circles."""
    return from_generators([np.diag([1j, np.sqrt(2.0) * 1j])], name="torus")


UNRECOGNISED = {
    "torus": (torus(), np.diag(np.exp([4j, 4j * np.sqrt(2.0)]))),
    "SU(3)": (from_generators(SU(3).generators, name="su(3)"), np.diag(np.exp([2j, 2.1j, -4.1j]))),
}


@pytest.mark.parametrize(("group", "element"), UNRECOGNISED.values(), ids=UNRECOGNISED)
def test_an_element_beyond_the_principal_logarithm_is_not_called_off_the_group(group, element):
    assert not group.contains(element)
    with pytest.raises(InputError):
        group.log(element)
    np.testing.assert_allclose(group.inverse(element) @ element, np.eye(group.size), rtol=0, atol=1e-15)
    turned = element @ group.generators @ np.linalg.inv(element)
    expected = np.array([group.vee(matrix) for matrix in turned]).T
    np.testing.assert_allclose(group.Ad(element), expected, rtol=0, atol=1e-14)


RULED_OUT = {
    "reflection": (SO(3).generators, np.diag([1.0, 1.0, -1.0])),
    "scaled": (SO(3).generators, 1.001 * np.eye(3)),
    "sheared": (se3(), np.eye(4) + 1e-3 * unit(0, 1, 4)),
    "projective": (se3(), np.eye(4) + 1e-3 * unit(3, 0, 4)),
    "singular": (sl2(), np.ones((2, 2))),
    "singular to rounding": (se3(), np.array([[1, 2, 3, 4], [0.1, 0.7, 3, 2], [1.1, 2.7, 6, 6], [1, 1, 0.3, 2]])),
    "infinite": (sl2(), np.diag([np.inf, 1.0])),
    "not a number": (heisenberg(), np.full((3, 3), np.nan)),
    "dilated": ([np.diag([1j, np.sqrt(2.0) * 1j])], 2.0 * np.eye(2)),
    "turned": ([np.diag([1.0, 2.0]) + 0j], 1j * np.eye(2)),
}


@pytest.mark.parametrize(("generators", "matrix"), RULED_OUT.values(), ids=RULED_OUT)
def test_what_no_element_can_be_is_refused(generators, matrix):
    group = from_generators(generators)
    for function in (group.Ad, group.inverse):
        with pytest.raises(InputError):
            function(matrix)


@pytest.mark.parametrize("reach", [1.0, 1e4, 1e8])
def test_far_rigid_motions_are_ruled_in(reach):
    """Their condition number is the square of their reach, and the inverse is known."""
    group, turn = from_generators(se3()), SO(3).exp([0.3, -2.0, 1.0])
    shift = reach * np.array([0.5, -0.7, 0.2])
    motion, back = np.eye(4), np.eye(4)
    motion[:3], back[:3] = np.c_[turn, shift], np.c_[turn.T, -turn.T @ shift]
    np.testing.assert_allclose(group.inverse(motion), back, rtol=0, atol=1e-15 * reach)


@pytest.mark.parametrize("size", [1e-49, 1e49])
def test_generators_of_any_other_size_serve(size):
    group = from_generators(size * SO(3).generators)
    np.testing.assert_allclose(group.structure_constants, size * SO(3).structure_constants, rtol=1e-14, atol=0)
    np.testing.assert_allclose(group.exp([0.0, 0.1 / size, 0.0]), SO(3).exp([0.0, 0.1, 0.0]), rtol=0, atol=1e-15)


@pytest.mark.parametrize("make", GENERATED.values(), ids=GENERATED)
def test_the_generators_given_are_not_shared(make):
    given = make()
    group = from_generators(given)
    given[0] += 1.0
    np.testing.assert_array_equal(group.generators, make())
    for array in (group.generators, group.structure_constants, group.adjoint_representation, group.trace_metric):
        with pytest.raises(ValueError):
            array[0] = 0.0
