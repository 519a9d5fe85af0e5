"""Changing a bag behind its writer's back: read every message, change some, write all with a foreign writer."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.reader import make_reader
from mcap.summary import Summary
from mcap.writer import Writer

from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages import encode_string


class Message(NamedTuple):
    """One message of a bag."""

    topic: str
    log_time: int
    data: bytes


Change = Callable[[list[Message]], list[Message]]


def tamper(source: Path, target: Path, change: Change, chunk_size: int = 2**20, library: str = "someone else") -> Path:
    """Write a changed copy of a bag, without the record that counts the samples at its end."""
    summary, messages = _read(source, source.stat().st_mtime_ns)
    with target.open("wb") as stream:
        writer = Writer(stream, chunk_size=chunk_size)
        writer.start(profile="ros2", library=library)
        channels = {}
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            number = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.topic] = writer.register_channel(
                channel.topic, channel.message_encoding, number, channel.metadata
            )
        for message in change([*messages]):
            writer.add_message(channels[message.topic], message.log_time, message.data, message.log_time)
        writer.finish()
    return target


@lru_cache(maxsize=4)
def _read(source: Path, written_ns: int) -> tuple[Summary, tuple[Message, ...]]:
    """Summary and messages of a bag that is not written again: most are changed in many ways."""
    with source.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        read_in_order = reader.iter_messages(log_time_order=False)
        return summary, tuple(Message(c.topic, m.log_time, m.data) for _, c, m in read_in_order)


def messages_of(bag: Path) -> list[Message]:
    """Messages in the order of the file."""
    return [*_read(bag, bag.stat().st_mtime_ns)[1]]


def on(topic: str, change: Callable[[list[Message]], list[Message]]) -> Change:
    """A change of the messages of one topic, left where they are among the others as far as their number allows."""

    def changed(messages: list[Message]) -> list[Message]:
        own = change([m for m in messages if m.topic == topic])
        rest = [m for m in messages if m.topic != topic]
        return (
            sorted(rest + own, key=lambda m: m.log_time)
            if len(own) != len(messages) - len(rest)
            else _merge(messages, topic, own)
        )

    return changed


def _merge(messages: list[Message], topic: str, own: list[Message]) -> list[Message]:
    replacements = iter(own)
    return [next(replacements) if m.topic == topic else m for m in messages]


def with_numbers(message: Message, first: int, change: Callable[[np.ndarray], np.ndarray]) -> Message:
    """Change the numbers at the end of a message, from number ``first`` of its seven or six, counted from the end."""
    data = bytearray(message.data)
    numbers = np.frombuffer(bytes(data[-8 * first :]), dtype="<f8").copy()
    data[-8 * first :] = np.asarray(change(numbers), dtype="<f8").tobytes()
    return message._replace(data=bytes(data))


def rotated(angle: float, axis: np.ndarray) -> Callable[[Message], Message]:
    """A pose turned about an axis of the world."""
    turn = quaternion.exp(angle * np.asarray(axis) / np.linalg.norm(axis))
    return lambda message: with_numbers(message, 4, lambda q: quaternion.multiply(turn, q))


def scaled_rate(factor: float) -> Callable[[Message], Message]:
    """A twist of another size."""
    return lambda message: with_numbers(message, 3, lambda w: factor * w)


def flipped(message: Message) -> Message:
    """A pose with the other quaternion of the same rotation."""
    return with_numbers(message, 4, lambda q: -q)


def at(index: int, change: Callable[[Message], Message]) -> Callable[[list[Message]], list[Message]]:
    """The change of one message."""
    return lambda ms: [change(m) if i == index else m for i, m in enumerate(ms)]


def declared(**changes: object) -> Change:
    """The scenario message with other values."""

    def changed(message: Message) -> Message:
        return message._replace(data=encode_string(json.dumps({**json.loads(message.data[8:-1]), **changes})))

    return on("/lie_rigid_body/scenario", at(0, changed))
