"""Compiled and plain code give the same bits, changed kernels are compiled anew, and numba waits until it pays."""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lie_rigid_body
from lie_rigid_body import MovingChart, RigidBody, State
from lie_rigid_body.compilation import StepLoop, compiler, step_loop
from lie_rigid_body.compilation.step_loop import MAX_LIVE_SAMPLES, MAX_LIVE_STEPS, MIN_STEPS_TO_COMPILE
from lie_rigid_body.motion import METHODS
from lie_rigid_body.motion.moser_veselov.loop import LOOP
from lie_rigid_body.motion.munthe_kaas.integrator import LOOPS
from sampled import sampled

BODIES = {
    "principal": RigidBody([0.6, 0.8, 1.0]),
    "products": RigidBody([1.0, 0.1, -0.05, 1.4, 0.2, 1.9]),
    "symmetric": RigidBody([1.0, 1.0, 2.0]),
}
START = State([0.5, -0.5, 0.5, 0.5], [3.0, 0.5, -0.9])
needs_numba = pytest.mark.skipif(not find_spec("numba"), reason="numba is not installed")


def states(body: RigidBody, method: str, times: np.ndarray, max_step: float) -> np.ndarray:
    found = MovingChart(body, START, method=method, max_step=max_step).at(times)
    return np.concatenate([found.attitude_xyzw, found.body_rate], axis=1)


def compiled_loop(method: str) -> StepLoop:
    """The loop of a method, compiled."""
    assert MovingChart(BODIES["principal"], START, method=method).compile()
    return LOOPS.get(method, LOOP)


@needs_numba
@pytest.mark.parametrize("max_step", [0.001, 0.01, 0.3, 0.9])
@pytest.mark.parametrize("method", sampled(METHODS, every=3))
def test_compiled_code_gives_the_bits_of_plain_python(method, max_step, monkeypatch):
    count = 60 if max_step < 0.1 else 4  # or the low orders run away
    times = np.cumsum(np.random.default_rng(3).integers(0, int(3e9 * max_step), size=count))
    loop = compiled_loop(method)
    for body in BODIES.values():
        found = states(body, method, times, max_step)
        with monkeypatch.context() as patch:
            patch.setattr(loop, "_compiled", None)
            patch.setattr(loop, "_may_compile", False)
            np.testing.assert_array_equal(states(body, method, times, max_step), found)


@needs_numba
def test_short_pieces_are_the_whole(monkeypatch):
    """Compiled code comes back now and then to look at signals, also in the middle of a sample."""
    times = 10_000_000 * np.array([3, 3, 500, 501, 1700, 1701, 2300])
    for method in ("dmv20", "rkmk4"):
        compiled_loop(method)
        whole = states(BODIES["products"], method, times, 0.01)
        with monkeypatch.context() as patch:
            patch.setattr(step_loop, "MAX_STEPS_AT_ONCE", 100)
            np.testing.assert_array_equal(states(BODIES["products"], method, times, 0.01), whole)


CHANGED_KERNEL = """
import sys
from pathlib import Path

def run():
    for name in [name for name in sys.modules if name.startswith("lie_rigid_body")]:
        del sys.modules[name]
    from lie_rigid_body import MovingChart, RigidBody, State
    chart = MovingChart(RigidBody([1, 2, 3]), State([0, 0, 0, 1], [0.1, 1, 0.1]), method="rkmk2")
    assert chart.compile()
    return chart.at(10**9).attitude_xyzw.tolist(), {path: path.stat().st_mtime_ns for path in Path().rglob("*.nbc")}

before, kept = run()
assert kept
assert run() == (before, kept)
series = Path("lie_rigid_body", "lie", "series.py")
series.write_text(series.read_text("utf-8").replace("float(abs(b) /", "float(2 * abs(b) /"), "utf-8")
after, _ = run()
assert after != before
"""


@pytest.mark.slow
@needs_numba
def test_a_kernel_that_changes_is_compiled_anew_and_one_that_does_not_is_loaded(tmp_path: Path):
    """Numba's own cache would run yesterday's code, as the file that changes is not that of the loop.

    Each run imports the package anew, in one process: numba takes long to load.
    """
    source = Path(lie_rigid_body.__file__).parent
    shutil.copytree(source, tmp_path / "lie_rigid_body", ignore=shutil.ignore_patterns("config", "__pycache__"))
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-B", "-c", CHANGED_KERNEL]
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("numba", [None, "raise ImportError('Numba needs NumPy 2.0 or less')"])
def test_without_a_numba_that_loads_everything_runs_in_python(numba, monkeypatch, tmp_path):
    for name in [name for name in sys.modules if name.partition(".")[0] == "numba"]:
        monkeypatch.delitem(sys.modules, name)
    if numba is None:
        monkeypatch.setitem(sys.modules, "numba", None)
    else:
        (tmp_path / "numba.py").write_text(numba)
        monkeypatch.syspath_prepend(tmp_path)
    assert not StepLoop(nothing, tuple).compile((0.0,), (0.0,))


