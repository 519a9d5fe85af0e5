"""Fits of an estimate to the truth: the convention, the constant rotations and the time lag between them.

The model is

    q_estimate(t) = C[ exp(ψ e_z) ⊗ q_truth(t − τ) ⊗ q_mounting ]

with a heading offset ψ, a constant rotation of the body q_mounting, a lag τ and a discrete convention C. Its residuals
are the rotation vectors between both sides after C is undone. They are fitted by Gauss–Newton with the weights of
Geman and McClure, so that the convergence of a filter from a bad start hardly pulls the constants.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation.attitude_error import angles
from lie_rigid_body.evaluation.attitudes import sizes, turns
from lie_rigid_body.evaluation.truth import Truth
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import short_repr

HEADING: Final = "heading_offset"
MOUNTING: Final = "body_mounting"
LAG: Final = "lag"
"""Names of the constants that a fit may determine."""

UP: Final = np.array([0.0, 0.0, 1.0])
"""Vertical of the world, its z axis."""
ENU_TO_NED: Final = np.array([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0])
"""Quaternion that exchanges x and y and negates z: half a turn about (1, 1, 0), its own inverse."""
FLU_TO_FRD: Final = np.array([1.0, 0.0, 0.0, 0.0])
"""Half a turn about the body's x axis, its own inverse."""

KEPT_STATES: Final = 8
MOST_KEPT_STAMPS: Final = 10_000
"""Largest number of answers of the truth that a comparison keeps, and of the stamps of one, at 64 bytes a stamp."""


@dataclass(frozen=True)
class Convention:
    """Convention in which an estimate is written, if not as world-from-body, scalar last, world z up.

    Attributes
    ----------
    scalar_first : bool
        Its components come as w, x, y, z.
    inverted : bool
        It takes world vectors to the body.
    ned_world : bool
        Its world has x north, y east, z down.
    frd_body : bool
        Its body has x forward, y right, z down. It goes with an NED world.
    conjugated_last : bool
        It is inverted as if its scalar came last, though it comes first: w changes its place, then x, y, z as read
        their signs.
    """

    scalar_first: bool = False
    inverted: bool = False
    ned_world: bool = False
    frd_body: bool = False
    conjugated_last: bool = False

    __repr__ = short_repr

    def undo(self, given_xyzw: Array) -> Array:
        """The estimate in the convention of this package, shape (..., 4)."""
        q = quaternion.conjugate(given_xyzw) if self.conjugated_last else given_xyzw
        if self.scalar_first:
            q = np.roll(q, -1, axis=-1)
        if self.inverted and not self.conjugated_last:
            q = quaternion.conjugate(q)
        if self.ned_world:
            q = quaternion.multiply(ENU_TO_NED, q)
        return quaternion.multiply(q, FLU_TO_FRD) if self.frd_body else q

    def apply(self, attitude_xyzw: Array) -> Array:
        """An attitude written in this convention, shape (..., 4)."""
        q = quaternion.multiply(attitude_xyzw, FLU_TO_FRD) if self.frd_body else attitude_xyzw
        if self.ned_world:
            q = quaternion.multiply(ENU_TO_NED, q)
        if self.inverted and not self.conjugated_last:
            q = quaternion.conjugate(q)
        if self.scalar_first:
            q = np.roll(q, 1, axis=-1)
        return quaternion.conjugate(q) if self.conjugated_last else q


@dataclass(frozen=True)
class Misalignment:
    """Constants that a fit determines: a heading offset in rad, a mounting as a unit quaternion, a lag in s."""

    heading: float = 0.0
    mounting: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    lag_s: float = 0.0

    __repr__ = short_repr

    @property
    def mounting_angle(self) -> float:
        """Angle of the mounting, from 0 to π, rad."""
        return float(angles(np.array(self.mounting)).total)

    def only(self, free: frozenset[str]) -> Misalignment:
        """Misalignment with some of the constants; the others are none."""
        kept = {HEADING: "heading", MOUNTING: "mounting", LAG: "lag_s"}
        return Misalignment(**{field: getattr(self, field) for name, field in kept.items() if name in free})

    def moved(self, step: Array) -> Misalignment:
        """Misalignment after a step of heading, mounting (on its own axes) and lag, shape (5,)."""
        mounting = quaternion.normalize(quaternion.multiply(self.mounting, quaternion.exp(step[1:4])))
        x, y, z, w = mounting.tolist()
        return Misalignment(self.heading + float(step[0]), (x, y, z, w), self.lag_s + float(step[4]))

    def bounded(self, longest_lag_s: float) -> Misalignment:
        """Misalignment with its lag within a limit."""
        return replace(self, lag_s=min(max(self.lag_s, -longest_lag_s), longest_lag_s))

    def predict(self, attitude_xyzw: Array) -> Array:
        """Estimate that a true attitude of the time before the lag leads to, shape (..., 4)."""
        turned = quaternion.multiply(quaternion.exp(self.heading * UP), attitude_xyzw)
        return quaternion.multiply(turned, np.array(self.mounting))


