"""What loads compiled code heeds signals, and does without where there is no room for it."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
from pathlib import Path

import pytest

from lie_rigid_body.compilation import compiler
from lie_rigid_body.compilation.compiler import loaded


def test_a_signal_while_compiled_code_is_loaded_is_not_lost(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """It comes amid a call back from C, as LLVM makes them, where an exception is printed and forgotten."""

    def load(*arguments: object) -> None:
        ctypes.CFUNCTYPE(None)(lambda: os.kill(os.getpid(), signal.SIGINT))()

    monkeypatch.setattr(compiler, "_compiled", load)
    former = signal.signal(signal.SIGINT, signal.default_int_handler)  # another test may have left its own
    try:
        with pytest.raises(KeyboardInterrupt):
            loaded(load, "void()")
    finally:
        signal.signal(signal.SIGINT, former)


def nothing() -> None:
    """A function to be compiled."""


def test_a_cache_without_room_leaves_the_plain_function(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Else what records a bag would end in an error that names no file, as if of the bag."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    try:
        assert loaded(nothing, "void()") is None
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_numba_that_is_set_up_oddly_leaves_the_plain_function(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """It reads a file of the working folder, which may be somebody else's."""
    numba = pytest.importorskip("numba")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(numba.config, "CACHE_LOCATOR_CLASSES", "none_of_that.Name", raising=False)
    assert loaded(nothing, "void()") is None
