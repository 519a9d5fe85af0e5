"""The messages of a bag that was found whole, read again: no checksum and no index is compared twice."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.records import Chunk

from lie_rigid_body.arrays import Integers
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages import Decoded
from lie_rigid_body.messages.decoding import byte_order
from lie_rigid_body.messages.layout import FRAME, numbers_after
from lie_rigid_body.recording.bag_files import Progress
from lie_rigid_body.recording.inflation import inflated_unverified
from lie_rigid_body.recording.mcap_reader import Outline, RawMessages, opened, state_of
from lie_rigid_body.recording.message_scan import FIND, TAKE, FoundMessages, Layout
from lie_rigid_body.recording.output_file import reason
from lie_rigid_body.recording.track_decoding import columns, named

_RECORD: Final = struct.Struct("<BQ")
_PAYLOAD: Final = 31
"""Byte of a message record where its payload begins."""


class TopicReader:
    """The messages of a topic, chunk by chunk.

    Parameters
    ----------
    path : Path
        Of the bag, for errors.
    key : tuple of (str, str)
        Topic and message type.
    numbers : int
        How many float64 fields each message has.
    stamped : bool
        Whether a std_msgs/Header comes first.
    """

    def __init__(self, path: Path, key: tuple[str, str], numbers: int, *, stamped: bool) -> None:
        self.key = key
        self._path, self._numbers, self._stamped = path, numbers, stamped
        self._layout: Layout | None = None
        self._frames: tuple[str, ...] = ()
        self._count = 0

    def take(self, data: bytes, channels: Sequence[int]) -> tuple[Integers, Decoded]:
        """Log times, ns, and contents of the messages in a chunk, in file order."""
        found = self._by_layout(data, channels[0]) if len(channels) == 1 and self._layout else None
        if found is None:
            found = self._one_by_one(data, channels)
        self._count += len(found[0])
        return found

    def _by_layout(self, data: bytes, channel: int) -> tuple[Integers, Decoded] | None:
        assert self._layout is not None
        taken = self._layout.take(data, channel)
        if taken is None:
            return None
        log_times, stamps, values = taken
        return log_times, Decoded(stamps if self._stamped else None, values, self._frames if len(stamps) else ())

    def _one_by_one(self, data: bytes, channels: Sequence[int]) -> tuple[Integers, Decoded]:
        """In the general way, from which the layout of those that follow is learned."""
        piece = _piece(data, channels)
        with named(self._path, self.key[0]):
            log_times, decoded = columns([piece], self._numbers, stamped=self._stamped, first=self._count)
        if len(decoded.numbers) and len(decoded.frame_ids) <= 1:
            self._learn(piece.data[piece.starts[0] : piece.ends[0]], decoded.frame_ids)
        return log_times, decoded

    def _learn(self, payload: bytes, frames: tuple[str, ...]) -> None:
        take = TAKE.compiled_for(0)
        if take is None or byte_order(payload, 0) != "<":
            return
        frame_end = FRAME + int.from_bytes(payload[12:FRAME], "little") if self._stamped else 0
        start = numbers_after(frame_end) if self._stamped else 4
        self._layout, self._frames = Layout(take, payload, self._numbers, start, frame_end), frames


def may_read_again(outlines: Sequence[Outline], count: int) -> bool:
    """Whether the files can be read again so: in chunks, by loops that are compiled for so many messages."""
    if not outlines or not all(outline.chunks for outline in outlines):
        return False
    return FIND.compiled_for(count) is not None and TAKE.compiled_for(count) is not None


def chunks(outlines: Sequence[Outline], progress: Progress) -> Iterator[tuple[Outline, bytes]]:
    """The records of each chunk of the files, with the file that they are in.

    Raises
    ------
    BagError
        If a file is not what it was when it was outlined.
    """
    for outline in outlines:
        with opened(outline.path) as stream:
            try:
                _require_same(outline, stream)
                before = 0
                for place in outline.chunks:
                    stream.seek(place)
                    _, length = _RECORD.unpack(stream.read(_RECORD.size))
                    content = stream.read(length)
                    progress(stream.tell() - before)
                    before = stream.tell()
                    yield outline, inflated_unverified(Chunk.read(ReadDataStream(BytesIO(content))))
                _require_same(outline, stream)
            except OSError as error:
                raise BagError(f"{outline.path} cannot be read: {reason(error)}: copy it to a better place") from None
            except (ValueError, struct.error) as error:
                raise _changed(outline) from error


def _require_same(outline: Outline, stream: BinaryIO) -> None:
    if state_of(stream) != outline.state:
        raise _changed(outline)


def _changed(outline: Outline) -> BagError:
    return BagError(f"{outline.path} changed while it was read: try again when nobody writes it")


def _piece(data: bytes, channels: Sequence[int]) -> RawMessages:
    """The messages of channels in a chunk."""
    find: Any = FIND.compiled_for(0)
    found, position = FoundMessages(find, data), 0
    starts, ends, log_times = ([np.empty(0, dtype=np.int64)] for _ in range(3))
    while position < len(data):
        table = found.at(position)
        if table is None:
            position += _RECORD.size + _RECORD.unpack_from(data, position)[1]
            continue
        own = np.isin(table.channels, list(channels))
        starts.append(table.starts[own] + _PAYLOAD)
        ends.append(table.ends[own])
        log_times.append(table.log_times[own])
        position = int(table.ends[-1])
    return RawMessages(data, np.concatenate(starts), np.concatenate(ends), np.concatenate(log_times))
