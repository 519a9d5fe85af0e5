"""What the room `groups` says when it refuses."""
# mypy: ignore-errors

from __future__ import annotations

import numpy as np
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
from_generators = MatrixLieGroup.from_generators


def torus() -> MatrixLieGroup:
    """One turn that winds about two circles."""
    return from_generators([np.diag([1j, np.sqrt(2.0) * 1j])])


REFUSED = {
    LieRigidBodyError: [
        lambda: mass_matrix(box(mass=2.0, edges=[0.3, 0.2, 0.1]), SO(3).generators),
        lambda: GroupMovingChart(TOP, 7),
        lambda: SO(4).hat(np.zeros(5)),
        lambda: SO(4).exp(np.zeros(6) + 1j),
        lambda: SO(4).vee(np.eye(3)),
        lambda: SO(4).log(np.eye(4) + 0j),
        lambda: SO(4).vee(np.eye(4)),
        lambda: SO(1),
        lambda: TOP.momenta([1e308, 1e308, 1e308]),
        lambda: coadjoint_action(SO(3), np.ones((2, 3)), np.ones((3, 3))),
        lambda: SO(3).contains(np.eye(3), "x"),
        lambda: product(),
        lambda: product(3),
        lambda: killing_form(TOP),
        lambda: legendre_transform(SO(3)),
        lambda: inverse_legendre_transform(TOP),
        lambda: SO(3).random(1),
        lambda: Lagrangian(SO(3), RigidBody([0.6, 0.8, 1.0])),
        lambda: TOP.action(np.eye(3), 0.1),
        lambda: MatrixLieGroup([[[1.0]]]),
        lambda: SO(3).project(np.diag([1.0, 0.0, 0.0])),
        lambda: SU(2).project(np.diag([1.0, -1.0])),
        lambda: U1().project([[0.0]]),
        lambda: SO(3).inverse(2.0 * np.eye(3)),
        lambda: SO(4).log(np.diag([-1.0, -1.0, -1.0, -1.0])),
        lambda: SU(2).log(-np.eye(2)),
        lambda: U1().log([[-1.0]]),
        lambda: SO(3).dexpinv([0.0, 2 * np.pi, 0.0]),
        lambda: from_generators(np.eye(3)),
        lambda: from_generators([np.eye(2), [[1.0, np.nan], [0.0, 1.0]]]),
        lambda: from_generators([*SO(3).generators, 2.0 * SO(3).generators[0] - 0.5 * SO(3).generators[2]]),
        lambda: from_generators([SO(3).generators[0], np.zeros((3, 3))]),
        lambda: from_generators([[[1.0]], [[1e60]]]),
        lambda: from_generators(so4_split()[[0, 3, 1]]),
        lambda: from_generators(2j * SU(2).generators),
        lambda: from_generators(SO(3).generators).log(np.diag([-1.0, -1.0, 1.0])),
        lambda: torus().log(np.diag(np.exp([4j, 4j * np.sqrt(2.0)]))),
        lambda: torus().project(np.eye(2)),
        lambda: Lagrangian(SO(3), np.eye(2)),
        lambda: Lagrangian(SO(3), np.diag([1.0, -1.0, 2.0])),
        lambda: mass_matrix(np.eye(3), np.stack([np.eye(3)])),
        lambda: mass_matrix(np.eye(2), SU(2).generators),
        lambda: pfaffian(np.eye(2)),
        lambda: unitary_casimirs(np.diag([1.0, -1.0])),
        lambda: rotation_casimirs(np.zeros((0, 0))),
        lambda: manakov_integrals(np.zeros((3, 3)), np.eye(4)),
        lambda: casimirs(from_generators(sl2()), np.ones(3)),
        lambda: steady_axes(Lagrangian(affine_line(), np.eye(2))),
        lambda: steady_rotation(TOP, [1.0, 1.0, 0.0]),
        lambda: steady_rotation(TOP, [np.nan, 0.0, 0.0]),
        lambda: chasles(np.ones((4, 1)), np.ones((4, 1))),
        lambda: chasles(np.eye(3), np.eye(3), [1.0, 1.0, -0.5]),
        lambda: chasles(np.eye(3), np.eye(3), [1.0, 1.0, 0.0]),
        lambda: chasles(OCTAHEDRON, -OCTAHEDRON),
        lambda: double_cover.lift(np.eye(3)),
        lambda: double_cover.lift(SO(3).exp([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])),
        lambda: double_cover.from_quaternion([0.0, 0.0, 0.0, 1.1]),
        lambda: GroupMovingChart(TOP, GroupState(2.0 * np.eye(3), np.zeros(3))),
        lambda: GroupMovingChart(TOP, GroupState(np.eye(4), np.zeros(3))),
        lambda: GroupMovingChart(TOP, GroupState(np.eye(3), np.array([0.0, np.nan, 0.0]))),
        lambda: GroupMovingChart(TOP, GroupState(np.eye(3), np.full(3, 10.0)), max_step=0.2).at(10**9),
        lambda: GroupMovingChart(TOP, GroupState(np.eye(3), np.full(3, 1e200)), max_step=0.2).at(10**9),
    ],
    ImportError: [lambda: exec("from lie_rigid_body.groups import SE3")],
}
