"""What the room `groups` says when it refuses."""
# mypy: ignore-errors

from __future__ import annotations

import numpy as np
from sample_groups import affine_line, sl2, so4_split

from lie_rigid_body import LieRigidBodyError, RigidBody, groups
from lie_rigid_body.groups import (
    SO,
    SU,
    U1,
    GroupMovingChart,
    GroupState,
    Hamiltonian,
    Lagrangian,
    MatrixLieGroup,
    ad_star,
    casimirs,
    chart_metric,
    chasles,
    conserved_momenta,
    double_cover,
    inverse_legendre_transform,
    lie_poisson_bracket,
    manakov_integrals,
    mass_matrix,
    momentum_matrix,
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


GENERATORS = SO(3).generators
SHIFT = np.zeros((3, 3))
SHIFT[0, 2] = 0.7
NO_GENERATORS = [
    so4_split()[[0, 3, 1]],
    so4_split()[:3] + 1e-6 * np.eye(4),
    [GENERATORS[2], SHIFT],
    [GENERATORS[0], 3.0 * GENERATORS[0], *GENERATORS[1:]],
    [[[1.0]], [[2.0]], [[3.0]]],
    np.zeros((2, 3, 4)),
    np.zeros((0, 3, 3)),
    [np.eye(2), np.eye(3)],
    "SO(3)",
    *([GENERATORS[0], size * GENERATORS[1]] for size in (1e-200, 1e-51, 1e51, 1e200)),
]
NO_COORDINATES = (0.0, list("abcdef"), ["1"] * 6, [[0.0] * 6, [0.0]])
NOT_NEAR = [
    (SO(3), np.diag([1.0, 1.0, -1.0])),
    (SO(3), np.full((3, 3), np.nan)),
    (SU(3), np.zeros((3, 3))),
]
NO_LOGARITHM = [
    (SU(3), np.exp(2j * np.pi / 3) * np.eye(3)),
    (product(SO(2), SU(2)), np.diag([-1.0, -1.0, 1.0, 1.0])),
]
V, M = [0.3, -0.5, 0.8], np.diag([1.0, 2.0, 3.0])
STATE = GroupState(np.eye(3), np.array(V))
OF_A_GROUP = {
    **dict.fromkeys(("casimirs", "chart_reach", "momentum_matrix", "poisson_tensor"), (V,)),
    **dict.fromkeys(("conserved_momenta", "Hamiltonian", "Lagrangian", "metric_derivative"), (M,)),
    **dict.fromkeys(("invariant_form", "killing_form", "quadratic_casimirs"), ()),
    "ad_star": (V, V),
    "lie_poisson_bracket": (V, V, V),
    "spatial_momentum": (np.eye(3), V),
}
"""Arguments behind the group."""
OF_A_LAGRANGIAN = {
    **dict.fromkeys(("christoffel_symbols", "connection_coefficients", "legendre_transform", "steady_axes"), ()),
    **dict.fromkeys(("chart_metric", "linearisation", "steady_rotation"), (V,)),
    "GroupMovingChart": (STATE,),
    "metric_at": (np.eye(3),),
}
NO_MATRICES = (np.ones(6), np.zeros((3, 4, 5)), None, np.array(list("abc")), SO(4), np.full((4, 4), np.nan))
OF_MATRICES = ("coordinates", "off_span", "vee", "restored", "project", "contains", "log", "inverse", "Ad")
NO_NUMBERS = ("x", None, np.ones(3), 10**400, np.nan)
NO_SHAPES = ("x", (-1,), 1.5, None, (2, "x"), [[1], [2, 3]])
NO_NAMES = ("SE", "SE3", "U2", "SO3", "SL", "Spin")
FAR = np.eye(4) + np.diag([1e308, 0.0, 0.0], 1)
NOT_ANTISYMMETRIC = (np.zeros((2, 3)), np.eye(2), np.full((2, 2), np.nan), [["a", "b"], ["c", "d"]])
NO_BODIES = (np.diag([1.0, 1.0, -1.0]), np.triu(np.ones((3, 3))), np.full((3, 3), np.nan))
POINTS = [
    (np.eye(3), np.eye(3)[:2]),
    (np.eye(3)[0], np.eye(3)[0]),
    (np.eye(3), np.eye(3) * np.nan),
    (np.eye(3) * 1j, np.eye(3)),
    ("here", "there"),
    (np.zeros((0, 3)), np.zeros((0, 3))),
    (np.eye(3), np.eye(3), [1.0, 1.0]),
    (np.eye(3), np.eye(3), [0.0, 0.0, 0.0]),
]


NO_METRICS = [
    *(np.eye(2), np.ones(3), "heavy", np.diag([1.0, np.nan, 1.0]), np.eye(3) + np.eye(3, k=1), np.zeros((3, 3))),
    *(np.diag([1.0, 0.0, 1.0]), np.diag([1.0, 1.0, 1e-16])),
]
NO_MASSES = [
    (np.diag([1, 1, -1e-9]), GENERATORS),
    ([[1.0, 1e-9], [0.0, 1.0]], SO(2).generators),
    (np.ones((2, 3)), SO(2).generators),
    (np.eye(3), SO(4).generators),
    (np.eye(3), 1j * GENERATORS),
    (np.eye(3), GENERATORS, np.eye(4)),
]
OFF_THE_COVER = [
    ("rotation", 2.0 * np.eye(2)),
    ("to_quaternion", np.eye(3)),
    ("from_quaternion", [0.0, 0.0, 1.0]),
    ("preimages", -np.eye(3)),
    ("preimages", np.eye(2)),
]


def called(name, *arguments):
    return getattr(groups, name)(*arguments)


def of_so4(name, *arguments):
    return getattr(SO(4), name)(*arguments)


REFUSED = {
    LieRigidBodyError: [
        *(lambda name=name, more=more: called(name, TOP, *more) for name, more in OF_A_GROUP.items()),
        *(lambda name=name, more=more: called(name, SO(3), *more) for name, more in OF_A_LAGRANGIAN.items()),
        *(lambda name=name: of_so4(name, np.zeros((3, 3))) for name in OF_MATRICES),
        *(lambda given=given: of_so4("vee", given) for given in NO_MATRICES),
        *(lambda name=name: of_so4(name, FAR) for name in ("log", "inverse", "as_elements", "Ad", "off_span")),
        *(lambda given=given: of_so4("contains", np.eye(4), given) for given in NO_NUMBERS),
        *(lambda given=given: of_so4("scaled_trace", given) for given in NO_NUMBERS),
        *(lambda shape=shape: of_so4("random", np.random.default_rng(1), shape) for shape in NO_SHAPES),
        *(lambda p=p: pfaffian(p) for p in NOT_ANTISYMMETRIC),
        *(lambda p=p: rotation_casimirs(p) for p in NOT_ANTISYMMETRIC),
        *(lambda p=p: unitary_casimirs(p) for p in NOT_ANTISYMMETRIC),
        *(lambda k=k: manakov_integrals(np.zeros((3, 3)), k) for k in NO_BODIES),
        *(lambda factor=factor: called("spatial_momentum", SO(3), factor * np.eye(3), V) for factor in (2.0, np.nan)),
        *(lambda factor=factor: called("metric_at", TOP, factor * np.eye(3)) for factor in (2.0, np.nan)),
        *(lambda points=points: chasles(*points) for points in POINTS),
        *(lambda given=given: from_generators(given) for given in NO_GENERATORS),
        *(lambda given=given: of_so4("exp", given) for given in NO_COORDINATES),
        *(lambda group=group, matrix=matrix: group.project(matrix) for group, matrix in NOT_NEAR),
        *(lambda group=group, matrix=matrix: group.log(matrix) for group, matrix in NO_LOGARITHM),
        *(lambda m=m: Lagrangian(SO(3), m) for m in NO_METRICS),
        *(lambda given=given: mass_matrix(*given) for given in NO_MASSES),
        *(lambda step=step: TOP.action(np.stack([np.eye(3)] * 3), step) for step in (0, -0.1, "a", np.nan)),
        *(lambda rate=rate: steady_rotation(TOP, rate) for rate in ([1.0, 1e-3, 0.0], [1.0, 0.0], [np.nan, 0.0, 0.0])),
        *(lambda name=name, given=given: getattr(double_cover, name)(given) for name, given in OFF_THE_COVER),
        lambda: Hamiltonian(SO(3), np.diag([1.0, 1.0, -1.0])),
        lambda: Hamiltonian(SO(3), np.eye(3)).equations(1.0),
        lambda: lie_poisson_bracket(SO(3), V, np.ones(4), V),
        lambda: conserved_momenta(SO(4), np.eye(3)),
        lambda: chart_metric(TOP, V[:2]),
        lambda: TOP.acceleration(V[:2]),
        lambda: momentum_matrix(affine_line(), V[:2]),
        lambda: casimirs(product(SO(3), from_generators(sl2())), np.ones(6)),
        lambda: product([SO(3), SU(2)]),
        lambda: from_generators(
            1j * np.array([[[0.0, 1.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, -1.0]], [[0, -1], [1, 0]]])
        ),
        lambda: from_generators(-2.0 * SU(2).generators[:2]),
        lambda: from_generators(GENERATORS).project(np.eye(3)),
        lambda: product(SO(40), SO(40)),
        lambda: mass_matrix(RigidBody([0.6, 0.8, 1.0]), SO(3).generators),
        lambda: mass_matrix(np.eye(3), SO(3)),
        lambda: mass_matrix(np.diag(np.full(4, 1e308)), SO(4).generators),
        lambda: ad_star(SO(3), V[:2], V),
        lambda: GroupMovingChart(TOP, STATE, method="rkmk9"),
        lambda: GroupMovingChart(TOP, STATE).at([10, 5]),
        lambda: mass_matrix(box(mass=2.0, edges=[0.3, 0.2, 0.1]), SO(3).generators),
        lambda: GroupMovingChart(TOP, 7),
        lambda: SO(4).exp(np.zeros(6) + 1j),
        lambda: SO(4).vee(np.eye(3)),
        lambda: SO(4).log(np.eye(4) + 0j),
        lambda: SO(4).vee(np.eye(4)),
        lambda: TOP.momenta([1e308, 1e308, 1e308]),
        lambda: product(),
        lambda: product(3),
        lambda: inverse_legendre_transform(TOP),
        lambda: SO(3).random(1),
        lambda: Lagrangian(SO(3), RigidBody([0.6, 0.8, 1.0])),
        lambda: TOP.action(np.eye(3), 0.1),
        lambda: U1().project([[0.0]]),
        lambda: SU(2).log(-np.eye(2)),
        lambda: SO(3).dexpinv([0.0, 2 * np.pi, 0.0]),
        lambda: from_generators([np.eye(2), [[1.0, np.nan], [0.0, 1.0]]]),
        lambda: from_generators([SO(3).generators[0], np.zeros((3, 3))]),
        lambda: from_generators(2j * SU(2).generators),
        lambda: from_generators(SO(3).generators).log(np.diag([-1.0, -1.0, 1.0])),
        lambda: torus().log(np.diag(np.exp([4j, 4j * np.sqrt(2.0)]))),
        lambda: Lagrangian(SO(3), np.diag([1.0, -1.0, 2.0])),
        lambda: mass_matrix(np.eye(3), np.stack([np.eye(3)])),
        lambda: rotation_casimirs(np.zeros((0, 0))),
        lambda: manakov_integrals(np.zeros((3, 3)), np.eye(4)),
        lambda: casimirs(from_generators(sl2()), np.ones(3)),
        lambda: steady_axes(Lagrangian(affine_line(), np.eye(2))),
        lambda: steady_rotation(TOP, [1.0, 1.0, 0.0]),
        lambda: chasles(np.ones((4, 1)), np.ones((4, 1))),
        lambda: chasles(np.eye(3), np.eye(3), [1.0, 1.0, -0.5]),
        lambda: chasles(np.eye(3), np.eye(3), [1.0, 1.0, 0.0]),
        lambda: double_cover.lift(np.eye(3)),
        lambda: double_cover.lift(SO(3).exp([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])),
        lambda: double_cover.from_quaternion([0.0, 0.0, 0.0, 1.1]),
        lambda: GroupMovingChart(TOP, GroupState(np.eye(3), np.full(3, 10.0)), max_step=0.2).at(10**9),
    ],
    ImportError: [lambda name=name: exec(f"from lie_rigid_body.groups import {name}") for name in NO_NAMES],
}
