"""The exact solution evaluated in balls: theta functions, an elliptic integral of Carlson, and what they degenerate to.

**Body frame.** For a motion that is neither steady nor a symmetric top's choose a right-handed frame of principal axes
1 2 3 with reciprocal moments e₁, e₂, e₃. Let it be such that 2 is the axis of the middle moment and p₃ > 0 at the
start. Here 3 is the axis that the motion circulates about, or on the separatrix that of the largest moment. With σ the
sign of e₁ − e₃ and G = 2H − e₃p² = (e₁−e₃)p₁² + (e₂−e₃)p₂²,

    a₁² = G/(e₁−e₃),    a₂² = G/(e₂−e₃),    a₃² = (e₁p² − 2H)/(e₁−e₃),    ν² = (e₂−e₃)(e₁p² − 2H),
    k² = (e₁−e₂)G/ν²,   1 − k² = (e₁−e₃)(e₂p² − 2H)/ν²,

Euler's equations p₁' = (e₃−e₂)p₂p₃ and so on in turn are solved by

    p₁ = a₁ cn u,    p₂ = σ a₂ sn u,    p₃ = a₃ dn u,    u = u₀ + νt,

as sn' = cn dn, cn' = −sn dn, dn' = −k² sn cn show (Landau and Lifshitz §37; DLMF 22.13). On the separatrix k = 1: cn
= dn = 1/cosh u, times the sign of p₁, and sn = tanh u.

**Attitude.** Let g = A + B j be the rotation from the body frame to a frame whose z axis is the momentum. It is written
with complex numbers A and B in which the imaginary unit is the quaternion k. That it takes p to the z axis, and g' = ½
g ∘ ω, mean (p is also written for the norm)

    abs(A)² = (p + p₃)/2p,    B = −A (p₁ + i p₂)/(p + p₃),    χ' = ½ (e₃p + G/(p + p₃)),    χ = arg A.

p₃ never vanishes, so nothing here is singular, and the attitude is q(0) ∘ g(0)⁻¹ ∘ g(t) for any choice of χ(0).

**The phase.** Let K and K' be the quarter periods, z = u/2K and τ = iK'/K. A'/A as a function of u has the periods 2K
and 4iK', since dn and dn' have. Its poles are those of dn, at iK' and 3iK', with the residue −½, and one of the two
points where p₃ = −p, with the residue 1. (At the other the residues of iχ' and of ½p₃'/(p + p₃) cancel). At these
points u = ±ia, and the one is u* = −iσa, as p₃'(u*) = iG tells. Now

    A = C exp(iκt) θ₁(z + iσa/2K | 2τ) / √θ₄(z | τ)

has a logarithmic derivative with the same poles, residues and periods (over 4iK' the derivatives of log θ₁ and of ½ log
θ₄ change by the same −2πi). They differ by a constant, which is iκ. On the real axis θ₄ > 0, so that

    χ(t) − χ(0) = κt + arg(θ₁(z + iσa/2K | 2τ)/θ₁(z₀ + iσa/2K | 2τ)),

and κ is what makes the derivative at the start right. Since dn(ib) = dc(b, k') and dn(2iK' − ib) = −dn(ib), a = 2K' −
b with sc²(b, k') = (p² − a₃²)/(k²a₃²) = (e₂−e₃)/(e₁−e₂), the inverse of which is Carlson's R_F (DLMF 19.25.31 and
on). On the separatrix the integral of χ' is elementary.

The theta functions with their derivative, R_F and the arithmetic-geometric mean come from Arb, each with a proved
error.
"""

from __future__ import annotations

from typing import TypeAlias

from flint import acb, arb, ctx, fmpq, fmpq_poly

from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.proof.balls import (
    Balls,
    added,
    conjugate,
    cross,
    dot,
    exact,
    norm,
    product,
    rotated,
    rotation,
    scaled,
    sign,
)
from lie_rigid_body.proof.start import Kind, Start

