"""How much of its limit does each stepper's error use? Measured error over the certificate's limit, by method.

A ratio of 1 would be an honest bag refused, and one of 1/1000 a limit that lets forgeries through. Motions of every
kind are stepped for 20 to 600 s with steps of several lengths, and compared with the closed form, whose own error is
below 1e-15 rad. Samples are left out where a limit reaches its cap, as there a motion is no truth any more. Run it with

    python benchmarks/stepper_bounds.py [METHOD]...

which takes minutes, and much longer without numba.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.certificate.tolerance import ATTITUDE_CAP, ENERGY_CAP, READING, tolerance
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import METHODS
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import SampleClock

MOTIONS: Final[dict[str, tuple[list[float], list[float]]]] = {
    "dzhanibekov": ([1.0, 2.0, 3.0], [0.01, 1.0, 0.01]),
    "separatrix, 1e-2": ([1.3, 2.1, 2.9], [1e-2, 1.0, 1e-2]),
    "separatrix, 1e-4": ([1.3, 2.1, 2.9], [1e-4, 1.0, 1e-4]),
    "separatrix, 1e-6": ([1.3, 2.1, 2.9], [1e-6, 1.0, 1e-6]),
    "asymmetric": ([0.6, 0.8, 1.0], [3.0, 0.5, -0.9]),
    "symmetric": ([1.0, 1.0, 1.8], [0.4, 0.0, 2.0]),
    "about the equator": ([1.0, 1.0, 1.7], [0.5, 0.7, 1e-9]),
    "spherical": ([1.0, 1.0, 1.0], [0.3, -0.8, 1.1]),
    "nearly spherical": ([1.0, 1.0 + 1e-7, 1.0 + 3e-7], [0.5, 0.7, 0.1]),
    "flat": ([0.25, 0.5, 0.75], [1.5, 0.4, 0.8]),
    "slender": ([1e-3, 1.0, 1.0005], [0.5, 0.2, 0.1]),
    "products of inertia": ([1.4, -0.173205, 0.45, 1.2, -0.086603, 1.6], [1.0, 0.7, -0.4]),
    "slow": ([0.1542, 0.0012, -0.0008, 0.12, 0.0021, 0.0509], [0.035, -0.021, 0.031]),
    "fast": ([1.22e-3, 1.22e-3, 2.35e-3], [2.0, 0.0, 40.0]),
    "steady": ([0.6, 0.8, 1.0], [0.0, 0.0, 1.3]),
}
STEPS: Final = ((100.0, 1e-3), (70.0, 1e-3), (100.0, 1e-2), (20.0, 0.05))
"""Samples per second, of the truth or of an IMU, and the largest step, s."""
DURATIONS: Final = (20.0, 60.0, 200.0, 600.0)
"""s"""
SAMPLES: Final = 10_000
"""Largest number of samples of a run that are compared."""


class Ratio(NamedTuple):
    """Error over limit of one quantity in one run.

    Parameters
    ----------
    worst : float
        The largest of all samples.
    late : float
        The largest error over the limit at the end.
    """

    worst: float
    late: float


@dataclass(frozen=True)
class Run:
    """One motion by one stepper."""

    motion: str
    method: str
    rate: float
    max_step: float
    duration: float

    def scenario(self) -> Scenario:
        """The scenario, which is refused where the body turns too far in a step."""
        inertia, body_rate = MOTIONS[self.motion]
        return Scenario.from_parameters(
            {
                "inertia": inertia,
                "initial_body_rate": body_rate,
                "motion": "moving_chart",
                "method": self.method,
                "rate": self.rate,
                "max_step": self.max_step,
            }
        )

    def ratios(self) -> dict[str, Ratio]:
        """The ratios of each quantity whose limit is not its cap all the time."""
        scenario = self.scenario()
        count = int(self.duration * self.rate)
        t_ns = SampleClock(0, self.rate).stamps_ns(0, count + 1)
        ends = np.unique(np.linspace(1, count, min(count, SAMPLES)).astype(np.int64))
        try:
            found, motion = scenario.make_motion().at(t_ns), scenario.exact_motion()
        except InputError:  # the steps lead to infinity
            return {}
        states, before = (_rows(found, ends - k) for k in (0, 1))
        exact, exact_before = (motion.at(t_ns[ends - k]) for k in (0, 1))
        t, spans = (np.asarray(1e-9 * ns, dtype=np.float64) for ns in (t_ns[ends], t_ns[ends] - t_ns[ends - 1]))
        limits = tolerance(scenario, self.duration)
        body, start = scenario.body(), scenario.start()
        momentum, energy = body.angular_momentum(start), float(body.kinetic_energy(start))
        turned = np.abs(body.angular_momentum(states) - momentum).max(axis=1) / so3.norm(momentum)
        rate_cap, mean = ATTITUDE_CAP * limits.fastest, _mean_rate(before, states, spans)
        rate_limit = READING * so3.norm(exact.body_rate) + limits.stepper_rate(t)
        mean_limit = READING * (limits.fastest + 2.0 * self.rate) + limits.stepper_mean_rate(t, 1.0 / self.rate)
        compared = {
            "attitude": (_angle(exact, states), limits.attitude(t), ATTITUDE_CAP),
            "rate": (so3.norm(states.body_rate - exact.body_rate), rate_limit, rate_cap),
            "mean rate": (
                so3.norm(np.asarray(mean - _mean_rate(exact_before, exact, spans))),
                mean_limit,
                math.inf if rate_limit.max() < rate_cap else 0.0,
            ),
            "momentum": (turned, limits.world_momentum(t), ENERGY_CAP),
            "energy": (np.abs(body.kinetic_energy(states) / energy - 1.0), limits.energy(t), ENERGY_CAP),
        }
        return {name: _ratio(*three) for name, three in compared.items() if three[1][0] < three[2]}


def _rows(states: State, rows: Integers) -> State:
    return State.trusted(states.attitude_xyzw[rows], states.body_rate[rows])


def _angle(one: State, other: State) -> Array:
    turn = quaternion.multiply(quaternion.conjugate(one.attitude_xyzw), other.attitude_xyzw)
    return np.asarray(so3.norm(quaternion.log(turn)))


def _mean_rate(before: State, after: State, spans: Array) -> Array:
    turn = quaternion.multiply(quaternion.conjugate(before.attitude_xyzw), after.attitude_xyzw)
    return np.asarray(quaternion.log(turn) / spans[:, np.newaxis])


def _ratio(errors: Array, limits: Array, cap: float) -> Ratio:
    below = limits < cap
    return Ratio(float((errors / limits)[below].max()), float(errors[below].max() / limits[below][-1]))


def runs(methods: list[str]) -> Iterator[Run]:
    """Every run of these methods whose scenario is possible; those of first order only up to a minute."""
    for method in methods:
        for motion in MOTIONS:
            for rate, max_step in STEPS:
                for duration in DURATIONS if METHODS[method].order > 1 else DURATIONS[:2]:
                    run = Run(motion, method, rate, max_step, duration)
                    try:
                        run.scenario()
                    except ValueError:
                        continue
                    yield run


def main() -> None:
    """Print the largest ratio and the median of the late ones, by method and quantity."""
    names = ("attitude", "rate", "mean rate", "momentum", "energy")
    print(f"{'largest, median':<16}" + "".join(f"{name:>20}" for name in names))
    for method in sys.argv[1:] or METHODS:
        found = [run.ratios() for run in runs([method])]
        cells = []
        for name in names:
            ratios = [one[name] for one in found if name in one]
            late = float(np.median([ratio.late for ratio in ratios]))
            cells.append(f"{max(ratio.worst for ratio in ratios):>11.2f}, {late:7.4f}")
        print(f"{method:<16}" + "".join(cells), flush=True)


if __name__ == "__main__":
    main()
