"""What the room `groups` says when it refuses: the value, the limit and the remedy; digits of round-off are a star."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from group_bodies import affine_line
from sample_groups import sl2, so4_split

from lie_rigid_body import LieRigidBodyError, RigidBody
from lie_rigid_body.groups import (
    SO,
    SU,
    U1,
    GroupMovingChart,
    GroupState,
    Lagrangian,
    MatrixLieGroup,
    casimirs,
    chasles,
    coadjoint_action,
    double_cover,
    inverse_legendre_transform,
    killing_form,
    legendre_transform,
    manakov_integrals,
    mass_matrix,
    pfaffian,
    product,
    rotation_casimirs,
    steady_axes,
    steady_rotation,
    unitary_casimirs,
)
from lie_rigid_body.mechanics import box

TOP = Lagrangian(SO(3), np.diag([1.0, 2.0, 3.0]))
OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
from_generators: Any = MatrixLieGroup.from_generators


def torus() -> MatrixLieGroup:
    """One turn that winds about two circles."""
    group: MatrixLieGroup = from_generators([np.diag([1j, np.sqrt(2.0) * 1j])])
    return group


def noisy_line() -> list[np.ndarray]:
    """Points of a line, measured twice."""
    rng = np.random.default_rng(0)
    line = np.outer(rng.normal(size=9), [1.0, 2.0, 3.0])
    return [line + 1e-3 * rng.normal(size=line.shape) for _ in range(2)]


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (
            lambda: mass_matrix(box(mass=2.0, edges=[0.3, 0.2, 0.1]), SO(3).generators),  # type: ignore[arg-type]
            "second moment: a MassMoments was given: give its second_moment",
        ),
        (
            lambda: GroupMovingChart(TOP, 7),  # type: ignore[arg-type]
            "start: 7 is no state: give GroupState(element, rate)",
        ),
        (
            lambda: SO(4).hat(np.zeros(5)),
            "coordinates: shape (5,) is not (..., 6): put a component for each generator on the last axis",
        ),
        (
            lambda: SO(4).exp(np.zeros(6) + 1j),
            "coordinates: complex numbers of type complex128: give their real part if that is meant",
        ),
        (
            lambda: SO(4).vee(np.eye(3)),
            "matrices of SO(4): shape (3, 3) is not (..., 4, 4): put rows and columns on the last two axes",
        ),
        (
            lambda: SO(4).log(np.eye(4) + 0j),
            "matrices of SO(4): complex numbers of type complex128: give their real part if that is meant",
        ),
        (
            lambda: SO(4).vee(np.eye(4)),
            "a matrix lies outside the span of the generators by 1 of its size (limit 1e-09): give a "
            "combination of them",
        ),
        (
            lambda: SO(1),
            "n: 1 is no whole number from 2 to 40: give one",
        ),
        (
            lambda: TOP.momenta([1e308, 1e308, 1e308]),
            "momenta: a result is beyond double precision, 1.8e308: give smaller numbers",
        ),
        (
            lambda: coadjoint_action(SO(3), np.ones((2, 3)), np.ones((3, 3))),
            "leading axes (2,) of rate, (3,) of momentum do not go together: give equal ones, or 1 for all",
        ),
        (
            lambda: SO(3).contains(np.eye(3), "x"),  # type: ignore[arg-type]
            "tolerance: 'x' is not numbers: give an array of them, in equal rows",
        ),
        (
            lambda: product(),
            "product() of 0 groups (limit 1): give at least one group",
        ),
        (
            lambda: product(3),  # type: ignore[arg-type]
            "product() of 3, which is no MatrixLieGroup: give groups as arguments of their own, as "
            "product(SO(3), SU(2))",
        ),
        (
            lambda: killing_form(TOP),  # type: ignore[arg-type]
            "Lagrangian(...) is no MatrixLieGroup: give a group, as SO(3) or lagrangian.group",
        ),
        (
            lambda: legendre_transform(SO(3)),  # type: ignore[arg-type]
            "<SO(3): dimension 3, 3×3 matrices> is no Lagrangian: give Lagrangian(group, metric)",
        ),
        (
            lambda: inverse_legendre_transform(TOP),  # type: ignore[arg-type]
            "Lagrangian(...) is no Hamiltonian: give legendre_transform(lagrangian)",
        ),
        (
            lambda: SO(3).random(1),  # type: ignore[arg-type]
            "1 is no Generator: give numpy.random.default_rng(seed)",
        ),
        (
            lambda: Lagrangian(SO(3), RigidBody([0.6, 0.8, 1.0])),  # type: ignore[arg-type]
            "metric: a RigidBody was given: give its inertia",
        ),
        (
            lambda: TOP.action(np.eye(3), 0.1),
            "path: shape (3, 3) is one element: stack two or more, at equal intervals",
        ),
        (
            lambda: MatrixLieGroup([[[1.0]]]),  # type: ignore[call-arg, arg-type]
            "MatrixLieGroup([[[1.0]]]) has no elements: make a group by SO(n), SU(n), U1(), product(group, …) or "
            "MatrixLieGroup.from_generators(matrices)",
        ),
        (
            lambda: SO(3).project(np.diag([1.0, 0.0, 0.0])),
            "no nearest rotation: the smallest singular values of a matrix leave a margin of 0 (limit 1e-12 of "
            "the largest), so that several are equally near; give a matrix nearer to one",
        ),
        (
            lambda: SU(2).project(np.diag([1.0, -1.0])),
            "no nearest element of SU(n): the singular values or the phase of a matrix leave a margin of 0 "
            "(limit 1e-12), so that several are equally near; give a matrix nearer to one",
        ),
        (
            lambda: U1().project([[0.0]]),
            "no nearest phase: 0 is equally near to all; give a number other than 0",
        ),
        (
            lambda: SO(3).inverse(2.0 * np.eye(3)),
            "a matrix is 7 off SO(3) (limit 1e-09): give an element of the group, or its projection by project()",
        ),
        (
            lambda: SO(4).log(np.diag([-1.0, -1.0, -1.0, -1.0])),
            "no principal logarithm: a plane turns by 3.14159265358979 rad (limit π − 1e-13), where either "
            "sense is right; give an element closer to the identity",
        ),
        (
            lambda: SU(2).log(-np.eye(2)),
            "no logarithm is singled out: the eigenvalues' angles spread over 6.28318530717959 rad (limit 2π − "
            "1e-13), where several are equally short; give an element closer to the identity",
        ),
        (
            lambda: U1().log([[-1.0]]),
            "no principal logarithm: a phase is −1 (within 1e-13 rad), where either sign of the angle is right;"
            " give an element closer to 1",
        ),
        (
            lambda: SO(3).dexpinv([0.0, 2 * np.pi, 0.0]),
            "dexpinv has entries of * (limit 1e+12): exp is not invertible there, as an eigenvalue of "
            "ad(x) is a multiple of 2πi; take x closer to 0",
        ),
        (
            lambda: from_generators(np.eye(3)),
            "generators: shape (3, 3) is not (d, n, n) with d, n ≥ 1: stack square matrices",
        ),
        (
            lambda: from_generators([np.eye(2), [[1.0, np.nan], [0.0, 1.0]]]),
            "T1 has an entry that is not a finite number: give finite generators",
        ),
        (
            lambda: from_generators([*SO(3).generators, 2.0 * SO(3).generators[0] - 0.5 * SO(3).generators[2]]),
            "the generators are dependent, T3 = +2 T0 -0.5 T2 over the reals: leave one of these out",
        ),
        (
            lambda: from_generators([SO(3).generators[0], np.zeros((3, 3))]),
            "T1 is zero: leave it out; for an algebra with a centre give other matrices than the adjoint ones",
        ),
        (
            lambda: from_generators([[[1.0]], [[1e60]]]),
            "the largest entry of T1 is 1e+60 (limits 1e-50 and 1e+50): rescale it, which changes the unit of "
            "its coordinate alone",
        ),
        (
            lambda: from_generators(so4_split()[[0, 3, 1]]),
            "[T0, T2] leaves the span by 1 (limit 1e-09), one of 1 commutators that do: add the matrices that it needs",
        ),
        (
            lambda: from_generators(2j * SU(2).generators),
            "the commutators are i times matrices of the span, and elements are exp(xᵃTᵃ) without an i: give −i times "
            "the generators",
        ),
        (
            lambda: from_generators(SO(3).generators).log(np.diag([-1.0, -1.0, 1.0])),
            "no principal logarithm: a matrix is singular, far from normal, or has an eigenvalue on the "
            "negative real axis (within 1e-13 rad); give an element closer to the identity",
        ),
        (
            lambda: torus().log(np.diag(np.exp([4j, 4j * np.sqrt(2.0)]))),
            "a matrix is not recognised as an element: its principal logarithm leaves the span of the "
            "generators by 1.5 (limit 1e-09); give an element closer to the identity",
        ),
        (
            lambda: torus().project(np.diag(np.exp([4j, 4j * np.sqrt(2.0)]))),
            "no nearest element found: the principal logarithm leads to one that is 1.43 of its size away "
            "(limit 0.5); give a matrix nearer to an element that contains() recognises",
        ),
        (
            lambda: Lagrangian(SO(3), np.eye(2)),
            "metric: shape (2, 2) is not (3, 3): give finite real numbers of shape (3, 3)",
        ),
        (
            lambda: Lagrangian(SO(3), np.diag([1.0, -1.0, 2.0])),
            "metric: smallest eigenvalue -1 is not positive beside the largest, 2 (limit: 1.4e-14 of that): "
            "give inertia about every axis, or rescale",
        ),
        (
            lambda: mass_matrix(np.eye(3), np.stack([np.eye(3)])),
            "generators: number 0 plus its transpose has an entry of 2 instead of 0: rotations of a body have "
            "antisymmetric generators, as those of SO(n)",
        ),
        (
            lambda: mass_matrix(np.eye(2), SU(2).generators),
            "generators: complex numbers: rotations of a body have real antisymmetric generators, as those of SO(n); "
            "for another group give Lagrangian a positive definite matrix",
        ),
        (
            lambda: pfaffian(np.eye(2)),
            "P: P + Pᵀ reaches 2, the limit is 1.42e-14: give an antisymmetric matrix",
        ),
        (
            lambda: unitary_casimirs(np.diag([1.0, -1.0])),
            "P: P + P† reaches 2, the limit is 1.42e-14: give an anti-Hermitian matrix",
        ),
        (
            lambda: rotation_casimirs(np.zeros((0, 0))),
            "P: shape (0, 0) has no rows: give momentum_matrix(group, p)",
        ),
        (
            lambda: manakov_integrals(np.zeros((3, 3)), np.eye(4)),
            "P: shape (3, 3) does not go with K of shape (4, 4): give both of the same body",
        ),
        (
            lambda: casimirs(from_generators(sl2()), np.ones(3)),
            "the Casimirs of G are not known: give SO(n), SU(n), U(1) or a product of these, or take "
            "quadratic_casimirs",
        ),
        (
            lambda: steady_axes(Lagrangian(affine_line(), np.eye(2))),
            "G has no regular invariant form, as tr(TᵃTᵇ) is singular: give a semisimple or compact group, or "
            "take quadratic_casimirs or steady_rotation",
        ),
        (
            lambda: steady_rotation(TOP, [1.0, 1.0, 0.0]),
            "the rotation at rate [1.0, 1.0, 0.0] is not steady: its momentum turns by 0.316 of |ω||p|, "
            "the limit is 1e-09: take a rate that keeps its momentum, as steady_axes are if there are any",
        ),
        (
            lambda: steady_rotation(TOP, [np.nan, 0.0, 0.0]),
            "rates: nan is not finite: give finite numbers",
        ),
        (
            lambda: chasles(np.ones((4, 1)), np.ones((4, 1))),
            "points: 1 coordinate has no rotations: give at least 2 coordinates a point",
        ),
        (
            lambda: chasles(np.eye(3), np.eye(3), [1.0, 1.0, -0.5]),
            "weights: -0.5 is not allowed: give values of at least 0, some above 0",
        ),
        (
            lambda: chasles(np.eye(3), np.eye(3), [1.0, 1.0, 0.0]),
            "the rotation is not determined: about their centre the points and their images span rank 1 in 3 "
            "dimensions, and at least 2 is needed: add points off their common subspace",
        ),
        (
            lambda: chasles(OCTAHEDRON, -OCTAHEDRON),
            "not determined for a mirror image: the smallest singular values 2 and 2 (largest 2) must differ: "
            "undo the reflection, or add points that break the symmetry",
        ),
        (
            lambda: chasles(*noisy_line()),
            "the rotation is not determined: the images miss the points by * times the width of the body, which may be "
            "noise alone: add points off their common subspace, or measure them better",
        ),
        (
            lambda: double_cover.lift(np.eye(3)),
            "a path needs shape (N, 3, 3) with N ≥ 1, given (3, 3): stack its rotations",
        ),
        (
            lambda: double_cover.lift(SO(3).exp([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])),
            "the path turns by 2 rad from point 0 to 1 (limit π/2): sample it more finely",
        ),
        (
            lambda: double_cover.from_quaternion([0.0, 0.0, 0.0, 1.1]),
            "a quaternion's norm is 0.1 off 1 (limit 1e-09): normalize it",
        ),
        (
            lambda: GroupMovingChart(TOP, GroupState(2.0 * np.eye(3), np.zeros(3))),
            "the start is not an element of SO(3): a matrix is 7 off SO(3) (limit 1e-09): give an element of "
            "the group, or its projection by project()",
        ),
        (
            lambda: GroupMovingChart(TOP, GroupState(np.eye(4), np.zeros(3))),
            "start has shapes (4, 4) and (3,): give (3, 3) and (3,) for SO(3)",
        ),
        (
            lambda: GroupMovingChart(TOP, GroupState(np.eye(3), np.array([0.0, np.nan, 0.0]))),
            "rates: nan is not finite: give finite numbers",
        ),
        (
            lambda: GroupMovingChart(TOP, GroupState(np.eye(3), np.full(3, 10.0)), max_step=0.2).at(10**9),
            "within a step the chart turns by 3.4 rad (limit 3.14 rad): lower max_step",
        ),
        (
            lambda: GroupMovingChart(TOP, GroupState(np.eye(3), np.full(3, 1e200)), max_step=0.2).at(10**9),
            "within a step the chart turns by 1.73e+199 rad (limit 3.14 rad): lower max_step",
        ),
    ],
)
def test_a_refusal_in_one_line(build, said):
    with pytest.raises(LieRigidBodyError) as caught:
        build()
    assert re.fullmatch(re.escape(said).replace(r"\*", r"\S*"), str(caught.value))


def test_a_group_that_has_no_name_in_one_line():
    with pytest.raises(ImportError) as caught:
        exec("from lie_rigid_body.groups import SE3")
    assert str(caught.value) == (
        "there is no SE3: make it by SO(n), SU(n), U1(), product(group, …) or "
        "MatrixLieGroup.from_generators(matrices), as help(MatrixLieGroup.from_generators) does SE(3)"
    )
