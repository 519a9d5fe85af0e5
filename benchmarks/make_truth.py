"""Compute the true attitudes that the benchmark holds everyone against: ``python benchmarks/make_truth.py``.

Taylor series of M ω′ = Mω × ω and q′ = ½ q ⊗ ω in decimal arithmetic: no elliptic functions, and nothing of the package
but the task. It carries 64 digits and writes 50 of them. It takes some minutes, and its result is kept in data/.
"""

from __future__ import annotations

import json
from decimal import Decimal, localcontext
from operator import mul
from typing import Final

from peers.task import ATTITUDE, INERTIA, NS, RATE, TASKS
from peers.truth import FILE

DIGITS: Final = 64
ORDER: Final = 60
STEP_NS: Final = 62_500_000
"""0.2 rad for this body: the series then ends below 1e-60."""

Vector = list[Decimal]


def series(attitude: Vector, rate: Vector) -> tuple[list[Vector], list[Vector]]:
    """Taylor coefficients of attitude and rate about one instant."""
    a, b, c = (Decimal(float(moment)) for moment in INERTIA)
    factors = ((b - c) / a, (c - a) / b, (a - b) / c)
    q, w = [[x] for x in attitude], [[x] for x in rate]
    for k in range(1, ORDER + 1):
        # the products of two series, taken from the coefficients before they grow
        turn = _quaternion_rate(q, w)
        torque = (_cauchy(w[1], w[2]), _cauchy(w[2], w[0]), _cauchy(w[0], w[1]))
        for row, value in zip(q, turn, strict=True):
            row.append(value / (2 * k))
        for row, factor, value in zip(w, factors, torque, strict=True):
            row.append(factor * value / k)
    return q, w


def _cauchy(left: Vector, right: Vector) -> Decimal:
    return sum(map(mul, left, reversed(right)), Decimal(0))


def _quaternion_rate(q: list[Vector], w: list[Vector]) -> Vector:
    """The newest coefficient of q ⊗ ω."""
    (x, y, z, s), (a, b, c) = q, w
    return [
        _cauchy(s, a) + _cauchy(y, c) - _cauchy(z, b),
        _cauchy(s, b) + _cauchy(z, a) - _cauchy(x, c),
        _cauchy(s, c) + _cauchy(x, b) - _cauchy(y, a),
        -_cauchy(x, a) - _cauchy(y, b) - _cauchy(z, c),
    ]


def _sum(coefficients: list[Vector], h: Decimal) -> Vector:
    values = []
    for row in coefficients:
        value = Decimal(0)
        for coefficient in reversed(row):
            value = value * h + coefficient
        values.append(value)
    return values


def attitudes(times_ns: list[int]) -> dict[int, Vector]:
    """The attitude at each of the rising times."""
    q, w = [Decimal(float(x)) for x in ATTITUDE], [Decimal(float(x)) for x in RATE]
    now, found = 0, {}
    for goal in times_ns:
        while now < goal:
            step = min(STEP_NS, goal - now)
            qs, ws = series(q, w)
            h = Decimal(step).scaleb(-9)
            q, w, now = _sum(qs, h), _sum(ws, h), now + step
        found[goal] = q
    return found


def main() -> None:
    """Write the file."""
    times = sorted({t for task in TASKS for t in task.judged_ns})
    with localcontext() as context:
        context.prec = DIGITS
        found = attitudes(times)
    text = {t: [format(component, ".50g") for component in q] for t, q in found.items()}
    FILE.parent.mkdir(exist_ok=True)
    body = {"seconds_per_unit": 1 / NS, "attitude_xyzw": text}
    FILE.write_text(json.dumps(body, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
