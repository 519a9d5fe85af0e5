"""Columns of stamped rows: samples, readings and messages of many instants, cut and joined in one way."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sized
from dataclasses import fields
from functools import reduce
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lie_rigid_body.foundation.arrays import Booleans, Integers

if TYPE_CHECKING:
    from typing_extensions import Self


class Stamped:
    """Base class of dataclasses of columns, each with a row for every stamp.

    A column is an array, or what is cut and joined as one, such as a `State`; or a mapping of names to arrays. A field
    that has no length, a text or a tuple is the same for all rows.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    """

    stamps_ns: Integers

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, rows: slice | Integers | Booleans) -> Self:
        return cast("Self", _columnwise(lambda column: column[rows], self))

    @classmethod
    def joined(cls, parts: Iterable[Self]) -> Self:
        """Rows that follow each other as one; of at least one part, whose fields of all rows it has."""
        return cast("Self", _columnwise(_concatenated, *parts))


def _columnwise(function: Callable[..., Any], *parts: Any) -> Any:
    """The parts, or what they are columns of, with a function of their columns in place of these."""
    first = parts[0]
    if isinstance(first, str | tuple) or not isinstance(first, Sized):
        return first
    if isinstance(first, Mapping):
        return {name: _columnwise(function, *(part[name] for part in parts)) for name in first}
    if not isinstance(first, Stamped):
        return function(*parts)
    names = [field.name for field in fields(cast(Any, first))]
    return type(first)(*(_columnwise(function, *(getattr(part, name) for part in parts)) for name in names))


def _concatenated(*columns: Any) -> Any:
    if isinstance(columns[0], np.ndarray):
        return np.concatenate(columns)
    return reduce(lambda earlier, later: earlier.joined(later), columns)
