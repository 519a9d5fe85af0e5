"""Loops of peers that are written here, compiled where numba is installed."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """The function itself where there is no numba."""
    if importlib.util.find_spec("numba") is None:
        return function
    import numba

    made: Function = numba.njit(function)
    return made
