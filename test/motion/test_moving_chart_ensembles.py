"""Ensembles in the moving chart: each body moves as it does alone, all of them or none, within the memory allowed."""

from __future__ import annotations

import re
import tracemalloc
from collections.abc import Sequence
from importlib.util import find_spec
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_ensembles import INERTIAS, RATES, assert_bits, attitudes, many, resized, tensors

from lie_rigid_body import ClosedForm, InputError, MovingChart, RigidBody, State
from lie_rigid_body.compilation import Loop, work
from lie_rigid_body.compilation import work as loops
from lie_rigid_body.lie import quaternion, vectors
from lie_rigid_body.motion import METHODS
from lie_rigid_body.motion.moser_veselov import integrator as moser_veselov_integrator
from lie_rigid_body.motion.moser_veselov import loop as moser_veselov_loop
from lie_rigid_body.motion.munthe_kaas import integrator as munthe_kaas_integrator
from lie_rigid_body.motion.munthe_kaas import loop as munthe_kaas_loop

TIMES = np.array([0, 0, 1, 77, 123_456_789, 10**9, 1_700_000_000])
LOOPS = (munthe_kaas_loop.LOOP, moser_veselov_loop.LOOP)
RUNGE_KUTTA = [name for name, method in METHODS.items() if method.largest_turn > 1.0]


def mixed() -> tuple[RigidBody, State]:
    """Bodies with every kind of motion, twice the first, with rates that ask for different numbers of steps."""
    return RigidBody(tensors()), State(attitudes(len(INERTIAS)), RATES)


@pytest.mark.parametrize("method", METHODS)
def test_each_body_has_the_bits_that_it_has_alone(method: str):
    body, start = mixed()
    motion = MovingChart(body, start, method=method, max_step=0.1)
    states, once = motion.at(TIMES), motion.at(2 * 10**9)
    assert states.attitude_xyzw.shape == (len(INERTIAS), len(TIMES), 4)
    assert once.body_rate.shape == (len(INERTIAS), 3)
    for i in range(len(INERTIAS)):
        alone = MovingChart(body[i], start[i], method=method, max_step=0.1)
        assert_bits(states[i], alone.at(TIMES))
        assert_bits(once[i], alone.at(2 * 10**9))
    np.testing.assert_array_equal(states.attitude_xyzw[:, 0], start.attitude_xyzw)


@pytest.mark.parametrize("method", ["dmv20", "dmv6", "rkmk4"])
def test_many_random_bodies_have_the_bits_that_they_have_alone(method: str):
    body, start = many(60)
    states = MovingChart(body, start, method=method, max_step=0.03).at(TIMES)
    for i in range(60):
        assert_bits(states[i], MovingChart(body[i], start[i], method=method, max_step=0.03).at(TIMES))


@pytest.mark.parametrize("method", ["dmv20", "rkmk2"])
def test_bodies_and_starts_broadcast(method: str):
    moments, rates = np.array([[0.6, 0.8, 1.0], [1.0, 2.0, 3.0]]), np.array(RATES[:3])
    turned = attitudes(3)

    def states(body: RigidBody, start: State) -> State:
        return MovingChart(body, start, method=method, max_step=0.05).at(TIMES)

    grid = states(RigidBody.from_principal_moments(moments[:, np.newaxis]), State(turned, rates))
    assert grid.attitude_xyzw.shape == (2, 3, len(TIMES), 4)
    for i, j in np.ndindex(2, 3):
        assert_bits(grid[i][j], states(RigidBody(moments[i]), State(turned[j], rates[j])))
    assert_bits(states(RigidBody(moments[1]), State(turned, rates)), grid[1])
    one_start = states(RigidBody.from_principal_moments(moments), State(turned[2], rates[2]))
    for i in range(2):
        assert_bits(one_start[i], grid[i][2])


def test_bodies_of_one_shape_and_rate_keep_their_attitudes():
    """They share all constants but the spatial momentum."""
    turned, body = attitudes(5), RigidBody([1.0, 0.1, -0.05, 1.4, 0.2, 1.9])
    start = State(turned, np.tile([0.4, -1.2, 0.7], (5, 1)))
    found, exact = MovingChart(body, start, max_step=0.05).at(TIMES), ClosedForm(body, start).at(TIMES)
    np.testing.assert_allclose(found.attitude_xyzw, exact.attitude_xyzw, rtol=0, atol=2e-15)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.floats(0.01, 1.0), st.floats(-7, 7))
