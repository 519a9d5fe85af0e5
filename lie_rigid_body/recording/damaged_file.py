"""Search for the records of a damaged MCAP file: behind each other, where its summary says, or where one begins."""

from __future__ import annotations

import re
import zlib
from bisect import bisect_right
from collections.abc import Callable, Container, Iterator, Mapping
from functools import cached_property, partial
from itertools import chain, takewhile
from typing import Final

from mcap.opcode import Opcode

from lie_rigid_body.recording.records import LARGEST_RECORD, MAGIC, RECORD_HEAD, FileBytes, Place, records
from lie_rigid_body.recording.sound_records import ENDING, says_twice, sound

_CHUNK: Final = rb"\x06(?=(.{8}).{28}(?:\0{4}|\x03\0{3}lz4|\x04\0{3}zstd))"
_CHUNK_HEAD, _CHUNKED_HEAD, _LOOSE_HEAD = (
    re.compile(re.escape(MAGIC) + rb"\x01|" + head, re.DOTALL)
    for head in (
        _CHUNK,
        _CHUNK + rb"|[\x09\x0c](?=.{4}(\0{4}))",
        rb"[\x03\x04\x05\x09\x0c](?=.{4}\0{4}(.{2}))",
    )
)
"""Beginnings of a chunk; of that, attachments and metadata; and of what stands in no chunk, with a message's channel.

Or of another file, as of one that is attached."""
_DATA_END: Final = RECORD_HEAD.pack(Opcode.DATA_END, 4)
"""Head of the record DataEnd, behind which the summary stands: its kind, and the length 4 of its content."""
_BEFORE: Final = Place(0, 0, 0, len(MAGIC))
"""Place of what stands before the first record."""
_INDEXES: Final[Mapping[int, tuple[int, int]]] = {
    Opcode.CHUNK_INDEX: (16, 0),
    Opcode.ATTACHMENT_INDEX: (0, 16),
    Opcode.METADATA_INDEX: (0, 16),
}
"""Bytes of an index where it tells at which byte its record begins, and how the content of that begins."""
_KEY: Final = 16
"""Bytes at the beginning of the content of a record that its index repeats."""
_HEAD_SIZE: Final = 64
"""Bytes of which the longest beginning that is looked for takes less."""
_PIECE: Final = 2**12
"""Bytes that are looked through at a time."""
_FOOTER_SIZE: Final = RECORD_HEAD.size + 20 + len(MAGIC)
"""Bytes of the footer, and of what follows it."""
_LARGEST_SUMMARY: Final = 2**24
"""Bytes before the end of a file in which a displaced summary is looked for: the indexes of some 100 000 chunks."""
_CRC_PIECE: Final = 2**18
"""Bytes of which a checksum is computed at a time."""


