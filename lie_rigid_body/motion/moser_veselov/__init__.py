"""The discrete Moser–Veselov steppers ``dmv2`` to ``dmv20``, which keep energy and spatial momentum at any step length.

``dmv20`` is the exact step in Moser–Veselov form: the literature's series end at order 10 (Hairer and Vilmart 2006),
and here they are continued until round-off. The momentum step is Jacobi's addition theorem; no equation of Moser and
Veselov is solved in a step.

Modules:

- `principal_frame`: the frame and units of a motion;
- `preprocessing`: the preprocessed inertia, as power series in the step;
- `records`: the numbers that the kernels share;
- `step`, `loop`: the kernels: one step, and many with projections onto the invariants;
- `integrator`: the constants of a motion, and one body's motion.
"""

from lie_rigid_body.motion.moser_veselov.integrator import MAX_TURN, MoserVeselovIntegrator

__all__ = ["MAX_TURN", "MoserVeselovIntegrator"]
