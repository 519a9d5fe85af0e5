"""Constants of many motions of one kind as columns: each number of the motion becomes an array of shape (B, 1).

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

IDENTITY: Final[Quadruple] = (0.0, 0.0, 0.0, 1.0)

_NUMBER: Final = (float, np.ndarray)

_Form = TypeVar("_Form")


def numbers(form: object) -> list[Number]:
    """The numbers in a nest of dataclasses and tuples, in order."""
    if isinstance(form, _NUMBER):
        return [cast(Number, form)]
    return [number for part in _parts(form) for number in numbers(part)]


def filled(form: _Form, columns: Iterator[Array]) -> _Form:
    """The same nest with other numbers, taken in order."""
    if isinstance(form, _NUMBER):
        return cast(_Form, next(columns))
    made = tuple(filled(part, columns) for part in _parts(form))
    kind: Any = type(form)
    return cast(_Form, made if kind is tuple else kind(*made))


def columns_of(components: Array) -> Quadruple:
    """The four components on the last axis, each of shape (B, 1)."""
    x, y, z, w = (components[..., i] for i in range(4))
    return x, y, z, w


def _parts(form: Any) -> Iterable[object]:
    return form if isinstance(form, tuple) else vars(form).values()
