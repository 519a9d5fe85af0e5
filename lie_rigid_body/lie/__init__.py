"""Lie groups as arrays: SO(3) on rotation vectors, unit quaternions and matrices."""

from lie_rigid_body.lie import quaternion, so3

__all__ = ["quaternion", "so3"]
