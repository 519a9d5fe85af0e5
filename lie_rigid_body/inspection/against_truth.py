"""Clock and mounting of a truth, and the gyro's factor and bias against it.

Rotations of the body over short times, log(q(t)⁻¹ q(t + w)), do not depend on the world of a truth. Those of its body
are those that the gyro integrates, times a rotation of the axes and a factor, less the bias times w.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from lie_rigid_body.evaluation import Truth
from lie_rigid_body.evaluation.attitudes import angle_and_axis, places, relative_rotations
from lie_rigid_body.evaluation.matched import Matched, lags_of_rates, spread
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.inspection.findings import Findings
from lie_rigid_body.inspection.rule import (
    CHUNKS,
    DEGREE,
    GYRO_HZ,
    MAX_TRUTH_MISFIT,
    MAX_TRUTH_STEPS,
    MIN_DELAY_S,
    MIN_LOG_FACTOR,
    MIN_TRUTH_MOUNTING,
    SIGMAS,
    TRUTH_STEP,
)
from lie_rigid_body.inspection.stamps import Stream
from lie_rigid_body.inspection.world import attitudes
from lie_rigid_body.lie import quaternion, so3

LONGEST_S: Final = 10.0
"""Largest difference of the clocks that is looked for, s."""
_UNITS: Final = tuple(sign * unit for unit in (1.0, DEGREE, 1.0 / DEGREE) for sign in (1.0, -1.0))
"""Multipliers of the gyro's readings with which a fit begins."""


class AgainstTruth(NamedTuple):
    """Gyro against a truth.

    Attributes
    ----------
    late_s : float
        Time from when attitudes were true to their stamps, s.
    mounting_xyzw : ndarray, shape (4,)
        From the gyro's axes to those of the truth's body.
    factor : float
        By which the gyro's readings are multiplied.
    misfit : float
        RMS of what remains of the rotations, over their RMS.
    """

    late_s: float
    mounting_xyzw: Array
    factor: float
    misfit: float


class _Steps(NamedTuple):
    """Rotations of the gyro over short times, rad, and the stamps at their ends, ns, shape (2, K)."""

    ends_ns: Integers
    rotations: Array
    truth: Truth

    def true_rotations(self, late_s: float) -> tuple[Array, Booleans]:
        """Rotations of the truth's body at some delay of its clock, and where the truth is known."""
        stamps = self.ends_ns + round(late_s * NS)
        known = self.truth.covers(stamps).all(axis=0)
        inside = np.clip(stamps, self.truth.first_ns, self.truth.last_ns)
        return relative_rotations(*self.truth.at(inside)), known

    def fitted(self, late_s: float) -> AgainstTruth:
        """Least squares of mounting, factor and bias at a delay."""
        true, known = self.true_rotations(late_s)
        if np.count_nonzero(known) < CHUNKS:
            return AgainstTruth(late_s, np.array([0.0, 0.0, 0.0, 1.0]), 1.0, np.inf)
        true = true[known] - true[known].mean(axis=0)
        own = self.rotations[known] - self.rotations[known].mean(axis=0)
        mounting, _ = Rotation.align_vectors(true, own)
        turned = mounting.apply(own)
        factor = float(np.sum(turned * true) / np.sum(own * own))
        misfit = float(np.sqrt(np.sum((true - factor * turned) ** 2) / np.sum(true**2)))
        return AgainstTruth(late_s, mounting.as_quat(), factor, misfit)

    def best_near(self, late_s: float, reach_s: float) -> AgainstTruth:
        """The best fit at delays up to a distance, s."""
        found = minimize_scalar(
            lambda late: self.fitted(late).misfit,
            bounds=(late_s - reach_s, late_s + reach_s),
            method="bounded",
            options={"xatol": 1e-5},
        )
        return self.fitted(float(found.x))

    def standard_errors(self, found: AgainstTruth) -> Array:
        """Standard errors of delay, s, mounting, rad, and factor, shape (5,): a jackknife of successive parts."""
        sides = [self.true_rotations(found.late_s + shift) for shift in (-MIN_DELAY_S, 0.0, MIN_DELAY_S)]
        known = np.all([is_known for _, is_known in sides], axis=0)
        before, true, after = (rotations[known] for rotations, _ in sides)
        turned = quaternion.rotate(found.mounting_xyzw, self.rotations[known])
        by_delay = (after - before) / (2.0 * MIN_DELAY_S)
        identity = np.broadcast_to(np.eye(3), (len(true), 3, 3))
        J = np.concatenate(
            [
                -by_delay[..., np.newaxis],
                -found.factor * so3.hat(turned),
                turned[..., np.newaxis],
                identity,
            ],
            axis=2,
        )
        error = true - found.factor * turned
        rows = np.array_split(np.arange(len(J)), CHUNKS)
        normal = np.array([np.einsum("kij,kil->jl", J[part], J[part]) for part in rows])
        right = np.array([np.einsum("kij,ki->j", J[part], error[part]) for part in rows])
        without = np.linalg.solve(normal.sum(axis=0) - normal, (right.sum(axis=0) - right)[..., np.newaxis])[..., 0]
        return np.asarray(np.sqrt((CHUNKS - 1.0) * np.var(without, axis=0))[:5])


