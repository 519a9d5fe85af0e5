"""The decorators `kernel` and `kernel_of` for functions called from code that numba compiles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

_WAITING: Final[list[tuple[Callable[..., Any], Callable[..., Any]]]] = []
"""Marked functions that numba has not been told of yet, each with the function that is compiled in its place."""


def kernel(function: Function) -> Function:
    """Let compiled code call a function of numbers. The function itself is not changed."""
    return kernel_of(function)(function)


def kernel_of(compiled: Callable[..., Any]) -> Callable[[Function], Function]:
    """Let compiled code call another function, which gives the same bits, in place of the decorated one."""

    def mark(function: Function) -> Function:
        _WAITING.append((function, compiled))
        return function

    return mark


def register_kernels(extending: Any) -> None:
    """Tell numba of the marked functions that it does not know yet; ``extending`` is its module of that name."""
    while _WAITING:
        function, compiled = _WAITING.pop(0)
        _register(extending, function, compiled)


def _register(extending: Any, function: Callable[..., Any], compiled: Callable[..., Any]) -> None:
    extending.overload(function, jit_options={"forceinline": True, "error_model": "numpy"}, strict=False)(
        lambda *_, **__: compiled
    )
