"""What the room `mechanics` says when it refuses."""
# mypy: ignore-errors

from __future__ import annotations

import numpy as np

from lie_rigid_body import RigidBody, State
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.mechanics import (
    MassMoments,
    ball,
    box,
    cylinder,
    disc,
    ellipsoid,
    inertia_from_second_moment,
    moments_of_density,
    moments_of_points,
    moments_on_grid,
    rod,
    rotated_second_moment,
    second_moment_about,
    second_moment_from_inertia,
)

BODY = RigidBody([1.0, 2.0, 2.5])
UNIT = np.eye(3)
OF_STATES = ("body_momentum", "angular_acceleration", "angular_momentum", "kinetic_energy")

NO_MOMENTS = [[1.0, 1.0, np.nan], [1.0, np.inf, 1.0], [0.0, 1.0, 1.0], [1.0, 2.0], [1.0, 2.0, 0.0, 1.0, 0.0, 3.0]]
NO_MOMENTS += [np.ones((5, 3)), np.empty((0, 3, 3))]
NO_INERTIAS = [np.diag([1, 1, 2.1]), np.eye(2), np.diag([1e308, 2, 3])]
NO_GRIDS = [
    (np.ones((2, 2)), [0, 1], [1, 1]),
    (-np.ones((2, 2)), [0, 0], [1, 1]),
    (np.ones((2, 2)), [0], [1]),
    (np.ones((2, 0)), [0, 0], [1, 1]),
    (1.0, [0], [1]),
]
NO_ENDS = [[], 3, [[0, 0, 0], [1, 1, 1]], "ab", [(1, 0)], [(0, np.inf)]]

REFUSED = {
    LieRigidBodyError: [
        lambda: RigidBody("heavy"),
        lambda: RigidBody([10**400]),
        lambda: RigidBody(np.ma.masked_array([1.0, 2.0, 2.5], mask=[False, True, True])),
        *(lambda moments=moments: RigidBody(moments) for moments in NO_MOMENTS),
        lambda: RigidBody([UNIT, UNIT]),
        lambda: RigidBody(1j * UNIT),
        lambda: RigidBody(np.ones((4, 6))),
        lambda: RigidBody([[2.0, 0.1], [0.0, 1.0]]),
        lambda: RigidBody(np.triu(np.ones((3, 3)))),
        lambda: RigidBody([-0.1, 2.0, 3.0]),
        lambda: RigidBody([1.0, 1.0, 2.1]),
        lambda: RigidBody.from_second_moment(np.diag([1, 1, -1])),
        lambda: RigidBody.from_second_moment(rod(1.0, 1.0).second_moment),
        lambda: RigidBody([0.0833333, 0.0833333, 0.166667]),
        *(lambda name=name: getattr(BODY, name)(np.ones(3)) for name in OF_STATES),
        lambda: State([0, 0, 0, 1], np.array([0.0, 1.0, np.longdouble("1e400")])),
        *(
            lambda attitude=attitude: State(attitude, [0, 0, 0])
            for attitude in ([0, 0, 1], [0, 0, 0, 0], [0, 0, 0, np.nan])
        ),
        *(lambda rate=rate: State([0, 0, 0, 1], rate) for rate in ([0, np.inf, 0], [0, 0])),
        lambda: State([[[0, 0, 0, 1], [0, 0, 0, 2]]], np.zeros((1, 2, 3))),
        lambda: State([[0, 0, 0, 1]] * 2, [[0, 0, 0], [0, np.inf, 0]]),
        lambda: State(np.ones((4, 9)), np.ones((9, 3))),
        lambda: State([0, 0, 0, 1.00001], [0, 0, 0]),
        lambda: State([[0, 0, 0, 1]], [0, 0, 0]),
        *(lambda mass=mass: disc(mass, 0.1) for mass in (-1.0, 0.0, np.nan)),
        *(lambda radius=radius: ball(1.0, radius) for radius in (0.0, -0.1)),
        *(lambda dimension=dimension: ball(1.0, 1.0, dimension) for dimension in (0, 2.5, "3")),
        *(lambda axes=axes: ellipsoid(1.0, axes) for axes in ([1.0, -2.0], 1.0)),
        *(lambda edges=edges: box(1.0, edges) for edges in ([1.0, -2.0], [], [1.0, np.inf])),
        lambda: cylinder(1.0, 1.0, -1.0),
        *(lambda length=length: rod(1.0, length) for length in (np.nan, 1e308)),
        lambda: MassMoments(0.0, np.zeros(2), np.eye(2)),
        lambda: MassMoments(1.0, np.zeros(2), UNIT),
        lambda: MassMoments(1.0, np.zeros(3), np.diag([1, 1, -0.5])),
        lambda: MassMoments(1.0, np.zeros(2), np.array([[1.0, 0.5], [0.0, 1.0]])),
        lambda: ball(1.0, 1.0) + ball(1.0, 1.0, 4),
        lambda: ball(1.0, 1.0) - ball(1.0, 1.0),
        lambda: ball(2.0, 1.0) - ball(1.0, 3.0),
        *(lambda turn=turn: ball(1.0, 1.0).rotated(turn) for turn in (2 * UNIT, np.eye(2))),
        lambda: ball(1.0, 1.0).moved(UNIT, [1.0]),
        lambda: ball(1.0, 1.0).about([1.0]),
        *(lambda turn=turn: rotated_second_moment(UNIT, turn) for turn in (2 * UNIT, 1e160 * UNIT)),
        lambda: rotated_second_moment(1e308 * np.ones((3, 3)), UNIT),
        lambda: second_moment_about(UNIT, 1.0, [0.0, 0], [0, 0]),
        lambda: second_moment_about(UNIT, 1.0, [2.0, 0, 0], [0, 0, 0]),
        *(lambda K=K: inertia_from_second_moment(K) for K in (np.eye(4), 1e308 * UNIT)),
        *(lambda inertia=inertia: second_moment_from_inertia(inertia) for inertia in NO_INERTIAS),
        *(
            lambda masses=masses: moments_of_points(np.eye(2), masses)
            for masses in ([1.0, -0.25], np.ones(5), np.zeros(2))
        ),
        lambda: moments_of_points(np.eye(2) - np.inf, np.ones(2)),
        *(lambda given=given: moments_on_grid(*given) for given in NO_GRIDS),
        *(lambda density=density: moments_of_density(density, [(0, 1)]) for density in (np.ones(4), None, 1.0)),
        *(lambda ends=ends: moments_of_density(lambda x: x[:, 0], ends) for ends in NO_ENDS),
        *(lambda nodes=nodes: moments_of_density(lambda x: x[:, 0], [(0, 1)], nodes) for nodes in ("x", [1], 4.5, 2)),
        lambda: moments_of_density(lambda x: x[:, 0], [(0, 1)] * 2, 10**4000),
        lambda: moments_of_density(lambda x: x[:, 0], [(0, 1)] * 6),
        lambda: moments_of_density(lambda x: x[:, 0], [(-1, 1)]),
        lambda: moments_of_density(lambda x: 1.0, [(-1, 1)]),
        lambda: moments_of_density(lambda x: np.ones(3), [(-1, 1)]),
        lambda: moments_of_density(lambda x: np.full(len(x), np.nan), [(-1, 1)]),
        lambda: moments_of_density(lambda x: np.where(x[:, 0] < 0.3, 1.0, 4.0), [(0, 1)]),
    ],
}
