"""The functions that compiled code may call, and the compiler: another process, which fills the cache."""

from __future__ import annotations

import atexit
import importlib
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from typing import Any, Final, TypeVar

from lie_rigid_body.compilation.cache import cache_folder, is_kept, mark
from lie_rigid_body.system.portable import lock

Function = TypeVar("Function", bound=Callable[..., Any])

_LOCK: Final = threading.RLock()
"""Held while numba's configuration is changed, which is one for the whole process."""
_FILL: Final = "import sys; sys.path[:] = sys.argv[4:]; from {} import fill; fill(*sys.argv[1:4])"
_WAITING: Final[list[tuple[Callable[..., Any], Callable[..., Any]]]] = []
"""Marked functions that numba does not know yet, each with what tells numba the function to compile in its place."""


def kernel(function: Function) -> Function:
    """Let compiled code call a function of numbers. The function itself is not changed."""
    return kernel_of(function)(function)


def kernel_of(compiled: Callable[..., Any]) -> Callable[[Function], Function]:
    """Let compiled code call another function, which gives the same bits, in place of the decorated one."""

    def mark(function: Function) -> Function:
        _WAITING.append((function, lambda *_, **__: compiled))
        return function

    return mark


def register_kernels(extending: Any) -> None:
    """Tell numba of the marked functions that it does not know yet; ``extending`` is its module of that name."""
    while _WAITING:
        function, told = _WAITING.pop(0)
        extending.overload(function, jit_options={"forceinline": True, "error_model": "numpy"}, strict=False)(told)


def started(function: Callable[..., None], signature: str) -> subprocess.Popen[bytes] | None:
    """Another process that compiles a function into the cache, and ends with this one; None where there is no need.

    It has a session of its own, as the signals of a terminal are for the work, which ends it.

    Parameters
    ----------
    function : callable
        A function of a module.
    signature : str
        Its types as numba writes them.
    """
    if is_kept(function) or not (find_spec("numba") and sys.executable and cache_folder(function)):
        return None
    quiet = subprocess.DEVNULL
    what = [function.__module__, function.__name__, signature]
    process = subprocess.Popen(
        [sys.executable, "-c", _FILL.format(__name__), *what, *sys.path],
        stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True,
    )  # fmt: skip
    atexit.register(_end, process)
    return process


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()


def fill(module: str, name: str, signature: str) -> None:
    """Compile a function into the cache; the other process runs this. Of runs side by side one compiles."""
    function: Callable[..., None] = getattr(importlib.import_module(module), name)
    folder = cache_folder(function)
    if folder is None:
        raise SystemExit(1)
    with (folder / "lock").open("w") as file, lock(file, wait=True):
        if not mark(folder, function).exists():
            if _compiled(function, signature) is None:
                raise SystemExit(1)
            mark(folder, function).touch()


def loaded(function: Callable[..., None], signature: str) -> Callable[..., None] | None:
    """The compiled function from the cache, or compiled now; None without numba, or without room for a cache.

    A thread of its own, which handles no signals, loads it: LLVM calls back into Python, and an exception that a signal
    handler raises in there is lost.
    """
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(_compiled, function, signature).result()


def _compiled(function: Callable[..., None], signature: str) -> Callable[..., None] | None:
    folder = cache_folder(function)
    try:
        numba: Any = importlib.import_module("numba")
        extending: Any = importlib.import_module("numba.extending")
    except ImportError:  # it refuses a NumPy that is newer than itself
        return None
    with _LOCK:
        register_kernels(extending)
        previous = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = str(folder) if folder else previous
        try:
            made: Callable[..., None] = numba.njit(
                signature, cache=folder is not None, error_model="numpy", nogil=True
            )(function)
        except (OSError, RuntimeError):  # no room for a cache, whose mark is of another place, or a numba set up oddly
            return None
        finally:
            numba.config.CACHE_DIR = previous
    return made
