"""Ensembles: each body of a batch moves as it does alone, within the memory that was allowed."""

from __future__ import annotations

import time
import tracemalloc

import numpy as np
import pytest

from lie_rigid_body import ClosedForm, InputError, RigidBody, State
from lie_rigid_body.lie import quaternion

# every kind of motion: circular, hyperbolic, on the separatrix, steady and at rest
INERTIAS = [
    *([0.6, 0.8, 1.0, 0.0, 0.0, 0.0], [1.0, 2.0, 3.0, 0.0, 0.0, 0.0], [3.0, 4.0, 6.0, 0.0, 0.0, 0.0]),
    *([1.0, 1.0, 1.8, 0.0, 0.0, 0.0], [2.0, 2.0, 2.0, 0.0, 0.0, 0.0], [1.0, 1.4, 1.9, 0.1, -0.05, 0.2]),
    [0.6, 0.8, 1.0, 0.0, 0.0, 0.0],
]
RATES = [
    *([0.3, 0.5, -1.1], [1e-3, 1.0, 1e-3], [-2.0, 3.0, 1.0], [0.3, 0.5, 1.1], [0.3, 0.5, 1.1], [0.4, -1.2, 0.7]),
    [0.0, 0.0, 0.0],
]
TIMES = np.array([0, 1, -77, 10**9, 123456789012, -(10**16), 10**18])


def tensors() -> np.ndarray:
    return np.array([[[a, d, e], [d, b, f], [e, f, c]] for a, b, c, d, e, f in INERTIAS])


def attitudes(*shape: int) -> np.ndarray:
    return quaternion.normalize(np.random.default_rng(5).normal(size=(*shape, 4)))


def many(count: int) -> tuple[RigidBody, State]:
    """Bodies of all shapes, in random positions and rotations."""
    random = np.random.default_rng(11)
    second = np.abs(random.normal(size=(count, 3))) + 0.1
    axes = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
    moments = second.sum(axis=-1, keepdims=True) - second
    matrices = axes @ (moments[..., np.newaxis] * axes.swapaxes(-1, -2))
    body = RigidBody(0.5 * (matrices + matrices.swapaxes(-1, -2)))
    return body, State(attitudes(count), random.normal(size=(count, 3)))


def assert_bits(states: State, alone: State) -> None:
    np.testing.assert_array_equal(states.attitude_xyzw, alone.attitude_xyzw)
    np.testing.assert_array_equal(states.body_rate, alone.body_rate)


def test_each_body_has_the_bits_that_it_has_alone():
    body, start = RigidBody(tensors()), State(attitudes(len(INERTIAS)), RATES)
    motion = ClosedForm(body, start)
    states, once = motion.at(TIMES), motion.at(10**9)
    assert states.attitude_xyzw.shape == (len(INERTIAS), len(TIMES), 4)
    assert once.body_rate.shape == (len(INERTIAS), 3)
    for i in range(len(INERTIAS)):
        alone = ClosedForm(body[i], start[i])
        assert_bits(states[i], alone.at(TIMES))
        assert_bits(once[i], alone.at(10**9))


