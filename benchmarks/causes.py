"""How often the score of an estimate names its cause: the confusion matrix of causes, on 2 400 cases.

    python benchmarks/causes.py             all cases, in minutes
    python benchmarks/causes.py --sample    every tenth
    python benchmarks/causes.py --first 2400    as many others: the rule was made on those before

A case is a motion, sensors of a grade, a right filter or the truth with errors of its own, and no, one or two mistakes.
It is fair where each mistake moves the estimate by at least four times of what the filter errs without it, and by more
than the declared errors of the sensors leave. A name is right where it is that of the mistake, or where the message
says that the motion does not tell it from that, or where no more causes leave no more than undoing the mistakes does:
of a spin several are the same map.
"""

from __future__ import annotations

import argparse
import os
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import permutations
from multiprocessing import get_context
from typing import Any, Final

import numpy as np
from tqdm import tqdm

from lie_rigid_body import Run, simulate
from lie_rigid_body.evaluation import SampledTruth
from lie_rigid_body.evaluation.attitudes import angles_between
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.scoring import SensorLimits, score_estimate
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.runs.bound import left_by_errors_of

Array = np.ndarray[Any, Any]

SAMPLES: Final = 1000
"""Samples of a run."""
CASES: Final = 2400
MOTIONS: Final[dict[str, tuple[dict[str, Any], float]]] = {
    "asymmetric_top": ({}, 50.0),
    "dzhanibekov": ({}, 25.0),
    "flat_plate": ({}, 25.0),
    "off_axis_wheel": ({}, 25.0),
    "prolate_top": ({}, 50.0),
    "slow_dzhanibekov": ({}, 25.0),
    "spherical_top": ({}, 25.0),
    "symmetric_top": ({}, 25.0),
    "thrown_disc": ({}, 500.0),
    "tossed_phone": ({}, 200.0),
    "tumbling_cubesat": ({}, 20.0),
    "tumbling_cubesat, faster": ({"initial_body_rate": [0.4, 0.6, -0.3]}, 25.0),
}
"""Scenarios, each with parameters and readings a second."""
GRADES: Final = ("perfect", "tactical", "mems")
UP: Final = np.array([0.0, 0.0, 1.0])
NED: Final = np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0])
FRD: Final = np.array([1.0, 0.0, 0.0, 0.0])
CONVENTIONS: Final[dict[str, Callable[[Array], Array]]] = {
    "inverted": quaternion.conjugate,
    "scalar_first": lambda q: np.roll(q, 1, axis=-1),
    "ned_world": lambda q: quaternion.multiply(NED, q),
    "ned_world, frd": lambda q: quaternion.multiply(quaternion.multiply(NED, q), FRD),
}
CONSTANTS: Final = ("heading_offset", "body_mounting", "world_turned", "lagging", "leading")
NO_REPAIR: Final = ("clock_rate", "stuck", "mixed", "turn_rate", "turn_axes", "gaps", "not_unit")
PAIRS: Final = (  # in the order in which they are made
    ("scalar_first", "inverted"),
    ("ned_world", "inverted"),
    ("ned_world", "scalar_first"),
    *((constant, convention) for convention in CONVENTIONS for constant in ("heading_offset", "body_mounting")),
    *((lag, convention) for convention in ("inverted", "scalar_first", "ned_world") for lag in ("lagging", "leading")),
    ("heading_offset", "body_mounting"),
    ("lagging", "heading_offset"),
    ("leading", "heading_offset"),
    ("lagging", "body_mounting"),
)
HONEST: Final = ("white", "correlated", "drift", "heading drift", "random walk", "heading walk", "convergence", "bias")
"""Errors without a cause, beside those of right filters."""
KINDS: Final[tuple[tuple[str, ...], ...]] = (
    *((code,) for code in (*CONVENTIONS, *CONSTANTS, *NO_REPAIR)),
    *PAIRS,
    *((error,) for error in HONEST),
    *((f"right {i}",) for i in range(12)),
)


