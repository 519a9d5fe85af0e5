"""Clock and mounting of a truth, and the gyro's factor and bias against it.

Rotations of the body over short times, log(q(t)⁻¹ q(t + w)), do not depend on the world of a truth. Those of its body
are the readings of the gyro, added up, times a rotation of the axes and a factor, less the bias times w. Those of the
truth are added up over parts of w: rotations about two axes do not commute.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from lie_rigid_body.evaluation import Truth
from lie_rigid_body.evaluation.attitudes import angle_and_axis, places, relative_rotations
from lie_rigid_body.evaluation.matched import MIN_KNOWN, spread
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.inspection.findings import Findings
from lie_rigid_body.inspection.rule import (
    CHUNKS,
    GYRO_HZ,
    GYRO_UNITS,
    MAX_TRUTH_MISFIT,
    MAX_TRUTH_STEPS,
    MIN_DELAY_S,
    MIN_LOG_FACTOR,
    MIN_TRUTH_MOUNTING,
    SIGMAS,
    TOLD_APART,
    TRUTH_PARTS,
    TRUTH_STEP,
    nearest_unit,
)
from lie_rigid_body.inspection.stamps import Stream
from lie_rigid_body.lie import quaternion

LONGEST_S: Final = 10.0
"""Largest difference of the clocks that is looked for, s."""


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
    """Times, ns, shape (P, K), over which a gyro's readings were added up, these sums, and a truth."""

    times_ns: Integers
    rotations: Array
    truth: Truth

    def known(self, late_s: float) -> Booleans:
        """Where the truth is known at a delay of its clock."""
        return np.asarray(self.truth.covers(self.times_ns + round(late_s * NS)).all(axis=0))

    def fitted(self, late_s: float) -> AgainstTruth:
        """Least squares of mounting, factor and bias at a delay; a negative factor only if none else fits."""
        known = self.known(late_s)
        if np.count_nonzero(known) < CHUNKS:
            return AgainstTruth(late_s, np.array([0.0, 0.0, 0.0, 1.0]), 1.0, np.inf)
        attitude = self.truth.at(self.times_ns[:, known] + round(late_s * NS))
        true = relative_rotations(attitude[:-1], attitude[1:]).sum(axis=0)
        true -= true.mean(axis=0)
        own = self.rotations[known] - self.rotations[known].mean(axis=0)
        fits = []
        for sign in (1.0, -1.0):
            mounting, _ = Rotation.align_vectors(true, sign * own)
            turned = mounting.apply(own)
            factor = float(np.sum(turned * true) / np.sum(own * own))
            misfit = float(np.sqrt(np.sum((true - factor * turned) ** 2) / np.sum(true**2)))
            fits.append(AgainstTruth(late_s, mounting.as_quat(), factor, misfit))
        return fits[fits[0].misfit > TOLD_APART * fits[1].misfit]

    def best_near(self, late_s: float, reach_s: float) -> AgainstTruth:
        """The best fit at delays up to a distance, s."""
        found = minimize_scalar(
            lambda late: self.fitted(late).misfit,
            bounds=(late_s - reach_s, late_s + reach_s),
            method="bounded",
            options={"xatol": 1e-5},
        )
        return self.fitted(float(found.x))

    def standard_errors(self, found: AgainstTruth, reach_s: float) -> Array:
        """Standard errors of delay, s, mounting, rad, and factor, shape (5,): a jackknife of successive parts."""
        numbers = []
        for part in np.array_split(np.arange(len(self.rotations)), CHUNKS):
            rest = _Steps(np.delete(self.times_ns, part, axis=1), np.delete(self.rotations, part, axis=0), self.truth)
            fit = rest.best_near(found.late_s, reach_s)
            turn = relative_rotations(found.mounting_xyzw, fit.mounting_xyzw)
            numbers.append([fit.late_s, *turn, fit.factor])
        return np.asarray(np.sqrt(CHUNKS - 1.0) * np.std(numbers, axis=0))


