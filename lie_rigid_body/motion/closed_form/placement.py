"""The rotation W that makes a motion begin at its attitude: for one motion in floats, for many in arrays."""

from __future__ import annotations

import math
from typing import NamedTuple

from lie_rigid_body.arithmetic.numbers import Number, Quadruple, Triple, each, sqrt
from lie_rigid_body.motion.closed_form.wave import Wave


class Start(NamedTuple):
    """Where on its way a motion begins.

    Attributes
    ----------
    wave : Wave
    phase : number
        The phase of the wave.
    direction : 3 numbers
        n, the unit momentum in the frame.
    across : 2 numbers
        n₁ and ±n₂, the sign that of the sense, in proportion.
    """

    wave: Wave
    phase: Number
    direction: Triple
    across: tuple[Number, Number]

    def libration(self) -> Number:
        """ψ times the sense; see `GeneralMotion`."""
        sine, cosine, drift = self.wave.begin(self.phase)
        x, y = self.across
        return each(math.atan2, sine * x - cosine * y, cosine * x + sine * y) + drift


def world(start: Start, frame: Quadruple, attitude: Quadruple, sense: Number) -> Quadruple:
    """W of a `GeneralMotion`.

    Parameters
    ----------
    start : Start
    frame : 4 numbers
        conj(F).
    attitude : 4 numbers
        At the start.
    sense : number
    """
    half_turn = 0.5 * sense * start.libration()
    untilted = _turn_and_untilt(each(math.sin, half_turn), each(math.cos, half_turn), *start.direction)
    x, y, z, w = multiply(untilted, frame)
    size = sqrt(x * x + y * y + z * z + w * w)
    return multiply(attitude, (-x / size, -y / size, -z / size, w / size))


def _turn_and_untilt(s: Number, c: Number, n1: Number, n2: Number, n3: Number) -> Quadruple:
    """exp(ψ e₃) ⊗ conj(b(n)) from the sine and cosine of ψ/2; see `general_motion`."""
    scale = 1.0 / sqrt(2.0 + 2.0 * n3)
    upright = (1.0 + n3) * scale
    return (c * n2 + s * n1) * scale, (s * n2 - c * n1) * scale, s * upright, c * upright


def multiply(p: Quadruple, q: Quadruple) -> Quadruple:
    """The product p⊗q."""
    px, py, pz, pw = p
    qx, qy, qz, qw = q
    return (
        pw * qx + px * qw + py * qz - pz * qy,
        pw * qy - px * qz + py * qw + pz * qx,
        pw * qz + px * qy - py * qx + pz * qw,
        pw * qw - px * qx - py * qy - pz * qz,
    )
