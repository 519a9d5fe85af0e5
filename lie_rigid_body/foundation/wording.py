"""Values and names in few words, for error lines and reprs: one line of bounded length, whatever is given.

NumPy is not imported here: an error line must not wait for it.
"""

from __future__ import annotations

import difflib
import reprlib
import sys
from collections.abc import Collection, Iterable, Mapping
from itertools import islice
from pathlib import Path
from typing import Any, Final

MAX_LINE: Final = 200
"""Largest length of a repr, characters."""

MAX_VALUE: Final = 60
"""Largest length of a value in a line, characters."""

MAX_NAMES: Final = 5
"""Largest number of names listed in a line."""

SI: Final = {"gyro": "rad/s", "accelerometer": "m/s²", "gravity": "m/s²", "magnetometer": "T"}
"""Units of the readings of sensors."""
_GAP: Final = "..."
_PACKAGE: Final = "lie_rigid_body"
_MAX_NUMBERS: Final = 7


class _ShortRepr(reprlib.Repr):
    """Reprs that show the first of many parts, and of an array the shape and the ends."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxlist = self.maxtuple = _MAX_NUMBERS
        self.maxdict = self.maxset = self.maxfrozenset = 4
        self.maxstring = MAX_VALUE - 8
        self.maxother = sys.maxsize

    def repr_float(self, x: float, level: int) -> str:
        """Nine digits of a number that has more."""
        exact = repr(x)
        return exact if len(exact) <= 12 else f"{x:.9g}"

    def repr_int(self, x: int, level: int) -> str:
        """All digits, or how many there are: Python refuses to print very many."""
        return repr(x) if x.bit_length() <= 128 else f"<{'-' if x < 0 else ''}2**{x.bit_length() - 1} or more>"

    def repr_array(self, x: Any, level: int) -> str:
        """The numbers, as of a list: ROS gives lists of numbers so."""
        return self.repr1(x.tolist(), level)

    def repr_ndarray(self, x: Any, level: int) -> str:
        """The numbers of a short row, or shape and ends of more."""
        if x.ndim == 0 or (x.ndim == 1 and x.size <= _MAX_NUMBERS):
            return self.repr1(x.tolist(), level)
        if x.size == 0:
            return f"<array of shape {x.shape}>"
        rows = x.reshape(-1, x.shape[-1]) if x.ndim > 1 and x.shape[-1] <= _MAX_NUMBERS else x.reshape(-1)
        first, last = rows[[0, -1]].tolist()
        return f"<{x.shape}, {_ends(first)} to {_ends(last)}>"


def _ends(value: object) -> str:
    """A number, or a row of them, to three digits."""
    if isinstance(value, list):
        return f"[{', '.join(map(_ends, value))}]"
    return f"{value:.3g}" if isinstance(value, float | complex) else _SHORT.repr(value)


_SHORT: Final = _ShortRepr()


def shown(value: object, most: int = MAX_VALUE) -> str:
    """A value as an error line repeats it: its repr on one line, of a long one the beginning.

    Parameters
    ----------
    value : object
    most : int, optional
        Largest length of the result, characters.

    Returns
    -------
    str
    """
    return shortened(_SHORT.repr(value), most)


def printable(text: str) -> str:
    """A text with escapes in place of what would control a terminal, and of bytes of a name that are no characters."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def shortened(value: str, most: int = MAX_VALUE) -> str:
    """The text of a value on one line of bounded length: of a longer one the words for which there is room.

    Parameters
    ----------
    value : str
        A value, a name, or what another program said: no sentence of this package.
    most : int, optional
        Largest length of the result, characters.

    Returns
    -------
    str
    """
    line = printable(" ".join(value[: 10 * most].split()))
    if len(line) <= most:
        return line
    words = line[: most - len(_GAP)].rpartition(" ")[0]
    return f"{words} {_GAP}" if words else f"{line[: most - len(_GAP)]}{_GAP}"


def listed(names: Collection[object]) -> str:
    """Names with commas between them; of many the first, and how many more there are.

    Parameters
    ----------
    names : collection of object

    Returns
    -------
    str
    """
    first = ", ".join(shortened(str(name)) for name in islice(names, MAX_NAMES))
    return first if len(names) <= MAX_NAMES else f"{first} and {len(names) - MAX_NAMES} more"


def components(vector: Iterable[float], digits: int) -> str:
    """Components of a vector of length 1 with so many digits; what is round-off is 0."""
    return ", ".join(f"{round(float(v), digits + 1) + 0.0:.{digits}g}" for v in vector)


def numerals(numbers: Iterable[float], digits: int = 6) -> str:
    """Numbers to six digits, enough to recognise them elsewhere, or to others, with commas between them."""
    return ", ".join(f"{number:.{digits}g}" for number in numbers)


def in_degrees(error_deg: float, digits: int = 4) -> str:
    """An error, degrees, in some digits; round-off, of 1e-13°, is 0."""
    return f"{round(error_deg, 12) + 0.0:.{digits}g}°"


def counted(count: int, noun: str) -> str:
    """A number of things, with an s where there is not one."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def snake_case(name: str) -> str:
    """A name in snake case: ``GetEntities`` as ``get_entities``."""
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")


def suggestion(name: str, known: Collection[str], kind: str) -> str:
    """A hint for an unknown name: the known names most like it, or else the first of all.

    Parameters
    ----------
    name : str
    known : collection of str
    kind : str
        What the names are called, in the plural.

    Returns
    -------
    str
    """
    near = difflib.get_close_matches(name[:MAX_VALUE], known, n=3)
    return f"did you mean {' or '.join(near)}?" if near else f"the {kind} are {listed(known)}"


def program(verb: str) -> str:
    """The command of a verb: an executable of its own where ROS 2 installed this one, else one of ``lie-rigid-body``.

    ROS 2 has executables in ``lib/lie_rigid_body``, where ``python -m lie_rigid_body`` has its ``__main__.py``.
    """
    this = Path(sys.argv[0])
    of_ros = this.parent.name == _PACKAGE and this.suffix != ".py"
    return f"ros2 run {_PACKAGE} {verb}" if of_ros else f"lie-rigid-body {verb}"


def call_repr(instance: object, arguments: Mapping[str, object]) -> str:
    """A repr in the form of a call of the instance's class, with as many arguments, `shown`, as there is room for.

    Parameters
    ----------
    instance : object
    arguments : mapping of str to object

    Returns
    -------
    str
        Of at most `MAX_LINE` characters.
    """
    given = [f"{name}={shown(value)}" for name, value in arguments.items()]
    call = f"{type(instance).__name__}({', '.join(given)})"
    while len(call) > MAX_LINE:
        given.pop()
        call = f"{type(instance).__name__}({', '.join(given)}, {_GAP})"
    return call
