"""The rotation of a free motion in decimals, by the formulas of the samples, to 20 digits and more.

A motion that goes on from where another one ended begins with this rotation, so that round-off does not grow from one
to the next. The theta functions are those of `jacobi`, whose polynomials are exact to 2e-22.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from typing import Any, Final, TypeAlias

from lie_rigid_body.arithmetic.decimals import NANOSECOND, PI, Tensor, dot, sine_cosine_of_turns, working_precision
from lie_rigid_body.lie.quaternion import product
from lie_rigid_body.motion.closed_form.attitude import Three, untilted
from lie_rigid_body.motion.closed_form.constants import Constants, Periods, Polhode, constants_of, unit_momentum
from lie_rigid_body.motion.closed_form.frame import digits_for, is_steady
from lie_rigid_body.motion.closed_form.jacobi import EllipticValues, ImaginaryTheta, RealTheta

Rotation: TypeAlias = tuple[Decimal, Decimal, Decimal, Decimal]
"""A unit quaternion x y z w."""

DIGITS: Final = 28
"""Decimal digits of what is not multiplied by a time."""


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
            x, y, z = (Decimal(component) for component in body_rate)
            speed = dot((x, y, z), (x, y, z)).sqrt()
            sine, cosine = sine_cosine_of_turns(_remainder(speed * seconds / (4 * PI)))
            a, b, c = (component / speed if speed else component for component in (x, y, z))
            return a * sine, b * sine, c * sine, cosine
        constants = constants_of(inertia, body_rate)
        phases = _phases(constants, Decimal(0)), _phases(constants, seconds)
        with working_precision(DIGITS):
            untilted_at = _untilting(constants)
            (x, y, z, w), last = (untilted_at(*each) for each in phases)
            x, y, z, w = product((-x, -y, -z, w), last)
            size = (x * x + y * y + z * z + w * w).sqrt()
            a, b, c = (dot(row, (x, y, z)) / size for row in zip(*constants[0].axes, strict=True))
            return a, b, c, w / size


def _remainder(turns: Decimal) -> Decimal:
    return turns - turns.to_integral_value()


def _phases(constants: Constants, seconds: Decimal) -> tuple[Decimal, Decimal]:
    """The argument of the elliptic functions within a period, in periods 4K or as it is on the separatrix, and ½ψ."""
    _, polhode, periods, mean_rate = constants
    u = polhode.argument_rate * seconds + polhode.start
    half_turn = _remainder(mean_rate * seconds / (4 * PI))
    return (_remainder(u / (4 * periods.real)) if polhode.m1 else u), half_turn


def _untilting(constants: Constants) -> Callable[[Decimal, Decimal], Rotation]:
    """A function of the phases: the rotation between the frames of the momentum and of the axes, times a factor."""
    frame, polhode, periods, _ = constants
    values_at = (_real if 2 * polhode.m1 >= 1 else _imaginary)(polhode, periods)
    n1, n2, n3 = unit_momentum(frame, polhode, polhode.amplitudes)

    def untilted_at(argument: Decimal, half_turn: Decimal) -> Rotation:
        values, own = values_at(argument)
        turns = _remainder(half_turn + frame.sense * own)
        return untilted(frame.sense, (n1, n2), (n1, frame.sense * n2, n3), values, *sine_cosine_of_turns(turns))

    return untilted_at


Functions: TypeAlias = Callable[[Decimal], tuple[EllipticValues, Decimal]]
"""The elliptic functions of an argument, and what they leave of ½ψ, in turns."""


def _real(_: Polhode, periods: Periods) -> Functions:
    """The functions for m ≤ ½; see `states.SmallModulus`."""
    decay, codecay = ((-PI * x / periods.real).exp() for x in (periods.pole, periods.copole))
    theta: Any = RealTheta
    functions = theta.of(decay * codecay, decay, codecay, 1 - decay)
    return lambda turns: (functions.values(*sine_cosine_of_turns(turns)), Decimal(0))


def _imaginary(polhode: Polhode, periods: Periods) -> Functions:
    """The functions for m > ½; see `states.LargeModulus` and `states.Separatrix`."""
    scale = PI / (2 * periods.imaginary)
    quarter = scale * periods.real
    sine, cosine = (sine_cosine_of_turns(x / (4 * periods.imaginary))[0] for x in (periods.pole, periods.copole))
    theta: Any = ImaginaryTheta
    functions = theta.of((-2 * quarter).exp(), quarter, sine, cosine, 0)
    if polhode.m1 == 0:
        return lambda u: (functions.values((scale * u, 0)), Decimal(0))

    def values_at(turns: Decimal) -> tuple[EllipticValues, Decimal]:
        half = (2 * turns).to_integral_value() / 2
        phase = 4 * quarter * (turns - half)
        values = functions.values((phase, 0)).half_period_later(1 - 4 * abs(half))
        return values, periods.pole / periods.real * phase / (4 * PI)

    return values_at
