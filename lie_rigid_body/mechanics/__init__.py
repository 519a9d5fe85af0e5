"""What is true of the motion: the body, its inertia, its state and what they conserve."""

from lie_rigid_body.mechanics.chasles import Displacement, chasles
from lie_rigid_body.mechanics.group_state import GroupState
from lie_rigid_body.mechanics.hamiltonian import (
    Hamiltonian,
    HamiltonsEquations,
    inverse_legendre_transform,
    legendre_transform,
    lie_poisson_bracket,
    poisson_tensor,
)
from lie_rigid_body.mechanics.invariants import momentum_matrix, rotation_casimirs, spatial_momentum, unitary_casimirs
from lie_rigid_body.mechanics.lagrangian import Lagrangian, metric_at, require_metric
from lie_rigid_body.mechanics.manakov import manakov_integrals
from lie_rigid_body.mechanics.mass_distribution import moments_of_density, moments_of_points, moments_on_grid
from lie_rigid_body.mechanics.mass_matrix import mass_matrix
from lie_rigid_body.mechanics.mass_moments import MassMoments
from lie_rigid_body.mechanics.pfaffian import pfaffian
from lie_rigid_body.mechanics.rigid_body import RigidBody
from lie_rigid_body.mechanics.second_moment import (
    inertia_from_second_moment,
    rotated_second_moment,
    second_moment_about,
    second_moment_from_inertia,
)
from lie_rigid_body.mechanics.shapes import ball, box, cylinder, disc, ellipsoid, rod
from lie_rigid_body.mechanics.state import State
from lie_rigid_body.mechanics.steady import Stability, SteadyRotation, linearisation, steady_axes, steady_rotation
from lie_rigid_body.mechanics.symmetries import conserved_momenta

__all__ = [
    "Displacement",
    "GroupState",
    "Hamiltonian",
    "HamiltonsEquations",
    "Lagrangian",
    "MassMoments",
    "RigidBody",
    "Stability",
    "State",
    "SteadyRotation",
    "ball",
    "box",
    "chasles",
    "conserved_momenta",
    "cylinder",
    "disc",
    "ellipsoid",
    "inertia_from_second_moment",
    "inverse_legendre_transform",
    "legendre_transform",
    "lie_poisson_bracket",
    "linearisation",
    "manakov_integrals",
    "mass_matrix",
    "metric_at",
    "moments_of_density",
    "moments_of_points",
    "moments_on_grid",
    "momentum_matrix",
    "pfaffian",
    "poisson_tensor",
    "require_metric",
    "rod",
    "rotated_second_moment",
    "rotation_casimirs",
    "second_moment_about",
    "second_moment_from_inertia",
    "spatial_momentum",
    "steady_axes",
    "steady_rotation",
    "unitary_casimirs",
]
