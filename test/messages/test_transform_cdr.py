"""Transforms: what other libraries read in them, whatever the lengths of the frames' names."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from lie_rigid_body.messages import TransformEncoder

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPE = "tf2_msgs/msg/TFMessage"
NAMES = ["w" * length for length in range(1, 9)]
"""Every length modulo the largest alignment."""
STAMPS = np.array([0, 1, 999_999_999, 10**9, (2**31 - 1) * 10**9 + 999_999_999])
ATTITUDES = np.array(
    [[0, 0, 0, 1], [-0.0, 5e-324, 1, -1], [0.5, -0.5, 0.5, -0.5], [1 / 3, 1e-300, 0.1, 0.2], [1, 0, 0, 0]]
)
POSITIONS = np.array([[0, 0, 0], [-0.0, 5e-324, 1], [1 / 3, 1e300, -7], [-1, 1e9, 0.1], [2, 3, 4]])


def require_transform(payload: bytes, k: int, frame: str, child: str) -> None:
    message: Any = STORE.deserialize_cdr(payload, TYPE)
    [transform] = message.transforms
    stamp, q, t = transform.header.stamp, transform.transform.rotation, transform.transform.translation
    assert stamp.sec * 10**9 + stamp.nanosec == STAMPS[k]
    assert (transform.header.frame_id, transform.child_frame_id) == (frame, child)
    assert np.array([t.x, t.y, t.z]).tobytes() == POSITIONS[k].tobytes()
    assert np.array([q.x, q.y, q.z, q.w]).tobytes() == ATTITUDES[k].tobytes()


@pytest.mark.parametrize("frame", [*NAMES, "wörld"])
def test_others_read_the_transform(frame: str) -> None:
    for child in (*NAMES, "körper", "刚体"):
        payloads = TransformEncoder(frame, child).encode(STAMPS, POSITIONS, ATTITUDES)
        assert len(payloads) == len(STAMPS)
        for k, payload in enumerate(payloads):
            require_transform(payload, k, frame, child)


@pytest.mark.parametrize("frame", NAMES)
def test_bytes_equal_those_of_another_serialiser(frame: str) -> None:
    for child in NAMES:
        for payload in TransformEncoder(frame, child).encode(STAMPS, POSITIONS, ATTITUDES):
            again = STORE.serialize_cdr(STORE.deserialize_cdr(payload, TYPE), TYPE)
            assert payload == bytes(again)


def test_batches_of_any_size_give_the_same_bytes() -> None:
    encoder = TransformEncoder("world", "base_link")
    rows = [slice(k, k + 1) for k in range(len(STAMPS))]
    one_by_one = [encoder.encode(STAMPS[k], POSITIONS[k], ATTITUDES[k])[0] for k in rows]
    assert one_by_one == list(encoder.encode(STAMPS, POSITIONS, ATTITUDES))
    assert len(encoder.encode(STAMPS[:0], POSITIONS[:0], ATTITUDES[:0])) == 0
