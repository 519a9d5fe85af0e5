"""A world that is turned about any axis: what a filter makes of references that contradict what is read.

A vector of wrong sign, read or referred to, turns the world of a filter that corrects its attitude to where the errors
of all vectors together are least; a wrong first attitude that nothing corrects turns it as well. Whatever the body
does, the turn is constant in the world, once the filter has converged: q_estimate = q_turn ⊗ q_truth.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.alignment import LAG, Convention, Misalignment, RunComparison
from lie_rigid_body.evaluation.attitude_error import angles
from lie_rigid_body.evaluation.attitudes import angles_between, from_mean, mean
from lie_rigid_body.evaluation.diagnosis import Diagnosis
from lie_rigid_body.evaluation.explanation import NEGLIGIBLE, TIE_FACTOR, Explanation, median_left
from lie_rigid_body.evaluation.findings import Finding, angle_and_axis, gain
from lie_rigid_body.evaluation.statistics import FEWEST_SAMPLES, later_quarters, rms, worst_quarter
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import short_repr

LARGEST_LEFT: Final = float(np.radians(5.0))
"""Largest median angle that a turn may leave in any quarter of the run but the first, rad."""
LARGEST_SHARE: Final = 0.25
"""Largest median angle that a turn may leave there, as a share of the error and of `from_mean`."""
LEAST_TILT: Final = float(np.radians(10.0))
"""Least tilt of the vertical by a turn, rad: sensors err by less, and a turn about the vertical is a heading offset."""

NAMED_TURNS: Final = {"ned_world", "heading_offset"}
"""Causes that turn the world as well, and are named so."""
LAG_AS_GOOD: Final = 4.0
"""Ratio of the median angles left by a near lag and by a turn, up to which the lag is told: of a spin both fit."""
NEAR_SAMPLES: Final = 3.0
"""Largest near lag, samples: a filter errs by one or two."""


@dataclass(frozen=True)
class TurnedWorld:
    """A constant turn of the world, and the errors before and after it is undone.

    Attributes
    ----------
    turn_xyzw : ndarray, shape (4,)
        The estimate is turn ⊗ truth.
    before, after : ndarray, shape (N,)
        Angles, rad.
    """

    turn_xyzw: Array
    before: Array
    after: Array

    __repr__ = short_repr

    @property
    def cost(self) -> float:
        """Cost as `Explanation.cost`: one cause, the least simple one."""
        return 1.0 + float(np.log2(TIE_FACTOR * max(np.median(self.after), NEGLIGIBLE)))

    def is_better_than(self, diagnosis: Diagnosis, period_s: float) -> bool:
        """Whether the turn costs less than what a diagnosis names, and that is not such a turn itself.

        `period_s` is the time between two estimates, s.
        """
        named = diagnosis.explanation
        with_others = [e for e in (named, *diagnosis.tried) if set(named.causes) <= set(e.causes)]
        is_turn = _turns_the_world(named) and any(self._may_be(e, period_s) for e in with_others)
        return self.cost < named.cost and not is_turn

    def _may_be(self, explanation: Explanation, period_s: float) -> bool:
        """Whether causes that turn the world leave little; with a lag, little beside this turn too."""
        before, after = float(np.median(self.before)), float(np.median(self.after))
        most = min(LARGEST_SHARE * before, LAG_AS_GOOD * after) if LAG in explanation.free else np.inf
        is_far = abs(explanation.misalignment.lag_s) > NEAR_SAMPLES * period_s
        return _turns_the_world(explanation) and explanation.median < min(LEAST_TILT, most) and not is_far

    def beside(self, comparison: RunComparison) -> tuple[RunComparison, Explanation]:
        """Comparison with the world turned back, and the explanation by no cause of what is left."""
        back = quaternion.multiply(quaternion.conjugate(self.turn_xyzw), comparison.estimate_xyzw)
        rest, none = replace(comparison, estimate_xyzw=back).inner(), (Convention(), Misalignment())
        return rest, Explanation(none[0], frozenset(), none[1], median_left(rest, *none))

    @property
    def finding(self) -> Finding:
        """Finding of the turn, in words."""
        before, after = np.degrees(self.before), np.degrees(self.after)
        message = (
            f"The world of the estimate is turned by {angle_and_axis(self.turn_xyzw)} of the world: see whether "
            "nothing corrects a wrong first attitude, or the accelerometer, the magnetometer or what they are held "
            f"against has the wrong sign or other axes ({gain(before, after)})."
        )
        return Finding("world_turned", message, rms(after))


def _turns_the_world(explanation: Explanation) -> bool:
    """Whether all causes turn the world, as a lag of a body that spins does."""
    return set(explanation.causes) <= NAMED_TURNS | {LAG}


def world_turned(estimate_xyzw: Array, true_xyzw: Array) -> TurnedWorld | None:
    """Find the turn of an estimate's world, if it explains nearly all; shapes (N, 4), in the order of time."""
    if len(estimate_xyzw) < FEWEST_SAMPLES:
        return None
    errors = quaternion.multiply(estimate_xyzw, quaternion.conjugate(true_xyzw))
    late = np.concatenate(later_quarters(len(errors)))
    turn = mean(errors[late])
    before, after = angles_between(true_xyzw, estimate_xyzw), angles_between(turn, errors)
    error, left = float(np.median(before[late])), worst_quarter(after)
    most = min(LARGEST_LEFT, LARGEST_SHARE * error, LARGEST_SHARE * from_mean(true_xyzw[late]))
    if left > most or angles(turn).inclination < LEAST_TILT:
        return None
    return TurnedWorld(turn, before, after)
