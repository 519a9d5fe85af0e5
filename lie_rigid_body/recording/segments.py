"""Segments of a bag, from one reset to the next, and the numbers of their samples by the stamps."""

from __future__ import annotations

import itertools
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Booleans, Integers
from lie_rigid_body.errors import BagError, InputError, ParameterError
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.bag_writer import REWRITTEN
from lie_rigid_body.recording.tracks import UNNAMED, BagFacts
from lie_rigid_body.simulation import SOFTWARE, SampleClock, Segment

MOST_SEGMENTS: Final = 10_000
"""Largest number of segments of a bag: each takes up to 1 ms."""
_RECORDER: Final = "libmcap "
"""Beginning of the library name in a file by `ros2 bag record`."""


def declared_segments(scenario_texts: Iterable[str], bag: str = UNNAMED) -> dict[str, Segment]:
    """Segments by the texts that declare them, in the order of their starts; repeats of a text count once.

    Parameters
    ----------
    scenario_texts : iterable of str
    bag : str, optional
        Name of the bag, for errors.

    Raises
    ------
    BagError
        If a scenario message cannot be read.
    ParameterError
        If one declares what cannot be, such as an impossible inertia.
    """
    texts = dict.fromkeys(scenario_texts)
    if len(texts) > MOST_SEGMENTS:
        raise BagError(f"{bag} declares {len(texts)} segments: at most {MOST_SEGMENTS} are read, record fewer resets")
    try:
        segments = {text: Segment.from_json(text) for text in texts}
    except ParameterError:
        raise
    except InputError as error:
        raise BagError(f"{bag} does not explain itself: {error}: record it anew") from None
    return dict(sorted(segments.items(), key=lambda item: item[1].start_ns))


def as_written(bag: BagFacts) -> bool:
    """Whether a bag is to be whole from its run's first sample on, and logged at its stamps, as by `BagWriter`.

    It is if it says so, by its library or by the record at its end, or if its first scenario is logged at its start.
    What `ros2 bag record` made of a running node begins in the midst, and is logged when it was received; what
    `Run.to_bag` made of such a bag begins there as well.
    """
    if REWRITTEN in bag.library:
        return False
    if bag.library.startswith(f"{SOFTWARE} ") or bag.expected_samples is not None:
        return True
    log_time, text = bag.scenario_texts[0]
    return log_time == Segment.from_json(text).start_ns and not bag.library.startswith(_RECORDER)


def with_inertia(segment: Segment, inertia: Sequence[float] | None) -> Segment:
    """Replace the inertia of a segment's body, kg m², if another one is given."""
    if inertia is None:
        return segment
    parameters: dict[str, object] = {**segment.scenario.parameters(), "inertia": list(inertia)}
    return replace(segment, scenario=type(segment.scenario).from_parameters(parameters))


def segment_parts(segments: Sequence[Segment], stamps_ns: Integers) -> Iterator[tuple[int, slice | Booleans]]:
    """Places of the segments that stamps belong to, and which of the stamps are theirs.

    Stamps before the first segment are left out.
    """
    if not len(stamps_ns):
        return
    starts = np.array([segment.start_ns for segment in segments])
    lowest, highest = np.searchsorted(starts, [stamps_ns.min(), stamps_ns.max()], side="right") - 1
    if lowest == highest >= 0:
        yield int(lowest), slice(None)
        return
    at = np.searchsorted(starts, stamps_ns, side="right") - 1
    for i in np.unique(at[at >= 0]).tolist():
        yield i, at == i


def segments_with_samples(
    segments: Sequence[Segment], seen: Container[int], *, whole: bool
) -> Iterator[tuple[int, int | None]]:
    """Places of the segments that have samples or lack them, and where the next one starts, ns, if there is one.

    A segment without a sample lacks some if recording had begun before it, and no reset followed it at once.

    Parameters
    ----------
    segments : sequence of Segment
        In the order of their starts.
    seen : container of int
        Places of those that have a pose or a twist.
    whole : bool
        Whether the bag is to be whole from its run's first sample on.
    """
    begun = whole
    for i, (segment, later) in enumerate(itertools.zip_longest(segments, segments[1:])):
        following = None if later is None else later.start_ns
        if i in seen or (begun and following is not None and following > segment.start_ns):
            yield i, following
            begun = True


def number_samples(clock: SampleClock, stamps_ns: Integers) -> Integers:
    """Numbers of the grid's samples nearest to the stamps.

    Parameters
    ----------
    clock : SampleClock
    stamps_ns : ndarray of int64, shape (N,)

    Returns
    -------
    ndarray of int64, shape (N,)
    """
    # in two parts, as the product of a long time and a rate exceeds 53 bits
    elapsed = stamps_ns - clock.epoch_ns
    whole = elapsed // NS  # half of the time of `divmod`
    rest = elapsed - whole * NS
    if float(clock.rate).is_integer():
        rate = int(clock.rate)
        return whole * rate + np.rint(rest * (clock.rate * 1e-9)).astype(np.int64)
    return np.rint(whole * clock.rate + rest * (clock.rate * 1e-9)).astype(np.int64)


def grid(clock: SampleClock, numbers: Integers) -> Integers:
    """The exact stamps of samples by their numbers, ns."""
    low, high = int(numbers.min()), int(numbers.max())
    if high - low > 4 * numbers.size + 1000:  # far-off stamps: no table of all between
        return np.array([clock.stamp_ns(int(k)) for k in numbers], dtype=np.int64)
    return clock.stamps_ns(low, high - low + 1)[numbers - low]
