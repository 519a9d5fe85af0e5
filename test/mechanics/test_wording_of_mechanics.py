"""What the room `mechanics` says when it refuses: the value, the limit and the remedy, in one line."""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body import LieRigidBodyError, RigidBody, State
from lie_rigid_body.foundation.wording import shown
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

UNIT = np.eye(3)


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (
            lambda: RigidBody("heavy"),
            "inertia: 'heavy' is not numbers: give an array of them, in equal rows",
        ),
        (
            lambda: RigidBody([10**400]),
            f"inertia: {shown([10**400])} is not numbers: give an array of them, in equal rows",
        ),
        (
            lambda: RigidBody(np.ma.masked_array([1.0, 2.0, 2.5], mask=[False, True, True])),
            "inertia: 2 of its numbers are masked: fill them in, or leave their rows out, with their stamps",
        ),
        (lambda: RigidBody([1.0, 1.0, np.nan]), "inertia: nan is not finite: give finite numbers"),
        (
            lambda: RigidBody(1j * UNIT),
            "inertia: complex numbers: give finite real numbers of shape (…)",
        ),
        (
            lambda: RigidBody(np.ones((4, 6))),
            "inertia: 24 numbers of shape (4, 6): give 3 principal moments or ixx ixy ixz iyy iyz izz, and many bodies "
            "as tensors (..., 3, 3) or by from_principal_moments",
        ),
        (
            lambda: RigidBody([[2.0, 0.1], [0.0, 1.0]]),
            "inertia: 4 numbers of shape (2, 2): give 3 principal moments or ixx ixy ixz iyy iyz izz, and many bodies "
            "as tensors (..., 3, 3) or by from_principal_moments",
        ),
        (
            lambda: RigidBody([UNIT, np.triu(np.ones((3, 3)))]),
            "inertia: [[1.0, 1.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]] is not symmetric: give equal entries across "
            "the diagonal",
        ),
        (
            lambda: RigidBody([-0.1, 2.0, 3.0]),
            "inertia: smallest principal moment -0.1 is not positive: give moments above 0 kg m²",
        ),
        (
            lambda: RigidBody([1.0, 1.0, 2.1]),
            "inertia: principal moments 1.0, 1.0, 2.1 break the triangle inequality: lower the largest to at most the "
            "sum of the others",
        ),
        *(
            (
                lambda name=name: getattr(RigidBody([1.0, 2.0, 2.5]), name)(np.ones(3)),
                "states: [1.0, 1.0, 1.0] is no State: give State(attitude_xyzw, body_rate)",
            )
            for name in ("body_momentum", "angular_acceleration", "angular_momentum", "kinetic_energy")
        ),
        (
            lambda: State([0, 0, 0, 1], np.array([0.0, 1.0, np.longdouble("1e400")])),
            "body_rate: inf is not finite: give finite numbers",
        ),
        (
            lambda: State([0, 0, 1], [0, 0, 0]),
            "attitude_xyzw: shape (3,) is not (…, 4): give finite real numbers of shape (…, 4)",
        ),
        (
            lambda: State(np.ones((4, 9)), np.ones((9, 3))),
            "attitude_xyzw: shape (4, 9) is not (…, 4): its rows are columns: transpose it, as array.T",
        ),
        (
            lambda: State([0, 0, 0, 1.00001], [0, 0, 0]),
            "attitude_xyzw: norm 1.00001 is not 1 within 1e-06: divide the quaternion x y z w by its norm",
        ),
        (
            lambda: State([[0, 0, 0, 1]], [0, 0, 0]),
            "body_rate: shape (3,) does not go with attitudes of shape (1, 4): give equal leading axes",
        ),
        (lambda: box(1.0, [1.0, -2.0]), "edges: -2 m is not positive: give more than 0 m"),
        (lambda: ball(1.0, 1.0, 0), "dimension: 0 is no whole number from 1 on: give one"),
        (
            lambda: ball(1.0, 1.0, 2.5),  # type: ignore[arg-type]
            "dimension: 2.5 is no whole number from 1 on: give one",
        ),
        (
            lambda: MassMoments(1.0, np.zeros(3), np.diag([1, 1, -0.5])),
            "second moment: smallest eigenvalue -0.5 is below 0 by more than round-off (-2.13e-14): give a positive "
            "semidefinite matrix, and check signs and units",
        ),
        (
            lambda: MassMoments(1.0, np.zeros(2), np.array([[1.0, 0.5], [0.0, 1.0]])),
            "second moment: entries across the diagonal differ by 0.5, more than round-off (1.42e-14): give a "
            "symmetric matrix",
        ),
        (
            lambda: ball(1.0, 1.0) + ball(1.0, 1.0, 4),
            "body: 4 dimensions where the first has 3: give both in one space",
        ),
        (
            lambda: ball(1.0, 1.0) - ball(1.0, 1.0),
            "mass: 0 kg would be left, not above 0 kg: subtract only a part of the body",
        ),
        (
            lambda: rotated_second_moment(UNIT, 2 * UNIT),
            "rotation: AᵀA differs from 1 by 3, more than 1e-09: give an orthogonal matrix, or project it onto the "
            "group",
        ),
        (
            lambda: second_moment_about(UNIT, 1.0, [0.0, 0], [0, 0]),
            "centre: shape (2,) is not (3,): give finite real numbers of shape (3,)",
        ),
        (
            lambda: inertia_from_second_moment(np.eye(4)),
            "second moment: 4 dimensions, where 3 have an inertia tensor: use mass_matrix in other dimensions",
        ),
        (
            lambda: moments_of_points(np.eye(2), [1.0, -0.25]),
            "masses: -0.25 kg is not allowed: give values of at least 0, some above 0",
        ),
        (
            lambda: moments_on_grid(np.ones((2, 2)), [0, 1], [1, 1]),
            "limits: 1 m is not below 1 m: give the lower end first",
        ),
        (
            lambda: moments_of_density(lambda x: x[:, 0], [(0, 1)], nodes=3),
            "nodes: 3 is no whole number from 4 on: give one",
        ),
        (
            lambda: moments_of_density(lambda x: x[:, 0], []),
            "limits: of no coordinate: give two numbers, or a function, for each",
        ),
        (
            lambda: moments_of_density(lambda x: x[:, 0], [(0, 1)] * 6),
            "nodes: 16 along each of 6 coordinates are 16777216 points, more than 4194304: give at most 12 nodes, or "
            "split the region and add the parts",
        ),
        (
            lambda: moments_of_density(lambda x: np.where(x[:, 0] < 0.3, 1.0, 4.0), [(0, 1)]),
            "density: quadrature with 14 and 16 nodes a coordinate differs by 0.0362, more than the tolerance 1e-09: "
            "raise nodes, or split the region where the density jumps",
        ),
    ],
)
def test_a_refusal_in_one_line(build, said):
    with pytest.raises(LieRigidBodyError) as caught:
        build()
    assert str(caught.value) == said