@dataclass(frozen=True)
class Case:
    """A case by number; everything of it follows from that.

    Attributes
    ----------
    number : int
    """

    number: int

    @property
    def kind(self) -> tuple[str, ...]:
        """Mistakes, or the error."""
        return KINDS[self.number % len(KINDS)]

    @property
    def codes(self) -> frozenset[str]:
        """What may be named; empty where nothing is wrong."""
        known = {*CONVENTIONS, *CONSTANTS, *NO_REPAIR}
        return frozenset(name.split(",")[0] for name in self.kind if name in known)

    @property
    def is_far(self) -> bool:
        """Whether a lag is far; every other one that is the only mistake."""
        return len(self.kind) == 1 and self.number // len(KINDS) % 2 == 1

    def rng(self) -> np.random.Generator:
        """Random numbers of this case alone."""
        return np.random.default_rng([25, self.number])


def given(motion: str, grade: str, seed: int) -> Run:
    """The run of a motion with sensors of a grade."""
    parameters, rate = MOTIONS[motion]
    first = quaternion.normalize(np.random.default_rng([7, seed, len(motion)]).normal(size=4))
    return simulate(
        motion.split(",")[0],
        sensor_grade=grade,
        sensor_seed=seed,
        duration=SAMPLES / rate,
        imu_rate=rate,
        rate=rate,
        magnetometer_rate=rate,
        accelerometer_mode="pivot_gravity",
        gyro_rate="integrated",
        initial_attitude_xyzw=first.tolist(),
        **parameters,
    )


@dataclass(frozen=True)
class Readings:
    """Readings of a run, and its truth; N = `SAMPLES`.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    step_s : float
    gyro, up, field : ndarray, shape (N, 3)
        rad/s, and unit vectors on the axes of the body.
    north : ndarray, shape (3,)
        The unit vector of the field in the world.
    truth_xyzw : ndarray, shape (N, 4)
    truth : SampledTruth
    left : float
        Largest turn that the constant errors of the sensors leave to a filter, rad.
    """

    stamps_ns: Array
    step_s: float
    gyro: Array
    up: Array
    field: Array
    north: Array
    truth_xyzw: Array
    truth: SampledTruth
    left: float


