"""Dataclasses whose repr stays on one line, whatever their fields hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from lie_rigid_body.foundation.wording import call_repr

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


if TYPE_CHECKING:
    # Type checkers know the standard library's decorator, and this one makes classes of the same type.
    from dataclasses import dataclass as short_dataclass
else:
    import dataclasses

    def short_dataclass(**options: bool) -> Callable[[type[T]], type[T]]:
        """Make a dataclass, by the standard library's options, whose repr is `short_repr`.

        Parameters
        ----------
        **options : bool
            As of `dataclasses.dataclass`, without ``repr``.

        Returns
        -------
        callable
            Decorator of a class.
        """

        def decorated(owner: type[T]) -> type[T]:
            owner.__repr__ = short_repr
            return dataclasses.dataclass(repr=False, **options)(owner)

        return decorated
