"""The law of the stamps: every topic has every sample once, in order, stamped on the nanosecond."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.parameters import NS
from lie_rigid_body.simulation import SampleClock, Segment

_SHOWN: Final = 4
"""Number of faults of each kind listed in a message."""


def number_samples(clock: SampleClock, stamps_ns: Integers) -> Integers:
    """The numbers of the grid's samples nearest to the stamps.

    Parameters
    ----------
    clock : SampleClock
    stamps_ns : ndarray of int64, shape (N,)

    Returns
    -------
    ndarray of int64, shape (N,)
    """
    # in two parts, as the product of a long time and a rate exceeds 53 bits
    whole, rest = np.divmod(stamps_ns - clock.epoch_ns, NS)
    if float(clock.rate).is_integer():
        rate = int(clock.rate)
        return whole * rate + np.rint(rest * (clock.rate * 1e-9)).astype(np.int64)
    return np.rint(whole * clock.rate + rest * (clock.rate * 1e-9)).astype(np.int64)


def stamp_law(
    segment: Segment, following: int | None, stamps: Mapping[str, Integers], *, late_start: bool, open_end: bool
) -> LawResult:
    """Whether every topic has every sample of the segment once, in order, stamped on the grid.

    Parameters
    ----------
    segment : Segment
    following : int or None
        Start of the next segment, ns, if there is one.
    stamps : mapping of str to ndarray of int64
        By topic, in file order.
    late_start, open_end : bool
        Whether the recording may begin after the start, or end at a different sample on each topic (a recorder that
        subscribes to a running node does both).

    Returns
    -------
    LawResult
        ``worst`` is how far a stamp is off the grid, ns; the message names gaps, duplicates and swaps.
    """
    clock = segment.clock()
    numbers = {topic: number_samples(clock, values) for topic, values in stamps.items()}
    first, last = _expected(segment, following, numbers, late_start=late_start, open_end=open_end)
    faults: list[str] = []
    worst, at = 0, None
    for topic, values in stamps.items():
        found = numbers[topic]
        off = np.abs(values - _grid(clock, found))
        if off.size and off.max() > worst:
            worst, at = int(off.max()), int(found[int(off.argmax())])
        faults += _faults(topic, found, off, values, first[topic], last[topic], clock)
    checked = sum(len(v) for v in stamps.values())
    stamp = None if at is None else int(clock.stamps_ns(at, 1)[0])
    return LawResult("stamps", "ns", float(worst), 0.0, at, stamp, len(faults), checked, "; ".join(faults))


def _expected(
    segment: Segment, following: int | None, numbers: Mapping[str, Integers], *, late_start: bool, open_end: bool
) -> tuple[dict[str, int], dict[str, int]]:
    """First and last sample number that each topic must have."""
    filled = [found for found in numbers.values() if found.size]
    first, last = {}, {}
    end = max(int(found.max()) for found in filled)
    if following is not None:
        end = int(number_samples(segment.clock(), np.array([following]))[0]) - 1
    for topic, found in numbers.items():
        begin_late = late_start and found.size
        end_early = open_end and found.size
        first[topic] = int(found.min()) if begin_late else segment.first_sample
        last[topic] = int(found.max()) if end_early else end
    return first, last


def _grid(clock: SampleClock, numbers: Integers) -> Integers:
    """The exact stamps of samples by their numbers, ns."""
    if numbers.size == 0:
        return numbers
    low, high = int(numbers.min()), int(numbers.max())
    if high - low > 4 * numbers.size + 1000:  # far-off stamps: no table of all between
        return np.array([int(clock.stamps_ns(int(k), 1)[0]) for k in numbers], dtype=np.int64)
    return clock.stamps_ns(low, high - low + 1)[numbers - low]


def _faults(
    topic: str, found: Integers, off: Integers, values: Integers, first: int, last: int, clock: SampleClock
) -> list[str]:
    """What is wrong with the stamps of a topic, in words."""
    faults = []
    order = np.flatnonzero(np.diff(found) < 0)
    if order.size:
        pairs = [f"{found[i]} stands before {found[i + 1]}" for i in order]
        faults.append(f"{topic}: out of order, sample {_some(pairs)}")
    counted, times = np.unique(found, return_counts=True)
    if (times > 1).any():
        faults.append(f"{topic}: duplicate of sample {_some([str(k) for k in counted[times > 1]])}")
    gaps = _gaps(counted, first, last)
    if gaps:
        faults.append(f"{topic}: gap, {_some(gaps)}")
    if off.any():
        i = int(off.argmax())
        faults.append(
            f"{topic}: {np.count_nonzero(off)} stamps off the grid, sample {found[i]} stamped {values[i]} ns "
            f"instead of {int(clock.stamps_ns(int(found[i]), 1)[0])}"
        )
    return faults


def _gaps(present: Integers, first: int, last: int) -> list[str]:
    """The runs of missing numbers between first and last, in words."""
    edges = np.concatenate([[first - 1], present[(present >= first) & (present <= last)], [last + 1]])
    gaps = []
    for before, after in itertools.pairwise(edges):
        missing = int(after - before) - 1
        if missing == 1:
            gaps.append(f"sample {before + 1} is missing")
        elif missing > 1:
            gaps.append(f"{missing} samples from {before + 1} to {after - 1} are missing")
    return gaps


def _some(items: list[str]) -> str:
    """Text: the first four faults, then the number of the rest."""
    more = len(items) - _SHOWN
    return ", ".join(items[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
