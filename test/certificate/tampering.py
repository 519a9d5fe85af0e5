"""Changing a bag behind its writer's back: read every message, change some, write all as another program would."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from foreign_bags import Message, laid_out, messages_of
from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages import encode_string

Change = Callable[[list[Message]], list[Message]]


def tamper(source: Path, target: Path, change: Change, chunk_size: int = 2**20, library: str = "someone else") -> Path:
    """Write a changed copy of a bag, without the record that counts the samples at its end."""
    changed = (m._replace(publish_time=m.log_time) for m in change(messages_of(source)))
    target.write_bytes(laid_out(changed, library, chunk_size))
    return target


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
