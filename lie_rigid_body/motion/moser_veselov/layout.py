"""Places of the numbers in the two vectors of floats that the integrator fills and the kernels read.

Compiled code takes plain vectors, so their places are named here, once for the writer and all readers. Every number is
a double-double: hi at its place, lo at the next one. Units are those of `ScaledMotion`, axes those of its frame.
"""

from __future__ import annotations

from typing import Any, Final, TypeAlias

from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.compilation import kernel

Three: TypeAlias = tuple[DoubleDouble, DoubleDouble, DoubleDouble]
Four: TypeAlias = tuple[DoubleDouble, DoubleDouble, DoubleDouble, DoubleDouble]
Seven: TypeAlias = tuple[
    DoubleDouble, DoubleDouble, DoubleDouble, DoubleDouble, DoubleDouble, DoubleDouble, DoubleDouble
]

# The state of a motion, which the steps change.

MOMENTUM: Final = 0
"""n₁, n₂, n₃: the body momentum."""

ATTITUDE: Final = MOMENTUM + 6
"""x, y, z, w: the quaternion that takes vectors of the frame to the world's."""

SINCE_RESTORATION: Final = ATTITUDE + 8
"""One float: the steps since the last projection onto the invariants, long ones counted as more than one."""

STEP_LENGTH: Final = SINCE_RESTORATION + 1
"""x: the length of the latest step, −1 before the first. A step as long as the one before needs no new constants."""

MOMENTUM_STEP: Final = STEP_LENGTH + 2
"""χ − 1, χδ − 1, δ − 1; Sδ(e₃ − e₂), S(e₁ − e₃), Sχ(e₂ − e₁); S²(e₃ − e₂)(e₂ − e₁); see `step`."""

ROTATION_STEP: Final = MOMENTUM_STEP + 14
"""½d₁, ½d₂, ½d₃: half the preprocessed inertia; see `step`."""

STATE_SIZE: Final = ROTATION_STEP + 6

# The constants of a motion.

SCALED_NANOSECOND: Final = 0
"""One nanosecond in the motion's unit of time."""

INVERSE_MOMENTS: Final = SCALED_NANOSECOND + 2
"""e₁, e₂, e₃."""

P: Final = INVERSE_MOMENTS + 6
Q: Final = P + 2
"""P = (e₂ − e₃)(e₁ − 2H) and Q = (e₁ − e₂)(2H − e₃)."""

M1: Final = Q + 2
M3: Final = M1 + 2
"""n₁² and n₃² where n₂ = 0."""

ENERGY: Final = M3 + 2
"""2H − e₂."""

SPATIAL_MOMENTUM: Final = ENERGY + 2
"""The momentum in the world, three numbers."""

RATES: Final = SPATIAL_MOMENTUM + 6
"""The body rates of n₁, n₂, n₃ = 1, rad/s."""

DIFFERENCES: Final = RATES + 6
"""e₁ − e₂, e₁ − e₃, e₂ − e₃."""

ALPHA: Final = DIFFERENCES + 6
BETA: Final = ALPHA + 2
SERIES_STRIDE: Final = 4
"""The first coefficients of α and β; the later ones follow by turns, at least two of each, to the end of the vector."""


@kernel
def three(values: Any, place: int) -> Three:
    """The three double-doubles stored from index ``place``."""
    return (
        (values[place], values[place + 1]),
        (values[place + 2], values[place + 3]),
        (values[place + 4], values[place + 5]),
    )


@kernel
def four(values: Any, place: int) -> Four:
    """The four double-doubles stored from index ``place``."""
    return (
        (values[place], values[place + 1]),
        (values[place + 2], values[place + 3]),
        (values[place + 4], values[place + 5]),
        (values[place + 6], values[place + 7]),
    )


@kernel
def seven(values: Any, place: int) -> Seven:
    """The seven double-doubles stored from index ``place``."""
    return (*three(values, place), *four(values, place + 6))


@kernel
def store(values: Any, place: int, numbers: Any) -> None:
    """Store double-doubles from index ``place``."""
    for j in range(len(numbers)):
        values[place + 2 * j], values[place + 2 * j + 1] = numbers[j]
