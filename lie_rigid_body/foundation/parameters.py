"""Parameters: their types and limits, and how their values are read."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence, Set
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from typing import Final, Literal, TypeAlias

from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import shown, suggestion

Kind: TypeAlias = Literal["double", "double_array", "int", "string", "string_array", "bool"]
Vector: TypeAlias = tuple[float, ...]
Names: TypeAlias = tuple[str, ...]
Value: TypeAlias = float | int | str | bool | Vector | Names
Given: TypeAlias = Mapping[str, object]
"""Values by the names under which they are given, most often those of parameters."""

NS: Final = 1_000_000_000
"""Nanoseconds in a second."""

MAX_EPOCH_NS: Final = (2**31 - 1) * NS
"""The latest stamp, in 2038: builtin_interfaces/Time has 32-bit seconds."""

MAX_FRAME_NAME_LENGTH: Final = 255
"""Largest length of a frame name, characters; every message carries one."""

_NUMBER: Final = re.compile(r"[-+.0-9eE]+")
"""Characters of a finite decimal number: Decimal alone would take spaces, underscores and words."""


def decimal_ns(seconds: float) -> int:
    """Round a time, s, to ns: that of its shortest decimal."""
    return round(Decimal(repr(seconds)) * NS)


def exact_duration(given: object, name: str, example: str, *, is_text: bool = False) -> Fraction:
    """A duration as the decimal number that was written, s.

    Parameters
    ----------
    given : object
    name : str
        What it was given as, for the message.
    example : str
        What to give instead.
    is_text : bool, optional
        Whether it comes from a command line; otherwise it has to be an int or a float.

    Raises
    ------
    InputError
        If it is not a time from 1e-9 to 1e10 seconds.
    """
    try:
        text = str(given) if is_text else repr(given) if type(given) in (int, float) else ""
        value = Decimal(text) if _NUMBER.fullmatch(text) else Decimal("nan")
    except (InvalidOperation, ValueError):  # Python writes no integer of more than 4300 digits
        value = Decimal("nan")
    # from a nanosecond to what is beyond every stamp of builtin_interfaces/Time; compared before it becomes a fraction,
    # which 1e999999999 would fill the memory with
    if not (value.is_finite() and Decimal("1e-9") <= value <= Decimal("1e10")):
        said = given if is_text else shown(given)
        raise InputError(f"{name} {said} is not a time from 1e-9 to 1e10 seconds: give for example {example}")
    return Fraction(value)


@short_dataclass
class Parameter:
    """One parameter: its type, default, limits and description.

    Parameters
    ----------
    name : str
    kind : str
        ``double``, ``double_array``, ``int``, ``string``, ``string_array`` or ``bool``.
    default : value of that kind
    description : str
        One sentence, with the unit.
    lengths : sequence of int, optional
        Allowed lengths of an array; a range stands for the multiples of its step.
    minimum, maximum : float, optional
        Inclusive range of a number, or of each number of an array.
    choices : tuple of str, optional
        Allowed strings.
    scope : str, optional
        ``scenario``, or ``node``: of the live node alone, where it changes when and where samples are sent, and no
        sample.
    """

    name: str
    kind: Kind
    default: Value
    description: str
    lengths: Sequence[int] = ()
    minimum: float = -math.inf
    maximum: float = math.inf
    choices: Names = ()
    scope: Literal["scenario", "node"] = "scenario"

    def read(self, value: object) -> Value:
        """The value in this parameter's own type.

        Parameters
        ----------
        value : object
            As a YAML file or a ROS parameter gives it. An integer stands for a double.

        Returns
        -------
        float, int, str, bool, tuple of float or tuple of str

        Raises
        ------
        ParameterError
            If the type, the length, the range or the choice is another.
        """
        match self.kind, value:
            case "double", _:
                return self._number(value)
            case "double_array", _:
                return self._array(value)
            case "int", _:
                return self._integer(value)
            case "string_array", list() | tuple() if all(isinstance(v, str) for v in value):
                return tuple(value)
            case "string_array", _:
                raise ParameterError(
                    self.name, f"{shown(value)} is not a list of strings: give for example [/evaluator]"
                )
            case ("bool", bool() as given) | ("string", str() as given) if not self.choices or given in self.choices:
                return given
            case "string", str():
                raise ParameterError(self.name, f"{shown(value)} is unknown: choose one of {', '.join(self.choices)}")
        raise ParameterError(self.name, f"{shown(value)} is not a {self.kind}: give for example {self.default!r}")

    def _number(self, value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ParameterError(self.name, f"{shown(value)} is not a number: give {self._example()}")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise ParameterError(self.name, f"{shown(value)} is not finite: give {self._example()}")
        if not self.minimum <= number <= self.maximum:
            raise ParameterError(
                self.name, f"{number:g} is outside [{self.minimum:g}, {self.maximum:g}]: give {self._example()}"
            )
        return number

    @property
    def wanted_numbers(self) -> str:
        """How many finite numbers an array has, in words; empty where it is no array of numbers."""
        if isinstance(self.lengths, range):
            return f"a multiple of {self.lengths.step} finite numbers, at most {self.lengths[-1]}"
        wanted = " or ".join(str(n) for n in self.lengths)
        return f"{wanted} finite numbers" if wanted else ""

    def _example(self) -> str:
        return self.wanted_numbers or f"for example {self.default!r}"

    def _integer(self, value: object) -> int:
        is_beyond = isinstance(value, float) and abs(value) >= 2.0**63  # as YAML and rcl read longer integers
        if not is_beyond and (isinstance(value, bool) or not isinstance(value, int)):
            raise ParameterError(self.name, f"{shown(value)} is not an integer: give for example {self.default!r}")
        if not (isinstance(value, int) and self.minimum <= value <= self.maximum):
            raise ParameterError(
                self.name,
                f"{shown(value)} is outside [{int(self.minimum)}, {int(self.maximum)}]: give {self._example()}",
            )
        return value

    def _array(self, value: object) -> tuple[float, ...]:
        if isinstance(value, str | bytes | Mapping | Set) or not isinstance(value, Collection):
            raise ParameterError(self.name, f"{shown(value)} is not a list: give {self._example()}")
        if len(value) not in self.lengths:
            raise ParameterError(self.name, f"{shown(value)} has {len(value)} numbers: give {self._example()}")
        return tuple(self._number(v) for v in value)


def read_table(table: Collection[Parameter], given: Given) -> dict[str, Value]:
    """The value of every parameter of a table: the given ones in their own types, the rest at their defaults.

    Parameters
    ----------
    table : collection of Parameter
    given : mapping of str to object

    Returns
    -------
    dict of str to value
        In the order of the table.

    Raises
    ------
    ParameterError
        If a name is unknown or a value is not of its parameter's type, length, range or choice.
    """
    names = dict.fromkeys(parameter.name for parameter in table)
    for name in given:
        if name not in names:
            raise ParameterError(str(name), f"no such parameter: {suggestion(str(name), names, 'parameters')}")
    return {p.name: p.read(given[p.name]) if p.name in given else p.default for p in table}


def require_frame_name(name: str, value: str) -> None:
    """Refuse a frame name that tf2 would not take.

    Raises
    ------
    ParameterError
        If it is empty, too long, begins with a slash, or has spaces or unprintable characters.
    """
    if len(value) > MAX_FRAME_NAME_LENGTH:
        raise ParameterError(name, f"{shown(value)} has {len(value)} characters: give at most {MAX_FRAME_NAME_LENGTH}")
    if not value or value.startswith("/") or any(c.isspace() or not c.isprintable() for c in value):
        raise ParameterError(
            name, f"{shown(value)} is not a frame name: give a word without spaces that does not begin with a slash"
        )


def require_at_most(name: str, numbers: Vector, limit: float, unit: str) -> None:
    """Refuse numbers beyond what any instrument has, with which readings could overflow.

    Raises
    ------
    ParameterError
        If the size of one exceeds the limit.
    """
    worst = max(numbers, key=abs)
    if abs(worst) > limit:
        within = f"{limit:g} {unit}".rstrip()
        raise ParameterError(name, f"{worst:g} is outside ±{within}: give numbers of that size at most")
