"""Write the cases by which engines are judged, with proved truth: ``python benchmarks/make_conformance.py``.

The truth has 40 digits. `lie_rigid_body.proof` encloses it in balls: theta functions in ball arithmetic. Taylor series
of p′ = p × Jp and q′ = ½ q ⊗ Jp in decimal arithmetic, which share nothing with them, have to agree. It needs mpmath
and python-flint, and takes a minute. The cases are frozen: numbers of a release are not made anew.
"""

from __future__ import annotations

import json
from decimal import Decimal, localcontext
from fractions import Fraction
from operator import mul
from pathlib import Path
from typing import Any, Final, NamedTuple

import mpmath
import numpy as np
from flint import arb, ctx

from lie_rigid_body.lie import quaternion
from lie_rigid_body.proof import enclose

FILE: Final = Path(__file__).resolve().parent.parent / "config" / "conformance" / "1.json"
DIGITS: Final = 40
"""Decimals of a component of an attitude; a rate has as many below the norm of the rate at the start."""
INSTANTS: Final = 16
"""Number of instants with a truth. A duration is a power of two, so that each of them is a double."""
ORDER: Final = 70
TURN: Final = 0.1
"""Largest rotation in a step of the series, rad: they then end below 1e-60."""


class Body(NamedTuple):
    """A case as it is designed: in a frame that a quaternion takes to the body's, which need not be of unit norm."""

    about: str
    moments: tuple[float, float, float]
    rate: tuple[float, float, float]
    frame_wxyz: tuple[float, float, float, float]
    attitude_xyzw: tuple[float, float, float, float]
    duration: float
    products: tuple[float, float, float] = (0.0, 0.0, 0.0)


BODIES: Final = {
    "tumble": Body(
        "an asymmetric body far from every steady rotation, in principal axes",
        (0.6, 0.8, 1.0), (3.0, 0.5, -0.9), (1, 0, 0, 0), (0.5, -0.1, 0.7, 0.5), 16.0,
    ),
    "near_sphere": Body(
        "a body whose moments differ by half a percent",
        (0.4, 0.401, 0.402), (2.0, 1.5, -1.0), (3, 1, -2, 1), (0.1, 0.2, -0.3, 0.9), 32.0,
    ),
    "spin_smallest": Body(
        "a spin about the axis of the smallest moment, with a wobble",
        (0.01, 0.022, 0.025), (4.0, 0.3, 0.2), (2, 1, 1, -1), (-0.4, 0.3, 0.1, 0.8), 16.0,
    ),
    "spin_largest": Body(
        "a spin about the axis of the largest moment, with a wobble",
        (1.2, 2.0, 2.7), (0.2, -0.3, 2.5), (1, 2, -1, 3), (0.6, 0.2, 0.3, -0.7), 32.0,
    ),
    "dzhanibekov_1e-2": Body(
        "a body that turns over, 1e-2 away from its intermediate axis",
        (0.3, 1.0, 1.15), (0.05, 5.0, 0.05), (2, -1, 1, 1), (0.3, 0.5, 0.1, 0.8), 16.0,
    ),
    "dzhanibekov_1e-6": Body(
        "a body that turns over, 1e-6 away from its intermediate axis",
        (2.0e-4, 5.0e-4, 6.0e-4), (1.2e-5, -12.0, 1.2e-5), (4, 1, 3, -2), (0.2, -0.7, 0.4, 0.5), 8.0,
    ),
    "dzhanibekov_1e-9": Body(
        "a body that turns over, 1e-9 away from its intermediate axis",
        (0.1, 1.0, 1.05), (7.0e-9, 7.0, 7.0e-9), (3, 2, -1, 2), (-0.5, 0.4, 0.6, 0.3), 16.0,
    ),
    "rod": Body(
        "a thin rod of some grams, fast",
        (6.58e-6, 1.7231e-4, 1.7243e-4), (300.0, 20.0, -10.0), (1, 1, -2, 2), (0.7, 0.1, 0.2, 0.6), 0.25,
    ),
    "plate": Body(
        "a plate, nearly flat",
        (0.01, 0.02, 0.0299), (1.5, -0.8, 2.0), (5, -2, 1, 3), (0.2, 0.6, -0.5, 0.4), 32.0,
    ),
    "disc": Body(
        "a thrown disc that precesses, fast: an oblate symmetric top",
        (0.001, 0.001, 0.002), (2.0, 0.0, 40.0), (1, 0, 0, 0), (0.1, -0.3, 0.2, 0.9), 2.0,
    ),
    "pencil": Body(
        "a prolate symmetric top that precesses, its axis along z of the body",
        (1.0e-4, 1.0e-4, 2.0e-6), (0.4, -0.6, 9.0), (1, 0, 0, 0), (0.4, 0.4, -0.5, 0.6), 8.0,
    ),
    "satellite": Body(
        "a tensor with products of inertia, as CAD writes it, slow",
        (120.0, 95.0, 140.0), (0.011, -0.013, 0.017), (1, 0, 0, 0), (-0.3, 0.2, 0.8, 0.5), 4096.0, (-8.0, 5.0, -12.0),
    ),
}  # fmt: skip
Row = dict[str, Any]


