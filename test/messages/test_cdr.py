"""Message bytes: the same as rclpy's where it is installed, and back again to the last bit."""

from __future__ import annotations

import struct
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from foreign_bags import decode
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.mechanics import State
from lie_rigid_body.messages import POSE_NUMBERS, TWIST_NUMBERS, PoseTwistEncoder, decode_string, encode_string
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Samples

TINY = 5e-324
FRAMES = ["w", "ab", "map", "base", "world", "base_1", "imu_lin", "base_lin", "base_link", "å", "körper", "刚体"]
NUMBERS = st.floats(allow_nan=False, width=64)
STAMPS = st.integers(0, (2**31 - 1) * 10**9 + 999_999_999)
NAMES = st.text(st.characters(categories=["L", "N"]), min_size=1, max_size=20)


def samples_of(stamps: list[int], attitudes: object, rates: object) -> Samples:
    state = State.trusted(np.array(attitudes, dtype=float), np.array(rates, dtype=float))
    return Samples(np.array(stamps, dtype=np.int64), state)


def encoder(frame: str = "world", body: str = "base_link", stamped: bool = True) -> PoseTwistEncoder:
    return PoseTwistEncoder(
        Scenario.from_parameters({"world_frame": frame, "body_frame": body, "stamped_twist": stamped})
    )


AWKWARD = samples_of(
    [0, 1, 999_999_999, 10**9, (2**31 - 1) * 10**9 + 999_999_999],
    [[0, 0, 0, 1], [-0.0, TINY, -TINY, -1], [0.5, -0.5, 0.5, -0.5], [1 / 3, 1e-300, 2.2e-308, 0.1], [1, 0, 0, -0.0]],
    [[0.01, 1, 0.01], [-0.0, TINY, 1e308], [1 / 3, -2 / 3, 0.1], [0, 0, -0.0], [1e-9, 1e9, np.pi]],
)


def bits(values: object) -> bytes:
    return np.ascontiguousarray(values, dtype=float).tobytes()


@given(
    st.lists(st.tuples(STAMPS, st.tuples(*[NUMBERS] * 4), st.tuples(*[NUMBERS] * 3)), min_size=1, max_size=5),
    NAMES,
    NAMES,
)
def test_decoding_inverts_encoding_to_the_bit(
    content: list[tuple[int, tuple[float, ...], tuple[float, ...]]], frame: str, body: str
) -> None:
    stamps, attitudes, rates = (list(column) for column in zip(*content, strict=True))
    samples = samples_of(stamps, attitudes, rates)
    body = body if body != frame else f"{body}_"
    poses = decode(encoder(frame, body).poses(samples), POSE_NUMBERS, stamped=True)
    twists = decode(encoder(frame, body).twists(samples), TWIST_NUMBERS, stamped=True)
    bare = decode(encoder(frame, body, stamped=False).twists(samples), TWIST_NUMBERS, stamped=False)
    assert poses.stamps_ns is not None
    assert twists.stamps_ns is not None
    assert poses.stamps_ns.tolist() == twists.stamps_ns.tolist() == stamps
    assert (poses.frame_ids, twists.frame_ids) == ((frame,), (body,))
    assert bits(poses.numbers[:, 3:]) == bits(attitudes)
    assert bits(twists.numbers[:, 3:]) == bits(bare.numbers[:, 3:]) == bits(rates)
    assert bits(poses.numbers[:, :3]) == bits(twists.numbers[:, :3]) == bytes(24 * len(stamps))
    assert bare.stamps_ns is None
    assert bare.frame_ids == ()


def test_batches_of_any_size_give_the_same_bytes() -> None:
    rng = np.random.default_rng(1)
    stamps = np.sort(rng.integers(0, 10**15, 50)).tolist()
    samples = samples_of(stamps, rng.normal(size=(50, 4)), rng.normal(size=(50, 3)))
    for make in (encoder().poses, encoder().twists, encoder(stamped=False).twists):
        one_by_one = [
            make(Samples(samples.stamps_ns[i : i + 1], samples.states[slice(i, i + 1)]))[0] for i in range(50)
        ]
        assert list(make(samples)) == one_by_one


CHARACTERS = st.one_of(st.integers(0, 0xD7FF), st.integers(0xE000, 0x10FFFF)).map(chr)
"""All that UTF-8 has; the tables of hypothesis' own take seconds to make."""


@given(st.lists(CHARACTERS, max_size=30).map("".join))
def test_strings_come_back(text: str) -> None:
    payload = encode_string(text)
    assert decode_string(payload) == text
    assert decode_string(payload + bytes(3)) == text  # padded by a middleware


@pytest.mark.parametrize("frame", FRAMES)
def test_big_endian_messages_are_read(frame: str) -> None:
    name = frame.encode() + b"\0"
    head = struct.pack(">iII", 7, 8, len(name)) + name
    numbers = [1.5, -2.5, 0.0, 0.1, 0.2, 0.3, 0.4]
    payload = b"\0\0\0\0" + head + bytes(-len(head) % 8) + struct.pack(">7d", *numbers)
    little = encoder(frame, "body").poses(AWKWARD)
    both = decode([payload, *little, payload], POSE_NUMBERS, stamped=True)
    assert both.stamps_ns is not None
    assert both.stamps_ns.tolist() == [7 * 10**9 + 8, *AWKWARD.stamps_ns.tolist(), 7 * 10**9 + 8]
    assert both.numbers[0].tolist() == both.numbers[-1].tolist() == numbers
    assert bits(both.numbers[1:-1, 3:]) == bits(AWKWARD.states.attitude_xyzw)
    assert both.frame_ids == (frame,)


