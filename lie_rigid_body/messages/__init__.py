"""Messages as bytes, for publishers and bags alike: CDR, the byte form of ROS 2 messages, without ROS.

A payload is 4 bytes of encapsulation (0, the byte order, two options) and a body in which a number of n bytes begins at
a multiple of n. Padding is written as zeros; rclpy leaves there what the memory held before.

- `layout`: the fields that all messages share, and rows of bytes that differ in some words only;
- `batch`: samples as messages, and those of the truth and the sensors in the order of their stamps;
- `decoding`: messages of either byte order, from any writer, also those of two frames;
- `definitions`: type names and definitions of the messages, and their quality of service.
"""

from lie_rigid_body.messages.batch import (
    NOT_GIVEN,
    PoseTwistEncoder,
    ReadingEncoder,
    TransformEncoder,
    encode_string,
    encode_strings,
    numbers_of,
)
from lie_rigid_body.messages.decoding import Decoded, decode_places, decode_string
from lie_rigid_body.messages.layout import POSE_NUMBERS, TWIST_NUMBERS

__all__ = [
    "NOT_GIVEN",
    "POSE_NUMBERS",
    "TWIST_NUMBERS",
    "Decoded",
    "PoseTwistEncoder",
    "ReadingEncoder",
    "TransformEncoder",
    "decode_places",
    "decode_string",
    "encode_string",
    "encode_strings",
    "numbers_of",
]