@cache
def readings(motion: str, grade: str, seed: int) -> Readings:
    """Readings of a run."""
    run = given(motion, grade, seed)
    imu, magnetometer, model = run.imu, run.magnetometer, run.scenario.sensors.magnetometer
    assert imu is not None
    assert magnetometer is not None
    assert model is not None
    step_ns = int(1e9 / MOTIONS[motion][1])
    fine = np.arange(4 * SAMPLES - 3) * (step_ns // 4)
    unit = [v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (imu.specific_force, magnetometer.field)]
    north = np.array(model.field) / np.linalg.norm(model.field)
    truth = SampledTruth(fine, run.attitude().at(fine))
    true = truth.at(imu.t_ns)
    return Readings(
        imu.t_ns, step_ns / 1e9, imu.gyro, unit[0], unit[1], north, true, truth, left_by_errors_of(run.segments)
    )


def mahony(r: Together, gyro: Array, gain: float, *, bias: float = 0.0, ahead: bool = False) -> Array:
    """Mahony's filter; `ahead` by up to a sample where it corrects before it turns, as textbooks do."""
    q, b, h = r.truth_xyzw[:, 0], np.zeros((len(gyro), 3)), r.step_s
    found = [q]
    for k in range(1, SAMPLES):
        turn = quaternion.exp((gyro[:, k] - b) * h)
        turned = q if ahead else quaternion.multiply(q, turn)
        back = quaternion.conjugate(turned)
        error = np.cross(r.up[:, k], quaternion.rotate(back, UP)) + np.cross(
            r.field[:, k], quaternion.rotate(back, r.north)
        )
        b = b - bias * error * h
        step = (gyro[:, k] - b + gain * error) * h if ahead else gain * error * h
        q = quaternion.normalize(quaternion.multiply(turned, quaternion.exp(step)))
        found.append(q)
    return np.stack(found, axis=1)


def mekf(r: Together, gyro: Array, noise: float) -> Array:
    """A multiplicative extended Kalman filter of attitude and gyro bias."""
    q, b, h = r.truth_xyzw[:, 0], np.zeros((len(gyro), 3)), r.step_s
    P = np.tile(np.diag([0.01] * 3 + [1e-3] * 3), (len(gyro), 1, 1))
    Q = h[..., np.newaxis] * np.diag([1e-4] * 3 + [1e-6] * 3)
    found = [q]
    for k in range(1, SAMPLES):
        turn = quaternion.exp((gyro[:, k] - b) * h)
        q = quaternion.multiply(q, turn)
        F = np.tile(np.eye(6), (len(gyro), 1, 1))
        F[:, :3, :3] = np.swapaxes(quaternion.to_matrix(turn), 1, 2)
        F[:, :3, 3:] = -h[..., np.newaxis] * np.eye(3)
        P = F @ P @ np.swapaxes(F, 1, 2) + Q
        back = quaternion.conjugate(q)
        known = np.concatenate([quaternion.rotate(back, UP), quaternion.rotate(back, r.north)], axis=1)
        H = np.zeros((len(gyro), 6, 6))
        H[:, :3, :3], H[:, 3:, :3] = so3.hat(known[:, :3]), so3.hat(known[:, 3:])
        PH = P @ np.swapaxes(H, 1, 2)
        K = PH @ np.linalg.inv(H @ PH + noise**2 * np.eye(6))
        read = np.concatenate([r.up[:, k], r.field[:, k]], axis=1)
        dx = np.einsum("bij,bj->bi", K, read - known)
        P = (np.eye(6) - K @ H) @ P
        q, b = quaternion.normalize(quaternion.multiply(q, quaternion.exp(dx[:, :3]))), b + dx[:, 3:]
        found.append(q)
    return np.stack(found, axis=1)


def integrated(r: Readings, gyro: Array) -> Array:
    """The gyro's turns from the true attitude; each round doubles the number of factors."""
    found, factors = np.concatenate([r.truth_xyzw[:1], quaternion.exp(gyro[1:] * r.step_s)]), 1
    while factors < len(found):
        found[factors:] = quaternion.multiply(found[:-factors], found[factors:])
        factors *= 2
    return quaternion.normalize(found)


@dataclass(frozen=True)
class Together:
    """Readings of all runs side by side: shapes (runs, N, 3), and (runs, 1) of the step."""

    step_s: Array
    gyro: Array
    up: Array
    field: Array
    north: Array
    truth_xyzw: Array
    bias: Array


@cache
def everything() -> dict[str, Array]:
    """The attitudes of every filter on every run, (runs, N, 4), in the order of `RUNS`."""
    each = [readings(*run) for run in RUNS]
    names = ("gyro", "up", "field", "north", "truth_xyzw")
    stacked = {name: np.stack([getattr(r, name) for r in each]) for name in names}
    rng = np.random.default_rng(5)
    bias = rng.normal(size=(len(RUNS), 1, 3)) * np.radians(10.0 ** rng.uniform(-2.0, 0.0, (len(RUNS), 1, 1)))
    r = Together(step_s=np.array([[one.step_s] for one in each]), bias=bias, **stacked)
    return {name: run(r) for name, run in FILTERS.items()}


FILTERS: Final[dict[str, Callable[[Together], Array]]] = {
    "Mahony": lambda r: mahony(r, r.gyro, 1.0),
    "Mahony with bias": lambda r: mahony(r, r.gyro, 1.0, bias=0.1),
    "Mahony of a textbook": lambda r: mahony(r, r.gyro, 0.5, bias=0.05, ahead=True),
    "MEKF": lambda r: mekf(r, r.gyro, 0.02),
    "biased": lambda r: mahony(r, r.gyro + r.bias, 0.2),
}
"""Filters; the last has a gyro with a bias that it does not know."""
RIGHT: Final = tuple(FILTERS)[:-1]
SEEDS: Final = 3
RUNS: Final = tuple((motion, grade, seed) for motion in MOTIONS for grade in GRADES for seed in range(SEEDS))


def filtered(name: str, motion: str, grade: str, seed: int) -> Array:
    """The attitudes of a filter."""
    return everything()[name][RUNS.index((motion, grade, seed))]


def honest(name: str, r: Readings, rng: np.random.Generator) -> Array:
    """The truth with errors that have no cause."""
    count, time_s = len(r.stamps_ns), r.stamps_ns / 1e9
    size = np.radians(10.0 ** rng.uniform(-1.0, 1.2))
    white, share = rng.normal(size=(count, 3)), np.linspace(0.0, 1.0, count)[:, np.newaxis]
    walk = np.cumsum(white, axis=0) / np.sqrt(count)
    noise = 0.03 * size * rng.normal(size=(count, 3))
    if name == "correlated":
        memory = np.exp(-1.0 / rng.uniform(3.0, 100.0))
        for k in range(1, count):
            white[k] = memory * white[k - 1] + np.sqrt(1.0 - memory**2) * white[k]
    direction = rng.normal(size=3)
    errors = {
        "white": white,
        "correlated": white,
        "drift": share * direction,
        "heading drift": share * UP,
        "random walk": walk,
        "heading walk": walk * UP,
        "convergence": np.exp(-time_s / (time_s[-1] * rng.uniform(0.02, 0.12)))[:, np.newaxis] * direction * 5.0,
    }
    turn = quaternion.exp(size * errors[name] + noise)
    on_world = name.startswith("heading") or rng.random() < 0.5
    return quaternion.multiply(turn, r.truth_xyzw) if on_world else quaternion.multiply(r.truth_xyzw, turn)


def wrong(
    code: str, r: Readings, stamps: Array, q: Array, rng: np.random.Generator, *, far: bool = False
) -> tuple[Array, Array]:
    """Stamps and attitudes with one mistake; a lag is of some samples, or of a tenth of the run or more."""
    sign = 1.0 if rng.random() < 0.5 else -1.0
    if code in CONVENTIONS:
        return stamps, CONVENTIONS[code](q)
    if code == "heading_offset":
        angle = np.radians(sign * rng.choice([4.09, 90.0, rng.uniform(8.0, 179.0), rng.uniform(8.0, 179.0)]))
        return stamps, quaternion.multiply(quaternion.exp(angle * UP), q)
    if code == "body_mounting":
        axis = quaternion.normalize(np.append(rng.normal(size=3), 0.0))[:3]
        size = np.radians(rng.uniform(8.0, 160.0))
        right = np.eye(3)[rng.integers(3)] * np.pi / 2.0 * sign
        return stamps, quaternion.multiply(q, quaternion.exp(right if rng.random() < 0.3 else size * axis))
    if code == "world_turned":
        angle, size = rng.uniform(0.0, 2.0 * np.pi), np.radians(rng.uniform(20.0, 160.0))
        axis = np.array([np.cos(angle), np.sin(angle), rng.normal() * 0.3])
        return stamps, quaternion.multiply(quaternion.exp(size * axis / np.linalg.norm(axis)), q)
    if code in {"lagging", "leading"}:
        count = int(rng.choice([100, 150, 200, 300, 400] if far else [2, 3, 5, 10, 20]))
        if code == "lagging":
            return stamps[count:], q[: len(q) - count]
        return stamps[: len(stamps) - count], q[count:]
    if code == "clock_rate":
        rate = float(rng.choice([0.1, 0.5, 0.9, 0.97, 1.03, 1.1, 1.25, 2.0, 10.0]))
        return np.round(stamps * rate).astype(np.int64), q
    if code == "stuck":
        k = 0 if rng.random() < 0.5 else int(rng.uniform(0.3, 0.7) * len(q))
        return stamps, np.where(np.arange(len(q))[:, np.newaxis] < k, q, q[k])
    if code == "mixed":
        other = quaternion.multiply(q[::-1], quaternion.exp(rng.normal(size=3)))
        return stamps, np.where(np.arange(len(q))[:, np.newaxis] % int(rng.integers(2, 5)) == 0, other, q)
    if code == "gaps":
        k = int(rng.uniform(0.3, 0.7) * len(q))
        kept = np.delete(np.arange(len(q)), slice(k, k + int(rng.integers(5, 80))))
        return stamps[kept], q[kept]
    if code == "not_unit":
        return stamps, q * float(rng.choice([0.5, 0.98, 1.01, 1.1]))
    raise ValueError(code)


def of_gyro(code: str, r: Readings, rng: np.random.Generator) -> Array:
    """A gyro that is integrated, of another unit or on other axes."""
    if code == "turn_rate":
        return integrated(r, r.gyro * float(rng.choice([180.0 / np.pi, np.pi / 180.0, 2.0, 0.5])))
    order = list(permutations(range(3)))[rng.integers(6)]
    signs = np.where(rng.random(3) < 0.5, 1.0, -1.0)
    if order == (0, 1, 2) and signs.min() > 0.0:
        signs[rng.integers(3)] = -1.0
    return integrated(r, r.gyro[:, list(order)] * signs)


@dataclass(frozen=True)
class Result:
    """What became of a case.

    Attributes
    ----------
    number : int
    put, told : tuple of str
    fair, named_or : bool
        Whether the mistakes outweigh the errors, and whether the message says what is put in beside the name.
    seconds : float
    where : str
    message : str
    """

    number: int
    put: tuple[str, ...]
    told: tuple[str, ...]
    fair: bool
    right: bool
    seconds: float
    where: str
    message: str


def prepared(case: Case) -> tuple[Readings, Array, Array, bool, str, float]:
    """Readings, stamps and attitudes of a case, whether it is fair, where it is, and the error without, degrees."""
    rng = case.rng()
    motion, grade = str(rng.choice(list(MOTIONS))), str(rng.choice(GRADES))
    seed, name = int(rng.integers(SEEDS)), str(rng.choice([*RIGHT, "truth"]))
    is_right = case.kind[0].startswith("right")
    name = RIGHT[case.number // len(KINDS) % len(RIGHT)] if is_right else name
    r, where = readings(motion, grade, seed), f"{motion}, {grade}, seed {seed}, {name}"
    if not case.codes:
        own = name if is_right else "biased" if case.kind[0] == "bias" else None
        attitude = honest(case.kind[0], r, rng) if own is None else filtered(own, motion, grade, seed)
        return r, r.stamps_ns, attitude, True, where, 0.0
    if case.kind[0] in {"turn_rate", "turn_axes"}:
        q, right = of_gyro(case.kind[0], r, rng), integrated(r, r.gyro)
        drift = float(np.median(angles_between(right, r.truth_xyzw)))
        moved = float(np.median(angles_between(q, right)))
        return r, r.stamps_ns, q, moved > max(4.0 * drift, 0.5), where, 0.0
    if name == "truth":
        noise = np.radians(10.0 ** rng.uniform(-2.0, 0.3)) * rng.normal(size=(len(r.stamps_ns), 3))
        right = quaternion.multiply(r.truth_xyzw, quaternion.exp(noise))
    else:
        right = filtered(name, motion, grade, seed)
    stamps, q = r.stamps_ns, right
    error, fair = angles_between(right, r.truth_xyzw), True
    settled = float(np.sqrt(np.mean(error[len(error) // 4 :] ** 2)))
    for code in case.kind:
        before, old = q, stamps
        stamps, q = wrong(code, r, stamps, q, rng, far=case.is_far)
        if code not in {"gaps", "not_unit"}:
            shared = np.isin(stamps, old)
            if code == "clock_rate":
                shared = stamps <= old[-1]
                was = SampledTruth(old, before).at(stamps[shared])
            else:
                was = before[np.isin(old, stamps)]
            least = max(4.0 * settled, r.left)
            fair &= bool(np.median(angles_between(q[shared], was)) > least) and settled < np.radians(20.0)
    return r, stamps, q, fair, where, float(np.degrees(np.sqrt(np.mean(error**2))))


def judged(number: int) -> Result:
    """Score a case."""
    case = Case(number)
    r, stamps, q, fair, where, without_deg = prepared(case)
    begin = time.process_time()
    findings = score_estimate(Estimate(q, stamps), r.truth, sensors=SensorLimits(left_rad=r.left)).findings
    seconds = time.process_time() - begin
    told = [f.code for f in findings]
    if "gaps" not in case.codes:  # stamps that are wrong lie outside of the truth
        told = [code for code in told if code != "gaps"]
    right = set(told) == case.codes
    if not right and len(told) == len(case.codes) > 0:
        doubts = " ".join(f.message.partition("does not tell it from")[2] for f in findings)
        lag = {"lagging": "lag", "leading": "lag"}
        right = all(lag.get(c, c.replace("_", " ")) in doubts for c in case.codes - set(told))
    if not right and 0 < len(told) <= len(case.codes):
        left = [f.rms_deg_after for f in findings if f.code in told]
        right = min(left) <= 1.1 * without_deg
    return Result(
        number,
        case.kind,
        tuple(told),
        fair,
        right,
        seconds,
        where,
        " | ".join(f"{f.code}: {f.message}" for f in findings),
    )


def matrix(results: Sequence[Result]) -> list[str]:
    """Lines of the confusion matrix: what was put in, and how often what was told."""
    rows: dict[str, Counter[str]] = defaultdict(Counter)
    for result in results:
        put = " + ".join(result.put)
        put = "right filter" if put.startswith("right") else put
        rows[put]["right" if result.right else " + ".join(result.told) or "nothing"] += 1
    lines = []
    for put, told in rows.items():
        parts = ", ".join(f"{name} {count}" for name, count in told.most_common())
        lines.append(f"{put:<32}{sum(told.values()):>4}  {parts}")
    return lines


def summary(results: Sequence[Result]) -> list[str]:
    """Counts: right, wrong names, silent; healthy ones that were named."""
    mistakes = [r for r in results if Case(r.number).codes and r.fair]
    none = [r for r in results if not Case(r.number).codes]
    right = sum(r.right for r in mistakes)
    silent = sum(not r.told for r in mistakes)
    wrong_names = [r for r in mistakes if r.told and not r.right]
    named = [r for r in none if r.told]
    healthy = [r for r in none if r.put[0].startswith("right")]
    total = len(mistakes) + len(none)
    hidden = [r for r in results if Case(r.number).codes and not r.fair]
    hidden_wrong = sum(not set(r.told) <= Case(r.number).codes and not r.right for r in hidden)
    partly = sum(set(r.told) < Case(r.number).codes for r in wrong_names)
    return [
        f"fair mistakes {len(mistakes)}: right {right} ({right / len(mistakes):.1%}), silent {silent}, "
        f"other names {len(wrong_names)} ({len(wrong_names) / len(mistakes):.1%}), of these one of two {partly}",
        f"no cause {len(none)}: named {len(named)}; of {len(healthy)} right filters "
        f"{sum(bool(r.told) for r in healthy)}",
        f"all {total}: right {(right + len(none) - len(named)) / total:.2%}, "
        f"wrong names {(len(wrong_names) + len(named)) / total:.2%}",
        f"mistakes that other errors hide {len(hidden)}: a wrong name {hidden_wrong}",
        f"CPU s a case: median {np.median([r.seconds for r in results]):.3f}, "
        f"largest {max(r.seconds for r in results):.2f}",
    ]


def main() -> None:
    """Print the matrix, the counts, and each case that was not right."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", action="store_true", help="every tenth case")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--verbose", action="store_true", help="print each case that was not right")
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1))
    arguments = parser.parse_args()
    numbers = range(arguments.first, arguments.first + arguments.cases, 10 if arguments.sample else arguments.every)
    everything()  # before the workers begin, who have it then
    with ProcessPoolExecutor(arguments.workers, mp_context=get_context("fork")) as pool:
        results = list(tqdm(pool.map(judged, numbers, chunksize=8), total=len(numbers), disable=None))
    fair = [r for r in results if r.fair]
    print("\n".join([*matrix(fair), "", *summary(results)]))
    if arguments.verbose:
        for r in results:
            if not r.right and (r.fair or r.told):
                told = "+".join(r.told) or "nothing"
                print(f"#{r.number} {'+'.join(r.put)} -> {told}{'' if r.fair else ' (hidden)'}: {r.where}")
                print("    " + r.message)


if __name__ == "__main__":
    main()
