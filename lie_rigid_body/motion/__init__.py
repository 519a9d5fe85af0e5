"""How a state moves in time: the moving chart and its steppers, and the closed form that referees them."""

from lie_rigid_body.motion.closed_form import ClosedForm
from lie_rigid_body.motion.motion import Motion
from lie_rigid_body.motion.moving_chart import METHODS, Method, MovingChart

__all__ = ["METHODS", "ClosedForm", "Method", "Motion", "MovingChart"]
