"""What is true of the motion: the body, its inertia, its state and what they conserve."""

from lie_rigid_body.mechanics.rigid_body import RigidBody
from lie_rigid_body.mechanics.state import State

__all__ = ["RigidBody", "State"]
