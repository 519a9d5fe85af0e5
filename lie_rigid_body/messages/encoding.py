"""Samples as the bytes of ROS 2 messages: poses, twists, readings of sensors, transforms and texts."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.messages.layout import (
    ENCAPSULATION,
    POSE_NUMBERS,
    TWIST_NUMBERS,
    Layout,
    Payloads,
    numbers_after,
    text,
)
from lie_rigid_body.messages.template import Template
from lie_rigid_body.parameters import NS
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Samples

_VECTOR: Final = [0.0, 0.0, 0.0]
_IDENTITY: Final = [0.0, 0.0, 0.0, 1.0]
_NOT_GIVEN: Final = [-1.0, *[0.0] * 8]
"""Covariance of what is not given (REP-145)."""
_ONE_TRANSFORM: Final = struct.pack("<I", 1)
_TRANSLATION: Final = 3


class PoseTwistEncoder:
    """Samples of the truth as geometry_msgs/PoseStamped and TwistStamped or Twist.

    Parameters
    ----------
    scenario : Scenario
        Gives the frame names and whether twists are stamped.
    """

    def __init__(self, scenario: Scenario) -> None:
        twist_frame = scenario.body_frame if scenario.stamped_twist else None
        # position and linear velocity stay zero; the rotation's numbers follow them
        self._pose = Layout(scenario.world_frame, [0.0] * POSE_NUMBERS, [(3, 4)])
        self._twist = Layout(twist_frame, [0.0] * TWIST_NUMBERS, [(3, 3)])

    def poses(self, samples: Samples) -> Payloads:
        """One geometry_msgs/PoseStamped a sample, position 0."""
        return self._pose.encode(samples.stamps_ns, samples.states.attitude_xyzw)

    def twists(self, samples: Samples) -> Payloads:
        """One geometry_msgs/TwistStamped or Twist a sample, linear velocity 0."""
        return self._twist.encode(samples.stamps_ns, samples.states.body_rate)


class ImuEncoder:
    """Readings of an IMU, or its true bias, as sensor_msgs/Imu (REP-145).

    Parameters
    ----------
    frame : str
        The sensor's frame.
    angular_velocity_variance : float
        On each axis, (rad/s)²; 0: unknown.
    linear_acceleration_variance : float
        On each axis, (m/s²)²; 0: unknown.
    orientation_covariance : sequence of float, length 9
        Row by row, rad²; by default no orientation is given.
    """

    def __init__(
        self,
        frame: str,
        angular_velocity_variance: float = 0.0,
        linear_acceleration_variance: float = 0.0,
        orientation_covariance: Sequence[float] = _NOT_GIVEN,
    ) -> None:
        velocity, acceleration = _diagonal(angular_velocity_variance), _diagonal(linear_acceleration_variance)
        numbers = [*_IDENTITY, *orientation_covariance, *_VECTOR, *velocity, *_VECTOR, *acceleration]
        self._layout = Layout(frame, numbers, [(13, 3), (25, 3)])
        self._oriented = Layout(frame, numbers, [(13, 3), (25, 3), (0, 4)])

    def encode(
        self,
        stamps_ns: Integers,
        angular_velocity: Array,
        linear_acceleration: Array,
        orientation_xyzw: Array | None = None,
    ) -> Payloads:
        """One sensor_msgs/Imu a sample.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        angular_velocity : ndarray, shape (N, 3)
            rad/s.
        linear_acceleration : ndarray, shape (N, 3)
            m/s².
        orientation_xyzw : ndarray, shape (N, 4), optional
            The identity by default.

        Returns
        -------
        Payloads
        """
        if orientation_xyzw is None:
            return self._layout.encode(stamps_ns, angular_velocity, linear_acceleration)
        return self._oriented.encode(stamps_ns, angular_velocity, linear_acceleration, orientation_xyzw)


class MagneticFieldEncoder:
    """Readings of a magnetometer as sensor_msgs/MagneticField.

    Parameters
    ----------
    frame : str
        The sensor's frame.
    variance : float
        On each axis, T²; 0: unknown.
    """

    def __init__(self, frame: str, variance: float = 0.0) -> None:
        self._layout = Layout(frame, [*_VECTOR, *_diagonal(variance)], [(0, 3)])

    def encode(self, stamps_ns: Integers, magnetic_field: Array) -> Payloads:
        """One sensor_msgs/MagneticField a sample.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        magnetic_field : ndarray, shape (N, 3)
            T.

        Returns
        -------
        Payloads
        """
        return self._layout.encode(stamps_ns, magnetic_field)


class AttitudeEncoder:
    """Readings of an attitude sensor as geometry_msgs/PoseWithCovarianceStamped, position 0.

    Parameters
    ----------
    frame : str
        The world frame.
    """

    def __init__(self, frame: str) -> None:
        self._layout = Layout(frame, [0.0] * (POSE_NUMBERS + 36), [(3, 4), (POSE_NUMBERS, 36)])

    def encode(self, stamps_ns: Integers, attitude_xyzw: Array, covariance: Array) -> Payloads:
        """One message a reading.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        attitude_xyzw : ndarray, shape (N, 4)
        covariance : ndarray, shape (N, 3, 3)
            Of small rotations about the fixed axes of the frame, rad²; that of the position is 0.

        Returns
        -------
        Payloads
        """
        whole = np.zeros((len(stamps_ns), 6, 6))
        whole[:, 3:, 3:] = covariance
        return self._layout.encode(stamps_ns, attitude_xyzw, whole.reshape(-1, 36))


class VectorEncoder:
    """Vectors as geometry_msgs/Vector3Stamped.

    Parameters
    ----------
    frame : str
    """

    def __init__(self, frame: str) -> None:
        self._layout = Layout(frame, _VECTOR, [(0, 3)])

    def encode(self, stamps_ns: Integers, vectors: Array) -> Payloads:
        """One message a vector, shape (N, 3)."""
        return self._layout.encode(stamps_ns, vectors)


class TransformEncoder:
    """Attitudes as tf2_msgs/TFMessage, each with one transform and no translation.

    Parameters
    ----------
    frame, child_frame : str
        Frame names: an attitude takes components in ``child_frame`` to those in ``frame``.
    """

    def __init__(self, frame: str, child_frame: str) -> None:
        head = ENCAPSULATION + _ONE_TRANSFORM + bytes(8) + text(frame)
        head = head.ljust(-(-len(head) // 4) * 4, b"\x00") + text(child_frame)
        start = numbers_after(len(head))
        self._template = head.ljust(start + 8 * (_TRANSLATION + 4), b"\x00")
        self._fields = np.dtype(
            {
                "names": ["sec", "nanosec", "rotation"],
                "formats": ["<i4", "<u4", ("<f8", (4,))],
                "offsets": [8, 12, start + 8 * _TRANSLATION],
                "itemsize": len(self._template),
            }
        )

    def encode(self, stamps_ns: Integers, attitude_xyzw: Array) -> list[bytes]:
        """One message a sample.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        attitude_xyzw : ndarray, shape (N, 4)

        Returns
        -------
        list of bytes
        """
        buffer = bytearray(self._template * len(stamps_ns))
        rows = np.frombuffer(buffer, dtype=self._fields)
        rows["sec"], rows["nanosec"] = np.divmod(stamps_ns, NS)
        rows["rotation"] = attitude_xyzw
        size = len(self._template)
        return [bytes(buffer[i : i + size]) for i in range(0, len(buffer), size)]


def encode_string(value: str) -> bytes:
    """A text as std_msgs/String."""
    return ENCAPSULATION + text(value)


def encode_strings(values: Sequence[str], length: int) -> Payloads:
    """Texts as std_msgs/String, with blanks behind each, so that all have one length in characters of ASCII."""
    data = b"".join(encode_string(value.ljust(length)) for value in values)
    rows = np.frombuffer(data, dtype=np.uint8).reshape(len(values), -1)
    template = _text_template(rows.shape[1])
    return Payloads(template, template.words(rows))


@lru_cache(maxsize=8)
def _text_template(size: int) -> Template:
    """Words all along; the last one has bytes of the one before."""
    return Template(bytes(size), [(0, size // 8), (size - 8, 1)])


def _diagonal(variance: float) -> list[float]:
    """The covariance of three independent components, row by row."""
    return [variance if i % 4 == 0 else 0.0 for i in range(9)]
