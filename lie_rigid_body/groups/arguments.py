"""Arguments that are mixed up: a body given for its group, or an object for one of its arrays."""

from __future__ import annotations

from typing import Final, TypeVar

from lie_rigid_body.errors import InputError, ParameterError
from lie_rigid_body.wording import shown

Kind = TypeVar("Kind")

MADE_BY: Final = "SO(n), SU(n), U1(), product(group, …) or MatrixLieGroup.from_generators(matrices)"
"""How groups are made, for messages."""

_REMEDIES: Final = {
    "MatrixLieGroup": "a group, as SO(3) or lagrangian.group",
    "Lagrangian": "Lagrangian(group, metric)",
    "Hamiltonian": "legendre_transform(lagrangian)",
    "Generator": "numpy.random.default_rng(seed)",
}


def of_kind(value: object, kind: type[Kind]) -> Kind:
    """An argument that is an instance of the class wanted.

    Raises
    ------
    InputError
        If it is of another class.
    """
    if not isinstance(value, kind):
        raise InputError(f"{shown(value)} is no {kind.__name__}: give {_REMEDIES[kind.__name__]}")
    return value


def refuse_whole(name: str, value: object, part: str) -> None:
    """Refuse an object in the place of its array.

    Parameters
    ----------
    name : str
        Name of the argument in the message.
    value : object
    part : str
        The attribute that is the array.

    Raises
    ------
    ParameterError
    """
    if hasattr(value, part):
        raise ParameterError(name, f"a {type(value).__name__} was given: give its {part}")
