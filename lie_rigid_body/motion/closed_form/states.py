"""The states of the four kinds of motion: the row of numbers that each is given by, and its kernel.

- circular: m ≤ ½, elliptic functions by theta functions of real argument;
- hyperbolic: m > ½, by theta functions of imaginary argument;
- separatrix: m = 1, the same with a nome of 0 and a phase that never returns;
- steady: rotation about a fixed axis, and rest.

A row is a NamedTuple of constants with its nesting taken away, and `general_constants` and `steady_constants` give the
nesting back: the places are those of the fields in their order. The formulas take floats, arrays or compiled numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, Final, NamedTuple

from lie_rigid_body.arithmetic.double_double import (
    ZERO,
    DoubleDouble,
    fast_two_sum,
    from_integer,
    remainder,
    two_sum,
)
from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.arithmetic.numbers import Number, pair, quadruple, sqrt, triple
from lie_rigid_body.compilation import Work, kernel
from lie_rigid_body.motion.closed_form.attitude import (
    AttitudeConstants,
    BodyMotion,
    GeneralMotion,
    Sample,
    SteadyMotion,
    attitude_constants,
    sample,
)
from lie_rigid_body.motion.closed_form.clock import PhaseClock, endless_phase, folded_phase, turns, turns_from_zero
from lie_rigid_body.motion.closed_form.jacobi import (
    QUOTIENTS_LENGTH,
    ImaginaryTheta,
    RealTheta,
    ThetaQuotients,
    half_period_later,
    imaginary_values,
    real_values,
    theta_quotients,
)

_HALF_IN_TURNS: Final = 0.25 / math.pi
"""Half a radian, in turns."""


class GeneralConstants(NamedTuple):
    """The numbers of a `GeneralMotion` that its samples take.

    Attributes
    ----------
    rate, start : DoubleDouble
        Rate and start of the phase, turns/ns and turns; on the separatrix in the unit of the phase.
    half_turn_rate : DoubleDouble
        Rate of ψ/2, turns/ns.
    period : DoubleDouble
        Period of a hyperbolic motion, in the unit of the phase; else 0.
    drift : number
        Turns of half of ψ per unit of the phase of a hyperbolic motion; else 0.
    theta : ThetaQuotients
    attitude : AttitudeConstants
    """

    rate: DoubleDouble
    start: DoubleDouble
    half_turn_rate: DoubleDouble
    period: DoubleDouble
    drift: Number
    theta: ThetaQuotients
    attitude: AttitudeConstants

    @classmethod
    def of(cls, motion: GeneralMotion) -> GeneralConstants:
        """The constants of one motion, or of many."""
        clock, theta = motion.phase_clock, motion.theta
        period: DoubleDouble = ZERO
        drift: Number = 0.0
        if isinstance(theta, ImaginaryTheta) and isinstance(clock, PhaseClock):
            period, drift = clock.period, motion.sense * theta.drift * _HALF_IN_TURNS
        attitude = AttitudeConstants.of(motion)
        return cls(clock.rate, clock.start, motion.half_turn_rate, period, drift, theta.quotients, attitude)


_RATE, _START, _HALF_TURN_RATE, _PERIOD, _DRIFT = 0, 2, 4, 6, 8
_THETA = _DRIFT + 1
_ATTITUDE = _THETA + QUOTIENTS_LENGTH


@kernel
def general_constants(row: Sequence[Number]) -> GeneralConstants:
    """The constants from their row."""
    return GeneralConstants(
        pair(row, _RATE),
        pair(row, _START),
        pair(row, _HALF_TURN_RATE),
        pair(row, _PERIOD),
        row[_DRIFT],
        theta_quotients(row, _THETA),
        attitude_constants(row, _ATTITUDE),
    )


@kernel
def steady_constants(row: Sequence[Number]) -> SteadyMotion:
    """The constants from their row."""
    return SteadyMotion(pair(row, 0), quadruple(row, 2), quadruple(row, 6), triple(row, 10))


def flattened(constants: Any) -> list[Number]:
    """The numbers of nested tuples in a row."""
    parts = (flattened(part) if isinstance(part, tuple) else [part] for part in constants)
    return list(chain.from_iterable(parts))


@kernel
def circular_sample(constants: GeneralConstants, time: DoubleDouble) -> Sample:
    """The state of a circular motion at a time in ns."""
    s, c = sine_cosine(turns(constants.rate, constants.start, time))
    half_turn = turns_from_zero(constants.half_turn_rate, time)
    return sample(constants.attitude, real_values(constants.theta, s, c), half_turn)


@kernel
def hyperbolic_sample(constants: GeneralConstants, time: DoubleDouble) -> Sample:
    """The state of a hyperbolic motion at a time in ns."""
    # the theta functions serve for half a period, |χ| ≤ X; half a period later sn and cn have changed their signs
    phase, parity = folded_phase(turns(constants.rate, constants.start, time), constants.period)
    values = half_period_later(imaginary_values(constants.theta, phase), parity)
    # ½ψ = its mean growth + ½ χ·drift + what the values give
    half_turn = turns_from_zero(constants.half_turn_rate, time)
    growth = two_sum(half_turn[0], constants.drift * phase[0])
    half_turn = remainder(fast_two_sum(growth[0], growth[1] + half_turn[1]))
    return sample(constants.attitude, values, half_turn)


@kernel
def separatrix_sample(constants: GeneralConstants, time: DoubleDouble) -> Sample:
    """The state of a motion on the separatrix at a time in ns."""
    values = imaginary_values(constants.theta, endless_phase(constants.rate, constants.start, time))
    return sample(constants.attitude, values, turns_from_zero(constants.half_turn_rate, time))


@kernel
def steady_sample(constants: SteadyMotion, time: DoubleDouble) -> Sample:
    """The state of a steady motion at a time in ns: q₀ ⊗ (axis · sin ½ωt + cos ½ωt)."""
    s, c = sine_cosine(turns_from_zero(constants.half_turn_rate, time))
    p, q, (u, v, w) = constants.attitude, constants.across, constants.body_rate
    x, y, z, r = p[0] * c + q[0] * s, p[1] * c + q[1] * s, p[2] * c + q[2] * s, p[3] * c + q[3] * s
    size = 1.0 / sqrt((x * x + y * y) + (z * z + r * r))
    return x * size, y * size, z * size, r * size, u, v, w


_COLUMNS: Final = 7
"""Number of doubles in a sample: attitude x y z w and body rate."""
_BLOCK: Final = 256
"""Samples whose columns stay in a processor's nearest cache."""

