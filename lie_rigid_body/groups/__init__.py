"""The paper on any matrix Lie group: Chasles, algebra, Lagrangian, Hamiltonian, conserved quantities, moving chart.

The paper is A. Lucas, *Lagrangian mechanics on Lie groups: a pedagogical approach*, arXiv 1111.1275. In its order:
`displacement`; `metric` and `lagrangian`; `symmetries` and `invariants`; `double_cover`; `hamiltonian`; and of
the appendices `group_chart`, `algebra`, `matrix_lie_group` and `classical_groups`. The motion is integrated in
`group_moving_chart`. The table of docs/paper.md leads from each equation to its function.

No executable needs this room. It uses rotations, the second moment of a body and the tableaus of the steppers; nothing
imports it.
"""

import re
from typing import NoReturn

from lie_rigid_body.groups import double_cover
from lie_rigid_body.groups.arguments import MADE_BY
from lie_rigid_body.groups.classical_groups import SO, SU, U1
from lie_rigid_body.groups.coadjoint import ad_star, invariant_form, killing_form
from lie_rigid_body.groups.displacement import Displacement, chasles
from lie_rigid_body.groups.group_chart import ChartReach, chart_metric, chart_reach
from lie_rigid_body.groups.group_moving_chart import GROUP_METHODS, GroupMovingChart, GroupState
from lie_rigid_body.groups.hamiltonian import (
    Hamiltonian,
    HamiltonsEquations,
    inverse_legendre_transform,
    legendre_transform,
    lie_poisson_bracket,
    poisson_tensor,
)
from lie_rigid_body.groups.invariants import (
    casimirs,
    manakov_integrals,
    momentum_matrix,
    pfaffian,
    quadratic_casimirs,
    rotation_casimirs,
    unitary_casimirs,
)
from lie_rigid_body.groups.lagrangian import Lagrangian, christoffel_symbols, connection_coefficients, metric_at
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup
from lie_rigid_body.groups.metric import mass_matrix, metric_derivative, require_metric
from lie_rigid_body.groups.product import product
from lie_rigid_body.groups.steady_rotations import (
    RelativeEquilibrium,
    Stability,
    linearisation,
    steady_axes,
    steady_rotation,
)
from lie_rigid_body.groups.symmetries import conserved_momenta, spatial_momentum

__all__ = [
    "GROUP_METHODS",
    "SO",
    "SU",
    "U1",
    "ChartReach",
    "Displacement",
    "GroupMovingChart",
    "GroupState",
    "Hamiltonian",
    "HamiltonsEquations",
    "Lagrangian",
    "MatrixLieGroup",
    "RelativeEquilibrium",
    "Stability",
    "ad_star",
    "casimirs",
    "chart_metric",
    "chart_reach",
    "chasles",
    "christoffel_symbols",
    "connection_coefficients",
    "conserved_momenta",
    "double_cover",
    "invariant_form",
    "inverse_legendre_transform",
    "killing_form",
    "legendre_transform",
    "lie_poisson_bracket",
    "linearisation",
    "manakov_integrals",
    "mass_matrix",
    "metric_at",
    "metric_derivative",
    "momentum_matrix",
    "pfaffian",
    "poisson_tensor",
    "product",
    "quadratic_casimirs",
    "require_metric",
    "rotation_casimirs",
    "spatial_momentum",
    "steady_axes",
    "steady_rotation",
    "unitary_casimirs",
]


def __getattr__(name: str) -> NoReturn:
    """The way to make a group that has no name here, in place of ``cannot import name``."""
    if re.fullmatch(r"(S?[EOU]|[GS]L|U?Sp|Spin)\d*", name):
        raise ImportError(
            f"there is no {name}: make it by {MADE_BY}, as help(MatrixLieGroup.from_generators) does SE(3)"
        )
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