@dataclass(frozen=True)
class RunComparison:
    """Estimates, their stamps and the truth, with a limit to the lag.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    estimate_xyzw : ndarray, shape (N, 4)
        In the convention of this package.
    truth : Truth
    longest_lag_s : float
    """

    stamps_ns: Integers
    estimate_xyzw: Array
    truth: Truth
    longest_lag_s: float
    _states: dict[bytes, tuple[Array, Array]] = field(default_factory=dict, repr=False, compare=False)

    __repr__ = short_repr

    def part(self, chosen: slice | Integers) -> RunComparison:
        """Comparison of some of the samples."""
        return replace(self, stamps_ns=self.stamps_ns[chosen], estimate_xyzw=self.estimate_xyzw[chosen])

    def inner(self) -> RunComparison:
        """Comparison of the samples that have a truth whatever the lag is: every lag is judged by the same ones."""
        early, late = self.true_stamps(self.longest_lag_s), self.true_stamps(-self.longest_lag_s)
        return self.part(np.flatnonzero(self.truth.covers(early) & self.truth.covers(late)))

    def true_stamps(self, lag_s: float) -> Integers:
        """Stamps moved back by a lag, ns: the true times of the estimates."""
        return self.stamps_ns - round(lag_s * 1e9)

    def true_states(self, lag_s: float) -> tuple[Array, Array]:
        """True attitudes, shape (N, 4), and body rates, rad/s, shape (N, 3), of the times before a lag.

        Fits ask for the same times again and again: the last few answers are kept, for all parts of a comparison.
        """
        stamps = self.true_stamps(lag_s)
        if len(stamps) > MOST_KEPT_STAMPS:
            return self.truth.states(stamps)
        times = stamps.tobytes()
        if times not in self._states:
            while len(self._states) >= KEPT_STATES:
                self._states.pop(next(iter(self._states)))
            self._states[times] = self.truth.states(stamps)
        return self._states[times]

    def fastest(self) -> float:
        """Largest rate of the body at the samples, rad/s."""
        return float(sizes(self.true_states(0.0)[1]).max())

    def angles(self, misalignment: Misalignment) -> Array:
        """Angles between predicted and given estimates where the truth is known, shape (≤ N,), rad."""
        stamps = self.true_stamps(misalignment.lag_s)
        known = np.flatnonzero(self.truth.covers(stamps))
        return sizes(_residual(misalignment, self.truth.at(stamps[known]), self.estimate_xyzw[known]))


def columns(free: frozenset[str]) -> list[int]:
    """Indices of the free ones of the five parameters: heading, mounting (three), lag."""
    return [*([0] if HEADING in free else []), *([1, 2, 3] if MOUNTING in free else []), *([4] if LAG in free else [])]


def fit(
    comparison: RunComparison,
    free: frozenset[str],
    start: Misalignment,
    steps: int = 25,
    smallest_step: float = 1e-10,
) -> Misalignment:
    """Fit the misalignment of least robust cost near a start.

    Parameters
    ----------
    comparison : RunComparison
    free : frozenset of str
        Which of `HEADING`, `MOUNTING` and `LAG` to fit; the others stay as in the start.
    start : Misalignment
    steps : int
        At most so many steps of Gauss–Newton.
    smallest_step : float
        The fit ends at a step below this, rad and s.

    Returns
    -------
    Misalignment
        The last, or if the fit has not ended the best of all steps.
    """
    chosen, now = columns(free), start
    if not chosen:
        return start
    best, best_cost = start, np.inf
    truth, rate = comparison.true_states(now.lag_s)
    for _ in range(steps):
        residual = _residual(now, truth, comparison.estimate_xyzw)
        size = sizes(residual)
        if np.mean(size) < best_cost:
            best, best_cost = now, float(np.mean(size))
        J = _derivative(now, truth, rate)[..., chosen]
        normal, slope = _normal_equations(J, residual, _weights(size))
        step = np.zeros(5)
        # least squares of least norm: what the motion does not tell apart stays where it was
        step[chosen] = np.linalg.lstsq(normal, slope, rcond=1e-10)[0]
        now = now.moved(step).bounded(comparison.longest_lag_s)
        if np.all(np.abs(step) < smallest_step):
            return now
        if LAG in free:
            truth, rate = comparison.true_states(now.lag_s)
    return best