def nothing(state, constants, spans, counts, takes, out):
    """A loop that does nothing."""
    return state


def test_only_much_work_in_long_calls_asks_for_the_compiler(monkeypatch):
    loop, asked = StepLoop(nothing, tuple), []
    monkeypatch.setattr(step_loop, "compiled", lambda *_: asked.append(_))

    def work(steps: int, samples: int = 1) -> None:
        spans = np.full(samples, 1000)
        loop.run((0.0,), (0.0,), spans, np.full(samples, steps // samples), np.empty((samples, 7)))

    for _ in range(2 * MIN_STEPS_TO_COMPILE // MAX_LIVE_STEPS):
        work(MAX_LIVE_STEPS - 1)
        work(MAX_LIVE_SAMPLES, MAX_LIVE_SAMPLES)
    assert not asked  # a live node never waits for it
    work(MIN_STEPS_TO_COMPILE - MAX_LIVE_STEPS - 1)
    work(500, 100)
    assert not asked
    work(MAX_LIVE_STEPS)
    assert len(asked) == 1


def test_a_signal_while_code_is_compiled_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """It comes amid a call back from C, as LLVM makes them, where an exception is printed and forgotten."""

    def load(*_: object) -> list[Any]:
        ctypes.CFUNCTYPE(None)(lambda: os.kill(os.getpid(), signal.SIGINT))()
        return []

    monkeypatch.setattr(compiler, "_compiled", load)
    former = signal.signal(signal.SIGINT, signal.default_int_handler)  # another test may have left its own
    try:
        with pytest.raises(KeyboardInterrupt):
            compiler.compiled(nothing, ())
    finally:
        signal.signal(signal.SIGINT, former)


@needs_numba
@pytest.mark.parametrize("method", ["dmv20", "rkmk4"])
def test_a_compiled_call_runs_no_python_code(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception of a signal handler as it returns would end the process: numba goes on without what it asked for.

    The first call alone looks for types by Python code, and raises what comes from there.
    """
    loop = compiled_loop(method)
    states(BODIES["principal"], method, 10**9 * np.arange(20), 0.01)
    calls: list[str] = []
    function: Any = loop._compiled

    def watched(*arguments: Any) -> Any:
        sys.setprofile(lambda frame, event, _: calls.append(frame.f_code.co_name) if event == "call" else None)
        try:
            return function(*arguments)
        finally:
            sys.setprofile(None)

    monkeypatch.setattr(loop, "_compiled", watched)
    states(BODIES["principal"], method, 10**9 * np.arange(20), 0.01)
    assert calls == []


@pytest.mark.slow
@needs_numba
def test_without_a_cache_that_works_code_is_compiled_all_the_same(monkeypatch, tmp_path) -> None:
    """Be its disk full, a file of it damaged, as by a loss of power, or numba set up oddly."""
    resource = pytest.importorskip("resource")
    numba = pytest.importorskip("numba")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    try:
        assert StepLoop(nothing, tuple).compile((0.0,), (0.0,))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    for _ in range(2):
        assert StepLoop(nothing, tuple).compile((0.0,), (0.0,))
    for file in tmp_path.rglob("*.nb?"):
        file.write_bytes(file.read_bytes()[:100])
    for _ in range(2):
        assert StepLoop(nothing, tuple).compile((0.0,), (0.0,))
    assert [*tmp_path.rglob("*.nbc")]
    monkeypatch.setattr(numba.config, "CACHE_LOCATOR_CLASSES", "none_of_that.Name", raising=False)
    assert StepLoop(nothing, tuple).compile((0.0,), (0.0,))


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="a folder has no mode here")
@pytest.mark.parametrize("mode", [0o700, 0o777, 0o702])
def test_code_is_kept_where_this_user_alone_may_write(mode: int, monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "home"))
    folder = compiler.cache_folder("1.0")
    assert folder is not None
    assert folder.is_relative_to(tmp_path / "home")
    assert compiler.cache_folder("1.1") != folder
    folder.chmod(mode)
    assert compiler.cache_folder("1.0") == (folder if mode == 0o700 else None)
