"""The messages of the sensors, as REP-145 wants them filled in."""

from __future__ import annotations

from typing import Final

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.messages.layout import Layout

_VECTOR: Final = [0.0, 0.0, 0.0]
_NO_ORIENTATION: Final = [0.0, 0.0, 0.0, 1.0, -1.0, *[0.0] * 8]
"""The identity, and a covariance that begins with −1: "not given"."""


def _diagonal(variance: float) -> list[float]:
    return [variance if i % 4 == 0 else 0.0 for i in range(9)]


class ImuEncoder:
    """Readings as sensor_msgs/Imu without an orientation; a true bias too is told by such a message.

    Parameters
    ----------
    frame : str
        The sensor's frame.
    angular_velocity_variance : float
        On each axis, (rad/s)²; 0: unknown.
    linear_acceleration_variance : float
        On each axis, (m/s²)²; 0: unknown.
    """

    def __init__(
        self, frame: str, angular_velocity_variance: float = 0.0, linear_acceleration_variance: float = 0.0
    ) -> None:
        velocity, acceleration = _diagonal(angular_velocity_variance), _diagonal(linear_acceleration_variance)
        numbers = [*_NO_ORIENTATION, *_VECTOR, *velocity, *_VECTOR, *acceleration]
        self._layout = Layout(frame, numbers, [(13, 3), (25, 3)])

    def encode(self, stamps_ns: Integers, angular_velocity: Array, linear_acceleration: Array) -> list[bytes]:
        """One sensor_msgs/Imu a sample.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        angular_velocity : ndarray, shape (N, 3)
            rad/s.
        linear_acceleration : ndarray, shape (N, 3)
            m/s².

        Returns
        -------
        list of bytes
        """
        return self._layout.encode(stamps_ns, angular_velocity, linear_acceleration)


class MagneticFieldEncoder:
    """Readings as sensor_msgs/MagneticField.

    Parameters
    ----------
    frame : str
        The sensor's frame.
    variance : float
        On each axis, T²; 0: unknown.
    """

    def __init__(self, frame: str, variance: float = 0.0) -> None:
        self._layout = Layout(frame, [*_VECTOR, *_diagonal(variance)], [(0, 3)])

    def encode(self, stamps_ns: Integers, magnetic_field: Array) -> list[bytes]:
        """One sensor_msgs/MagneticField a sample.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        magnetic_field : ndarray, shape (N, 3)
            T.

        Returns
        -------
        list of bytes
        """
        return self._layout.encode(stamps_ns, magnetic_field)
