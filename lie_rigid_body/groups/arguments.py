"""Arguments that are mixed up, as a body given for its group, and arguments whose results leave double precision."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import fields
from functools import wraps
from typing import Any, Final, ParamSpec, TypeVar, cast

import numpy as np

from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.wording import shown

Kind = TypeVar("Kind")
Given = ParamSpec("Given")
Result = TypeVar("Result")

MADE_BY: Final = "SO(n), SU(n), U1(), product(group, …) or MatrixLieGroup.from_generators(matrices)"
"""How groups are made, for messages."""

_REMEDIES: Final = {
    "MatrixLieGroup": "a group, as SO(3) or lagrangian.group",
    "Lagrangian": "Lagrangian(group, metric)",
    "Hamiltonian": "legendre_transform(lagrangian)",
    "Generator": "numpy.random.default_rng(seed)",
}


class MadeAnew:
    """Base class of frozen dataclasses whose copies are made by their constructors: what they cache stays behind."""

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), tuple(getattr(self, field.name) for field in fields(cast(Any, self)))


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


def within_doubles(function: Callable[Given, Result]) -> Callable[Given, Result]:
    """A function of finite arguments whose results, if they are arrays, are finite, or refused in place of a warning.

    Raises
    ------
    ParameterError
        Naming the function.
    """

    @wraps(function)
    def checked(*arguments: Given.args, **named: Given.kwargs) -> Result:
        with np.errstate(all="ignore"), suppress(np.linalg.LinAlgError):  # what goes wrong is said below
            result = function(*arguments, **named)
            if not isinstance(result, np.ndarray | np.number) or np.isfinite(result).all():
                return result
        raise ParameterError(function.__name__, "a result is beyond double precision, 1.8e308: give smaller numbers")

    return checked
