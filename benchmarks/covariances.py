"""What is said of right covariances and of wrong ones: ``python benchmarks/covariances.py``.

Errors of some runs are drawn with a known covariance: one that is constant over a run, one that grows like a random
walk, and one of a stationary process. What is said of the true covariance and of wrong ones is counted over campaigns;
in the last line of each kind the covariance is wrong by the factor that so many runs are said to show.

    python benchmarks/covariances.py --campaigns 200 --runs 12
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from lie_rigid_body.evaluation.ensemble_consistency import EnsembleConsistency, ensemble_consistency

Array = NDArray[np.float64]

RUNS: Final = 100
TIMES: Final = np.linspace(0.0, 60.0, 60)
LATE: Final = 40.0
"""Time from which on the covariance of the last kind is too small, s."""
KINDS: Final = ("constant", "growing", "stationary")
MEMORY: Final = 0.9
"""Correlation of neighbouring errors of the stationary process."""


def drawn(kind: str, draws: np.random.Generator, runs: int = RUNS) -> tuple[Array, Array]:
    """Errors of runs, shape (R, T, 3), rad, and their covariance, shape (R, T, 3, 3), rad²."""
    deviations, signs = draws.uniform(0.005, 0.02, 3), draws.choice([-1.0, 1.0], 2)
    correlation = np.eye(3)
    correlation[0, 1] = correlation[1, 0] = 0.4 * signs[0]
    correlation[0, 2] = correlation[2, 0] = 0.3 * signs[1]
    covariance = correlation * np.outer(deviations, deviations)
    steps = draws.normal(size=(runs, len(TIMES), 3)) @ np.linalg.cholesky(covariance).T
    factor = np.ones(len(TIMES))
    if kind == "constant":
        steps = np.repeat(steps[:, :1], len(TIMES), axis=1)
    elif kind == "growing":
        steps, factor = np.cumsum(steps, axis=1), np.arange(1.0, len(TIMES) + 1.0)
    else:
        for k in range(1, len(TIMES)):
            steps[:, k] = MEMORY * steps[:, k - 1] + np.sqrt(1.0 - MEMORY**2) * steps[:, k]
    return steps, np.broadcast_to(factor[:, np.newaxis, np.newaxis] * covariance, (runs, len(TIMES), 3, 3))


def _root(P: Array) -> Array:
    values, vectors = np.linalg.eigh(P)
    return np.asarray(vectors * np.sqrt(values)[..., np.newaxis, :] @ np.swapaxes(vectors, -1, -2))


GIVEN: Final[dict[str, Callable[[Array, Array], Array]]] = {
    "right": lambda P, R: P,
    "variance × 1.5": lambda P, R: 1.5 * P,
    "variance ÷ 1.5": lambda P, R: P / 1.5,
    "about the body's axes": lambda P, R: np.swapaxes(R, -1, -2) @ P @ R,
    "standard deviations": lambda P, R: _root(P),
    "degrees": lambda P, R: P * np.degrees(1.0) ** 2,
    "cross-covariances negated": lambda P, R: P * (2.0 * np.eye(3) - 1.0),
    "too small from 40 s on": lambda P, R: P * np.where(TIMES > LATE, 0.5, 1.0)[:, np.newaxis, np.newaxis],
}
"""What a filter gives in the place of its covariance, from the true one and the true rotations."""


def judged(kind: str, wrong: str, number: int, runs: int = RUNS) -> EnsembleConsistency:
    """The verdict of one campaign."""
    draws = np.random.default_rng((KINDS.index(kind), number))
    errors, covariance = drawn(kind, draws, runs)
    attitude = Rotation.from_quat(draws.normal(size=(runs * len(TIMES), 4)))  # of any direction alike
    R = attitude.as_matrix().reshape(runs, len(TIMES), 3, 3)
    return ensemble_consistency(
        TIMES, errors, GIVEN[wrong](covariance, R), attitude.as_quat().reshape(runs, len(TIMES), 4)
    )


def main() -> None:
    """Print a line for each kind of error and each wrong covariance."""
    parser = argparse.ArgumentParser(description="What is said of covariances that are known.")
    parser.add_argument("--campaigns", type=int, default=100, help="campaigns of each kind (default: %(default)s)")
    parser.add_argument("--runs", type=int, default=RUNS, help="runs of a campaign (default: %(default)s)")
    given = parser.parse_args()
    campaigns = given.campaigns
    print(f"{campaigns} campaigns of {given.runs} runs: what the covariance is called, and what is wrong with it")
    for wrong in GIVEN:
        for kind in KINDS:
            found = Counter(
                f"{v.verdict} {v.cause}".strip() for v in (judged(kind, wrong, i, given.runs) for i in range(campaigns))
            )
            print(
                f"{wrong:26} {kind:11} {', '.join(f'{count} {what}' for what, count in found.most_common())}",
                flush=True,
            )
    for kind in KINDS:
        shown = list[bool]()
        factors = list[float]()
        for number in range(campaigns):
            draws = np.random.default_rng((KINDS.index(kind), number))
            errors, covariance = drawn(kind, draws, given.runs)
            factors.append(ensemble_consistency(TIMES, errors, covariance).factor_shown)
            shown.append(not ensemble_consistency(TIMES, errors, covariance / factors[-1]).passed)
        print(f"{f'÷ {np.median(factors):.2f}, as told':26} {kind:11} {sum(shown)} shown", flush=True)


if __name__ == "__main__":
    main()