WORK_AREA: Final = _COLUMNS * _BLOCK
"""Length of the work array of the functions that fill in states."""

SIGNATURE: Final = "void(float64[:,:], int64[::1], int64[::1], float64[:,:,::1], float64[:,:,::1], float64[::1], int64)"
"""Types of the arguments of the functions that fill in an ensemble's states.

table : ndarray, shape (constants, B)
    Rows of motions of one kind, side by side.
members : ndarray of int64, shape (B,)
    Their places in the ensemble.
t_ns : ndarray of int64, shape (N,)
attitude_xyzw, body_rate : ndarray, shapes (bodies, T, 4) and (bodies, T, 3)
    Where the states go.
columns : ndarray, shape (WORK_AREA,)
    To work in: samples first go into columns, one after the other in one array. A compiler sees then that they do not
    overlap and has the processor compute several samples at a time.
first : int
    Place of the first of these times among T.
"""


@kernel
def put(columns: Any, i: int, sample: Sample) -> None:
    """Put a sample into place i of each column."""
    for k in range(_COLUMNS):
        columns[k * _BLOCK + i] = sample[k]


@kernel
def store(columns: Any, count: int, attitude: Any, rate: Any, first: int) -> None:
    """Store so many samples among the states of one body."""
    for i in range(count):
        for k in range(4):
            attitude[first + i, k] = columns[k * _BLOCK + i]
        for k in range(3):
            rate[first + i, k] = columns[(4 + k) * _BLOCK + i]


