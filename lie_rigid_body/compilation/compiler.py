"""The functions that compiled code may call, and the compiler, whose cache is named by the source of its code."""

from __future__ import annotations

import hashlib
import importlib
import os
import shutil
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np

from lie_rigid_body.system.portable import is_private

Function = TypeVar("Function", bound=Callable[..., Any])

_ROOMS: Final = ("arithmetic", "compilation", "lie", "motion")
"""Rooms of the package whose source goes into compiled code."""
_HOMES: Final = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA")
"""Variables of the environment that may name the folder of caches."""
_LOCK: Final = threading.RLock()
"""Held while numba's configuration is changed, which is one for the whole process."""
_UNREGISTERED: Final[list[Callable[..., Any]]] = []
"""Marked functions that numba does not know yet."""


def kernel(function: Function) -> Function:
    """Let compiled code call a function of numbers. The function itself is not changed."""
    _UNREGISTERED.append(function)
    return function


def compiled(function: Callable[..., Any], arguments: tuple[Any, ...]) -> Callable[..., Any] | None:
    """A function compiled for the types of some arguments, or loaded from the cache; None without numba.

    Another thread does it, which handles no signals: an exception of a signal handler would be lost in LLVM's calls
    back into Python. This one waits in short turns, and so hears Ctrl-C.
    """
    found: list[Callable[..., Any]] = []
    thread = threading.Thread(target=lambda: found.extend(_compiled(function, arguments)), daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(0.05)
    return found[0] if found else None


def _compiled(function: Callable[..., Any], arguments: tuple[Any, ...]) -> list[Callable[..., Any]]:
    try:
        numba: Any = importlib.import_module("numba")
        extending: Any = importlib.import_module("numba.extending")
    except ImportError:  # it refuses a NumPy that is newer than itself
        return []
    with _LOCK:
        options = {"forceinline": True, "error_model": "numpy"}
        while _UNREGISTERED:
            one = _UNREGISTERED.pop()
            extending.overload(one, jit_options=options, strict=False)(_giving(one))
        folder = cache_folder(numba.__version__)
        previous = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(folder or previous)
        try:
            for cache in (folder is not None, False):
                with suppress(Exception):  # no room for a cache, a damaged file in it, or a numba set up oddly
                    made = numba.njit(cache=cache, error_model="numpy", nogil=True)(function)
                    made.compile(tuple(map(numba.typeof, arguments)))
                    return [made]
                shutil.rmtree(folder or "", ignore_errors=True)
        finally:
            numba.config.CACHE_DIR = previous
    return []


def _giving(function: Callable[..., Any]) -> Callable[..., Any]:
    """Function that tells numba which one to compile, whatever the types of its arguments."""
    return lambda *_, **__: function


def cache_folder(numba_version: str) -> Path | None:
    """Folder of compiled code, made if need be; None where it cannot be made, or others may write to it.

    Numba itself notices only a change of a function's own file, while its code holds kernels and constants of others.
    """
    digest = hashlib.sha256(repr([sys.version, numba_version, np.__version__]).encode())
    package = Path(__file__).parent.parent
    for file in sorted(file for room in _ROOMS for file in (package / room).rglob("*.py")):
        digest.update(file.read_bytes())
    home = next(filter(None, map(os.environ.get, _HOMES)), os.path.expanduser("~/.cache"))
    folder = Path(home, "lie_rigid_body", digest.hexdigest()[:16])
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if is_private(folder) else None
