"""Clock and mounting of a truth beside the readings of a gyro, and the gyro's factor.

Rotations of the body over short times, log(q(t)⁻¹ q(t + w)), do not depend on the world of a truth. Those of its body
are the readings of the gyro, added up, times a rotation of the axes and a factor, less the bias times w. Those of the
truth are added up over parts of w: rotations about two axes do not commute.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from lie_rigid_body.evaluation.attitudes import Truth, relative_rotations
from lie_rigid_body.evaluation.matched import MIN_KNOWN, spread, valleys
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.parameters import NS

LONGEST_S: Final = 10.0
"""Largest difference of the clocks that is looked for, s."""
PARTS: Final = 10
"""Number of successive parts of the readings of which the jackknife leaves out one."""
ALIKE: Final = 1.6
"""Ratio of misfits up to which two fits are alike. Rotations about one axis fit with either sign of the gyro. Motions
that recur fit with several delays, of which the shortest is taken."""
MAX_VALLEYS: Final = 10
"""Largest number of delays that are refined."""
TRUTH_STEP: Final = 0.5
"""Rotation in the short times over which gyro and truth are compared, rad: it outweighs the noise of cameras."""
TRUTH_PARTS: Final = 4
"""Number of their parts: what does not commute in them is a sixteenth of what it is in the whole."""
MAX_TRUTH_STEPS: Final = 400
"""Largest number of such times."""


class GyroFit(NamedTuple):
    """Readings of a gyro beside a truth.

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
        """Mask of the steps whose truth is known at a delay of its clock."""
        return self.truth.covers(self.times_ns + round(late_s * NS)).all(axis=0)

    def fitted(self, late_s: float) -> GyroFit:
        """Least squares of mounting, factor and bias at a delay; a negative factor only if none else fits."""
        known = self.known(late_s)
        if np.count_nonzero(known) < PARTS:
            return GyroFit(late_s, np.array([0.0, 0.0, 0.0, 1.0]), 1.0, np.inf)
        attitude = self.truth.at(self.times_ns[:, known] + round(late_s * NS))
        true = relative_rotations(attitude[:-1], attitude[1:]).sum(axis=0)
        true -= true.mean(axis=0)
        own = self.rotations[known] - self.rotations[known].mean(axis=0)
        fits = []
        for sign in (1.0, -1.0):
            mounting, _ = Rotation.align_vectors(true, sign * own)
            turned = mounting.apply(own)
            factor = float(np.sum(turned * true) / np.sum(own * own))
            misfit = math.sqrt(np.sum((true - factor * turned) ** 2) / np.sum(true**2))
            fits.append(GyroFit(late_s, mounting.as_quat(), factor, misfit))
        return fits[fits[0].misfit > ALIKE * fits[1].misfit]

    def best_near(self, late_s: float, reach_s: float) -> GyroFit:
        """The best fit at delays up to a distance, s."""
        found = minimize_scalar(
            lambda late: self.fitted(late).misfit,
            bounds=(late_s - reach_s, late_s + reach_s),
            method="bounded",
            options={"xatol": 5e-5},
        )
        return self.fitted(float(found.x))

    def standard_errors(self, found: GyroFit, reach_s: float) -> Array:
        """Standard errors of delay, s, mounting, rad, and factor, shape (5,): a jackknife of successive parts."""
        numbers = []
        for part in np.array_split(np.arange(len(self.rotations)), PARTS):
            rest = _Steps(np.delete(self.times_ns, part, axis=1), np.delete(self.rotations, part, axis=0), self.truth)
            fit = rest.best_near(found.late_s, reach_s)
            turn = relative_rotations(found.mounting_xyzw, fit.mounting_xyzw)
            numbers.append([fit.late_s, *turn, fit.factor])
        return np.asarray(np.sqrt(PARTS - 1.0) * np.std(numbers, axis=0))


def compare_with_truth(t_ns: Integers, rate: Array, truth: Truth) -> tuple[GyroFit, Array]:
    """Fit clock, mounting and factor, and their standard errors.

    Parameters
    ----------
    t_ns : ndarray of int64, shape (N,)
    rate : ndarray, shape (N, 3)
        Readings of the gyro, rad/s, or in another unit.
    truth : Truth

    Returns
    -------
    fit : GyroFit
    errors : ndarray, shape (5,)
        Standard errors of the delay, s, of the mounting as a rotation vector, rad, and of the factor.
    """
    times = np.linspace(truth.first_ns, truth.last_ns, MAX_TRUTH_STEPS).astype(np.int64)
    fast = max(np.quantile(np.linalg.norm(truth.states(times)[1], axis=1), 0.95), 1e-9)
    t_s = (t_ns - t_ns[0]) / NS
    width = int(np.clip(TRUTH_STEP / fast / np.median(np.diff(t_s)), 1, len(t_s) // 4))
    first = spread(len(t_s) - width, MAX_TRUTH_STEPS)
    places = first + spread(width + 1, TRUTH_PARTS + 1)[:, np.newaxis]
    angles = cumulative_trapezoid(rate, t_s, axis=0, initial=0)[places]
    steps = _Steps(t_ns[places], angles[-1] - angles[0], truth)
    step_s = t_s[width] / 2.0
    lates = np.arange(-LONGEST_S, LONGEST_S + step_s, step_s)
    known = np.array([np.count_nonzero(steps.known(late)) for late in lates])
    lates = lates[known >= MIN_KNOWN * known.max()]
    likely = valleys(np.array([steps.fitted(late).misfit for late in lates]))[:MAX_VALLEYS]
    fits = [steps.best_near(late, 2.0 * step_s) for late in lates[likely]]
    least = min(each.misfit for each in fits)
    fit = min((each for each in fits if each.misfit <= ALIKE * least), key=lambda each: abs(each.late_s))
    return fit, steps.standard_errors(fit, 2.0 * step_s)