@pytest.mark.parametrize(("bodies", "times"), [(40, 1), (40, 3), (3, 9001), (700, 17), (40, 0)])
def test_the_blocks_do_not_matter(bodies: int, times: int):
    body, start = many(bodies)
    t_ns = np.random.default_rng(2).integers(-(10**16), 10**16, size=times)
    motion = ClosedForm(body, start)
    whole, narrow = motion.at(t_ns), motion.at(t_ns, memory_limit=56 * bodies * times + 8 * times + 1_400_000)
    assert whole.body_rate.shape == (bodies, times, 3)
    assert_bits(narrow, whole)
    for i in (0, bodies // 2, bodies - 1):
        assert_bits(whole[i], ClosedForm(body[i], start[i]).at(t_ns))


def test_bodies_and_starts_broadcast():
    moments, rates = np.array([[0.6, 0.8, 1.0], [1.0, 2.0, 3.0]]), np.array(RATES[:3])
    turned = attitudes(3)
    grid = ClosedForm(RigidBody.from_principal_moments(moments[:, np.newaxis]), State(turned, rates)).at(TIMES)
    assert grid.attitude_xyzw.shape == (2, 3, len(TIMES), 4)
    one_body = ClosedForm(RigidBody(moments[1]), State(turned, rates)).at(TIMES)
    one_start = ClosedForm(RigidBody.from_principal_moments(moments), State(turned[2], rates[2])).at(TIMES)
    for i, j in np.ndindex(2, 3):
        alone = ClosedForm(RigidBody(moments[i]), State(turned[j], rates[j])).at(TIMES)
        assert_bits(grid[i][j], alone)
    assert_bits(one_body, grid[1])
    for i in range(2):
        assert_bits(one_start[i], grid[i][2])


def test_an_ensemble_keeps_each_momentum_and_energy():
    body, start = many(30)
    states = ClosedForm(body, start).at(TIMES)
    momentum, energy = body.angular_momentum(start), body.kinetic_energy(start)
    size = np.linalg.norm(momentum, axis=-1)[:, np.newaxis, np.newaxis]
    assert (np.abs(body.angular_momentum(states) - momentum[:, np.newaxis]) / size).max() <= 4e-15
    np.testing.assert_allclose(body.kinetic_energy(states), np.broadcast_to(energy[:, np.newaxis], (30, 7)), rtol=4e-15)


@pytest.mark.parametrize(("bodies", "times"), [(1, 60_000), (300, 200), (5000, 1), (2, 5)])
@pytest.mark.parametrize("spare", [1_200_000, 3_000_000, 10_000_000])
def test_the_memory_limit_is_kept(bodies: int, times: int, spare: int):
    body, start = many(min(bodies, 50))
    body, start = RigidBody(np.resize(body.inertia, (bodies, 3, 3))), State(*resized(start, bodies))
    motion, t_ns, limit = ClosedForm(body, start), np.arange(times), 64 * bodies * times + spare
    tracemalloc.start()
    motion.at(t_ns, memory_limit=limit)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert 56 * bodies * times <= peak <= limit


def resized(start: State, count: int) -> tuple[np.ndarray, np.ndarray]:
    return np.resize(start.attitude_xyzw, (count, 4)), np.resize(start.body_rate, (count, 3))


def test_more_than_the_memory_limit_is_refused_before_it_is_taken():
    motion = ClosedForm(*many(3))
    with pytest.raises(InputError):
        motion.at(TIMES, memory_limit=1000)
    with pytest.raises(InputError):
        motion.at(np.zeros(30_000_000, dtype=np.int8))
    needed = 56 * 3 * 7 + 8 * 7 + 2_000_000
    assert motion.at(TIMES, memory_limit=needed).attitude_xyzw.shape == (3, 7, 4)


@pytest.mark.parametrize("limit", [1e9, "2 GB", None, True])
def test_a_memory_limit_that_is_no_number_of_bytes_is_refused(limit):
    with pytest.raises(InputError):
        ClosedForm(*many(1)).at(0, memory_limit=limit)


@pytest.mark.parametrize(("bodies", "starts"), [((2,), (3,)), ((3,), (2, 3)), ((2, 1), (3, 4, 5))])
def test_batches_that_do_not_go_together_are_refused(bodies, starts):
    body = RigidBody(np.broadcast_to(np.diag([1.0, 2.0, 3.0]), (*bodies, 3, 3)))
    start = State(np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*starts, 4)), np.ones((*starts, 3)))
    with pytest.raises(InputError):
        ClosedForm(body, start)


def test_no_bodies_have_no_states():
    start = State(np.empty((0, 4)), np.empty((0, 3)))
    assert ClosedForm(RigidBody([1.0, 2.0, 3.0]), start).at(TIMES).attitude_xyzw.shape == (0, 7, 4)


def test_a_sample_of_an_ensemble_costs_no_more_than_of_one_body():
    """No loop of Python over samples or bodies: that would cost some 100 µs each."""
    body, start = many(100)
    motion, t_ns = ClosedForm(body, start), np.arange(500) * 10**7
    motion.at(t_ns)
    begin = time.process_time()
    motion.at(t_ns)
    assert (time.process_time() - begin) / (100 * 500) < 5e-6