def compare_with_truth(gyro: Stream, truth: Truth) -> tuple[AgainstTruth, Array]:
    """Fit clock, mounting and factor, and their standard errors.

    Parameters
    ----------
    gyro : Stream
        Readings, rad/s, or in another unit.
    truth : Truth

    Returns
    -------
    fit : AgainstTruth
    errors : ndarray, shape (5,)
        Standard errors of the delay, s, of the mounting as a rotation vector, rad, and of the factor.
    """
    times = np.linspace(truth.first_ns, truth.last_ns, MAX_TRUTH_STEPS).astype(np.int64)
    fast = max(float(np.quantile(np.linalg.norm(truth.states(times)[1], axis=1), 0.95)), 1e-9)
    t_s, rate = gyro.averaged(GYRO_HZ, int(gyro.t_ns[0]))
    width = int(np.clip(TRUTH_STEP / fast / np.median(np.diff(t_s)), 1, len(t_s) // 4))
    first = spread(len(t_s) - width, MAX_TRUTH_STEPS)
    places = first + spread(width + 1, TRUTH_PARTS + 1)[:, np.newaxis]
    angles = cumulative_trapezoid(rate, t_s, axis=0, initial=0)[places]
    steps = _Steps(gyro.t_ns[0] + np.round(t_s[places] * NS).astype(np.int64), angles[-1] - angles[0], truth)
    step_s = (t_s[width] - t_s[0]) / 2.0
    lates = np.arange(-LONGEST_S, LONGEST_S + step_s, step_s)
    known = np.array([np.count_nonzero(steps.known(late)) for late in lates])
    start = min(lates[known >= MIN_KNOWN * known.max()], key=lambda late: steps.fitted(late).misfit)
    fit = steps.best_near(start, 2.0 * step_s)
    return fit, steps.standard_errors(fit, 2.0 * step_s)


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
    fit, errors = compare_with_truth(gyro, truth)
    if fit.misfit > MAX_TRUTH_MISFIT:
        why = f"by no clock and mounting the truth rotates as the gyro does: {fit.misfit:.0%} of its rotations remain"
        found.ask("truth_late", why)
        found.ask("truth_mounting", why)
        return None
    _report_factor(found, fit.factor, errors[4])
    text = f"the truth is {fit.late_s * 1e3:.4g} ms late against the gyro, ± {errors[0] * 1e3:.1g} ms"
    if abs(fit.late_s) > max(MIN_DELAY_S, SIGMAS * errors[0]):
        found.name("truth_late", "truth", text, f"{-fit.late_s:+.4f} s")
    else:
        found.note("truth_late", text, fit.late_s)
    angle = float(np.linalg.norm(quaternion.log(fit.mounting_xyzw)))
    turn = angle_and_axis(fit.mounting_xyzw)
    error = float(np.linalg.norm(errors[1:4]))
    text = f"the axes of the truth's body are those of the gyro rotated by {turn}, ± {np.degrees(error):.1g}°"
    if angle > max(MIN_TRUTH_MOUNTING, SIGMAS * error):
        found.name("truth_mounting", "truth", text + places(fit.mounting_xyzw), turn)
    else:
        found.note("truth_mounting", text, np.degrees(angle))
    return fit


def _report_factor(found: Findings, factor: float, sigma: float) -> None:
    """Report the gyro's sign and factor, and undo them."""
    size = abs(factor)
    text, unit, away = nearest_unit(size, GYRO_UNITS)
    if factor < 0.0:
        found.name("gyro_axes", "gyro", "the gyro has the opposite sign of the truth's rotations", "-x -y -z")
        found.changes["gyro"].matrix *= -1.0
    if away > max(MIN_LOG_FACTOR, SIGMAS * sigma / size):
        found.name("time_step", "gyro", "the gyro counts by another factor than the truth", f"× {size:.4g}")
        found.changes["gyro"].matrix *= size
    elif text:
        found.name("gyro_units", "gyro", "the gyro reads degrees, by the truth", f"× {unit:.6g}")
        found.changes["gyro"].matrix *= unit
