"""Motions of a free rigid body: the moving chart with its steppers, the closed form, and what does not need a time."""

from lie_rigid_body.motion.closed_form import ClosedForm
from lie_rigid_body.motion.description import Description, describe
from lie_rigid_body.motion.motion import Motion
from lie_rigid_body.motion.moving_chart import METHODS, Method, MovingChart

__all__ = ["METHODS", "ClosedForm", "Description", "Method", "Motion", "MovingChart", "describe"]