def test_ensembles_follow_the_closed_form(seed: int, count: int, turn: float, decades: float):
    """Through five turns of 1 rad of the fastest body, by steps of its own for each.

    Round-off grows by e⁵ at most, where it is 1e-18 a step, and is lost in that of a quaternion in doubles.
    """
    random = np.random.default_rng(seed)
    second = 10.0 ** random.uniform(-3, 0, size=(count, 3))
    second[random.integers(0, 4, size=count) == 0, 0] = 0.0  # flat
    axes = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
    moments = second.sum(axis=-1, keepdims=True) - second
    matrices = axes @ (moments[..., np.newaxis] * axes.swapaxes(-1, -2))
    body = RigidBody(0.5 * (matrices + matrices.swapaxes(-1, -2)))
    rates = 10.0**decades * random.normal(size=(count, 3)) * 10.0 ** random.uniform(-2, 0, size=(count, 1))
    start = State(attitudes(count), rates)
    # the largest rate that the momentum allows
    fastest = vectors.norm(body.body_momentum(start)) / body.principal_moments[:, 0]
    times = np.sort(random.integers(0, min(max(int(5e9 / fastest.max()), 2), 2**62), size=4))
    found = MovingChart(body, start, max_step=turn / float(fastest.max())).at(times)
    exact = ClosedForm(body, start).at(times)
    turned = quaternion.multiply(quaternion.conjugate(exact.attitude_xyzw), found.attitude_xyzw)
    assert vectors.norm(quaternion.log(turned)).max() < 5e-15
    assert (np.abs(found.body_rate - exact.body_rate) / fastest[:, np.newaxis, np.newaxis]).max() < 5e-15


def test_each_body_is_stepped_at_its_own_rate():
    """Rates from 1e-3 to 1e3 rad/s in one ensemble, whose largest step suits the slow only."""
    rates = np.array([0.3, 0.5, -1.1]) * 10.0 ** np.arange(-3, 4)[:, np.newaxis]
    body, start = RigidBody([0.6, 0.8, 1.0]), State(attitudes(7), rates)
    found, exact = MovingChart(body, start, max_step=10.0).at(10**9), ClosedForm(body, start).at(10**9)
    np.testing.assert_allclose(found.attitude_xyzw, exact.attitude_xyzw, rtol=0, atol=1e-14)


@pytest.mark.parametrize("method", METHODS)
def test_times_that_go_back_move_no_body(method: str):
    body, start = mixed()
    motion, other = (MovingChart(body, start, method=method, max_step=0.05) for _ in range(2))
    for moved in (motion, other):
        moved.at([5, 10**8])
    for times in (10**8 - 1, [2 * 10**8, 2 * 10**8 - 1], [3 * 10**8, 10**8 - 1]):
        with pytest.raises(InputError):
            motion.at(times)
    assert_bits(motion.at([10**8, 10**9]), other.at([10**8, 10**9]))


@pytest.mark.parametrize("batch", [(3,), (1, 3), ()])
@pytest.mark.parametrize("method", RUNGE_KUTTA)
def test_a_step_too_long_for_one_body_names_it_and_moves_none(method: str, batch: tuple[int, ...]):
    rates = np.array([[0.1, 0.2, 0.3], [0.3, 0.5, 1.1], [3.0, 4e3, 0.0]])
    body, name = RigidBody([1.0, 2.0, 3.0]), {(3,): "body 2: ", (1, 3): "body (0, 2): ", (): ""}[batch]
    start = State(attitudes(*batch), rates.reshape(*batch, 3) if batch else rates[2])
    motion = MovingChart(body, start, method=method)
    with pytest.raises(InputError) as caught:
        motion.at([0, 10**6])
    assert str(caught.value).startswith(name)
    # steps short enough are taken from the start
    states, alone = motion.at(10**5), MovingChart(body, start, method=method).at(10**5)
    assert_bits(states, alone)


@pytest.mark.parametrize("method", RUNGE_KUTTA)
def test_a_body_that_goes_to_infinity_is_named_and_none_has_moved(method: str):
    rates = np.array([[1e-3, 2e-3, 3e-3], [0.0, 0.5, 0.0], [20.0, 30.0, 10.0]])
    body, start = RigidBody([0.2, 1.0, 1.1]), State(attitudes(3), rates)
    motion, other = (MovingChart(body, start, method=method, max_step=0.08) for _ in range(2))
    with pytest.raises(InputError) as caught:
        motion.at([10**6, 400 * 10**9])
    assert str(caught.value).startswith("body 2: ")
    assert_bits(motion.at([10**6, 10**8]), other.at([10**6, 10**8]))


def test_too_many_steps_name_the_body():
    start = State(attitudes(2), [[0.1, 0.2, 0.3], [1e9, 2e9, 1e9]])
    motion = MovingChart(RigidBody([1.0, 2.0, 3.0]), start, max_step=1.0)
    with pytest.raises(InputError) as caught:
        motion.at(10**18)
    assert str(caught.value).startswith("body 1: ")
    assert motion.at(10).body_rate.shape == (2, 3)


