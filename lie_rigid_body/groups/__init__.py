"""The paper on any matrix Lie group: algebra, Lagrangian, Hamiltonian, what is conserved, and the moving chart.

No executable needs this room. It may use rotations, the rigid body and the steppers; nothing imports it.
"""

from lie_rigid_body.groups import double_cover
from lie_rigid_body.groups.chasles import Displacement, chasles
from lie_rigid_body.groups.circle import U1
from lie_rigid_body.groups.group_moving_chart import GROUP_METHODS, GroupMovingChart
from lie_rigid_body.groups.group_state import GroupState
from lie_rigid_body.groups.hamiltonian import (
    Hamiltonian,
    HamiltonsEquations,
    inverse_legendre_transform,
    legendre_transform,
    lie_poisson_bracket,
    poisson_tensor,
)
from lie_rigid_body.groups.invariants import momentum_matrix, rotation_casimirs, spatial_momentum, unitary_casimirs
from lie_rigid_body.groups.lagrangian import Lagrangian, metric_at, require_metric
from lie_rigid_body.groups.manakov import manakov_integrals
from lie_rigid_body.groups.mass_matrix import mass_matrix
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.pfaffian import pfaffian
from lie_rigid_body.groups.product import product
from lie_rigid_body.groups.special_orthogonal import SO
from lie_rigid_body.groups.special_unitary import SU
from lie_rigid_body.groups.steady import Stability, SteadyRotation, linearisation, steady_axes, steady_rotation
from lie_rigid_body.groups.symmetries import conserved_momenta

__all__ = [
    "GROUP_METHODS",
    "SO",
    "SU",
    "U1",
    "Displacement",
    "GroupMovingChart",
    "GroupState",
    "Hamiltonian",
    "HamiltonsEquations",
    "Lagrangian",
    "MatrixLieGroup",
    "Stability",
    "SteadyRotation",
    "chasles",
    "conserved_momenta",
    "double_cover",
    "inverse_legendre_transform",
    "legendre_transform",
    "lie_poisson_bracket",
    "linearisation",
    "manakov_integrals",
    "mass_matrix",
    "metric_at",
    "momentum_matrix",
    "pfaffian",
    "poisson_tensor",
    "product",
    "require_metric",
    "rotation_casimirs",
    "spatial_momentum",
    "steady_axes",
    "steady_rotation",
    "unitary_casimirs",
]