class DamagedFile:
    """The places of the records of a file, of which some may be damaged, lost, or elsewhere than they were written.

    Parameters
    ----------
    given : FileBytes
    known : callable
        Returns the numbers of the channels that are declared; called where messages in no chunk are looked for.

    Attributes
    ----------
    has_chunks : bool
        Whether a chunk was taken of it: whoever takes one says so, as of messages.
    messages : int
        How many were taken of it.
    """

    def __init__(self, given: FileBytes, known: Callable[[], Container[int]]) -> None:
        self._given, self._known = given, known
        self.has_chunks, self.messages = False, 0
        self._doubted: Place | None = None
        self._in_doubt = 0  # bytes

    def places(self) -> Iterator[Place]:
        """Records whose lengths are right, each behind the one before; what stands between them is damaged.

        A record that was `doubted` meanwhile may be the beginning of one with the end of another: then the next one may
        begin within it.
        """
        place = _BEFORE
        while found := next(filter(None, map(partial(sound, self._given), self._starts(place))), None):
            self._doubted = None
            yield (place := found)

    def doubt(self, place: Place) -> None:
        """Take notice that the record that `places` gave last has damaged content.

        Within a chunk or an attachment other records are looked for then, until all such records together are four
        times as long as the file. Where none overlaps another they are not twice as long.
        """
        self._in_doubt += place.end - place.begin
        if place.opcode in (Opcode.CHUNK, Opcode.ATTACHMENT) and self._looks_within:
            self._doubted = place
            self._displaced.add(self._key(place.start))

    @property
    def is_indexed(self) -> bool:
        """Whether the summary tells of a chunk that is there."""
        return bool(self._indexed)

    @property
    def _looks_within(self) -> bool:
        return self._in_doubt <= 4 * len(self._given)

    def _starts(self, before: Place) -> Iterator[int]:
        """Byte behind a record; should no sound one begin there, where the next chunk or message may, and the footer.

        The summary tells where chunks begin, or how, should they have been displaced. Without one, what looks like a
        chunk is tried; in a file without chunks what looks like a definition, or a message of a known channel. In an
        unfinished chunk, and in one without compression, stands none of these. What looks like an attachment or
        metadata is tried in either.
        """
        given, at, footer = self._given, before.end, len(self._given) - _FOOTER_SIZE
        indexed = self._indexed
        number = bisect_right(indexed, before.start if self._looks_within else before.end - 1)
        until = indexed[number] if number < len(indexed) else footer
        if self._doubted == before and (indexed or self._is_packed(before)):
            yield from self._chunks_within(before, at)
        yield at
        is_unfinished = given[at : at + 1] == bytes([Opcode.CHUNK]) and says_twice(given, at)
        if indexed:
            yield from self._chunks_within(before, until)
            yield from map(indexed.__getitem__, range(number, len(indexed)))
        elif is_unfinished and not self._has_footer:
            return
        elif is_unfinished or self.has_chunks or (self._is_chunked and not self.messages):
            yield from (begin for begin, _ in self._looked_for(_CHUNKED_HEAD, before))
        else:
            known, message = self._known(), bytes([Opcode.MESSAGE])
            found = self._looked_for(_LOOSE_HEAD, before)
            yield from (begin for begin, of in found if of in known or given[begin : begin + 1] != message)
        if self._has_footer and footer > at:
            yield footer

    def _is_packed(self, place: Place) -> bool:
        return place.opcode == Opcode.CHUNK and self._given[place.begin + 28 : place.begin + 32] != bytes(4)

    @cached_property
    def _has_footer(self) -> bool:
        """Whether the file was written to its end."""
        last = sound(self._given, max(0, len(self._given) - _FOOTER_SIZE))
        return last is not None and last.opcode == Opcode.FOOTER

    def _chunks_within(self, before: Place, end: int) -> Iterator[int]:
        """Bytes behind the beginning of a record where what looks like a chunk, attachment or metadata begins.

        Where indexes tell of such, only those of which one tells that does not stand where it says.
        """
        if self._displaced or not self._indexed:
            found = (begin for begin, _ in self._looked_for(_CHUNKED_HEAD, before._replace(end=before.start), end))
            of_these = (begin for begin in found if not self._indexed or self._key(begin) in self._displaced)
            yield from takewhile(end.__gt__, of_these)

    def _looked_for(self, head: re.Pattern[bytes], before: Place, end: int | None = None) -> Iterator[tuple[int, int]]:
        """Bytes behind a record where what looks like another one begins, and the first number in that.

        A record that lost some bytes, and is no message, reaches into the other.
        """
        since, least = before.end if before.opcode == Opcode.MESSAGE else before.start, before.end - _PIECE
        for begin, match in self._matches(head, since + 1, before.end + LARGEST_RECORD if end is None else end):
            if match.lastindex is None:
                ends = self._matches(ENDING, begin + match.end(), before.end + LARGEST_RECORD)
                piece, its_end = next(ends, (0, None))
                if its_end and its_end.lastindex and piece + its_end.end() < len(self._given):
                    least = max(least, piece + its_end.end())
            elif begin + match.start() >= least:
                yield begin + match.start(), int.from_bytes(match[match.lastindex], "little")

    def _matches(self, pattern: re.Pattern[bytes], first: int, end: int) -> Iterator[tuple[int, re.Match[bytes]]]:
        """Matches of a pattern between two bytes, each with where the piece begins that is looked through."""
        for begin in range(first, min(end, len(self._given)), _PIECE):
            piece = self._given[begin : begin + _PIECE + _HEAD_SIZE]
            for match in pattern.finditer(piece) if piece.strip(b"\0") else ():  # a file may end in very many zeros
                if match.start() < _PIECE:  # else it is found again in the next piece
                    yield begin, match

    @cached_property
    def _is_chunked(self) -> bool:
        """Whether there are chunks, by the beginning of the file."""
        return any(sound(self._given, begin) for begin, _ in self._looked_for(_CHUNK_HEAD, _BEFORE))

    @cached_property
    def summary(self) -> list[Place]:
        """Records of the summary, which leads from the end of the data to that of the file, be it where it was written.

        None if it is not read to its end, or its checksum is another one.
        """
        footer = self._given[RECORD_HEAD.size - _FOOTER_SIZE :]
        declared, tried = int.from_bytes(footer[16:20], "little"), set[int]()
        for begin in chain([int.from_bytes(footer[:8], "little")], self._ends_of_data()):
            known = records(self._given, begin) if self._is_end_of_data(begin) else ()
            found = [*takewhile(lambda place: place.start not in tried, known)]  # those lead nowhere
            tried.update(place.start for place in found)
            if found[1:] and found[-1].opcode == Opcode.FOOTER and found[-1].end == len(self._given) - len(MAGIC):
                return found if declared in (0, self.crc(begin, found[-1].end - 4)) else []
        return []

    def _is_end_of_data(self, begin: int) -> bool:
        before = begin - len(_DATA_END) - 4
        return before > 0 and self._given[before : before + len(_DATA_END)] == _DATA_END

    def _ends_of_data(self) -> Iterator[int]:
        """Bytes behind what may be the end of the data, the last first."""
        size = len(self._given)
        for begin in reversed(range(max(0, size - _LARGEST_SUMMARY), size, _PIECE)):
            piece = self._given[begin : begin + _PIECE + len(_DATA_END) - 1]
            yield from reversed([begin + found.end() + 4 for found in re.finditer(re.escape(_DATA_END), piece)])

    @cached_property
    def repeated(self) -> dict[tuple[int, bytes], bytes]:
        """Contents of the definitions in the summary, by their kinds and numbers."""
        own = [place for place in self.summary if place.opcode in (Opcode.SCHEMA, Opcode.CHANNEL)]
        contents = ((place.opcode, self._given[place.begin : place.end]) for place in own)
        return {(opcode, content[:2]): content for opcode, content in contents}

    @cached_property
    def _indexed(self) -> list[int]:
        """Bytes where chunks, attachments and metadata begin, by the indexes in a summary that tells of chunks."""
        starts = (self._start_of(place) for place in self.summary if place.opcode in _INDEXES)
        found = [place for start in starts if (place := sound(self._given, start))]
        return sorted(place.start for place in found) if Opcode.CHUNK in {place.opcode for place in found} else []

    def _start_of(self, index: Place) -> int:
        begin = index.begin + _INDEXES[index.opcode][0]
        return int.from_bytes(self._given[begin : begin + 8], "little")

    @cached_property
    def _displaced(self) -> set[bytes]:
        """Beginnings of those records of which an index tells, and which do not stand where it says."""
        there = {(start, self._key(start)) for start in self._indexed}
        indexes = [place for place in self.summary if place.opcode in _INDEXES]
        told = ((self._start_of(place), self._key(place.start)) for place in indexes)
        return {key for start, key in told if (start, key) not in there}

    def _key(self, start: int) -> bytes:
        """What a record, or its index, has at the beginning of the content: two times, or a name as far as it goes."""
        opcode, begin = self._given[start : start + 1][0], start + RECORD_HEAD.size
        begin += _INDEXES[opcode][1] if opcode in _INDEXES else 0
        found = self._given[begin : begin + _KEY]
        is_name = opcode in (Opcode.METADATA, Opcode.METADATA_INDEX)
        return found[: 4 + int.from_bytes(found[:4], "little")] if is_name else found

    def agrees(self, end: Place) -> bool:
        """Whether the checksum of the data, the summary, and the number of messages in that, are right if given.

        Parameters
        ----------
        end : Place
            The end of the data.
        """
        is_told = any(self._given[RECORD_HEAD.size - _FOOTER_SIZE :][:8])
        has_summary = is_told or end.end < len(self._given) - _FOOTER_SIZE
        declared = int.from_bytes(self._given[end.begin : end.end], "little")
        begins = (place.begin for place in self.summary if place.opcode == Opcode.STATISTICS)
        counts = {int.from_bytes(self._given[begin : begin + 8], "little") for begin in begins}
        is_right = (not declared or declared == self.crc(0, end.start)) and has_summary == bool(self.summary)
        return is_right and counts <= {self.messages}

    def crc(self, begin: int, end: int) -> int:
        """Checksum of the bytes between two places."""
        crc = 0
        for at in range(begin, end, _CRC_PIECE):
            crc = zlib.crc32(self._given[at : min(at + _CRC_PIECE, end)], crc)
        return crc
