"""How often the NEES of one run has a remark though its covariance is right: ``python benchmarks/run_consistency.py``.

Errors are stationary processes of first order with a memory of 0.01 to 10 s, and constants, over 60 s at 100 Hz. For
comparison the test is counted that takes the samples for independent, and the one that takes the long-run variance of
the NEES, by Bartlett's window over five memories.
"""

from __future__ import annotations

import argparse
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from lie_rigid_body.evaluation import nees

RATE: Final = 100.0
DURATION_S: Final = 60.0
MEMORIES_S: Final = (0.01, 0.1, 1.0, 10.0, np.inf)


def drawn(memory_s: float, draws: np.random.Generator) -> NDArray[np.float64]:
    """Errors of unit variance, shape (N, 3)."""
    from scipy.signal import lfilter  # slow to load

    count = int(RATE * DURATION_S)
    kept = float(np.exp(-1.0 / (RATE * memory_s)))
    steps = np.sqrt(1.0 - kept**2) * draws.normal(size=(count, 3))
    first = draws.normal(size=(1, 3))
    return np.asarray(lfilter([1.0], [1.0, -kept], steps, axis=0, zi=kept * first)[0])


def outside(values: NDArray[np.float64], memory_s: float) -> tuple[bool, bool]:
    """Whether two tests of 5 % call the mean wrong: of independent samples, and by the long-run variance."""
    count = len(values)
    low, high = (chi2.ppf(tail, 3 * count) / count for tail in (0.025, 0.975))
    centred = values - values.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * count)) ** 2
    covariances = np.fft.irfft(spectrum)[:count] / count
    length = int(min(5.0 * RATE * memory_s, count / 2.0)) + 1
    lags = np.arange(1, length)
    variance = covariances[0] + 2.0 * np.sum((1.0 - lags / length) * covariances[1:length])
    by_independence = not low <= values.mean() <= high
    return by_independence, bool(abs(values.mean() - 3.0) > 1.96 * np.sqrt(max(variance, 0.0) / count))


def main() -> None:
    """Print a line for each memory."""
    parser = argparse.ArgumentParser(description="How often one run has a remark on a right covariance.")
    parser.add_argument("--runs", type=int, default=2000, help="runs of each memory (default: %(default)s)")
    runs = parser.parse_args().runs
    print("shares of runs, %: remarked on; called wrong by a test for independent samples; by the long-run variance")
    for memory_s in MEMORIES_S:
        counted = np.zeros(3)
        draws = np.random.default_rng(1)
        for _ in range(runs):
            found = nees(drawn(memory_s, draws), np.eye(3))
            counted += [bool(found.remark), *outside(found.nees, memory_s)]
        shares = "  ".join(f"{share:6.2f}" for share in 100.0 * counted / runs)
        print(f"memory {memory_s:5g} s  {shares}", flush=True)


if __name__ == "__main__":
    main()
