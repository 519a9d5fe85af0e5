"""CDR, the byte form of ROS 2 messages: written for samples, read for whole tracks, without ROS.

A payload is 4 bytes of encapsulation (0, the byte order, two options) and a body in which a number of n bytes begins at
a multiple of n. Padding is written as zeros; rclpy leaves there what the memory held before.

A table of contents

- `layout`: what all messages share, and the bytes of those of one type;
- `encoding`, `sensor_encoding`: the messages of the truth and of the sensors;
- `decoding`: tracks of the truth, of either byte order, from any writer.
"""

from lie_rigid_body.messages.decoding import Decoded, decode, decode_string
from lie_rigid_body.messages.encoding import MessageEncoder, encode_string
from lie_rigid_body.messages.layout import POSE_NUMBERS, TWIST_NUMBERS
from lie_rigid_body.messages.sensor_encoding import ImuEncoder, MagneticFieldEncoder

__all__ = [
    "POSE_NUMBERS",
    "TWIST_NUMBERS",
    "Decoded",
    "ImuEncoder",
    "MagneticFieldEncoder",
    "MessageEncoder",
    "decode",
    "decode_string",
    "encode_string",
]
