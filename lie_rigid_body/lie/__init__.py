"""Rotations: SO(3) by rotation vectors, unit quaternions and matrices, on arrays with any leading axes."""

from lie_rigid_body.lie import quaternion, so3

__all__ = ["quaternion", "so3"]
