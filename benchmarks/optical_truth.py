"""How often `evaluate` names the three constants between a filter and a motion capture system, and no others.

A body is moved by hand: smooth rotations about all axes, with rests. Its true attitude is measured by a motion capture
system with a world, axes of its markers and a clock of its own. The estimates are the truth with noise, Mahony's
filter, right filters that converge slowly, and filters that do not hear their gyro. Printed for each kind: how often
the codes are those that were put in, how often others, how often none, and the errors of the constants.

    python benchmarks/optical_truth.py --runs 30
"""

from __future__ import annotations

import argparse
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body import SampledTruth, evaluate
from lie_rigid_body.evaluation import Score
from lie_rigid_body.lie import quaternion

Array = NDArray[np.float64]
NS: Final = 10**9
RATE: Final = 100.0
"""Readings a second."""
OPTICAL_RATE: Final = 120.0
UP: Final = np.array([0.0, 0.0, 1.0])
NORTH: Final = np.array([0.0, 0.5, -0.85])


@dataclass(frozen=True)
class Hand:
    """A motion by hand, and what sensors read of it.

    Attributes
    ----------
    t_s : ndarray, shape (N,)
    attitude_xyzw : ndarray, shape (N, 4)
    gyro, up, north : ndarray, shape (N, 3)
        rad/s; unit vectors on the axes of the body.
    """

    t_s: Array
    attitude_xyzw: Array
    gyro: Array
    up: Array
    north: Array


def moved(seed: int, length_s: float = 60.0, noise: float = 1.0) -> Hand:
    """A motion of harmonics in 0.05 to 1 Hz, 1 rad/s RMS an axis, which rests in a third of the time."""
    rng = np.random.default_rng([46, seed])
    t_s = np.arange(0.0, length_s, 1.0 / RATE)
    frequency = rng.uniform(0.05, 1.0, (8, 3))
    phase = rng.uniform(0.0, 2.0 * np.pi, (8, 3))
    rate = 0.5 * np.sin(2.0 * np.pi * frequency * t_s[:, np.newaxis, np.newaxis] + phase).sum(axis=1)
    calm = np.clip(3.0 * np.sin(2.0 * np.pi * t_s / 9.0 + rng.uniform(0.0, 6.0)) + 1.5, 0.0, 1.0)
    rate = rate * calm[:, np.newaxis]
    steps = quaternion.exp(rate / RATE)
    attitude = np.empty((len(t_s), 4))
    attitude[0] = quaternion.normalize(rng.normal(size=4))
    for k in range(1, len(t_s)):
        attitude[k] = quaternion.normalize(quaternion.multiply(attitude[k - 1], steps[k]))
    back = quaternion.conjugate(attitude)
    up, north = (
        quaternion.rotate(back, vector) + 0.01 * noise * rng.normal(size=(len(t_s), 3))
        for vector in (UP, NORTH / np.linalg.norm(NORTH))
    )
    gyro = rate + noise * (0.003 * rng.normal(size=rate.shape) + rng.normal(size=3) * 1e-3)
    return Hand(t_s, attitude, gyro, up, north)


def mahony(hand: Hand, gain: float, first: Array | None = None, gyro: float = 1.0, heading: float = 1.0) -> Array:
    """Mahony's filter, which compares readings with the attitude before the gyro's step."""
    q = hand.attitude_xyzw[0] if first is None else first
    found = [q]
    north = NORTH / np.linalg.norm(NORTH)
    for k in range(1, len(hand.t_s)):
        back = quaternion.conjugate(q)
        correction = np.cross(hand.up[k], quaternion.rotate(back, UP))
        correction += heading * np.cross(hand.north[k], quaternion.rotate(back, north))
        q = quaternion.multiply(q, quaternion.exp((gyro * hand.gyro[k] + gain * correction) / RATE))
        q = quaternion.normalize(q)
        found.append(q)
    return np.array(found)


def noisy(hand: Hand, seed: int) -> Array:
    """The truth with errors of half a second of memory, 1° RMS."""
    rng = np.random.default_rng([47, seed])
    error = rng.normal(size=(len(hand.t_s), 3))
    keep = np.exp(-1.0 / (0.5 * RATE))
    for k in range(1, len(error)):
        error[k] = keep * error[k - 1] + np.sqrt(1.0 - keep**2) * error[k]
    return quaternion.multiply(quaternion.exp(np.radians(0.6) * error), hand.attitude_xyzw)


def off(angle: float) -> Array:
    """A first attitude that is turned about the vertical, of a body that is level."""
    return quaternion.exp(angle * UP)


FILTERS: Final[dict[str, Callable[[Hand, int], Array]]] = {
    "noise": noisy,
    "Mahony": lambda hand, seed: mahony(hand, 1.0),
}
"""Estimates without a mistake."""
CONVERGING: Final[dict[str, Callable[[Hand, int], Array]]] = {
    "slow": lambda hand, seed: mahony(hand, 0.05, quaternion.multiply(off(1.5), hand.attitude_xyzw[0]), heading=1.0),
    "very slow": lambda hand, seed: mahony(
        hand, 0.02, quaternion.multiply(off(1.5), hand.attitude_xyzw[0]), heading=1.0
    ),
    "slow heading": lambda hand, seed: mahony(
        hand, 0.3, quaternion.multiply(off(1.5), hand.attitude_xyzw[0]), heading=0.05
    ),
}
"""Right filters that begin with a wrong heading and converge through the whole run."""
UNHEARD: Final[dict[str, Callable[[Hand, int], Array]]] = {
    "gyro in rad/s as deg/s": lambda hand, seed: mahony(hand, 1.0, gyro=np.pi / 180.0),
}
"""Filters that hear vectors alone: they are late by their time constant."""