def test_frame_names_are_listed_in_order_of_appearance() -> None:
    mixed = [encoder(frame).poses(AWKWARD)[1] for frame in ("zz", "aa", "much_longer", "zz", "bb")]
    assert decode(mixed, POSE_NUMBERS, stamped=True).frame_ids == ("zz", "aa", "much_longer", "bb")


def test_an_empty_frame_name_of_length_zero_is_read() -> None:
    payload = b"\0\1\0\0" + struct.pack("<iII", 1, 2, 0) + bytes(4) + struct.pack("<7d", *range(7))
    decoded = decode([payload], POSE_NUMBERS, stamped=True)
    assert decoded.numbers.tolist() == [list(range(7))]
    assert decoded.frame_ids == ("",)


GOOD = encoder().poses(AWKWARD)[0]
DAMAGED = {
    "empty": (b"", "begins with nothing"),
    "XCDR2": (b"\0\7" + GOOD[2:], "not plain CDR"),
    "cut in the header": (GOOD[:14], "ends after 14 bytes"),
    "cut in the frame name": (GOOD[:18], "has 18 bytes where"),
    "cut in the numbers": (GOOD[:-1], "has 83 bytes where its type and text lengths make 84"),
    "too long": (GOOD + bytes(8), "has 92 bytes where"),
    "frame length beyond the end": (GOOD[:12] + b"\xff\xff\xff\xff" + GOOD[16:], "its type and text lengths make"),
    "frame length beyond the message": (GOOD[:12] + struct.pack("<I", 100) + GOOD[16:], "has 84 bytes where"),
    "frame without its zero byte": (GOOD[:16] + b"worldx" + GOOD[22:], "does not end with a zero byte"),
    "frame not UTF-8": (GOOD[:16] + b"w\xff\xferl\0" + GOOD[22:], "not UTF-8"),
    "nanoseconds beyond a second": (GOOD[:8] + struct.pack("<I", 10**9) + GOOD[12:], "1000000000 nanosec"),
}


@pytest.mark.parametrize(("payload", "said"), DAMAGED.values(), ids=DAMAGED)
def test_a_malformed_payload_is_refused_by_number(payload: bytes, said: str) -> None:
    with pytest.raises(BagError, match=r"^message 2 ") as caught:
        decode([GOOD, GOOD, payload, GOOD], POSE_NUMBERS, stamped=True)
    assert said in str(caught.value)
    with pytest.raises(BagError, match=r"^message 0 "):
        decode([payload, payload], POSE_NUMBERS, stamped=True)


@given(st.binary(max_size=120))
def test_no_bytes_at_all_escape_as_another_error(payload: bytes) -> None:
    for numbers, stamped in ((POSE_NUMBERS, True), (TWIST_NUMBERS, True), (TWIST_NUMBERS, False)):
        with suppress(BagError):
            decode([payload, GOOD], numbers, stamped=stamped)
    with suppress(BagError):
        decode_string(payload)


def without_padding(payload: bytes, frame: str) -> bytes:
    """The bytes that mean something: rclpy leaves its padding before the numbers as the memory held it."""
    end = 16 + len(frame.encode()) + 1
    start = 4 + -(-(end - 4) // 8) * 8
    return payload[:end] + payload[start:]


@pytest.mark.ros
@pytest.mark.parametrize("frame", FRAMES)
def test_bytes_equal_rclpy_serialisation(frame: str) -> None:
    from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
    from rclpy.serialization import deserialize_message, serialize_message

    rows = zip(
        AWKWARD.stamps_ns.tolist(),
        AWKWARD.states.attitude_xyzw.tolist(),
        AWKWARD.states.body_rate.tolist(),
        encoder(frame, "body_0").poses(AWKWARD),
        encoder("world_0", frame).twists(AWKWARD),
        encoder("world_0", frame, stamped=False).twists(AWKWARD),
        strict=True,
    )
    for stamp, (x, y, z, w), (p, q, r), pose_bytes, twist_bytes, bare_bytes in rows:
        pose, twist, bare = PoseStamped(), TwistStamped(), Twist()
        for message in (pose, twist):
            message.header.frame_id = frame
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
        orientation = pose.pose.orientation
        orientation.x, orientation.y, orientation.z, orientation.w = x, y, z, w
        for angular in (twist.twist.angular, bare.angular):
            angular.x, angular.y, angular.z = p, q, r
        assert without_padding(pose_bytes, frame) == without_padding(serialize_message(pose), frame)
        assert without_padding(twist_bytes, frame) == without_padding(serialize_message(twist), frame)
        assert bare_bytes == serialize_message(bare)
        assert deserialize_message(pose_bytes, PoseStamped) == pose
        assert deserialize_message(twist_bytes, TwistStamped) == twist


@pytest.mark.ros
@pytest.mark.parametrize("text", ["", "a", '{"rate": 100.0}', "Trägheit", "刚体" * 100])
def test_strings_equal_rclpy_serialisation(text: str) -> None:
    from rclpy.serialization import serialize_message
    from std_msgs.msg import String

    assert encode_string(text) == serialize_message(String(data=text))