def test_an_interrupted_motion_has_not_moved(monkeypatch: pytest.MonkeyPatch):
    body, start = many(4)
    motion, run = MovingChart(body, start), LOOPS[1].run
    calls: list[tuple[Any, ...]] = []

    def interrupted(*arguments: Any) -> None:
        calls.append(arguments)
        run(*arguments)
        if len(calls) == 3:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(LOOPS[1], "run", interrupted)
        with pytest.raises(KeyboardInterrupt):
            motion.at(10**8)
    assert_bits(motion.at([5, 10**8]), MovingChart(body, start).at([5, 10**8]))


@pytest.mark.parametrize(("bodies", "starts"), [((2,), (3,)), ((3,), (2, 3)), ((2, 1), (3, 4, 5))])
def test_batches_that_do_not_go_together_are_refused(bodies: tuple[int, ...], starts: tuple[int, ...]):
    body = RigidBody(np.broadcast_to(np.diag([1.0, 2.0, 3.0]), (*bodies, 3, 3)))
    start = State(np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*starts, 4)), np.ones((*starts, 3)))
    with pytest.raises(InputError):
        MovingChart(body, start)


@pytest.mark.parametrize("method", METHODS)
def test_no_bodies_have_no_states(method: str):
    start = State(np.empty((0, 4)), np.empty((0, 3)))
    motion = MovingChart(RigidBody([1.0, 2.0, 3.0]), start, method=method)
    assert motion.at(TIMES).attitude_xyzw.shape == (0, len(TIMES), 4)
    assert motion.at(int(TIMES[-1])).body_rate.shape == (0, 3)
    assert MovingChart(*mixed(), method=method).at([]).body_rate.shape == (len(INERTIAS), 0, 3)


@pytest.mark.parametrize(("bodies", "times"), [(1, 2001), (40, 50), (300, 1), (2, 5)])
@pytest.mark.parametrize("method", ["dmv20", "rkmk4"])
def test_the_memory_limit_is_kept_and_does_not_matter_to_the_bits(bodies: int, times: int, method: str):
    body, start = many(min(bodies, 50))
    body, start = RigidBody(np.resize(body.inertia, (bodies, 3, 3))), State(*resized(start, bodies))
    t_ns = 1000 * np.arange(times) + 1
    motion = MovingChart(body, start, method=method)
    with pytest.raises(InputError) as caught:
        motion.at(t_ns, memory_limit=1000)
    needed = max(int(number) for number in re.findall(r"\d+", str(caught.value)))
    tracemalloc.start()
    states = motion.at(t_ns, memory_limit=needed)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert 56 * bodies * times <= peak <= needed
    assert_bits(states, MovingChart(body, start, method=method).at(t_ns))


@pytest.mark.parametrize("limit", [1e9, "2 GB", None, True])
def test_a_memory_limit_that_is_no_number_of_bytes_is_refused(limit: Any):
    with pytest.raises(InputError):
        MovingChart(*many(1)).at(0, memory_limit=limit)


@pytest.mark.skipif(not find_spec("numba"), reason="numba is not installed")
@pytest.mark.parametrize("method", METHODS)
def test_compiled_code_gives_the_bits_of_plain_python(method: str, monkeypatch: pytest.MonkeyPatch):
    body, start = many(12)
    with monkeypatch.context() as patch:
        for loop in LOOPS:
            patch.setattr(loop, "_compiled", None)
            patch.setattr(loop, "_may_compile", False)
        plain = MovingChart(body, start, method=method, max_step=0.02).at(TIMES)
    assert all(loop.compile() for loop in LOOPS)
    assert_bits(MovingChart(body, start, method=method, max_step=0.02).at(TIMES), plain)


@pytest.mark.parametrize("times", [[200_000_000], [150_000_000, 200_000_000], range(100_000_000, 100_000_010)])
@pytest.mark.parametrize("module", [moser_veselov_integrator, munthe_kaas_integrator])
def test_the_work_of_all_bodies_counts_as_one(
    module: ModuleType, times: Sequence[int], monkeypatch: pytest.MonkeyPatch
):
    """However few steps each of them takes, many bodies are worth compiling for, as soon as there is enough to do."""
    asked: list[int] = []
    monkeypatch.setattr(loops, "STEPS_FOR_COMPILING", 3999)
    loop = Loop(module.LOOP._plain)
    monkeypatch.setattr(work, "is_kept", lambda _: False)
    monkeypatch.setattr(work, "started", lambda *_: asked.append(1))
    monkeypatch.setattr(work, "loaded", lambda *_: None)
    monkeypatch.setattr(module, "LOOP", loop)
    method = "dmv20" if module is moser_veselov_integrator else "rkmk4"
    motion = MovingChart(*many(200), method=method, max_step=0.01)
    motion.at(10**8)
    assert not asked
    motion.at(times)
    assert asked
