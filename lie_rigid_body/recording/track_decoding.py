"""The messages of a bag's topic decoded; errors name bag and topic."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from lie_rigid_body import messages
from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages import Decoded
from lie_rigid_body.recording.mcap_reader import COMPRESSED_ONE_BY_ONE, ZSTD_MAGIC, RawMessages, RawTrack


@contextmanager
def named(path: Path, topic: str) -> Iterator[None]:
    """A context whose errors name the bag and the topic."""
    try:
        yield
    except BagError as error:
        raise BagError(f"{path}: topic {topic}: {error}: record the bag again") from None


def require_cdr(path: Path, track: RawTrack) -> None:
    """Refuse a topic whose messages are encoded otherwise."""
    if track.encoding != "cdr":
        raise BagError(f"{path}: topic {track.topic} is encoded as {track.encoding!r}: give one in cdr")


def taken(path: Path, track: RawTrack) -> list[RawMessages]:
    """The messages of a topic, which the track then forgets.

    Raises
    ------
    BagError
        If they are not in CDR, or compressed one by one.
    """
    require_cdr(path, track)
    pieces = track.take()
    if pieces and pieces[0].data[pieces[0].starts[0] :].startswith(ZSTD_MAGIC):
        raise BagError(f"{path}: {COMPRESSED_ONE_BY_ONE}")
    return pieces


def payloads(pieces: Sequence[RawMessages]) -> Iterator[tuple[int, bytes]]:
    """Log time, ns, and bytes of each message."""
    for piece in pieces:
        for time, start, end in zip(piece.log_times_ns.tolist(), piece.starts, piece.ends, strict=True):
            yield time, piece.data[start:end]


def texts(path: Path, track: RawTrack) -> list[tuple[int, str]]:
    """Log time, ns, and text of each std_msgs/String of a topic."""
    pieces = taken(path, track)
    with named(path, track.topic):
        return [(time, messages.decode_string(payload, i)) for i, (time, payload) in enumerate(payloads(pieces))]


def columns(pieces: Sequence[RawMessages], numbers: int, *, stamped: bool, first: int = 0) -> tuple[Integers, Decoded]:
    """Log times, ns, and contents of messages, the first of which has a number; see `messages.decode_places`."""
    data = b"".join([piece.data for piece in pieces])
    offsets = np.cumsum([0, *(len(piece.data) for piece in pieces)]).tolist()[: len(pieces)]
    starts, ends, log_times = (
        np.concatenate([np.empty(0, dtype=np.int64), *parts])
        for parts in (
            [piece.starts + at for piece, at in zip(pieces, offsets, strict=True)],
            [piece.ends + at for piece, at in zip(pieces, offsets, strict=True)],
            [piece.log_times_ns for piece in pieces],
        )
    )
    return log_times, messages.decode_places(data, starts, ends, numbers, stamped=stamped, first=first)


def stamped_columns(path: Path, track: RawTrack, numbers: int) -> tuple[Integers, Integers, Decoded]:
    """Log times and stamps, ns, and contents of all messages of a topic that have a header and so many numbers."""
    pieces = taken(path, track)
    with named(path, track.topic):
        log_times, decoded = columns(pieces, numbers, stamped=True)
    assert decoded.stamps_ns is not None
    return log_times, decoded.stamps_ns, decoded