@kernel
def fill(
    constants_of: Any,
    sample_at: Any,
    table: Any,
    members: Any,
    t_ns: Any,
    attitude: Any,
    rate: Any,
    columns: Any,
    first: int,
) -> None:
    """Fill in the states of motions of the kind that these two functions belong to; see `SIGNATURE`."""
    for b in range(len(members)):
        constants = constants_of(table[:, b])
        for begin in range(0, len(t_ns), _BLOCK):
            times = t_ns[begin : begin + _BLOCK]
            for i in range(len(times)):
                put(columns, i, sample_at(constants, from_integer(times[i])))
            store(columns, len(times), attitude[members[b]], rate[members[b]], first + begin)


def fill_circular(table: Any, members: Any, t_ns: Any, attitude: Any, rate: Any, columns: Any, first: int) -> None:
    """Fill in the states of circular motions; see `SIGNATURE`."""
    fill(general_constants, circular_sample, table, members, t_ns, attitude, rate, columns, first)


def fill_hyperbolic(table: Any, members: Any, t_ns: Any, attitude: Any, rate: Any, columns: Any, first: int) -> None:
    """Fill in the states of hyperbolic motions; see `SIGNATURE`."""
    fill(general_constants, hyperbolic_sample, table, members, t_ns, attitude, rate, columns, first)


def fill_separatrix(table: Any, members: Any, t_ns: Any, attitude: Any, rate: Any, columns: Any, first: int) -> None:
    """Fill in the states of motions on the separatrix; see `SIGNATURE`."""
    fill(general_constants, separatrix_sample, table, members, t_ns, attitude, rate, columns, first)


def fill_steady(table: Any, members: Any, t_ns: Any, attitude: Any, rate: Any, columns: Any, first: int) -> None:
    """Fill in the states of steady motions; see `SIGNATURE`."""
    fill(steady_constants, steady_sample, table, members, t_ns, attitude, rate, columns, first)


SAMPLES_FOR_COMPILING: Final = 5_000_000
"""Number of samples in long calls from which on compiling pays. Arrays take a second for so many. Numba loads in half a
second and compiles, once, in two."""

SAMPLES_FOR_LOADING: Final = 2_500_000
"""Number of samples from which on loading compiled code from the cache pays."""


@dataclass(frozen=True)
class KindOfMotion:
    """How the states of one kind of motion are computed.

    Attributes
    ----------
    name : str
        Name of the constant of this module that holds the kind.
    constants : callable
        The constants from a row.
    sample : callable
        The state from the constants and a time in ns.
    work : Work
        The function that fills in many states, compiled when it pays.
    """

    name: str
    constants: Callable[[Sequence[Number]], Any]
    sample: Callable[[Any, DoubleDouble], Sample]
    work: Work

    def __reduce__(self) -> str:
        """Name of the constant: copies share what is compiled, and another process has its own."""
        return self.name


MOTION_KINDS: Final = tuple(
    KindOfMotion(name, constants, sample_at, Work(fill_in, SIGNATURE, SAMPLES_FOR_COMPILING, SAMPLES_FOR_LOADING))
    for name, constants, sample_at, fill_in in (
        ("CIRCULAR", general_constants, circular_sample, fill_circular),
        ("HYPERBOLIC", general_constants, hyperbolic_sample, fill_hyperbolic),
        ("SEPARATRIX", general_constants, separatrix_sample, fill_separatrix),
        ("STEADY", steady_constants, steady_sample, fill_steady),
    )
)
CIRCULAR, HYPERBOLIC, SEPARATRIX, STEADY = MOTION_KINDS


def kind_and_row(motion: BodyMotion) -> tuple[KindOfMotion, list[Number]]:
    """The kind of a motion, and its constants in a row: of many motions, if its numbers are arrays."""
    if isinstance(motion, SteadyMotion):
        return STEADY, flattened(motion)
    row = flattened(GeneralConstants.of(motion))
    if isinstance(motion.theta, RealTheta):
        return CIRCULAR, row
    return (HYPERBOLIC if isinstance(motion.phase_clock, PhaseClock) else SEPARATRIX), row
