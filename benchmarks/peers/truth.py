"""The true attitudes to 50 digits, and how far a computed attitude is from them."""

from __future__ import annotations

import json
from decimal import Decimal, localcontext
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from peers.task import Task

FILE: Final = Path(__file__).resolve().parent.parent / "data" / "free_body_truth.json"
"""Written by ``make_truth.py``, by nanoseconds since the start."""


@cache
def truth() -> dict[int, list[Decimal]]:
    """The true attitudes, xyzw, by time in ns."""
    written = json.loads(FILE.read_text(encoding="utf-8"))["attitude_xyzw"]
    return {int(t): [Decimal(component) for component in q] for t, q in written.items()}


def errors(task: Task, attitudes: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far attitudes are from the truth, where it is known.

    Parameters
    ----------
    task : Task
    attitudes : ndarray, shape (N, 4)
        xyzw, at every time of the task; the sign of a quaternion and its norm do not matter.

    Returns
    -------
    ndarray, shape (M,)
        Angles, rad; infinite where there is no attitude.
    """
    exact = truth()
    pairs = zip(task.judged_ns, attitudes[task.judged], strict=True)
    return np.array([_angle(exact[t], q) if np.isfinite(q).all() else np.inf for t, q in pairs])


def _angle(exact: list[Decimal], computed: NDArray[np.float64]) -> float:
    """The angle of the rotation between, from its half's tangent: as sharp at 0 as at π."""
    with localcontext() as context:
        context.prec = 50
        x, y, z, w = exact
        a, b, c, d = (Decimal(float(v)) for v in computed)
        vector = (
            w * a - x * d - y * c + z * b,
            w * b + x * c - y * d - z * a,
            w * c - x * b + y * a - z * d,
        )
        sine = sum((v * v for v in vector), Decimal(0)).sqrt()
        cosine = abs(w * d + x * a + y * b + z * c)
        return float(2.0 * np.arctan2(float(sine), float(cosine)))
