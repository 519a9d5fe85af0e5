"""Constants of many motions of one kind as columns: each number of the motion becomes an array.

Every formula of a motion is elementwise, so a motion whose numbers are columns is that many motions, and each of them
has the bits that it has alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Final, TypeVar, cast

import numpy as np

from lie_rigid_body.motion.closed_form.double_double import Array, Number

Triple = tuple[Number, Number, Number]
Quadruple = tuple[Number, Number, Number, Number]

_NUMBER: Final = (float, np.ndarray)

_Form = TypeVar("_Form")


def numbers(form: object) -> list[Number]:
    """The numbers in a nest of dataclasses and tuples, in order."""
    gathered: list[Number] = []
    _gather(form, gathered)
    return gathered


def _gather(form: object, gathered: list[Any]) -> None:
    for part in _parts(form):
        if isinstance(part, _NUMBER):
            gathered.append(part)
        else:
            _gather(part, gathered)


def table(form: object, count: int) -> Array:
    """The numbers of so many motions, shape (numbers, count)."""
    entries = numbers(form)
    if count == 1:
        return np.array(entries, dtype=np.float64).reshape(-1, 1)
    return np.stack([np.broadcast_to(entry, count) for entry in entries])


def filled(form: _Form, columns: Iterator[Number]) -> _Form:
    """The same nest with other numbers, taken in order."""
    if isinstance(form, _NUMBER):
        return cast(_Form, next(columns))
    made = tuple(filled(part, columns) for part in _parts(form))
    kind: Any = type(form)
    return cast(_Form, made if kind is tuple else kind(*made))


def _parts(form: Any) -> Iterable[object]:
    return form if isinstance(form, tuple) else vars(form).values()
