"""Functions that compiled code calls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

_PARTS: Final[list[tuple[Callable[..., Any], Callable[..., Any]]]] = []
"""What compiled loops call, and what stands for it in them."""


def kernel(function: Function) -> Function:
    """Mark a function of numbers that compiled loops call. It stays what it is."""
    return kernel_of(function)(function)


def kernel_of(compiled: Callable[..., Any]) -> Callable[[Function], Function]:
    """Mark a function in whose place compiled loops call another, which gives the same bits."""

    def mark(function: Function) -> Function:
        _PARTS.append((function, compiled))
        return function

    return mark


def register_kernels(extending: Any) -> None:
    """Tell numba of those that it does not know yet; ``extending`` is its module of that name."""
    while _PARTS:
        function, compiled = _PARTS.pop(0)
        _register(extending, function, compiled)


def _register(extending: Any, function: Callable[..., Any], compiled: Callable[..., Any]) -> None:
    extending.overload(function, jit_options={"forceinline": True, "error_model": "numpy"}, strict=False)(
        lambda *_, **__: compiled
    )
