"""Compiled and plain code give the same bits, and numba is left alone until it pays."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from lie_rigid_body import MovingChart, RigidBody, State
from lie_rigid_body.compilation import Loop, work
from lie_rigid_body.compilation import work as loops
from lie_rigid_body.compilation.cache import cache_folder, mark
from lie_rigid_body.compilation.compiler import started
from lie_rigid_body.compilation.work import LONG_CALL, SIGNATURE, STEPS_FOR_COMPILING, STEPS_FOR_LOADING
from lie_rigid_body.motion import METHODS
from lie_rigid_body.motion.moser_veselov import loop as moser_veselov_loop
from lie_rigid_body.motion.munthe_kaas import loop as munthe_kaas_loop
from lie_rigid_body.system.portable import lock

MODULES = (moser_veselov_loop, munthe_kaas_loop)
BODIES = {
    "principal": RigidBody([0.6, 0.8, 1.0]),
    "products": RigidBody([1.0, 0.1, -0.05, 1.4, 0.2, 1.9]),
    "symmetric": RigidBody([1.0, 1.0, 2.0]),
}
needs_numba = pytest.mark.skipif(not find_spec("numba"), reason="numba is not installed")


def states(body: RigidBody, method: str, times: np.ndarray, max_step: float) -> np.ndarray:
    start = State([0.5, -0.5, 0.5, 0.5], [3.0, 0.5, -0.9])
    found = MovingChart(body, start, method=method, max_step=max_step).at(times)
    return np.concatenate([found.attitude_xyzw, found.body_rate], axis=1)


@needs_numba
@pytest.mark.parametrize("max_step", [0.001, 0.01, 0.3, 0.9])
@pytest.mark.parametrize("method", METHODS)
def test_compiled_code_gives_the_bits_of_plain_python(method, max_step, monkeypatch):
    count = 60 if max_step < 0.1 else 4  # or the low orders run away
    times = np.cumsum(np.random.default_rng(3).integers(0, int(3e9 * max_step), size=count))
    for body in BODIES.values():
        with monkeypatch.context() as patch:
            for module in MODULES:
                patch.setattr(module.LOOP, "_compiled", None)
                patch.setattr(module.LOOP, "_may_compile", False)
            plain = states(body, method, times, max_step)
        assert all(module.LOOP.compile() for module in MODULES)
        np.testing.assert_array_equal(states(body, method, times, max_step), plain)


@needs_numba
def test_short_pieces_are_the_whole(monkeypatch):
    """Compiled code comes back now and then to look at signals, also in the middle of a sample."""
    times = 10_000_000 * np.array([3, 3, 500, 501, 1700, 1701, 2300])
    assert all(module.LOOP.compile() for module in MODULES)
    for method in ("dmv20", "rkmk4"):
        whole = states(BODIES["products"], method, times, 0.01)
        with monkeypatch.context() as patch:
            patch.setattr(loops, "STEPS_PER_CALL", 100)
            np.testing.assert_array_equal(states(BODIES["products"], method, times, 0.01), whole)


def test_without_numba_everything_runs_in_python(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    loop = Loop(moser_veselov_loop.advance)
    assert not loop.compile()


def test_numba_that_does_not_load_is_done_without(monkeypatch, tmp_path):
    """As when its NumPy is too new."""
    (tmp_path / "numba.py").write_text("raise ImportError('Numba needs NumPy 2.0 or less')")
    for name in [name for name in sys.modules if name.partition(".")[0] == "numba"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.syspath_prepend(tmp_path)
    assert not Loop(moser_veselov_loop.advance).compile()


STATE = [0.5, -0.5, 0.5, 0.5, 0.0, 0.0, 1.0]


def done(loop: Loop, steps: int) -> np.ndarray:
    state, constants = list(STATE), [1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0]
    out = np.empty((1, 7))
    loop.run(state, constants, np.array([1000]), np.array([steps]), out)
    return out


def test_only_much_work_in_long_calls_starts_the_compiler(monkeypatch):
    loop, asked = Loop(munthe_kaas_loop.advance), []
    monkeypatch.setattr(work, "is_kept", lambda plain: False)
    monkeypatch.setattr(work, "started", lambda *function: asked.append(function))
    monkeypatch.setattr(work, "loaded", lambda *function: None)
    monkeypatch.setattr(loop, "_plain", lambda *_: None)
    for _ in range(2 * STEPS_FOR_COMPILING // LONG_CALL):
        done(loop, LONG_CALL - 1)
    assert not asked  # a live node never waits for it
    done(loop, STEPS_FOR_COMPILING - 1)
    assert not asked
    done(loop, LONG_CALL)
    assert asked


def test_what_is_kept_is_loaded_after_little_work(monkeypatch):
    loop = Loop(munthe_kaas_loop.advance)
    monkeypatch.setattr(work, "is_kept", lambda plain: True)
    monkeypatch.setattr(work, "started", lambda *function: None)
    kept = {(munthe_kaas_loop.advance, SIGNATURE): print}
    monkeypatch.setattr(work, "loaded", lambda *function: kept[function])
    assert loop.compiled_for(STEPS_FOR_LOADING - 1) is None
    assert loop.compiled_for(LONG_CALL) is print


@needs_numba
def test_work_goes_on_in_python_until_another_process_has_compiled(monkeypatch, tmp_path):
    """From one piece of a sample to the next, and the result is that of Python alone."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    plain, steps = Loop(munthe_kaas_loop.advance), 30_000
    monkeypatch.setattr(loops, "STEPS_IN_PYTHON", 100)
    expected = done(plain, steps)
    monkeypatch.setattr(loops, "STEPS_FOR_COMPILING", 1)
    loop = Loop(munthe_kaas_loop.advance)
    np.testing.assert_array_equal(done(loop, steps), expected)
    assert loop.compiled_for(0) is None
    assert loop._compiler is not None
    assert loop._compiler.wait(60) == 0
    np.testing.assert_array_equal(done(loop, steps), expected)
    assert loop.compiled_for(0) is not None
    another = Loop(munthe_kaas_loop.advance)
    np.testing.assert_array_equal(done(another, steps), expected)
    assert another.compiled_for(0) is not None  # at once, from the cache


@needs_numba
def test_the_compiling_process_ends_with_the_work(tmp_path):
    code = (
        "from lie_rigid_body.motion.munthe_kaas.loop import advance; "
        "from lie_rigid_body.compilation.compiler import started; "
        f"print(started(advance, {SIGNATURE!r}).pid)"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    found = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    with pytest.raises(ProcessLookupError):
        os.kill(int(found.stdout), 0)


@needs_numba
def test_of_runs_side_by_side_one_compiles(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folder = cache_folder(munthe_kaas_loop.advance)
    assert folder is not None
    with (folder / "lock").open("w") as file, lock(file):
        process = started(munthe_kaas_loop.advance, SIGNATURE)
        assert process is not None
        mark(folder, munthe_kaas_loop.advance).touch()  # as another process does at its end
    assert process.wait(60) == 0
    assert list(folder.rglob("*.nb?")) == []


@needs_numba
def test_a_compiler_that_fails_leaves_the_work_to_python(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    loop = Loop(munthe_kaas_loop.advance)
    assert loop.compiled_for(STEPS_FOR_COMPILING) is None
    assert loop._compiler is not None
    loop._compiler.kill()
    assert not loop.compile()
