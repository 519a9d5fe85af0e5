"""The discrete Moser–Veselov stepper: one step keeps the energy and the spatial momentum, whatever its length."""

from lie_rigid_body.motion.moser_veselov.integrator import LARGEST_TURN, moser_veselov_integrators

__all__ = ["LARGEST_TURN", "moser_veselov_integrators"]
