"""The compiler: another process, which leaves its result in the cache for this one."""

from __future__ import annotations

import atexit
import fcntl
import importlib
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from lie_rigid_body.compilation.cache import cache_folder, mark
from lie_rigid_body.compilation.kernels import register_kernels

_LOCK: Final = threading.RLock()
"""Held while numba's configuration is changed, which is one for the whole process."""


class Compiler:
    """Another process that compiles a function into the cache.

    Parameters
    ----------
    function : callable
        A function of a module.
    signature : str
        Its types as numba writes them.
    folder : Path or None
        The cache; without one there is no other process, and `result` compiles in this one.
    """

    def __init__(self, function: Callable[..., None], signature: str, folder: Path | None) -> None:
        self._function, self._signature, self._folder = function, signature, folder
        self._process: subprocess.Popen[bytes] | None = None
        if folder and not mark(folder, function).exists() and sys.executable:
            self._process = _started([function], signature)
            atexit.register(self._end)

    @classmethod
    def of(cls, function: Callable[..., None], signature: str) -> Compiler | None:
        """The compiler of a function, or None if numba is not installed."""
        return cls(function, signature, cache_folder(function)) if find_spec("numba") else None

    @property
    def done(self) -> bool:
        """Whether `result` returns without waiting."""
        return self._process is None or self._process.poll() is not None

    def result(self) -> Callable[..., None] | None:
        """The compiled function, or None if compiling fails."""
        if self._process is not None:
            try:
                failed = self._process.wait() != 0
            finally:
                self._end()
            if failed:
                return None
        # In a thread of its own, which handles no signals: LLVM calls back into Python, and an exception that a signal
        # handler raises in there is lost.
        with ThreadPoolExecutor(1) as thread:
            return thread.submit(_compiled, self._function, self._signature, self._folder).result()

    def _end(self) -> None:
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        atexit.unregister(self._end)


def fill_together(functions: Sequence[Callable[..., None]], signature: str) -> None:
    """Compile what the cache does not have yet, and wait: in one other process, as the first takes it the longest."""
    missing = [f for f in functions if (folder := cache_folder(f)) and not mark(folder, f).exists()]
    if missing and find_spec("numba") and sys.executable:
        process = _started(missing, signature)
        try:
            process.wait()
        finally:
            process.kill()


def _started(functions: Sequence[Callable[..., None]], signature: str) -> subprocess.Popen[bytes]:
    """Start the process, in a session of its own: the terminal's signals go to the work, which ends this process."""
    code = (
        "import sys; sys.path[:] = sys.argv[3:]; from lie_rigid_body.compilation.compiler import fill; "
        "[fill(*name.split(':'), sys.argv[2]) for name in sys.argv[1].split()]"
    )
    names = " ".join(f"{function.__module__}:{function.__name__}" for function in functions)
    quiet = subprocess.DEVNULL
    return subprocess.Popen(
        [sys.executable, "-c", code, names, signature, *sys.path],
        stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True,
    )  # fmt: skip


def fill(module: str, name: str, signature: str) -> None:
    """Compile a function into the cache; this is what the other process runs. Of runs side by side one does it."""
    function: Callable[..., None] = getattr(importlib.import_module(module), name)
    folder = cache_folder(function)
    if folder is None:
        raise SystemExit(1)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not mark(folder, function).exists():
            if _compiled(function, signature, folder) is None:
                raise SystemExit(1)
            mark(folder, function).touch()


def _compiled(function: Callable[..., None], signature: str, folder: Path | None) -> Callable[..., None] | None:
    """The function compiled, or loaded from the cache; None without numba or room in the cache."""
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
        except OSError:  # no room for it, where a cache that is marked is of the same source at another place
            return None
        finally:
            numba.config.CACHE_DIR = previous
    return made