Turned: TypeAlias = tuple[Balls, Balls]
"""A rotation, as a quaternion, and a vector after it: the momentum or the body rate."""


def exact_state(start: Start, t_ns: int, bits: int) -> Turned:
    """Attitude and body rate at a time, in balls of a precision.

    Parameters
    ----------
    start : Start
    t_ns : int
        Nanoseconds since the start.
    bits : int

    Returns
    -------
    attitude_xyzw, rate : tuple of 4, tuple of 3 arb
        World from body, continuous from the start; rad/s in the body frame. Not finite where the precision is too low.

    Raises
    ------
    UndecidedError
        If the precision is too low to decide a sign.
    """
    with ctx.workprec(bits):
        t = arb(fmpq(t_ns, 10**9))
        kind = start.kind
        given = exact(start.attitude_xyzw)
        attitude = scaled(1 / norm(given), given)
        rate = exact(start.rate)
        if kind is Kind.STEADY:
            return product(attitude, rotation(scaled(t, rate))), rate
        if kind is Kind.SYMMETRIC:
            return _symmetric_top(start, attitude, t)
        polhode = _EnclosedPolhode.of(start, kind)
        turn, momentum = (
            _separatrix_at(polhode, t) if kind is Kind.SEPARATRIX else _EnclosedCirculation.of(polhode).at(t)
        )
        turned = (*polhode.to_body(turn[:3]), turn[3])
        rates = tuple(e * p for e, p in zip(polhode.e, momentum, strict=True))
        return product(attitude, turned), polhode.to_body(rates)


def _symmetric_top(start: Start, attitude: Balls, t: arb) -> Turned:
    """Regular precession: a steady turn about the momentum, of rate p/I₁, after one about the body's axis of symmetry.

    With I₁ the moment of the two equal axes, ω − p/I₁ lies along the third, and is constant.
    """
    moment = arb(start.repeated_moment)
    momentum = scaled(1 / moment, exact(start.momentum))
    own = added(exact(start.rate), scaled(arb(-1), momentum))
    spin = rotation(scaled(t, own))
    precession = rotation(scaled(t, rotated(attitude, momentum)))
    rate = rotated(conjugate(spin), exact(start.rate))
    return product(product(precession, attitude), spin), rate