def tensor(body: Body) -> np.ndarray:
    """The tensor in the body's frame: its doubles are the case."""
    xy, xz, yz = body.products
    designed = np.diag(body.moments) + np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])
    R = frame(body)
    turned = R @ designed @ R.T
    return 0.5 * (turned + turned.T)


def frame(body: Body) -> np.ndarray:
    w, x, y, z = body.frame_wxyz
    return quaternion.to_matrix(quaternion.normalize(np.array([x, y, z, w], dtype=float)))


def principal(inertia: np.ndarray, designed: np.ndarray) -> tuple[list[float], list[float]]:
    """Moments, ascending, and the frame of their axes as a quaternion w x y z, of 50 digits rounded once.

    Each axis points as far as it can along a designed one; the last completes a right-handed frame.
    """
    with mpmath.workdps(60):
        values, columns = mpmath.eigsy(mpmath.matrix(inertia.tolist()))
        axes = np.array([[columns[i, j] for j in range(3)] for i in range(3)], dtype=object)
    axes = axes.astype(float)
    for j in range(2):
        along = designed.T @ axes[:, j]
        axes[:, j] *= np.sign(along[np.argmax(np.abs(along))])
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    x, y, z, w = quaternion.from_matrix(axes).tolist()
    moments = [float(value) for value in values]
    off = np.abs(axes @ np.diag(moments) @ axes.T - inertia).max()
    assert off < 8e-16 * max(moments), off
    return moments, [w, x, y, z]


def enclosed(inertia: np.ndarray, attitude: np.ndarray, rate: np.ndarray, t: float) -> tuple[list[str], list[str]]:
    """Digits of attitude and rate, which are proved. The time is stretched, to a whole number of nanoseconds."""
    stretch = 2 ** max(0, 30 - int(np.log2(t)))
    slow = rate / stretch
    t_ns = Fraction(t) * stretch * 10**9
    assert (slow * stretch == rate).all()
    assert t_ns.denominator == 1
    # its last bits are lost where the body turns over: a wider one of these widths would do
    found = enclose(inertia, attitude, slow, int(t_ns), width=10.0 ** -(DIGITS + 3))
    size = Decimal(float(np.linalg.norm(rate)))
    with ctx.workprec(found.bits), localcontext() as context:
        context.prec = 3 * DIGITS
        digits = [written(ball, Decimal(1)) for ball in found.attitude_xyzw]
        return digits, [written(ball * stretch, size) for ball in found.body_rate]


def written(ball: arb, size: Decimal) -> str:
    """Decimals of a ball, none of which is off by more than 1e-40 of a size: that is proved here."""
    quantum = Decimal(1).scaleb(size.adjusted() - DIGITS)
    text = str(Decimal(ball.mid().str(3 * DIGITS, radius=False)).quantize(quantum))
    assert abs(ball - arb(text)).upper() < arb(str(quantum)), text
    return text


def series(inertia: np.ndarray, attitude: np.ndarray, rate: np.ndarray, times: list[float]) -> list[list[Decimal]]:
    """The attitudes at rising times, by Taylor series; an independent method."""
    rows = [[Decimal(x) for x in row] for row in inertia.tolist()]
    J = inverse(rows)
    w = [Decimal(x) for x in rate.tolist()]
    p = [sum(map(mul, row, w), Decimal(0)) for row in rows]
    q = [Decimal(x) for x in attitude.tolist()]
    norm = sum(map(mul, q, q), Decimal(0)).sqrt()
    q = [x / norm for x in q]
    now, found = Fraction(0), []
    for t in map(Fraction, times):
        steps = int(float(t - now) * float(np.linalg.norm(rate)) / TURN) + 1
        h = Decimal((t - now).numerator) / Decimal((t - now).denominator) / steps
        for _ in range(steps):
            q, p = step(J, q, p, h)
        found.append(q)
        now = t
    return found


