"""The equations of motion enclosed step by step, by Taylor series with a proved remainder.

With J = M⁻¹ momentum p and attitude q (a quaternion, world from body) obey

    p' = p × Jp,        q' = ½ q ∘ Jp,

which keep abs(p) and abs(q). Let e be an upper bound of the largest eigenvalue of J, and δ of half the difference of
its extremes.

**Remainder.** Let pₙ and qₙ be the Taylor coefficients at a point with abs(p) ≤ P, abs(q) ≤ Q. Since x × y + y × x = 0,
J may be replaced by J − (e/2) 1 in (n+1) pₙ₊₁ = ½ Σ (pᵢ × Jpₙ₋ᵢ + pₙ₋ᵢ × Jpᵢ). The norm of J − (e/2) 1 is at most e/2,
as 0 < J ≤ e. So abs(pₙ) is at most the coefficient of y in y' = (e/2) y², y(0) = P, which has y = P/(1 − t/T) with T =
2/(eP). And abs(qₙ) is at most that of x in x' = (e/2) x y, x(0) = Q, which has x = Q/(1 − t/T). Both series therefore
converge for abs(t) < T, where they are the solution, which is unique. What N terms leave out at t = sT is at most P
sᴺ/(1 − s) and Q sᴺ/(1 − s). No step needs any other check.

**What grows.** A step starts at the exact midpoint (p̂, q̂) of the set that holds the state, so its balls are as thin
as round-off. The state itself is at most r away in p and at most ρ in q, and how far two solutions part is bounded by a
logarithmic norm. For Δ = p − p̂ and m = (p + p̂)/2, Δ' = m × JΔ + Δ × Jm exactly. So ½(Δ²)' = m·(JΔ × Δ) ≤ abs(m) δ Δ²,
as abs(JΔ × Δ) ≤ δ Δ² for a symmetric J. With (q − q̂)' = ½ (q − q̂) ∘ Jp + ½ q̂ ∘ JΔ, where the first term is
perpendicular to q − q̂, after a time h

    r → r exp(δ(P + r)h),        ρ → ρ + ½ e Q h r exp(δ(P + r)h),

to which the width of the step's own balls is added. δ is at most 0.6 e, so that the enclosure widens by less than
exp(0.6 ePt) in a time t, and by nothing but round-off for a nearly spherical body.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from flint import arb, arb_mat, ctx, fmpq

from lie_rigid_body.proof import Enclosure
from lie_rigid_body.proof.balls import Balls, added, at_most, exact, norm, scaled
from lie_rigid_body.proof.enclosure import WIDTH
from lie_rigid_body.proof.start import Start

_BITS_PER_TERM = 3
"""Bits that each term of a series adds: a term is at most s = 2⁻³ times the one before."""


@dataclass(frozen=True)
class _Equations:
    """J, with upper bounds of its largest eigenvalue e and of half the difference δ of its extreme ones."""

    inverse: arb_mat
    largest: arb
    half_spread: arb

    @classmethod
    def of(cls, start: Start) -> _Equations:
        """From the exact inverse of the inertia.

        Let t be the trace, and d the norm (Frobenius) of the deviator J − (t/3) 1. The largest eigenvalue is at most
        t/3 + √(2/3) d, and the difference of the extremes at most √2 d.
        """
        J = start.inertia.inv()
        third = (J[0, 0] + J[1, 1] + J[2, 2]) / 3
        squares = [(J[i, j] - (third if i == j else 0)) ** 2 for i in range(3) for j in range(3)]
        deviator = arb(sum(squares, fmpq(0))).sqrt()
        largest = (arb(third) + (arb(2) / 3).sqrt() * deviator).upper()
        return cls(arb_mat(J), largest, (deviator / arb(2).sqrt()).upper())

    def rate(self, momentum: Balls) -> Balls:
        """ω = Jp."""
        J = self.inverse
        return tuple(J[i, 0] * momentum[0] + J[i, 1] * momentum[1] + J[i, 2] * momentum[2] for i in range(3))


@dataclass(frozen=True)
class _Set:
    """All momenta within r of an exact p̂, and all quaternions within ρ of an exact q̂."""

    momentum: Balls
    attitude: Balls
    momentum_radius: arb
    attitude_radius: arb

    @classmethod
    def around(cls, momentum: Balls, attitude: Balls, momentum_radius: arb, attitude_radius: arb) -> _Set:
        """The set about the midpoints of balls, whose own radii are added."""
        return cls(
            tuple(x.mid() for x in momentum),
            tuple(x.mid() for x in attitude),
            (momentum_radius + norm(tuple(x.rad() for x in momentum))).upper(),
            (attitude_radius + norm(tuple(x.rad() for x in attitude))).upper(),
        )


def enclose_by_taylor(inertia, attitude_xyzw, body_rate, t_ns: int) -> Enclosure:
    """The true state at a time, with the arguments of `enclose`, as thin as its default.

    It takes some 30 ms for each radian of p t/I₁, with p the norm of the momentum and I₁ the smallest moment.
    """
    start, bits = Start.of(inertia, attitude_xyzw, body_rate), 128
    while True:
        with ctx.workprec(bits):
            found = Enclosure(*taylor_state(start, t_ns, bits), bits)
        if found.width <= WIDTH:
            return found
        bits *= 2


def taylor_state(start: Start, t_ns: int, bits: int) -> tuple[Balls, Balls]:
    """Attitude and body rate at a time, in balls.

    Parameters
    ----------
    start : Start
    t_ns : int
        Nanoseconds since the start.
    bits : int
        The present precision.

    Returns
    -------
    attitude_xyzw, rate : tuple of 4, tuple of 3 arb
        World from body, continuous from the start; rad/s in the body frame.
    """
    equations = _Equations.of(start)
    attitude = exact(start.attitude_xyzw)
    state = _Set.around(exact(start.momentum), scaled(1 / norm(attitude), attitude), arb(0), arb(0))
    turned = equations.largest * norm(state.momentum) * abs(t_ns) / 10**9
    # e P h / 2 is s, a little less than 2⁻³
    steps = max(1, math.ceil(at_most(turned) / 2 * 2**_BITS_PER_TERM * 1.001))
    h = arb(fmpq(t_ns, 10**9 * steps))
    for _ in range(steps):
        state = _step(equations, state, h, bits)
    momentum = tuple(x + arb(0, state.momentum_radius) for x in state.momentum)
    attitude = tuple(x + arb(0, state.attitude_radius) for x in state.attitude)
    return attitude, equations.rate(momentum)


def _step(equations: _Equations, state: _Set, h: arb, bits: int) -> _Set:
    """The set that a set becomes after a time h."""
    terms = bits // _BITS_PER_TERM + 2
    momentum, attitude = _series(equations, state, h, terms)
    P, Q, length = norm(state.momentum), norm(state.attitude), abs(h)
    s = equations.largest * P * length / 2
    if not s < 1:
        raise ArithmeticError("a step is longer than the radius of convergence that is proved")
    left_out = (s**terms / (1 - s)).upper()
    momentum = tuple(x + arb(0, (P * left_out).upper()) for x in momentum)
    attitude = tuple(x + arb(0, (Q * left_out).upper()) for x in attitude)
    r = state.momentum_radius
    grown = r * (equations.half_spread * (P + r) * length).exp()
    carried = state.attitude_radius + equations.largest * Q * length * grown / 2
    return _Set.around(momentum, attitude, grown.upper(), carried.upper())


def _series(equations: _Equations, state: _Set, h: arb, terms: int) -> tuple[Balls, Balls]:
    """The Taylor polynomials of p and q at h, with so many terms.

    Coefficients are of powers of t/h: (n+1) pₙ₊₁ = h Σ pᵢ × ωₙ₋ᵢ and (n+1) qₙ₊₁ = ½ h Σ qᵢ ∘ ωₙ₋ᵢ. One product of
    matrices sums all products of components.
    """
    p, q = state.momentum, state.attitude
    rows: list[list[arb]] = [[x] for x in (*p, *q)]
    rates = list(equations.rate(p))
    p_sum, q_sum = p, q
    for n in range(terms - 1):
        S = arb_mat(7, n + 1, [x for row in rows for x in row]) * arb_mat(n + 1, 3, rates)
        factor = h / (n + 1)
        p = scaled(factor, (S[1, 2] - S[2, 1], S[2, 0] - S[0, 2], S[0, 1] - S[1, 0]))
        q = scaled(
            factor / 2,
            (
                S[6, 0] + S[4, 2] - S[5, 1],
                S[6, 1] + S[5, 0] - S[3, 2],
                S[6, 2] + S[3, 1] - S[4, 0],
                -S[3, 0] - S[4, 1] - S[5, 2],
            ),
        )
        for row, x in zip(rows, (*p, *q), strict=True):
            row.append(x)
        rates = [*equations.rate(p), *rates]
        p_sum, q_sum = added(p_sum, p), added(q_sum, q)
    return p_sum, q_sum
