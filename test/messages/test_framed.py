"""Odometry and transforms as `rosbags` encodes them, with stamps at both ends, and hostile ones."""

from __future__ import annotations

import struct
from functools import partial

import numpy as np
import pytest
from estimate_messages import STORE, messages

from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.messages.decoding import decode_framed
from lie_rigid_body.messages.definitions import ODOMETRY, TF_MESSAGE
from said import numbers

NS = 10**9
DECODERS = {
    ODOMETRY: (partial(decode_framed, numbers=85, counted=False), 4),
    TF_MESSAGE: (partial(decode_framed, numbers=7, counted=True), 8),
}
"""What decodes a type, and the place of the first stamp."""
ATTITUDE = np.array([0.1, -0.7, 0.1, 0.7])


def encoded(kind: str, stamp: int) -> bytes:
    return bytes(STORE.serialize_cdr(messages(np.eye(3))[kind](stamp, ATTITUDE), kind))


@pytest.mark.parametrize("kind", [*DECODERS])
@pytest.mark.parametrize("stamp", [0, 1, -1, -(2**31) * NS, 2**31 * NS - 1])
def test_stamps_before_1970_and_at_both_ends(kind: str, stamp: int) -> None:
    found = DECODERS[kind][0]([encoded(kind, stamp)])
    assert found["world", "base_link"].stamps_ns == [stamp]
    assert [row[3:7] for row in found["world", "base_link"].numbers] == [tuple(ATTITUDE)]


@pytest.mark.parametrize("kind", [*DECODERS])
@pytest.mark.parametrize("nanosec", [NS, 2**32 - 1])
def test_nanoseconds_beyond_a_second_are_refused(kind: str, nanosec: int) -> None:
    decode, place = DECODERS[kind]
    payload = bytearray(encoded(kind, 5))
    struct.pack_into("<I", payload, place + 4, nanosec)
    with pytest.raises(BagError) as refusal:
        decode([encoded(kind, 5), bytes(payload)])
    assert numbers(str(refusal.value))[:2] == [1, nanosec]
