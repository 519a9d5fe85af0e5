"""Attitude and body rate of a motion that is not steady, from its phases.

With n = (N₁ cn u, ±N₂ sn u, N₃ dn u) the unit momentum in the `PrincipalFrame`, the attitude is

    W ⊗ exp(ψ e₃) ⊗ conj(b(n)) ⊗ conj(F).

F takes the frame to the body. b(n), proportional to (−n₂, n₁, 0, 1 + n₃), is the shortest rotation from e₃ to n, smooth
because n₃ > 0. W is fixed by the start. ψ is the angle about the momentum, with ψ′ = (2H/l + ω₃)/(1 + n₃): the
precession angle of the third axis less the azimuth of n about that axis. So ψ = Ωt ± (Θ − φ) with its mean rate Ω, the
periodic part Θ of the precession and the azimuth φ of (N₁ cn u, N₂ sn u). Θ and φ lie in the same quadrant, so their
difference stays within a quarter turn of 0. Its sine and cosine are known but for a factor, S and C; those of its half
are as S to C + √(S² + C²), and no arctangent is needed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple, TypeAlias

from lie_rigid_body.arithmetic.double_double import DoubleDouble
from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.arithmetic.numbers import Number, guarded, magnitude, sqrt
from lie_rigid_body.lie.quaternion import product
from lie_rigid_body.motion.closed_form.jacobi import EllipticValues, PeriodicPrecession

Three: TypeAlias = tuple[float, float, float]
Four: TypeAlias = tuple[float, float, float, float]
Rows: TypeAlias = tuple[tuple[float, ...], ...]

Sample: TypeAlias = tuple[Number, Number, Number, Number, Number, Number, Number]
"""A state: attitude x y z w and body rate, rad/s."""

_NEGLIGIBLE: Final = 1e-307
"""Added to C to avoid 0/0 where it underflows: without effect on any result."""


class AttitudeConstants(NamedTuple):
    """The numbers of a motion that its samples take, besides clocks and elliptic functions.

    Attributes
    ----------
    sense : float
        ±1: that of the frame.
    transverse : 2 floats
        N₁ and N₂, in proportion.
    directions : 3 floats
        N₁, ±N₂, N₃.
    attitude : 4 rows of 4 floats
        The matrix of p ↦ W ⊗ p ⊗ conj(F).
    rates : 3 rows of 3 floats
        The frame's axes in the body frame times the amplitudes of the rate, rad/s.
    """

    sense: float
    transverse: tuple[float, float]
    directions: Three
    attitude: Rows
    rates: tuple[Three, Three, Three]

    def sample(self, values: EllipticValues, half_turn: DoubleDouble) -> Sample:
        """The state from the elliptic functions, and ½ψ in turns without ½(Θ − φ) or its part that the values give."""
        p, q, r, s = untilted(self.sense, self.transverse, self.directions, values, *sine_cosine(half_turn))
        x, y, z, w = ((a * p + b * q) + (c * r + d * s) for a, b, c, d in self.attitude)
        size = 1.0 / sqrt((x * x + y * y) + (z * z + w * w))
        # ω = Σ axis · amplitude · (cn, sn, dn)
        a, b, c = (row[0] * values.cn + row[1] * values.sn + row[2] * values.dn for row in self.rates)
        return x * size, y * size, z * size, w * size, a, b, c


def untilted(
    sense: Any, transverse: Sequence[Any], directions: Sequence[Any], values: EllipticValues, sine: Any, cosine: Any
) -> tuple[Any, Any, Any, Any]:
    """A quaternion proportional to exp(ψ e₃) ⊗ conj(b(n)), of numbers of any kind.

    Parameters
    ----------
    sense, transverse, directions
        As of `AttitudeConstants`.
    values : EllipticValues
    sine, cosine : number
        Those of ½ψ without ½(Θ − φ), or its part that the values give.
    """
    # S = sin(Θ − φ) and C = cos(Θ − φ) from those of Θ and of φ, each in proportion
    x = transverse[0] * values.cn
    y = transverse[1] * values.sn
    across = values.sine * x - values.cosine * y
    # positive, but its square may be too small for a double, or even itself
    along = guarded(values.cosine * x + values.sine * y, _NEGLIGIBLE)
    scale = 1 / (along + magnitude(across))
    across = across * scale
    along = along * scale
    # tan ½x = S/(C + √(S² + C²))
    own_sine = sense * across
    own_cosine = along + sqrt(along * along + across * across)
    # the sum of the two angles
    s = sine * own_cosine + cosine * own_sine
    c = cosine * own_cosine - sine * own_sine
    # n₁, n₂ and 1 + n₃
    n1 = directions[0] * values.cn
    n2 = directions[1] * values.sn
    upright = 1 + directions[2] * values.dn
    # proportional to (0, 0, s, c) ⊗ (n₂, −n₁, 0, 1 + n₃)
    return c * n2 + s * n1, s * n2 - c * n1, s * upright, c * upright


def attitude_map(world_xyzw: Four, frame_xyzw: Four) -> Rows:
    """The rows of the matrix of p ↦ W ⊗ p ⊗ conj(F), from W and conj(F)."""
    x, y, z, w = world_xyzw
    # W ⊗ i, W ⊗ j, W ⊗ k and W
    columns = ((w, z, -y, -x), (-z, w, x, -y), (y, -x, w, -z), world_xyzw)
    return tuple(zip(*(product(column, frame_xyzw) for column in columns), strict=True))


def world_rotation(
    precession: PeriodicPrecession,
    direction: Three,
    transverse: tuple[float, float],
    sense: float,
    frame_xyzw: Four,
    attitude_xyzw: Four,
) -> Four:
    """The rotation W for which the motion begins at an attitude.

    Parameters
    ----------
    precession : PeriodicPrecession
        Θ at the start.
    direction : 3 floats
        n at the start, the unit momentum in the frame.
    transverse : 2 floats
        n₁ and ±n₂, the sign that of the sense, in proportion: their azimuth is φ.
    sense : float
        ±1: that of the frame.
    frame_xyzw : 4 floats
        conj(F).
    attitude_xyzw : 4 floats
        At the start.
    """
    sine, cosine, drift = precession
    x, y = transverse
    # ψ = ±(Θ − φ), as its mean growth begins at 0
    half_turn = 0.5 * sense * (math.atan2(sine * x - cosine * y, cosine * x + sine * y) + drift)
    s = math.sin(half_turn)
    c = math.cos(half_turn)
    n1, n2, n3 = direction
    untilted = (c * n2 + s * n1, s * n2 - c * n1, s * (1.0 + n3), c * (1.0 + n3))
    x, y, z, w = product(untilted, frame_xyzw)
    size = math.sqrt(x * x + y * y + z * z + w * w)
    a, b, c, d = product(attitude_xyzw, (-x / size, -y / size, -z / size, w / size))
    return a, b, c, d
