"""Motions of a free rigid body: the moving chart with its steppers, and the closed-form solution used as reference."""

from lie_rigid_body.motion.closed_form import ClosedForm
from lie_rigid_body.motion.motion import Motion
from lie_rigid_body.motion.moving_chart import METHODS, Method, MovingChart

__all__ = ["METHODS", "ClosedForm", "Method", "Motion", "MovingChart"]