@short_dataclass
class _EnclosedPolhode:
    """The curve of the momentum in the principal frame that the module describes.

    Parameters
    ----------
    axes : tuple of 3 vectors
        The axes 1 2 3 in the body frame.
    e : tuple of 3 arb
        Reciprocal principal moments.
    start : tuple of 3 arb
        Momentum at the start, in the principal frame.
    norm : arb
        p.
    excess, deficit : arb
        G and e₁p² − 2H.
    """

    axes: tuple[Balls, Balls, Balls]
    e: Balls
    start: Balls
    norm: arb
    excess: arb
    deficit: arb

    @classmethod
    def of(cls, start: Start, kind: Kind) -> _EnclosedPolhode:
        """Constants of a motion that is neither steady nor a symmetric top's."""
        p = exact(start.momentum)
        smallest, middle, largest = _moments(start)
        first, third = (largest, smallest) if kind is Kind.ABOUT_SMALLEST else (smallest, largest)
        three = _axis(start, third)
        three = scaled(arb(sign(dot(p, three))), three)
        two = _axis(start, middle)
        axes = (cross(two, three), two, three)
        e1, e2, e3 = e = (1 / first, 1 / middle, 1 / third)
        p1, p2, p3 = local = tuple(dot(axis, p) for axis in axes)
        excess = (e1 - e3) * p1**2 + (e2 - e3) * p2**2
        deficit = (e1 - e2) * p2**2 + (e1 - e3) * p3**2
        return cls(axes, e, local, arb(start.momentum_squared).sqrt(), excess, deficit)

    @property
    def sigma(self) -> int:
        """σ, the sign of e₁ − e₃."""
        return sign(self.e[0] - self.e[2])

    @property
    def amplitudes(self) -> Balls:
        """a₁, a₂, a₃."""
        e1, e2, e3 = self.e
        squares = (self.excess / (e1 - e3), self.excess / (e2 - e3), self.deficit / (e1 - e3))
        return tuple(square.sqrt() for square in squares)

    @property
    def frequency(self) -> arb:
        """ν."""
        return ((self.e[1] - self.e[2]) * self.deficit).sqrt()

    def phase_rate(self) -> arb:
        """χ' at the start."""
        return (self.e[2] * self.norm + self.excess / (self.norm + self.start[2])) / 2

    def turn(self, unit: acb, momentum: Balls) -> Balls:
        """g(0)⁻¹ ∘ g(t) from exp(iχ(t) − iχ(0)) and p(t), as a quaternion in the principal frame."""
        return product(conjugate(self._spinor(acb(1), self.start)), self._spinor(unit, momentum))

    def _spinor(self, unit: acb, momentum: Balls) -> Balls:
        """The components x y z w of g = A + B j, with exp(iχ) given."""
        p1, p2, p3 = momentum
        A = ((self.norm + p3) / (2 * self.norm)).sqrt() * unit
        B = -A * acb(p1, p2) / (self.norm + p3)
        return (-B.imag, B.real, A.imag, A.real)

    def to_body(self, vector: Balls) -> Balls:
        """A vector of the principal frame in the body frame."""
        one, two, three = (scaled(x, axis) for x, axis in zip(vector, self.axes, strict=True))
        return added(added(one, two), three)


def _moments(start: Start) -> list[arb]:
    """The principal moments, ascending: the roots of the characteristic polynomial, which Arb isolates."""
    trace, minors, determinant = start.invariants
    roots = [root.real for root, _ in fmpq_poly([-determinant, minors, -trace, 1]).complex_roots()]
    return sorted(roots, key=lambda root: root.mid())


def _axis(start: Start, moment: arb) -> Balls:
    """The unit eigenvector of a simple eigenvalue I: the columns of the adjugate of M − I 1 are multiples of it."""
    M = start.inertia
    rows = [tuple(M[i, j] - moment if i == j else arb(M[i, j]) for j in range(3)) for i in range(3)]
    columns = [cross(rows[i], rows[(i + 1) % 3]) for i in range(3)]
    longest = max(columns, key=lambda column: dot(column, column).mid())
    return scaled(1 / norm(longest), longest)


