"""Arguments that are mixed up are refused: a Lagrangian for its group, a group for a Lagrangian."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from group_bodies import affine_line

from lie_rigid_body import InputError, ParameterError, RigidBody, groups
from lie_rigid_body.groups import SO, SU, U1, Lagrangian, MatrixLieGroup
from lie_rigid_body.mechanics import box

GROUP, M, V = SO(3), np.diag([1.0, 2.0, 3.0]), [0.3, -0.5, 0.8]
BODY = Lagrangian(GROUP, M)
ROOM: Any = groups
"""The room without its types, which refuse as well."""
OF_A_GROUP: dict[str, tuple[Any, ...]] = {
    "casimirs": (V,),
    "chart_reach": (V,),
    "coadjoint_action": (V, V),
    "conserved_momenta": (M,),
    "Hamiltonian": (M,),
    "invariant_form": (),
    "killing_form": (),
    "Lagrangian": (M,),
    "lie_poisson_bracket": (V, V, V),
    "metric_derivative": (M,),
    "momentum_matrix": (V,),
    "poisson_tensor": (V,),
    "quadratic_casimirs": (),
    "spatial_momentum": (np.eye(3), V),
}
OF_A_LAGRANGIAN: dict[str, tuple[Any, ...]] = {
    "chart_metric": (V,),
    "christoffel_symbols": (),
    "connection_coefficients": (),
    "GroupMovingChart": (groups.GroupState(np.eye(3), np.array(V)),),
    "legendre_transform": (),
    "linearisation": (V,),
    "metric_at": (np.eye(3),),
    "steady_axes": (),
    "steady_rotation": ([1.0, 0.0, 0.0],),
}


@pytest.mark.parametrize("name", OF_A_GROUP)
def test_what_asks_for_a_group_takes_one_and_nothing_else(name):
    function, others = getattr(groups, name), OF_A_GROUP[name]
    function(GROUP, *others)
    for given in (BODY, RigidBody([0.6, 0.8, 1.0]), GROUP.structure_constants):
        with pytest.raises(InputError, match="MatrixLieGroup"):
            function(given, *others)


@pytest.mark.parametrize("name", OF_A_LAGRANGIAN)
def test_what_asks_for_a_lagrangian_takes_one_and_nothing_else(name):
    function, others = getattr(groups, name), OF_A_LAGRANGIAN[name]
    function(BODY, *others)
    for given in (GROUP, RigidBody([0.6, 0.8, 1.0]), groups.legendre_transform(BODY)):
        with pytest.raises(InputError, match="Lagrangian"):
            function(given, *others)


@pytest.mark.parametrize(
    ("build", "argument"),
    [
        (lambda: ROOM.Lagrangian(GROUP, RigidBody([0.6, 0.8, 1.0])), "metric"),
        (lambda: ROOM.mass_matrix(RigidBody([0.6, 0.8, 1.0]), GROUP.generators), "second moment"),
        (lambda: ROOM.mass_matrix(box(mass=2.0, edges=[0.3, 0.2, 0.1]), GROUP.generators), "second moment"),
        (lambda: ROOM.mass_matrix(np.eye(3), GROUP), "generators"),
        (lambda: ROOM.mass_matrix(np.eye(2), SU(2).generators), "generators"),
        (lambda: groups.coadjoint_action(GROUP, V[:2], V), "rates"),
        (lambda: groups.coadjoint_action(GROUP, V, [*V, 0.1]), "momenta"),
        (lambda: BODY.action(np.eye(3), 0.1), "path"),
    ],
)
def test_the_argument_at_fault_is_named(build, argument):
    with pytest.raises(ParameterError) as caught:
        build()
    assert caught.value.name == argument


def test_the_coadjoint_action_takes_lists():
    assert np.array_equal(groups.coadjoint_action(GROUP, [1, 0, 0], [0, 1, 0]), [0, 0, -1])


def test_a_list_of_groups_a_seed_and_matrices_alone_make_no_group():
    for build in (
        lambda: ROOM.product([SO(3), SU(2)]),
        lambda: ROOM.SO(3).random(1),
        lambda: ROOM.MatrixLieGroup([np.eye(2)]),
    ):
        with pytest.raises(InputError):
            build()


def test_generators_of_exp_with_an_i_are_told_as_such():
    """Open sets only: a closed one, as of a dilation, generates a group as it stands."""
    pauli, boost, turn = 2j * SU(2).generators, np.array([[0.0, 1.0], [1.0, 0.0]]), np.diag([1.0, -1.0])
    for generators in (pauli, 1j * np.stack([boost, turn, boost @ turn])):  # the second are not all Hermitian
        with pytest.raises(InputError, match="−i "):
            MatrixLieGroup.from_generators(generators)
    assert np.allclose(MatrixLieGroup.from_generators(-0.5j * pauli).structure_constants, GROUP.structure_constants)
    assert MatrixLieGroup.from_generators([np.eye(2)]).dimension == 1
    with pytest.raises(InputError) as caught:
        MatrixLieGroup.from_generators(1j * pauli[:2])
    assert "−i " not in str(caught.value)


@pytest.mark.parametrize("name", ["SE", "SE3", "E", "U", "U2", "SU2", "SO3", "O", "SL", "GL", "Sp", "Spin"])
def test_names_of_groups_tell_how_groups_are_made(name):
    with pytest.raises(ImportError, match="from_generators"):
        exec(f"from lie_rigid_body.groups import {name}")


def test_other_names_are_missed_as_usual_and_those_that_are_there_are_found():
    assert not hasattr(groups, "casimir")
    assert all(hasattr(groups, name) for name in groups.__all__)
    assert U1().dimension == 1


def test_without_an_invariant_form_a_single_rotation_is_still_steady_or_not():
    body = Lagrangian(affine_line(), np.eye(2))
    with pytest.raises(InputError, match="steady_rotation"):
        groups.steady_axes(body)
    groups.steady_rotation(body, [0.0, 0.0])
