"""Loops that run compiled where numba is installed and the work is long, and as plain Python otherwise.

The source is one and the same, and so are the bits: only sums, products, quotients and square roots of doubles are
used in it, all correctly rounded by either, and nothing is contracted or reordered. Numba is imported by the first long
piece of work, never before. What it compiles is kept in the user's cache folder, under a name that changes with the
source.

The first time, which takes some ten seconds in which Python would notice no signal, another process compiles; the work
goes on in Python until that is done.
"""

from __future__ import annotations

import atexit
import hashlib
import importlib
import inspect
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

Function = TypeVar("Function", bound=Callable[..., Any])
Array = NDArray[np.float64]
Integers = NDArray[np.int64]

LONG_CALL: Final = 1_000
"""Steps: shorter calls do not count. Those of a live node are shorter, and it cannot wait for a compiler."""

LONG_WORK: Final = 500_000
"""Steps in long calls after which compiled code pays: some seconds of Python, while numba loads in half of one and
compiles in ten, once."""

AT_ONCE: Final = 1_000_000
"""Steps of compiled code between two looks at signals, which it does not notice."""

WHILE_COMPILING: Final = 20_000
"""Steps in Python between two looks at whether the compiler is done."""

SIGNATURE: Final = "void(float64[::1], float64[::1], int64[::1], int64[::1], int64[::1], float64[:,::1])"

_PARTS: Final[list[Callable[..., Any]]] = []
_LOCK: Final = threading.Lock()


def kernel(function: Function) -> Function:
    """Mark a function of numbers that compiled loops call. It stays what it is."""
    _PARTS.append(function)
    return function


class Loop:
    """A loop over samples that advances a state, in Python until much work is seen, compiled from then on.

    Parameters
    ----------
    plain : callable
        Takes ``state`` (a list or array of float, changed in place), ``constants`` (floats), ``spans``, ``counts`` and
        ``takes`` (integers, one a sample: ns, the steps in them, and how many of these to take) and ``out`` (an array
        with one row a sample).
    """

    def __init__(self, plain: Callable[..., None]) -> None:
        self._plain = plain
        self._compiled: Callable[..., None] | None = None
        self._compiler: _Compiler | None = None
        self._work = 0
        self._may_compile = True

    def run(
        self,
        state: list[float],
        constants: list[float],
        spans: Integers,
        counts: Integers,
        out: Array,
        work: int | None = None,
    ) -> None:
        """Advance the state, and fill a row of ``out`` for each sample.

        Parameters
        ----------
        state : list of float
            Changed in place.
        constants : list of float
        spans, counts : ndarray of int64, shape (N,)
            Time from the sample before, ns, and the number of steps in it.
        out : ndarray, shape (N, K)
        work : int, optional
            Steps that this call counts as when it is judged whether compiling pays, those of ``counts`` unless given:
            of many calls that are one piece of work the first may count as all of them.
        """
        self._note(int(counts.sum()) if work is None else work)
        rest = slice(0, len(counts)), counts
        for some, takes in self._pieces(counts) if self._compiled or self._compiler else (rest,):
            if self._compiler and self._compiler.done:
                self.compile()
            if self._compiled is None:
                self._plain(state, constants, spans[some].tolist(), counts[some].tolist(), takes.tolist(), out[some])
                continue
            moved, fixed = np.array(state), np.array(constants)
            self._compiled(moved, fixed, spans[some], counts[some], takes, out[some])
            state[:] = moved.tolist()

    def compile(self) -> bool:
        """Compile, or load what was compiled before, and wait for it; whether numba is there to do it."""
        with _LOCK:
            if self._compiled is None and self._may_compile:
                compiler = self._compiler or _Compiler.of(self._plain)
                self._compiled = compiler.result() if compiler else None
                self._compiler, self._may_compile = None, self._compiled is not None
        return self._compiled is not None

    def _note(self, steps: int) -> None:
        """Have the loop compiled once there was enough work, without waiting for it."""
        if self._compiled is not None or self._compiler is not None or not self._may_compile or steps < LONG_CALL:
            return
        self._work += steps
        if self._work >= LONG_WORK:
            self._compiler = _Compiler.of(self._plain)
            self._may_compile = self._compiler is not None

    def _pieces(self, counts: Integers) -> Iterator[tuple[slice, Integers]]:
        """Samples and the steps to take in them, so that each piece is short; a sample of many steps is many pieces."""
        ends, begin = np.cumsum(counts), 0
        while begin < len(counts):
            at_once = AT_ONCE if self._compiled else WHILE_COMPILING
            reached = ends[begin] - counts[begin]
            end = max(begin + 1, int(np.searchsorted(ends, reached + at_once, side="right")))
            takes = counts[begin:end]
            while takes[0] > at_once:
                yield slice(begin, end), np.array([at_once])
                takes = takes - at_once
                at_once = AT_ONCE if self._compiled else WHILE_COMPILING
            yield slice(begin, end), takes
            begin = end


