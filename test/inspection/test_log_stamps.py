"""Mistakes of stamps and readings that need no model."""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body.inspection.findings import Findings
from lie_rigid_body.inspection.stamps import (
    Stream,
    checked_stamps,
    fresh,
    is_clipped,
    is_noisy,
    resolution,
    tell_broken_axes,
)

STAMPS = np.arange(1000) * 10_000_000
RNG = np.random.default_rng(3)


def stamps_of(t_ns: np.ndarray) -> tuple[np.ndarray, Findings]:
    found = Findings()
    return checked_stamps("imu", t_ns, STAMPS, found), found


def zeroed(t_ns: np.ndarray) -> np.ndarray:
    return np.where((t_ns > 2e9) & (t_ns < 4e9), 0, t_ns)


def going_back(t_ns: np.ndarray) -> np.ndarray:
    t_ns = t_ns.copy()
    t_ns[500] -= 50_000_000
    return t_ns


def in_bursts(t_ns: np.ndarray) -> np.ndarray:
    return t_ns - t_ns % 50_000_000 + np.arange(len(t_ns)) % 5 * 1000


def set_back(t_ns: np.ndarray) -> np.ndarray:
    return t_ns - np.where(np.arange(len(t_ns)) < 500, 0, 3_000_000_000)


def of_two_clocks(t_ns: np.ndarray) -> np.ndarray:
    return t_ns + np.where(np.arange(len(t_ns)) % 2, 12_000_000_000, 0)


@pytest.mark.parametrize("broken", [zeroed, going_back, in_bursts, np.zeros_like, set_back, of_two_clocks])
def test_broken_stamps_are_named_and_even_afterwards(broken) -> None:
    even, found = stamps_of(broken(STAMPS))
    assert [mistake.code for mistake in found.mistakes] == ["stamps"]
    assert np.abs(np.diff(even) - 10_000_000).max() < 100_000


def test_healthy_stamps_with_jitter_stay() -> None:
    jittered = STAMPS + RNG.integers(-4_000_000, 4_000_000, len(STAMPS))
    even, found = stamps_of(np.sort(jittered))
    assert found.mistakes == []
    assert np.array_equal(even, np.sort(jittered))


@pytest.mark.parametrize("pause_s", [1, 1000, 1_700_000_000])
def test_a_gap_is_named(pause_s: int) -> None:
    paused = STAMPS + np.where(np.arange(1000) < 500, 0, pause_s * 10**9)
    even, found = stamps_of(paused)
    assert [mistake.code for mistake in found.mistakes] == ["gaps"]
    assert np.array_equal(even, paused)


def waves(count: int = 1000) -> np.ndarray:
    phases = np.arange(count)[:, np.newaxis] / 20.0 + np.arange(3)
    return np.sin(phases)


@pytest.mark.parametrize(("hold", "mistakes", "notes"), [(1, 0, 0), (2, 1, 0), (5, 1, 0)])
def test_held_readings_are_named_and_left_out(hold: int, mistakes: int, notes: int) -> None:
    found = Findings()
    left = fresh(Stream("magnetometer", STAMPS, np.repeat(waves(), hold, axis=0)[: len(STAMPS)]), found)
    assert (len(found.mistakes), len(found.notes)) == (mistakes, notes)
    assert len(left.t_ns) == len(STAMPS) // hold


def test_readings_of_a_slightly_slower_sensor_are_a_note() -> None:
    index = np.repeat(np.arange(1000), RNG.integers(1, 3, 1000))[: len(STAMPS)]
    found = Findings()
    fresh(Stream("magnetometer", STAMPS, waves()[index]), found)
    assert found.mistakes == []
    assert [note.code for note in found.notes] == ["rates"]
    assert found.notes[0].value == pytest.approx(1.5, abs=0.05)


@pytest.mark.parametrize("step", [0.3e-6, 0.00106526, 1.0])
def test_the_resolution_is_found_exactly(step: float) -> None:
    values = step * np.round(RNG.normal(size=500) * 300.0)
    assert resolution(values) == pytest.approx(step, rel=1e-9)
    assert resolution(values + RNG.normal(size=500) * step) == 0.0


def test_a_range_is_where_readings_stay_and_drop_away() -> None:
    values = 3.0 * np.sin(np.arange(1000) / 30.0)
    assert not is_clipped(values)
    assert is_clipped(np.minimum(values, 2.0))
    assert not is_clipped(np.round(values))  # a coarse sensor stays at its peaks as well


@pytest.mark.parametrize("axes", [[1], [0, 1, 2]])
def test_stuck_axes_are_named(axes: list[int]) -> None:
    readings = waves() + RNG.normal(size=(1000, 3)) * 1e-3
    noisy = is_noisy(readings)
    readings[:, axes] = 0.25
    found = Findings()
    tell_broken_axes(Stream("gyro", STAMPS, readings), noisy=noisy, found=found)
    assert [(mistake.code, mistake.sensor) for mistake in found.mistakes] == [("stuck", "gyro")]


def test_an_axis_of_a_perfect_sensor_may_stay() -> None:
    """The rate of a symmetric top along its axis is constant."""
    readings = waves()
    readings[:, 1] = 0.25
    found = Findings()
    tell_broken_axes(Stream("gyro", STAMPS, readings), noisy=is_noisy(readings), found=found)
    assert (found.mistakes, list(found.undecided)) == ([], ["stuck"])
