"""Loops that run compiled where numba is installed and the work is long, and as plain Python or on arrays otherwise.

The source is one and the same, and so are the bits: only sums, products, quotients and square roots of doubles are
used in it, all correctly rounded by either, and nothing is contracted or reordered. Numba is imported by the first long
piece of work, never before. What it compiles is kept in the user's cache folder, under a name that changes with the
source.
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
import os
import tempfile
import threading
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

Function = TypeVar("Function", bound=Callable[..., Any])
Array = NDArray[np.float64]
Integers = NDArray[np.int64]

LONG_CALL: Final = 1_000
"""Steps or samples: shorter calls do not count. Those of a live node are shorter, and it cannot wait for a compiler."""

LONG_WORK: Final = 500_000
"""Steps in long calls after which compiled code pays: some seconds of Python, while numba loads in half of one and
compiles in ten, once."""

AT_ONCE: Final = 1_000_000
"""Steps of compiled code between two looks at signals, which it does not notice."""

SIGNATURE: Final = "void(float64[::1], float64[::1], int64[::1], int64[::1], int64[::1], float64[:,::1])"

_PARTS: Final[list[tuple[Callable[..., Any], Callable[..., Any]]]] = []
"""What compiled loops call, and what stands for it in them."""

_LOCK: Final = threading.Lock()


def kernel(function: Function) -> Function:
    """Mark a function of numbers that compiled loops call. It stays what it is."""
    return kernel_of(function)(function)


def kernel_of(compiled: Callable[..., Any]) -> Callable[[Function], Function]:
    """Mark a function in whose place compiled loops call another, which gives the same bits."""

    def mark(function: Function) -> Function:
        _PARTS.append((function, compiled))
        return function

    return mark


class Work:
    """A piece of code, and its compiled form from when much of it was called for.

    Parameters
    ----------
    plain : callable
    signature : str
        Numba's, of the compiled form.
    enough : int
        Units of work in long calls after which compiled code pays.
    """

    def __init__(self, plain: Callable[..., None], signature: str, enough: int) -> None:
        self._plain = plain
        self._signature = signature
        self._enough = enough
        self._compiled: Callable[..., None] | None = None
        self._work = 0
        self._may_compile = True

    def compile(self) -> bool:
        """Compile now, or load what was compiled before; whether numba is there to do it."""
        with _LOCK:
            if self._compiled is None and self._may_compile:
                self._compiled = _compiled(self._plain, self._signature) if find_spec("numba") else None
                self._may_compile = self._compiled is not None
        return self._compiled is not None

    def compiled_for(self, work: int) -> Callable[..., None] | None:
        """The compiled form, or None where this much more work does not make it pay, or numba is not there."""
        if self._compiled is None and self._may_compile and work >= LONG_CALL:
            self._work += work
            if self._work >= self._enough:
                self.compile()
        return self._compiled


class Loop(Work):
    """A loop over samples that advances a state, in Python until much work is seen, compiled from then on.

    Parameters
    ----------
    plain : callable
        Takes ``state`` (a list or array of float, changed in place), ``constants`` (floats), ``spans``, ``counts`` and
        ``takes`` (integers, one a sample: ns, the steps in them, and how many of these to take) and ``out`` (an array
        with one row a sample).
    """

    def __init__(self, plain: Callable[..., None]) -> None:
        super().__init__(plain, SIGNATURE, LONG_WORK)

    def run(self, state: list[float], constants: list[float], spans: Integers, counts: Integers, out: Array) -> None:
        """Advance the state, and fill a row of ``out`` for each sample.

        Parameters
        ----------
        state : list of float
            Changed in place.
        constants : list of float
        spans, counts : ndarray of int64, shape (N,)
            Time from the sample before, ns, and the number of steps in it.
        out : ndarray, shape (N, K)
        """
        compiled = self.compiled_for(int(counts.sum()))
        if compiled is None:
            steps = counts.tolist()
            self._plain(state, constants, spans.tolist(), steps, steps, out)
            return
        moved, fixed = np.array(state), np.array(constants)
        for some, takes in _pieces(counts):
            compiled(moved, fixed, spans[some], counts[some], takes, out[some])
        state[:] = moved.tolist()


def _pieces(counts: Integers) -> Iterator[tuple[slice, Integers]]:
    """Samples and the steps to take in them, so that each piece is short; a sample of many steps is many pieces."""
    ends, begin = np.cumsum(counts), 0
    while begin < len(counts):
        reached = ends[begin] - counts[begin]
        end = max(begin + 1, int(np.searchsorted(ends, reached + AT_ONCE, side="right")))
        takes = counts[begin:end]
        while takes[0] > AT_ONCE:
            yield slice(begin, end), np.array([AT_ONCE])
            takes = takes - AT_ONCE
        yield slice(begin, end), takes
        begin = end


def _compiled(loop: Callable[..., None], signature: str) -> Callable[..., None] | None:
    try:
        numba: Any = importlib.import_module("numba")
        extending: Any = importlib.import_module("numba.extending")
    except ImportError:  # it refuses a NumPy that is newer than itself
        return None
    while _PARTS:
        _register(extending, *_PARTS.pop(0))
    folder = _cache_folder(loop, numba.__version__)
    previous = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = folder or previous
    try:
        made: Callable[..., None] = numba.njit(signature, cache=folder is not None, error_model="numpy")(loop)
    finally:
        numba.config.CACHE_DIR = previous
    return made


def _register(extending: Any, function: Callable[..., Any], compiled: Callable[..., Any]) -> None:
    extending.overload(function, jit_options={"forceinline": True, "error_model": "numpy"}, strict=False)(
        lambda *_, **__: compiled
    )


def _cache_folder(loop: Callable[..., None], version: str) -> str | None:
    """A folder of this user that can be written to, or none."""
    name = f"lie_rigid_body/{_digest(loop, version)}"
    homes = [os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"), os.path.expanduser("~/.cache")]
    private = str(Path(tempfile.gettempdir()) / f"cache-{os.getuid()}")
    for home in [*homes, private]:
        if home and _is_own_folder(Path(home) / name):
            return str(Path(home) / name)
    return None


def _is_own_folder(path: Path) -> bool:
    """Whether a folder is there, made if need be, that this user owns and may write to: code is loaded from it."""
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        return path.stat().st_uid == os.getuid() and os.access(path, os.W_OK)
    except OSError:
        return False


def _digest(loop: Callable[..., None], version: str) -> str:
    """Of every source beside the loop's own, and of this: numba itself notices only a change of the one file."""
    sources = [Path(__file__), *sorted(Path(inspect.getfile(loop)).parent.glob("*.py"))]
    content = b"".join(path.read_bytes() for path in sources)
    return hashlib.sha256(content + version.encode()).hexdigest()[:16]