class _Compiler:
    """Another process that compiles a function into the cache.

    Parameters
    ----------
    function : callable
        Of a module.
    folder : Path or None
        The cache; without one there is no process, and the result is compiled here.
    """

    def __init__(self, function: Callable[..., None], folder: Path | None) -> None:
        self._function, self._folder = function, folder
        self._process: subprocess.Popen[bytes] | None = None
        if folder and not _is_filled(folder) and sys.executable:
            self._process = _started(function)
            atexit.register(self._end)

    @classmethod
    def of(cls, function: Callable[..., None]) -> _Compiler | None:
        """One for this function, if numba is installed."""
        return cls(function, _cache_folder(function)) if find_spec("numba") else None

    @property
    def done(self) -> bool:
        """Whether the result is there without waiting."""
        return self._process is None or self._process.poll() is not None

    def result(self) -> Callable[..., None] | None:
        """The compiled function, or None if that does not succeed."""
        if self._process is not None:
            try:
                failed = self._process.wait() != 0
            finally:
                self._end()
            if failed:
                return None
        return _compiled(self._function, self._folder)

    def _end(self) -> None:
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        atexit.unregister(self._end)


def _started(function: Callable[..., None]) -> subprocess.Popen[bytes]:
    """A process of its own session: the terminal's signals are for the work, which ends it."""
    code = "import sys; sys.path[:] = sys.argv[3:]; from lie_rigid_body import compilation as c; c.fill(*sys.argv[1:3])"
    quiet = subprocess.DEVNULL
    return subprocess.Popen(
        [sys.executable, "-c", code, function.__module__, function.__name__, *sys.path],
        stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True,
    )  # fmt: skip


def fill(module: str, name: str) -> None:
    """Compile a function into the cache: what the other process does."""
    function: Callable[..., None] = getattr(importlib.import_module(module), name)
    folder = _cache_folder(function)
    if _compiled(function, folder) is None or folder is None:
        raise SystemExit(1)
    (folder / "filled").touch()


def _is_filled(folder: Path) -> bool:
    return (folder / "filled").exists()


def _compiled(loop: Callable[..., None], folder: Path | None) -> Callable[..., None] | None:
    try:
        numba: Any = importlib.import_module("numba")
        extending: Any = importlib.import_module("numba.extending")
    except ImportError:  # it refuses a NumPy that is newer than itself
        return None
    while _PARTS:
        extending.register_jitable(_PARTS.pop(0))
    previous = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder) if folder else previous
    try:
        made: Callable[..., None] = numba.njit(SIGNATURE, cache=folder is not None, error_model="numpy")(loop)
    finally:
        numba.config.CACHE_DIR = previous
    return made


def _cache_folder(loop: Callable[..., None]) -> Path | None:
    """A folder of this user that can be written to, or none."""
    name = f"lie_rigid_body/{_digest(loop)}"
    homes = [os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"), os.path.expanduser("~/.cache")]
    private = str(Path(tempfile.gettempdir()) / f"cache-{os.getuid()}")
    for home in [*homes, private]:
        if home and _is_own_folder(Path(home) / name):
            return Path(home) / name
    return None


def _is_own_folder(path: Path) -> bool:
    """Whether a folder is there, made if need be, that this user owns and may write to: code is loaded from it."""
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        return path.stat().st_uid == os.getuid() and os.access(path, os.W_OK)
    except OSError:
        return False


def _digest(loop: Callable[..., None]) -> str:
    """Of every source beside the loop's own, as numba itself notices only a change of the one file; of Python and of
    the libraries that make the code.
    """
    sources = sorted(Path(inspect.getfile(loop)).parent.glob("*.py"))
    content = b"".join(path.read_bytes() for path in sources)
    makers = [sys.version, *(_version(name) for name in ("numba", "llvmlite", "numpy"))]
    return hashlib.sha256(content + "".join(makers).encode()).hexdigest()[:16]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""
