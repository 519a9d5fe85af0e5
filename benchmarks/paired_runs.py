"""Level and power of tests of paired runs, and coverage of their intervals: ``python benchmarks/paired_runs.py``.

Errors of two filters are drawn for each run: a difficulty that both feel, an own part of each, and a factor between
them. In some runs one of them diverges, to 20 to 120°. Counted is how often a difference is shown by the signed-rank
test of the logarithms of the ratios, and by Student's t of the differences in degrees; how often the interval holds the
true ratio; and among six filters that are equally good, in how many campaigns any pair is shown to differ.
"""

from __future__ import annotations

import argparse
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import ttest_1samp

from lie_rigid_body.evaluation.differences import of_pairs, of_runs

Array = NDArray[np.float64]

DIFFICULTY: Final = 0.5
"""Deviation of the logarithm of the difficulty of a run."""
OWN: Final = 0.25
"""Deviation of the logarithm of what is a filter's own."""
FILTERS: Final = 6


def drawn(draws: np.random.Generator, runs: int, filters: int, diverging: float) -> Array:
    """RMS errors of equally good filters, degrees, shape (filters, runs)."""
    common = DIFFICULTY * draws.normal(size=runs)
    errors = np.exp(common + OWN * draws.normal(size=(filters, runs)))
    lost = draws.random((filters, runs)) < diverging
    return np.where(lost, draws.uniform(20.0, 120.0, (filters, runs)), errors)


def main() -> None:
    """Print a line for each number of runs and share of runs that diverge."""
    parser = argparse.ArgumentParser(description="Level and power of tests of paired runs.")
    parser.add_argument("--campaigns", type=int, default=1000, help="campaigns of each kind (default: %(default)s)")
    campaigns = parser.parse_args().campaigns
    print(
        "shares of campaigns, %: shown by ranks and by t at a ratio of 1; at a ratio of 0.85; interval holds the ratio"
    )
    for runs in (10, 25, 100):
        for diverging in (0.0, 0.05):
            draws = np.random.default_rng(1)
            counts = np.zeros(5)
            for _ in range(campaigns):
                first, second = drawn(draws, runs, 2, diverging)
                better = np.where(first < 20.0, 0.85 * first, first)
                same = of_runs(first, second)
                other = of_runs(better, second)
                counts += [
                    same.is_shown,
                    ttest_1samp(first - second, 0.0).pvalue <= 0.05,
                    other.is_shown,
                    ttest_1samp(better - second, 0.0).pvalue <= 0.05,
                    other.low <= 0.85 <= other.high,
                ]
            shares = "  ".join(f"{share:5.1f}" for share in 100.0 * counts / campaigns)
            print(f"{runs:4d} runs, {diverging:4.0%} diverging  {shares}", flush=True)
    print(f"\n{FILTERS} filters that are equally good: campaigns, %, in which any pair is shown to differ")
    for runs in (10, 25, 100):
        draws = np.random.default_rng(2)
        any_shown = 0
        for _ in range(campaigns // 5):
            found = of_pairs([*combinations(drawn(draws, runs, FILTERS, 0.05), 2)])
            any_shown += any(each.is_shown for each in found)
        print(f"{runs:4d} runs  {100.0 * any_shown / (campaigns // 5):5.1f}", flush=True)


if __name__ == "__main__":
    main()
