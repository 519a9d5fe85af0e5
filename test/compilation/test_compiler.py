"""What loads compiled code heeds signals."""

from __future__ import annotations

import ctypes
import os
import signal
from pathlib import Path

import pytest

from lie_rigid_body.compilation import compiler
from lie_rigid_body.compilation.compiler import Compiler


def test_a_signal_while_compiled_code_is_loaded_is_not_lost(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """It comes amid a call back from C, as LLVM makes them, where an exception is printed and forgotten."""

    def load(*arguments: object) -> None:
        ctypes.CFUNCTYPE(None)(lambda: os.kill(os.getpid(), signal.SIGINT))()

    monkeypatch.setattr(compiler, "_compiled", load)
    former = signal.signal(signal.SIGINT, signal.default_int_handler)  # another test may have left its own
    try:
        with pytest.raises(KeyboardInterrupt):
            Compiler(load, "void()", None).result()
    finally:
        signal.signal(signal.SIGINT, former)
