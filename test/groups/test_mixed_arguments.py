"""Arguments that are mixed up are refused: a Lagrangian for its group, a group for a Lagrangian."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from group_bodies import affine_line

from lie_rigid_body import InputError, groups
from lie_rigid_body.groups import SO, SU, U1, Lagrangian, MatrixLieGroup

GROUP, M, V = SO(3), np.diag([1.0, 2.0, 3.0]), [0.3, -0.5, 0.8]
BODY = Lagrangian(GROUP, M)
ROOM: Any = groups
"""The room without its types, which refuse as well."""


def test_the_coadjoint_action_takes_lists():
    assert np.array_equal(groups.ad_star(GROUP, [1, 0, 0], [0, 1, 0]), [0, 0, -1])


def test_a_list_of_groups_and_a_seed_make_no_group():
    for build in (lambda: ROOM.product([SO(3), SU(2)]), lambda: ROOM.SO(3).random(1)):
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


def test_other_names_are_missed_as_usual_and_those_that_are_there_are_found():
    assert not hasattr(groups, "casimir")
    assert all(hasattr(groups, name) for name in groups.__all__)
    assert U1().dimension == 1


def test_without_an_invariant_form_a_single_rotation_is_still_steady_or_not():
    body = Lagrangian(affine_line(), np.eye(2))
    with pytest.raises(InputError, match="steady_rotation"):
        groups.steady_axes(body)
    groups.steady_rotation(body, [0.0, 0.0])
