"""The discrete Moser–Veselov steppers ``dmv2`` to ``dmv20``, which keep energy and spatial momentum at any step length.

Modules:

- `principal_frame`: the frame and units of a motion;
- `preprocessing`: the preprocessed inertia, as power series in the step;
- `layout`: the places of numbers in the vectors that the kernels share;
- `step`, `loop`: the kernels: one step, and many with projections onto the invariants;
- `integrator`: the constants of a motion, and one body's motion.
"""

from lie_rigid_body.motion.moser_veselov.integrator import LARGEST_TURN, moser_veselov_integrators

__all__ = ["LARGEST_TURN", "moser_veselov_integrators"]