def separable(comparison: RunComparison, free: frozenset[str], misalignment: Misalignment) -> bool:
    """Whether the motion tells a lag from the other free parameters, and turns at all.

    The variance of a lag that is fitted alone grows by a factor when other parameters are fitted with it, the variance
    inflation factor of a regression. Up to `LARGEST_INFLATION` they are told apart.
    """
    J = _derivative(misalignment, *comparison.true_states(misalignment.lag_s))[..., columns(free | {LAG})]
    normal, _ = _normal_equations(J, np.zeros(J.shape[:2]), np.ones(len(J)))
    alone = float(normal[-1, -1])
    if not alone > SLOWEST_RATE**2 * len(J):
        return False
    shared = normal[-1, :-1] @ np.linalg.lstsq(normal[:-1, :-1], normal[:-1, -1], rcond=1e-10)[0]
    return bool(alone <= LARGEST_INFLATION * (alone - shared))


def lag_standard_error(comparison: RunComparison, free: frozenset[str], misalignment: Misalignment) -> float:
    """Standard error of a fitted lag, s.

    The fit takes the lag as a weighted sum of the errors, G · ψ. The same sum with the errors moved along the run, in a
    circle, is what errors of that spectrum make of a lag where there is none: its root mean square over all shifts
    counts white errors as independent, and drifts as the few that they are. Errors keep to the axes of the world, as
    those of a heading, or to those of the body, as biases do. Of a body that turns evenly the shifts are all alike and
    tell nothing: errors that are independent are counted as well. The largest value counts.

    Parameters
    ----------
    comparison : RunComparison
    free : frozenset of str
        Which constants were fitted beside the lag.
    misalignment : Misalignment
        Of least cost.
    """
    truth, rate = comparison.true_states(misalignment.lag_s)
    residual = _residual(misalignment, truth, comparison.estimate_xyzw)
    weights = _weights(sizes(residual))
    J = _derivative(misalignment, truth, rate)[..., columns(free | {LAG})]
    normal, _ = _normal_equations(J, residual, weights)
    G = J @ np.linalg.pinv(normal, rcond=1e-10)[:, -1]
    psi = weights[:, np.newaxis] * residual
    predicted = misalignment.predict(truth)
    on_world = [quaternion.rotate(predicted, vectors) for vectors in (G, psi)]
    independent = float(np.sqrt(np.sum(G**2) * np.mean(psi**2)))
    return max(_rms_over_shifts(G, psi), _rms_over_shifts(*on_world), independent)


def _rms_over_shifts(weights: Array, errors: Array) -> float:
    """Root mean square of Σ weights · errors over all circular shifts of the errors, both of shape (N, 3)."""
    spectra = np.conj(np.fft.rfft(weights, axis=0)) * np.fft.rfft(errors, axis=0)
    sums = np.fft.irfft(spectra.sum(axis=1), n=len(weights))
    return float(np.sqrt(np.mean(sums**2)))


def _residual(misalignment: Misalignment, truth: Array, estimate: Array) -> Array:
    """Rotation vector from the predicted to the given estimate on the body's axes, shape (N, 3), rad."""
    return turns(misalignment.predict(truth), estimate)


def _derivative(misalignment: Misalignment, truth: Array, rate: Array) -> Array:
    """Derivative of the prediction, on the body's axes, by heading, mounting and lag, shape (N, 3, 5)."""
    vertical = quaternion.rotate(quaternion.conjugate(misalignment.predict(truth)), UP)
    turning = -quaternion.rotate(quaternion.conjugate(misalignment.mounting), rate)
    identity = np.broadcast_to(np.eye(3), (len(truth), 3, 3))
    return np.concatenate([vertical[..., np.newaxis], identity, turning[..., np.newaxis]], axis=-1)


def _normal_equations(J: Array, residual: Array, weights: Array) -> tuple[Array, Array]:
    weighted = J * weights[:, np.newaxis, np.newaxis]
    return np.einsum("nia,nib->ab", weighted, J), np.einsum("nia,ni->a", weighted, residual)


def _weights(norms: Array) -> Array:
    """Geman and McClure's weights, 1 / (1 + (r/s)²)², with a scale s of three medians: far residuals hardly count."""
    scale = 3.0 * float(np.median(norms))
    return 1.0 / (1.0 + (norms / scale) ** 2) ** 2 if scale else np.ones_like(norms)


LARGEST_INFLATION: Final = 10.0
"""Largest variance inflation factor at which a lag counts as told apart from the other parameters."""
SLOWEST_RATE: Final = 1e-6
"""Least body rate that tells something about time, rad/s."""