@dataclass(frozen=True)
class Case:
    """An estimate beside an optical truth, and what is between them."""

    kind: str
    codes: frozenset[str]
    score: Score
    lag_s: float = 0.0


def constants(rng: np.random.Generator, codes: frozenset[str]) -> tuple[Array, Array, float]:
    """World, mounting and clock of the truth: rotation vectors, rad, and a lag of the estimate, s."""
    world = np.zeros(3)
    if "heading_offset" in codes:
        world = rng.choice([-1.0, 1.0]) * np.radians(rng.uniform(15.0, 170.0)) * UP
    if "world_turned" in codes:
        axis = np.array([*rng.normal(size=2), 0.3 * rng.normal()])
        world = np.radians(rng.uniform(20.0, 150.0)) * axis / np.linalg.norm(axis)
    axis = rng.normal(size=3)
    mounting = np.radians(rng.uniform(10.0, 170.0)) * axis / np.linalg.norm(axis) if "body_mounting" in codes else 0.0
    lag = float(np.exp(rng.uniform(np.log(0.05), np.log(10.0))) * rng.choice([-1.0, 1.0])) if "lag" in codes else 0.0
    return world, mounting * np.ones(3), lag


def beside(estimate: Array, hand: Hand, codes: frozenset[str], rng: np.random.Generator) -> tuple[Score, float]:
    """The score of an estimate beside a truth with a world, a mounting and a clock of its own."""
    world, mounting, lag_s = constants(rng, codes)
    stamps = np.round(hand.t_s * NS).astype(np.int64)
    every = np.arange(0.0, hand.t_s[-1], 1.0 / OPTICAL_RATE)
    optical_ns = np.round(every * NS).astype(np.int64)
    true = SampledTruth(stamps, hand.attitude_xyzw).at(optical_ns)
    true = quaternion.multiply(true, quaternion.exp(np.radians(0.1) * rng.normal(size=(len(true), 3))))
    true = quaternion.multiply(quaternion.multiply(quaternion.exp(-world), true), quaternion.exp(-mounting))
    return evaluate(stamps, estimate, SampledTruth(optical_ns - round(lag_s * NS), true)), lag_s


COMBINATIONS: Final = (
    (),
    ("lag",),
    ("heading_offset", "body_mounting"),
    ("heading_offset", "lag"),
    ("body_mounting", "lag"),
    ("heading_offset", "body_mounting", "lag"),
    ("world_turned", "body_mounting"),
    ("world_turned", "lag"),
    ("world_turned", "body_mounting", "lag"),
)


def cases(runs: int) -> Iterator[Case]:
    """Every combination of constants with every estimate."""
    for seed in range(runs):
        hand = moved(seed)
        for name, estimate in FILTERS.items():
            q = estimate(hand, seed)
            for number, codes in enumerate(COMBINATIONS):
                rng = np.random.default_rng([48, seed, number])
                score, lag_s = beside(q, hand, frozenset(codes), rng)
                yield Case(f"{name}: {' + '.join(codes) or 'nothing'}", frozenset(codes), score, lag_s)
        for name, estimate in {**CONVERGING, **UNHEARD}.items():
            q = estimate(hand, seed)
            score, _ = beside(q, hand, frozenset(), np.random.default_rng([49, seed]))
            yield Case(name, frozenset({"lag"} if name in UNHEARD else ()), score)


def told(case: Case) -> frozenset[str]:
    """Codes of the findings, a lag either way as one."""
    lag = {"lagging": "lag", "leading": "lag"}
    return frozenset(lag.get(finding.code, finding.code) for finding in case.score.findings if finding.code != "gaps")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--verbose", action="store_true")
    arguments = parser.parse_args()
    rows: dict[str, Counter[str]] = defaultdict(Counter)
    lags = list[float]()
    for case in cases(arguments.runs):
        found = told(case)
        right = found == case.codes
        rows[case.kind]["right" if right else " + ".join(sorted(found)) or "nothing"] += 1
        if right and case.lag_s and case.score.lag_s is not None:
            lags.append(abs(case.score.lag_s - case.lag_s))
        if arguments.verbose and not right:
            print(
                f"{case.kind} lag {case.lag_s:.3f}: {[f'{f.code}: {f.message}' for f in case.score.findings]}",
                flush=True,
            )
    for kind, counts in rows.items():
        print(f"{kind:<52}{sum(counts.values()):>4}  {', '.join(f'{name} {n}' for name, n in counts.most_common())}")
    whole = sum(rows.values(), Counter[str]())
    print(f"right {whole['right']} of {whole.total()}, silent {whole['nothing']}")
    if lags:
        print(f"error of the lag: median {1e3 * np.median(lags):.2f} ms, largest {1e3 * np.max(lags):.2f} ms")


if __name__ == "__main__":
    main()
