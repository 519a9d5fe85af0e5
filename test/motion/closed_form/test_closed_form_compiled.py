"""The closed form on floats, on arrays and compiled: one source, and the same bits."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec

import numpy as np
import pytest
from test_closed_form_laws import MOTIONS
from test_ensembles import INERTIAS, RATES, attitudes, many, tensors

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.closed_form import solution
from lie_rigid_body.motion.closed_form.solution import compile_all
from lie_rigid_body.motion.closed_form.states import CIRCULAR, MOTION_KINDS

RANDOM = np.random.default_rng(12)
needs_numba = pytest.mark.skipif(not find_spec("numba"), reason="numba is not installed")


def times(count: int) -> np.ndarray:
    """Of both signs, near and as far as there are nanoseconds."""
    ends = np.array([0, 1, -1, 2**63 - 1, -(2**63), 2**53 + 1, -(2**32)])
    near, far = RANDOM.integers(-(10**11), 10**11, count), RANDOM.integers(-(2**63), 2**63 - 1, count)
    return np.concatenate([ends, near, far])


def bits(states: State) -> np.ndarray:
    return np.concatenate([states.attitude_xyzw, states.body_rate], axis=-1)


@pytest.fixture
def plain(monkeypatch) -> Iterator[pytest.MonkeyPatch]:
    """Without compiled code, as long as this is not undone."""
    with monkeypatch.context() as patch:
        for kind in MOTION_KINDS:
            patch.setattr(kind.work, "_compiled", None)
            patch.setattr(kind.work, "_may_compile", False)
        yield patch


def motions() -> Iterator[tuple[str, ClosedForm]]:
    for name, (inertia, rate) in MOTIONS.items():
        yield name, ClosedForm(RigidBody(inertia), State(quaternion.normalize([0.1, -0.7, 0.3, -0.5]), rate))
    # where exponentials underflow, and slopes are all but 0
    for rate in ([1e-300, 1.0, -1e-300], [1e-100, 1.0, 2e-100], [1.0, 1e-150, 1e-200]):
        yield str(rate), ClosedForm(RigidBody([1.0, 2.0, 3.0]), State([0.0, 0.0, 0.0, 1.0], rate))


EVERY_MOTION = pytest.mark.parametrize(("name", "motion"), list(motions()))


@EVERY_MOTION
def test_single_samples_have_the_bits_of_many(name: str, motion: ClosedForm, plain):
    """Few are computed in floats."""
    t_ns = times(60)
    whole = bits(motion.at(t_ns))
    np.testing.assert_array_equal(np.array([bits(motion.at(int(t))) for t in t_ns]), whole)
    assert np.isfinite(whole).all()


@needs_numba
@EVERY_MOTION
@pytest.mark.parametrize("count", [0, 3, 200, 3000])
def test_compiled_code_gives_the_bits_of_arrays(name: str, motion: ClosedForm, count: int, plain):
    t_ns = times(count)
    expected = bits(motion.at(t_ns))
    plain.undo()
    assert compile_all()
    np.testing.assert_array_equal(bits(motion.at(t_ns)), expected)
    np.testing.assert_array_equal(bits(motion.at(int(t_ns[-1]))), expected[-1])


@needs_numba
@pytest.mark.parametrize(("bodies", "samples"), [(1, 0), (300, 1), (40, 300), (3, 5000)])
def test_compiled_ensembles_have_the_bits_of_arrays(bodies: int, samples: int, plain):
    body, start = many(bodies)
    motion, t_ns = ClosedForm(body, start), times(samples)[:samples]
    kinds = ClosedForm(RigidBody(tensors()), State(attitudes(len(INERTIAS)), RATES))
    expected = bits(motion.at(t_ns)), bits(kinds.at(t_ns))
    plain.undo()
    assert compile_all()
    for found, states in zip((motion.at(t_ns), kinds.at(t_ns)), expected, strict=True):
        np.testing.assert_array_equal(bits(found), states)


@needs_numba
def test_compiled_code_looks_at_signals_between_pieces(monkeypatch):
    assert compile_all()
    body, start = many(30)
    motion, t_ns = ClosedForm(body, start), times(300)
    whole = bits(motion.at(t_ns))
    for most in (1, 100, 1000, 2000):
        monkeypatch.setattr(solution, "SAMPLES_PER_CALL", most)
        np.testing.assert_array_equal(
            bits(motion.at(t_ns[:50] if most == 1 else t_ns)), whole[:, : 50 if most == 1 else None]
        )


def test_a_short_script_does_not_import_the_compiler():
    code = (
        "import sys, numpy as np; from lie_rigid_body import ClosedForm, RigidBody, State; "
        "ClosedForm(RigidBody([1, 2, 3]), State([0, 0, 0, 1], [0.1, 1, 0])).at(np.arange(100_000)); "
        "assert 'numba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@needs_numba
def test_long_work_goes_on_compiled(monkeypatch):
    assert CIRCULAR.work.compile()  # so that it is in the cache
    monkeypatch.setattr(CIRCULAR.work, "_compiled", None)
    monkeypatch.setattr(CIRCULAR.work, "_may_compile", True)
    monkeypatch.setattr(CIRCULAR.work, "_work", 0)
    monkeypatch.setattr(CIRCULAR.work, "_enough", 5000)
    motion, t_ns = next(motions())[1], np.arange(3000)
    first = bits(motion.at(t_ns))
    assert CIRCULAR.work._compiled is None
    np.testing.assert_array_equal(bits(motion.at(t_ns)), first)
    assert CIRCULAR.work._compiled is not None
