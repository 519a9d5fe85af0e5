"""The closed form of torque-free motion: Jacobi's solution in theta functions, exact at every time.

docs/closed_form.md derives it. In the order of a computation:

- `frame`, `elliptic_integrals`, `constants`: its principal frame and constants in decimals;
- `clock`: phases at any time of 64-bit nanoseconds;
- `jacobi`: sn, cn, dn and the periodic part of the precession, by theta functions;
- `attitude`: attitude and body rate from phases;
- `states`: the formula of each kind of motion;
- `solution`: the class.
"""

from lie_rigid_body.motion.closed_form.solution import ClosedForm

__all__ = ["ClosedForm"]
