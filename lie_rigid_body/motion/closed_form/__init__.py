"""The closed form of torque-free motion: Jacobi's solution in theta functions, exact at every time.

A table of contents, in the order of a computation

- `precision`, `elliptic_integrals`: decimal arithmetic of many digits, for what is computed once per motion;
- `exact`, `principal_axes`, `principal_frame`: the body and its start, in the frame where the motion is simple;
- `polhode`, `periods`, `herpolhode`: the constants of the body rate's path in the body, and of the momentum's turn;
- `ordinary`, `ordinary_motions`: which motions need no decimals, and all of them together;
- `pairs`, `arctangent`, `landen`: double-double arithmetic for these, of one in floats or of many in arrays;
- `diagonal_frame`, `coupled_frame`, `ordinary_polhode`, `ordinary_motion`: their frames and constants;
- `double_double`, `clock`: phases of up to 1e19 ns reduced without loss, batched;
- `elementary`, `sine`, `exponential`, `theta`, `wave`, `circular_wave`, `hyperbolic_wave`: the elliptic functions;
- `placement`, `steady_motion`, `general_motion`: where a motion begins, and its constants;
- `course`, `circular_states`, `hyperbolic_states`, `separatrix_states`, `steady_states`: the formulas of the states;
- `columns`, `samples`, `evaluation`, `ensemble`, `memory`, `closed_form`: of many at once, block by block or compiled;
- `constants`, `description`: regime, period, precession and flips, for those who want to know them without the states.
"""

from lie_rigid_body.motion.closed_form.closed_form import ClosedForm

__all__ = ["ClosedForm"]