def _steps(gyro: Stream, factor: float, truth: Truth) -> tuple[_Steps, Matched]:
    begin_ns = int(gyro.t_ns[0])
    t_s, rate = gyro.averaged(GYRO_HZ, begin_ns)
    attitude = attitudes(t_s, rate * factor)
    stamps = begin_ns + np.round(t_s * NS).astype(np.int64)
    fast = max(float(np.quantile(np.linalg.norm(rate * factor, axis=1), 0.95)), 1e-9)
    width = int(np.clip(TRUTH_STEP / fast / np.median(np.diff(t_s)), 1, len(t_s) // 4))
    first = spread(len(t_s) - width, MAX_TRUTH_STEPS)
    ends = np.stack([first, first + width])
    return _Steps(stamps[ends], relative_rotations(*attitude[ends]), truth), Matched(stamps, attitude, truth)


def compare_with_truth(gyro: Stream, truth: Truth) -> tuple[AgainstTruth, AgainstTruth]:
    """Fit clock, mounting and factor, and their standard errors.

    Parameters
    ----------
    gyro : Stream
        Readings, rad/s, or in another unit.
    truth : Truth

    Returns
    -------
    tuple of AgainstTruth
        The fit, and standard errors: of the delay, s, of the mounting as a rotation vector, rad, of the factor, and 0.
    """
    best = []
    for unit in _UNITS:
        steps, track = _steps(gyro, unit, truth)
        reach_s = (steps.ends_ns[1, 0] - steps.ends_ns[0, 0]) / NS
        for lag_s in (0.0, *lags_of_rates(track, LONGEST_S)[:3]):
            found = steps.best_near(-lag_s, reach_s)
            best.append((found, unit, steps))
    found, unit, steps = min(best, key=lambda each: each[0].misfit)
    late_s, *turn, factor = steps.standard_errors(found)
    return found._replace(factor=unit * found.factor), AgainstTruth(late_s, np.array(turn), unit * factor, 0.0)


def report_truth(found: Findings, gyro: Stream, truth: Truth) -> AgainstTruth | None:
    """Report the clock and the mounting of a truth, and the gyro's factor where the other sensors do not show it.

    Parameters
    ----------
    found : Findings
    gyro : Stream
        Readings whose mistakes are undone, rad/s.
    truth : Truth

    Returns
    -------
    AgainstTruth or None
        The fit; None where the truth is not that of the gyro.
    """
    fit, sigma = compare_with_truth(gyro, truth)
    if fit.misfit > MAX_TRUTH_MISFIT:
        why = f"by no clock and mounting the truth rotates as the gyro does: {fit.misfit:.0%} of its rotations remain"
        found.ask("truth_late", why)
        found.ask("truth_mounting", why)
        return None
    _report_factor(found, fit.factor, sigma.factor)
    text = f"the truth is {fit.late_s * 1e3:.4g} ms late against the gyro, ± {sigma.late_s * 1e3:.1g} ms"
    if abs(fit.late_s) > max(MIN_DELAY_S, SIGMAS * sigma.late_s):
        found.name("truth_late", "truth", text, f"{-fit.late_s:+.4f} s")
    else:
        found.note("truth_late", text, fit.late_s)
    angle = float(np.linalg.norm(quaternion.log(fit.mounting_xyzw)))
    turn = angle_and_axis(fit.mounting_xyzw)
    error = float(np.linalg.norm(sigma.mounting_xyzw))
    text = f"the axes of the truth's body are those of the gyro rotated by {turn}, ± {np.degrees(error):.1g}°"
    if angle > max(MIN_TRUTH_MOUNTING, SIGMAS * error):
        found.name("truth_mounting", "truth", text + places(fit.mounting_xyzw), turn)
    else:
        found.note("truth_mounting", text, np.degrees(angle))
    return fit


def _report_factor(found: Findings, factor: float, sigma: float) -> None:
    if factor < 0.0:
        found.name("gyro_axes", "gyro", "the gyro has the opposite sign of the truth's rotations", "-x -y -z")
    unit = next((unit for unit in (DEGREE, 1.0 / DEGREE) if abs(np.log(abs(factor) / unit)) < MIN_LOG_FACTOR), 1.0)
    if unit != 1.0:
        found.name("gyro_units", "gyro", "the gyro reads degrees, by the truth", f"× {unit:.6g}")
    elif abs(np.log(abs(factor))) > max(MIN_LOG_FACTOR, SIGMAS * abs(sigma / factor)):
        found.name("time_step", "gyro", "the gyro counts by another factor than the truth", f"× {abs(factor):.4g}")
