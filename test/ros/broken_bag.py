"""A bag that was cut off, as far as it is whole."""

from __future__ import annotations

from pathlib import Path

from mcap.exceptions import McapError
from mcap.records import Message
from mcap.stream_reader import StreamReader


def stamps_in_whole_chunks(bag: Path) -> list[int]:
    """Log times in a file that was cut off."""
    found = []
    with bag.open("rb") as stream:
        try:
            for record in StreamReader(stream).records:
                if isinstance(record, Message):
                    found.append(record.log_time)
        except (McapError, EOFError, ValueError):
            pass
    return sorted(set(found))