@short_dataclass
class _EnclosedCirculation:
    """The motion that circulates about axis 3: Jacobi's elliptic functions of modulus k below 1.

    Parameters
    ----------
    polhode : _EnclosedPolhode
    complement : arb
        k' = √(1 − k²).
    quarter, other_quarter : arb
        K and K'.
    pole : arb
        σa/2K.
    """

    polhode: _EnclosedPolhode
    complement: arb
    quarter: arb
    other_quarter: arb
    pole: arb

    @classmethod
    def of(cls, polhode: _EnclosedPolhode) -> _EnclosedCirculation:
        """With k and 1 − k² each from sums of terms of one sign, but for the middle axis."""
        e1, e2, e3 = polhode.e
        p1, _, p3 = polhode.start
        square = polhode.frequency**2
        modulus = ((e1 - e2) * polhode.excess / square).sqrt()
        complement = ((e1 - e3) * ((e2 - e1) * p1**2 + (e2 - e3) * p3**2) / square).sqrt()
        quarter = arb.pi() / (2 * complement.agm(arb(1)))
        other = arb.pi() / (2 * modulus.agm(arb(1)))
        # F(φ, k') = R_F(c − 1, c − k'², c) with c = 1/sin²φ, and c − 1 = 1/tan²φ = (e₁−e₂)/(e₂−e₃)
        cotangent = (e1 - e2) / (e2 - e3)
        b = _carlson(cotangent, cotangent + modulus**2, cotangent + 1)
        pole = polhode.sigma * (2 * other - b) / (2 * quarter)
        return cls(polhode, complement, quarter, other, pole)

    def at(self, t: arb) -> Turned:
        """g(0)⁻¹ ∘ g(t) and p(t) in the principal frame."""
        polhode = self.polhode
        nu = polhode.frequency
        z0 = self._initial_argument() / (2 * self.quarter)
        z = z0 + nu * t / (2 * self.quarter)
        double = acb(0, 2 * self.other_quarter / self.quarter)
        before, after = (acb(x, self.pole).modular_theta(double)[0] for x in (z0, z))
        slope = (acb(z0, self.pole).modular_theta(double, 1)[0] / before).imag * nu / (2 * self.quarter)
        drift = acb(0, (polhode.phase_rate() - slope) * t).exp()
        momentum = self._momentum(z)
        ratio = after / before
        return polhode.turn(drift * ratio / abs(ratio), momentum), momentum

    def _momentum(self, z: arb) -> Balls:
        """a₁ cn u, σ a₂ sn u and a₃ dn u (DLMF 22.2)."""
        tau = acb(0, self.other_quarter / self.quarter)
        one, two, three, four = (theta.real for theta in acb(z).modular_theta(tau))
        _, two0, three0, four0 = (theta.real for theta in acb(0).modular_theta(tau))
        a1, a2, a3 = self.polhode.amplitudes
        return (
            a1 * four0 * two / (two0 * four),
            self.polhode.sigma * a2 * three0 * one / (two0 * four),
            a3 * four0 * three / (three0 * four),
        )

    def _initial_argument(self) -> arb:
        """u₀, by Legendre's F(φ, k) = sn R_F(cn², dn², 1) where cn is large, and by u₀ → K − u₀ where it is small."""
        cn, sn, dn = (p / a for p, a in zip(self.polhode.start, self.polhode.amplitudes, strict=True))
        sn = self.polhode.sigma * sn
        if abs(cn.mid()) >= abs(sn.mid()):
            nearest = sn * _carlson(cn**2, dn**2, arb(1))
            return nearest if sign(cn) > 0 else 2 * self.quarter - nearest
        # sn, cn and dn of K − |u| are cn/dn, k' |sn|/dn and k'/dn
        rest = cn / dn * _carlson((self.complement * sn / dn) ** 2, (self.complement / dn) ** 2, arb(1))
        return sign(sn) * (self.quarter - rest)


def _carlson(x: arb, y: arb, z: arb) -> arb:
    """R_F of numbers that are not negative, at most one of which is 0."""
    return acb.elliptic_rf(acb(x), acb(y), acb(z)).real


def _separatrix_at(polhode: _EnclosedPolhode, t: arb) -> Turned:
    """g(0)⁻¹ ∘ g(t) and p(t) in the principal frame, of the motion that takes for ever to reach the middle axis."""
    p = polhode.norm
    a1, _, a3 = polhode.amplitudes
    side = sign(polhode.start[0])
    u0 = (side * polhode.start[1] * a3 / (p * polhode.start[2])).asinh()
    u = u0 + polhode.frequency * t
    momentum = (side * a1 / u.cosh(), side * p * u.tanh(), a3 / u.cosh())
    # ∫ du/(p + a₃/cosh u) = u/p − 2a₃/(p a₁) arctan(a₁ tanh(u/2)/(p + a₃)), as p² = a₁² + a₃²
    arcs = [(a1 * (x / 2).tanh() / (p + a3)).atan() for x in (u0, u)]
    lag = 2 * a3 / (p * a1 * polhode.frequency) * (arcs[1] - arcs[0])
    phase = (polhode.e[2] * p * t + polhode.excess * (t / p - lag)) / 2
    return polhode.turn(acb(0, phase).exp(), momentum), momentum
