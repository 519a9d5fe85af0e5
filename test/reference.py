"""The truth at 40 digits, and how far a computed state is from it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf

from lie_rigid_body import RigidBody, State

TRUTH = Path(__file__).parent / "data" / "torque_free_truth.json"


class TruthPoint(NamedTuple):
    """One instant of a reference motion, as decimal strings."""

    t_ns: int
    attitude_xyzw: list[str]
    body_rate: list[str]


class TruthCase(NamedTuple):
    """A body, its start and the truth at several times."""

    body: RigidBody
    start: State
    points: list[TruthPoint]


def truth_cases() -> dict[str, TruthCase]:
    """All cases of the reference file by name."""
    content = json.loads(TRUTH.read_text())
    return {
        name: TruthCase(
            RigidBody(case["inertia"]),
            State(case["attitude_xyzw"], case["body_rate"]),
            [TruthPoint(p["t_ns"], p["attitude_xyzw"], p["body_rate"]) for p in case["truth"]],
        )
        for name, case in content.items()
    }


def attitude_error(computed: np.ndarray, exact: list[str]) -> float:
    """Angle between a computed quaternion and a 40-digit one, rad; their signs do not matter."""
    with mp.workdps(50):
        ex, ey, ez = (-mpf(c) for c in exact[:3])
        ew = mpf(exact[3])
        a, b, c, d = (mpf(float(v)) for v in computed)
        vector = (
            ew * a + ex * d + ey * c - ez * b,
            ew * b - ex * c + ey * d + ez * a,
            ew * c + ex * b - ey * a + ez * d,
        )
        sine = mp.sqrt(sum(v * v for v in vector))
        return float(2 * mp.asin(min(sine, mpf(1))))


def rate_error(computed: np.ndarray, exact: list[str]) -> float:
    """Distance of a computed body rate from a 40-digit one, relative to the latter's norm."""
    with mp.workdps(50):
        difference = mp.sqrt(sum((mpf(float(c)) - mpf(e)) ** 2 for c, e in zip(computed, exact, strict=True)))
        return float(difference / mp.sqrt(sum(mpf(e) ** 2 for e in exact)))
