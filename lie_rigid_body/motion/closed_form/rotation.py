"""The rotation of a free motion in decimals, by the formulas of the samples, to 20 digits and more.

A motion that goes on from where another one ended begins with this rotation, so that round-off does not grow from one
to the next. The theta functions are those of `jacobi`, whose polynomials are exact to 2e-22.
"""

from __future__ import annotations

from decimal import Decimal
from typing import Any, Final, TypeAlias

from lie_rigid_body.arithmetic.decimals import NANOSECOND, PI, Tensor, dot, sine_cosine_of_turns, working_precision
from lie_rigid_body.lie.quaternion import product
from lie_rigid_body.motion.closed_form.attitude import Three, untilted
from lie_rigid_body.motion.closed_form.constants import (
    Arithmetic,
    Constants,
    Periods,
    Polhode,
    constants_of,
    theta_functions,
    unit_momentum,
)
from lie_rigid_body.motion.closed_form.frame import digits_for, is_steady
from lie_rigid_body.motion.closed_form.jacobi import EllipticValues

Rotation: TypeAlias = tuple[Decimal, ...]
"""A unit quaternion x y z w."""

DIGITS: Final = 28
"""Decimal digits of what is not multiplied by a time."""
DECIMALS: Final = Arithmetic(
    Decimal, PI, Decimal.exp, lambda x: x.exp() - 1, lambda x: sine_cosine_of_turns(x / (2 * PI))[0]
)
"""Decimals in the precision in force."""


def rotation_of(inertia: Tensor, body_rate: Three, t_ns: int) -> Rotation:
    """The rotation from time 0 to another one: A(t) = A(0) ⊗ R(t), on the path that begins at 1.

    Parameters
    ----------
    inertia : 3 rows of 3
        kg m², body frame.
    body_rate : 3 floats
        At time 0, rad/s, body frame.
    t_ns : int
        ns

    Returns
    -------
    tuple of 4 Decimal
        x y z w, in the axes of the body at time 0.
    """
    with working_precision(digits_for(inertia)):
        seconds = t_ns * NANOSECOND
        if is_steady(inertia, body_rate):
            rate = [Decimal(component) for component in body_rate]
            speed = dot(rate, rate).sqrt()
            sine, cosine = sine_cosine_of_turns(_remainder(speed * seconds / (4 * PI)))
            return (*(component / (speed or 1) * sine for component in rate), cosine)
        constants = constants_of(inertia, body_rate)
        with working_precision(DIGITS):
            theta = theta_functions(*constants[1:3], DECIMALS)
        (x, y, z, w), last = (_untilted(constants, theta, time) for time in (Decimal(0), seconds))
        with working_precision(DIGITS):
            *turned, w = product((-x, -y, -z, w), last)
            size = dot((*turned, w), (*turned, w)).sqrt()
            return (*(dot(row, turned) / size for row in zip(*constants[0].axes, strict=True)), w / size)


def _remainder(turns: Decimal) -> Decimal:
    return turns - turns.to_integral_value()


def _untilted(constants: Constants, theta: Any, seconds: Decimal) -> tuple[Decimal, Decimal, Decimal, Decimal]:
    """The rotation between the frames of the momentum and of the axes at a time, times a factor."""
    frame, polhode, periods, mean_rate = constants
    u = polhode.argument_rate * seconds + polhode.start
    halves = (u / (2 * periods.real)).to_integral_value()  # 0 on the separatrix, where the period is infinite
    argument = u - 2 * periods.real * halves if halves else u
    half_turn = _remainder(mean_rate * seconds / (4 * PI))
    with working_precision(DIGITS):
        values, own = _values(theta, polhode, periods, argument)
        parity: Any = 1 - 4 * abs(_remainder(halves / 2))
        n1, n2, n3 = unit_momentum(frame, polhode, polhode.amplitudes)
        sine_cosine = sine_cosine_of_turns(_remainder(half_turn + frame.sense * own))
        directions = n1, frame.sense * n2, n3
        return untilted(frame.sense, (n1, n2), directions, values.half_period_later(parity), *sine_cosine)


def _values(theta: Any, polhode: Polhode, periods: Periods, argument: Decimal) -> tuple[EllipticValues, Decimal]:
    """The elliptic functions of an argument within half a period, and what they leave of ½ψ, in turns."""
    if polhode.is_far:
        return theta.values(*sine_cosine_of_turns(argument / (4 * periods.real))), Decimal(0)
    phase = PI * argument / (2 * periods.imaginary)
    return theta.values((phase, 0)), theta.drift * phase / (4 * PI)
