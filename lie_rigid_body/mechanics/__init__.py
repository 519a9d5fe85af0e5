"""The rigid body: mass distribution, inertia, state, conserved quantities and kinds of tops."""

from lie_rigid_body.mechanics import top
from lie_rigid_body.mechanics.mass_distribution import moments_of_density, moments_of_points, moments_on_grid
from lie_rigid_body.mechanics.mass_moments import MassMoments
from lie_rigid_body.mechanics.rigid_body import RigidBody
from lie_rigid_body.mechanics.second_moment import (
    inertia_from_second_moment,
    rotated_second_moment,
    second_moment_about,
    second_moment_from_inertia,
)
from lie_rigid_body.mechanics.shapes import ball, box, cylinder, disc, ellipsoid, rod
from lie_rigid_body.mechanics.state import State

__all__ = [
    "MassMoments",
    "RigidBody",
    "State",
    "ball",
    "box",
    "cylinder",
    "disc",
    "ellipsoid",
    "inertia_from_second_moment",
    "moments_of_density",
    "moments_of_points",
    "moments_on_grid",
    "rod",
    "rotated_second_moment",
    "second_moment_about",
    "second_moment_from_inertia",
    "top",
]
