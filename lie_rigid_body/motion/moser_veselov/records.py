"""The numbers of a motion that the kernels share; units are those of `DimensionlessMotion`, axes those of its frame."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.arithmetic.numbers import Number

Three: TypeAlias = tuple[DoubleDouble, DoubleDouble, DoubleDouble]
Four: TypeAlias = tuple[DoubleDouble, DoubleDouble, DoubleDouble, DoubleDouble]
Eight: TypeAlias = tuple[float, float, float, float, float, float, float, float]


class Step(NamedTuple):
    """The constants of all steps of one length.

    Attributes
    ----------
    length : DoubleDouble
        x, in the motion's unit of time; −1 where no step was taken yet.
    changes : 3 DoubleDouble
        χ − 1, χδ − 1, δ − 1.
    factors : 3 DoubleDouble
        Sδ(e₃ − e₂), S(e₁ − e₃), Sχ(e₂ − e₁).
    curvature : DoubleDouble
        S²(e₃ − e₂)(e₂ − e₁).
    half_inertia : 3 DoubleDouble
        ½d₁, ½d₂, ½d₃: half the preprocessed inertia.
    """

    length: DoubleDouble
    changes: Three
    factors: Three
    curvature: DoubleDouble
    half_inertia: Three


class StepperState(NamedTuple):
    """The state of a motion, which the steps change.

    Attributes
    ----------
    momentum : 3 DoubleDouble
        n₁, n₂, n₃: the body momentum.
    attitude : 4 DoubleDouble
        The quaternion, scalar last, that takes vectors of the frame to the world's.
    since_projection : float
        The steps since the last projection onto the invariants, long ones counted as more than one.
    step : Step
        The latest one. A step as long as the one before needs no new constants.
    """

    momentum: Three
    attitude: Four
    since_projection: Number
    step: Step


class PowerSeries(NamedTuple):
    """A power series in x²: its first two coefficients, and the eight after them, the last one first."""

    first: DoubleDouble
    second: DoubleDouble
    later: Eight


class StepperConstants(NamedTuple):
    """The constants of a motion.

    Attributes
    ----------
    nanosecond : DoubleDouble
        One nanosecond in the motion's unit of time.
    inverse_moments : 3 DoubleDouble
        e₁, e₂, e₃.
    differences : 3 DoubleDouble
        e₁ − e₂, e₁ − e₃, e₂ − e₃.
    p, q : DoubleDouble
        P = (e₂ − e₃)(e₁ − 2H) and Q = (e₁ − e₂)(2H − e₃).
    m1, m3 : DoubleDouble
        n₁² and n₃² where n₂ = 0.
    energy : DoubleDouble
        2H − e₂.
    world_momentum : 3 DoubleDouble
    rates : 3 DoubleDouble
        The body rates of n₁, n₂, n₃ = 1, rad/s.
    alpha, beta : PowerSeries
        α/x³ and β/x of the preprocessed inertia.
    """

    nanosecond: DoubleDouble
    inverse_moments: Three
    differences: Three
    p: DoubleDouble
    q: DoubleDouble
    m1: DoubleDouble
    m3: DoubleDouble
    energy: DoubleDouble
    world_momentum: Three
    rates: Three
    alpha: PowerSeries
    beta: PowerSeries