def inverse(m: list[list[Decimal]]) -> list[list[Decimal]]:
    """The inverse of a symmetric matrix, by its cofactors."""
    cofactor = [
        [
            m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3]
            - m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3]
            for j in range(3)
        ]
        for i in range(3)
    ]
    determinant = sum(map(mul, m[0], cofactor[0]), Decimal(0))
    return [[value / determinant for value in row] for row in cofactor]


def step(J: list[list[Decimal]], q: list[Decimal], p: list[Decimal], h: Decimal) -> tuple[list[Decimal], list[Decimal]]:
    """A step of the series, summed as it is made: its coefficients are scaled by powers of h."""
    qs, ps, ws = [[x] for x in q], [[x] for x in p], [[] for _ in p]

    def cauchy(left: list[Decimal], right: list[Decimal]) -> Decimal:
        return sum(map(mul, left, reversed(right)), Decimal(0))

    for k in range(1, ORDER + 1):
        for row, w in zip(J, ws, strict=True):
            w.append(sum((a * b[-1] for a, b in zip(row, ps, strict=True)), Decimal(0)))
        (x, y, z, s), (a, b, c) = qs, ws
        turn = (
            cauchy(s, a) + cauchy(y, c) - cauchy(z, b),
            cauchy(s, b) + cauchy(z, a) - cauchy(x, c),
            cauchy(s, c) + cauchy(x, b) - cauchy(y, a),
            -cauchy(x, a) - cauchy(y, b) - cauchy(z, c),
        )
        torque = [cauchy(ps[i], ws[j]) - cauchy(ps[j], ws[i]) for i, j in ((1, 2), (2, 0), (0, 1))]
        for row, value in zip(qs, turn, strict=True):
            row.append(value * h / (2 * k))
        for row, value in zip(ps, torque, strict=True):
            row.append(value * h / k)
    return [sum(row, Decimal(0)) for row in qs], [sum(row, Decimal(0)) for row in ps]


def case(name: str, body: Body) -> Row:
    """All numbers of a case."""
    inertia = tensor(body)
    attitude = quaternion.normalize(np.array(body.attitude_xyzw))
    rate = frame(body) @ body.rate
    times = [body.duration * k / INSTANTS for k in range(1, INSTANTS + 1)]
    truth = [enclosed(inertia, attitude, rate, t) for t in times]
    with localcontext() as context:
        context.prec = 64
        again = series(inertia, attitude, rate, times)
        off = max(
            abs(a - Decimal(b)) for q, (p, _) in zip(again, truth, strict=True) for a, b in zip(q, p, strict=True)
        )
    assert off < Decimal(1).scaleb(1 - DIGITS), off
    moments, frame_wxyz = principal(inertia, frame(body))
    fastest = max(np.linalg.norm(rate), *(np.linalg.norm([float(x) for x in w]) for _, w in truth))
    x, y, z, w = attitude.tolist()
    print(f"{name}: {body.duration * fastest / (2 * np.pi):.1f} turns, the two methods are {off:.0e} apart", flush=True)
    return {
        "name": name,
        "about": body.about,
        "inertia": inertia.tolist(),
        "attitude_xyzw": [x, y, z, w],
        "body_rate": rate.tolist(),
        "principal_moments": moments,
        "inertial_frame_wxyz": frame_wxyz,
        "attitude_wxyz": [w, x, y, z],
        "world_rate": quaternion.rotate(attitude, rate).tolist(),
        "period": float(f"{2 * np.pi / fastest:.3g}"),
        "duration": body.duration,
        "truth": [{"t_s": t, "attitude_xyzw": q, "body_rate": w} for t, (q, w) in zip(times, truth, strict=True)],
    }


def main() -> None:
    """Write the file."""
    rows = [case(name, body) for name, body in BODIES.items()]
    text = json.dumps({"edition": 1, "cases": rows}, indent=1)
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
