"""The closed form of torque-free motion: Jacobi's solution in theta functions, exact at every time.

docs/closed_form.md derives it. In the order of a computation:

- `decimal_frames`, `elliptic_integrals`, `decimal_constants`: its principal frame and constants in decimals;
- `fast_frames`, `landen`, `fast_constants`: the same in double-double, of most motions and of many at once;
- `clock`: phases at any time of 64-bit nanoseconds;
- `jacobi`: sn, cn, dn and the libration of the precession, by theta functions;
- `attitude`: what a motion is given by, and attitude and body rate from phases;
- `states`: the row of constants and the formula of each kind of motion;
- `solution`: many states of one kind, in floats, on arrays or compiled, motions of all kinds, and the class.
"""

from lie_rigid_body.motion.closed_form.solution import ClosedForm

__all__ = ["ClosedForm"]
