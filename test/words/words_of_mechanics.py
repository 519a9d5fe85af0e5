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
    inertia_from_second_moment,
    moments_of_density,
    moments_of_points,
    moments_on_grid,
    rotated_second_moment,
    second_moment_about,
)

BODY = RigidBody([1.0, 2.0, 2.5])
UNIT = np.eye(3)
OF_STATES = ("body_momentum", "angular_acceleration", "angular_momentum", "kinetic_energy")

REFUSED = {
    LieRigidBodyError: [
        lambda: RigidBody("heavy"),
        lambda: RigidBody([10**400]),
        lambda: RigidBody(np.ma.masked_array([1.0, 2.0, 2.5], mask=[False, True, True])),
        lambda: RigidBody([1.0, 1.0, np.nan]),
        lambda: RigidBody(1j * UNIT),
        lambda: RigidBody(np.ones((4, 6))),
        lambda: RigidBody([[2.0, 0.1], [0.0, 1.0]]),
        lambda: RigidBody(np.triu(np.ones((3, 3)))),
        lambda: RigidBody([-0.1, 2.0, 3.0]),
        lambda: RigidBody([1.0, 1.0, 2.1]),
        lambda: RigidBody([0.0833333, 0.0833333, 0.166667]),
        *(lambda name=name: getattr(BODY, name)(np.ones(3)) for name in OF_STATES),
        lambda: State([0, 0, 0, 1], np.array([0.0, 1.0, np.longdouble("1e400")])),
        lambda: State([0, 0, 1], [0, 0, 0]),
        lambda: State(np.ones((4, 9)), np.ones((9, 3))),
        lambda: State([0, 0, 0, 1.00001], [0, 0, 0]),
        lambda: State([[0, 0, 0, 1]], [0, 0, 0]),
        lambda: box(1.0, [1.0, -2.0]),
        lambda: ball(1.0, 1.0, 0),
        lambda: ball(1.0, 1.0, 2.5),
        lambda: MassMoments(1.0, np.zeros(3), np.diag([1, 1, -0.5])),
        lambda: MassMoments(1.0, np.zeros(2), np.array([[1.0, 0.5], [0.0, 1.0]])),
        lambda: ball(1.0, 1.0) + ball(1.0, 1.0, 4),
        lambda: ball(1.0, 1.0) - ball(1.0, 1.0),
        lambda: rotated_second_moment(UNIT, 2 * UNIT),
        lambda: second_moment_about(UNIT, 1.0, [0.0, 0], [0, 0]),
        lambda: inertia_from_second_moment(np.eye(4)),
        lambda: moments_of_points(np.eye(2), [1.0, -0.25]),
        lambda: moments_on_grid(np.ones((2, 2)), [0, 1], [1, 1]),
        lambda: moments_of_density(lambda x: x[:, 0], [(0, 1)], nodes=2),
        lambda: moments_of_density(lambda x: x[:, 0], []),
        lambda: moments_of_density(lambda x: x[:, 0], [(0, 1)] * 6),
        lambda: moments_of_density(lambda x: np.where(x[:, 0] < 0.3, 1.0, 4.0), [(0, 1)]),
    ],
}
