"""Frozen dataclasses whose repr stays on one line, whatever their fields hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar, overload

from lie_rigid_body.foundation.wording import call_repr

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:

    def dataclass_transform(**_: object) -> Callable[[T], T]:
        """Nothing: what type checkers are told of a decorator (PEP 681)."""
        return lambda decorator: decorator


T = TypeVar("T")

__all__ = ["short_dataclass", "short_repr"]


def short_repr(instance: Any) -> str:
    """A repr of a dataclass or a named tuple that stays on one line, whatever its fields hold.

    Parameters
    ----------
    instance : dataclass or namedtuple

    Returns
    -------
    str
        Of at most `MAX_LINE` characters.
    """
    names = getattr(instance, "_fields", None) or [f.name for f in instance.__dataclass_fields__.values() if f.repr]
    return call_repr(instance, {name: getattr(instance, name) for name in names})


@overload
def short_dataclass(owner: type[T], /) -> type[T]: ...


@overload
def short_dataclass(**options: bool) -> Callable[[type[T]], type[T]]: ...


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def short_dataclass(owner: type[Any] | None = None, /, **options: bool) -> Any:
    """Make a frozen dataclass whose repr is `short_repr`.

    Parameters
    ----------
    owner : type, optional
        The class; without it a decorator is made.
    **options : bool
        As of `dataclasses.dataclass`, without ``repr``; ``frozen`` is true if not given.

    Returns
    -------
    type or callable
    """

    def decorated(owner: type[Any]) -> type[Any]:
        if "__repr__" not in vars(owner):
            owner.__repr__ = short_repr  # type: ignore[assignment]
        made: type[Any] = dataclasses.dataclass(repr=False, **{"frozen": True, **options})(owner)
        return made

    return decorated if owner is None else decorated(owner)
