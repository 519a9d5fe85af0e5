"""The estimators that a campaign compares: functions with parameters, or programs, and the points of their grids."""

from __future__ import annotations

import inspect
import itertools
import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from lie_rigid_body.errors import InputError
from lie_rigid_body.runs.estimators import CommandEstimator, Estimator, NamedFunction
from lie_rigid_body.wording import short_repr, shown, suggestion

FUNCTION: Final = r"\w+(\.\w+)*:\w+"
"""What names a function: module, colon, function."""
MOST_POINTS: Final = 100
"""Largest number of estimators and points of grids: each is called in every run, and has its place in the run's row."""
_LONGEST_NAME: Final = 40
_KEYS: Final = ("function", "command", "parameters", "grid")


@dataclass(frozen=True)
class Contender:
    """One of the estimators of a campaign.

    Attributes
    ----------
    name : str
    function, command : str or None
        ``module:function``, or a program; one of them is given.
    parameters : dict of str to object
        Keyword arguments beside the run.
    grid : dict of str to list
        Values that are tried of further ones, each with each of the others.
    """

    name: str
    function: str | None = None
    command: str | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    grid: Mapping[str, list[Any]] = field(default_factory=dict)

    __repr__ = short_repr

    @property
    def entries(self) -> Iterator[Entry]:
        """The estimator at each point of its grid; one without a grid once."""
        for values in itertools.product(*self.grid.values()):
            yield Entry(self, {**self.parameters, **dict(zip(self.grid, values, strict=True))})

    def require_parameters(self) -> None:
        """Refuse parameters that the function does not take.

        Raises
        ------
        InputError
            Also if it cannot be imported.
        """
        if self.function is None:
            return
        function = NamedFunction(self.function).load()
        try:
            taken = inspect.signature(function).parameters
        except (TypeError, ValueError):  # of a function in C that does not tell
            return
        if any(one.kind is one.VAR_KEYWORD for one in taken.values()):
            return
        named = [name for name, one in taken.items() if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)]
        own = named[1:] if next(iter(taken.values()), None) and next(iter(taken)) in named else named
        unknown = next((name for name in (*self.parameters, *self.grid) if name not in own), None)
        if unknown is not None:
            remedy = suggestion(unknown, own, "parameters") if own else "leave it out"
            raise InputError(f"{_place(self.name)}: {self.function} takes no {shown(unknown)}: {remedy}")


@dataclass(frozen=True)
class Entry:
    """An estimator with the keyword arguments that it is called with.

    Attributes
    ----------
    contender : Contender
    parameters : dict of str to object
    """

    contender: Contender
    parameters: Mapping[str, Any]

    __repr__ = short_repr

    def load(self) -> Estimator:
        """The estimator as a function of a run.

        Raises
        ------
        InputError
            If it cannot be imported.
        """
        if self.contender.command is not None:
            return CommandEstimator(self.contender.command)
        found = NamedFunction(str(self.contender.function)).load()
        return partial(found, **self.parameters) if self.parameters else found


def contenders(given: object) -> dict[str, Contender]:
    """Read the estimators of a campaign by their names, in whose order they are.

    Parameters
    ----------
    given : object
        A mapping of names to mappings, as in the file.

    Raises
    ------
    InputError
    """
    if not isinstance(given, Mapping):
        raise InputError("estimators is to be a mapping of names: write 'estimators:' and 'name: {function: …}' below")
    found = dict(sorted((name, _contender(name, content)) for name, content in given.items()))
    count = sum(math.prod(len(values) for values in one.grid.values()) for one in found.values())
    if count > MOST_POINTS:
        raise InputError(f"estimators: {count} with the points of their grids: give at most {MOST_POINTS}")
    return found


def _contender(name: object, content: object) -> Contender:
    if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= _LONGEST_NAME):
        limit = f"give 1 to {_LONGEST_NAME} printable characters"
        raise InputError(f"estimators: {shown(name)} is no name: {limit}")
    place = _place(name)
    if not isinstance(content, Mapping):
        raise InputError(f'{place} is to be a mapping: give {{function: "module:function"}}')
    unknown = next((key for key in content if key not in _KEYS), None)
    if unknown is not None:
        raise InputError(f"{place}: there is no {shown(unknown)}: give {', '.join(_KEYS)}")
    function, command = content.get("function"), content.get("command")
    if (function is None) == (command is None):
        raise InputError(f"{place}: give function or command, one of them")
    if function is not None and not re.fullmatch(FUNCTION, str(function)):
        raise InputError(f"{place}.function: {shown(function)} names no function: give module:function")
    parameters, grid = (_mapping(f"{place}.{key}", content.get(key)) for key in ("parameters", "grid"))
    if command is not None and (not isinstance(command, str) or not command.strip() or parameters or grid):
        what = "a program takes its parameters in its line"
        raise InputError(f"{place}.command: {shown(command)}: {what}: give a text, and no parameters or grid")
    for key, values in grid.items():
        if not (isinstance(values, list | tuple) and values):
            raise InputError(f"{place}.grid.{key}: {shown(values)} is no list of values: give some, or leave it out")
    both = next((key for key in parameters if key in grid), None)
    if both is not None:
        raise InputError(f"{place}: {both} is in parameters and in grid: leave it out of one of them")
    if "grid" in content and not grid:
        raise InputError(f"{place}.grid is of nothing: give a parameter and its values, or leave it out")
    try:
        json.dumps([parameters, grid], allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"{place}: {error}: give finite numbers, texts, lists and mappings") from None
    return Contender(name, function, command, parameters, {key: [*values] for key, values in sorted(grid.items())})


def _mapping(place: str, value: object) -> dict[str, Any]:
    if value is None:
        return {}
    if not isinstance(value, Mapping) or not all(isinstance(key, str) and key.isidentifier() for key in value):
        raise InputError(f"{place}: {shown(value)} is no mapping of names of keyword arguments: give one")
    return dict(value)


def _place(name: str) -> str:
    return f"estimators.{name}"
