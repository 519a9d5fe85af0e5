"""The law of the stamps: every topic has every sample once, in order, stamped on the nanosecond."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.parameters import NS
from lie_rigid_body.simulation import SampleClock, Segment

OFF_GRID: Final = "ns"
GAP: Final = "gap"
DUPLICATE: Final = "dup"
DISORDER: Final = "ord"

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


@dataclass(frozen=True)
class _Fault:
    """What is wrong with the stamps of a topic: its kind, how many samples it concerns, the first one, in words."""

    kind: str
    count: int
    sample: int
    text: str


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
        ``worst`` is how far a stamp is off the grid, ns; where all are on it, the number of samples that are missing
        (unit ``gap``), doubled (``dup``) or out of order (``ord``), and ``sample`` the first. The message names all.
    """
    clock = segment.clock()
    numbers = {topic: number_samples(clock, values) for topic, values in stamps.items()}
    first, last = _expected(segment, following, numbers, late_start=late_start, open_end=open_end)
    faults = [
        fault
        for topic, values in stamps.items()
        for fault in _faults(topic, numbers[topic], values, first[topic], last[topic], clock)
    ]
    unit = next(
        (kind for kind in (OFF_GRID, GAP, DUPLICATE, DISORDER) if any(f.kind == kind for f in faults)), OFF_GRID
    )
    kindred = [fault for fault in faults if fault.kind == unit]
    checked = sum(len(values) for values in stamps.values())
    if not kindred:
        return LawResult("stamps", OFF_GRID, 0.0, 0.0, None, None, 0, checked)
    worst = max(f.count for f in kindred) if unit == OFF_GRID else sum(f.count for f in kindred)
    at = max(kindred, key=lambda f: f.count).sample if unit == OFF_GRID else min(f.sample for f in kindred)
    text = "; ".join(fault.text for fault in faults)
    return LawResult("stamps", unit, float(worst), 0.0, at, clock.stamp_ns(at), len(faults), checked, text)


def _expected(
    segment: Segment, following: int | None, numbers: Mapping[str, Integers], *, late_start: bool, open_end: bool
) -> tuple[dict[str, int], dict[str, int]]:
    """First and last sample number that each topic must have."""
    filled = [found for found in numbers.values() if found.size]
    first, last = {}, {}
    end = max((int(found.max()) for found in filled), default=segment.first_sample)
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


def _faults(topic: str, found: Integers, values: Integers, first: int, last: int, clock: SampleClock) -> list[_Fault]:
    """What is wrong with the stamps of a topic; of stamps off the grid, ``count`` is how far the worst is off, ns."""
    faults = []
    order = np.flatnonzero(np.diff(found) < 0)
    if order.size:
        pairs = [f"{found[i]} stands before {found[i + 1]}" for i in order]
        text = f"{topic}: out of order, sample {_some(pairs)}"
        faults.append(_Fault(DISORDER, len(order), int(found[order].min()), text))
    counted, times = np.unique(found, return_counts=True)
    doubled = counted[times > 1]
    if doubled.size:
        text = f"{topic}: duplicate of sample {_some([str(k) for k in doubled])}"
        faults.append(_Fault(DUPLICATE, len(doubled), int(doubled[0]), text))
    gaps = _gaps(counted, first, last)
    if gaps:
        text = f"{topic}: gap, {_some([_gap_in_words(*gap) for gap in gaps])}"
        faults.append(_Fault(GAP, sum(end - begin + 1 for begin, end in gaps), gaps[0][0], text))
    off = np.abs(values - _grid(clock, found))
    if off.any():
        i = int(off.argmax())
        text = (
            f"{topic}: {np.count_nonzero(off)} stamps off the grid, sample {found[i]} stamped {values[i]} ns "
            f"instead of {clock.stamp_ns(int(found[i]))}"
        )
        faults.append(_Fault(OFF_GRID, int(off[i]), int(found[i]), text))
    return faults


def _gaps(present: Integers, first: int, last: int) -> list[tuple[int, int]]:
    """First and last of each run of missing numbers between first and last."""
    edges = np.concatenate([[first - 1], present[(present >= first) & (present <= last)], [last + 1]])
    return [(int(edges[i]) + 1, int(edges[i + 1]) - 1) for i in np.flatnonzero(np.diff(edges) > 1)]


def _gap_in_words(begin: int, end: int) -> str:
    if begin == end:
        return f"sample {begin} is missing"
    return f"{end - begin + 1} samples from {begin} to {end} are missing"


def _some(items: list[str]) -> str:
    """Text: the first four faults, then the number of the rest."""
    more = len(items) - _SHOWN
    return ", ".join(items[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
