"""The laws of a segment: its samples beside the exact motion from the declared start, block by block."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.certificate.law_result import LawResult, LawTally, Watch
from lie_rigid_body.certificate.limits import MAX_NORM_ERROR, RATE_FACTOR, closed_form_error, max_attitude_error, remedy
from lie_rigid_body.foundation.arrays import Array, Integers, same_bits
from lie_rigid_body.lie import quaternion, vectors
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.samples import Block
from lie_rigid_body.simulation import Segment

_BLOCK: Final = 8192
"""Largest number of samples compared at once: arrays of so many stay in a processor's cache."""
_ATTITUDE: Final = "attitude"
_RATE: Final = "body rate"
_LAWS: Final = (
    (_ATTITUDE, "rad", "the attitude is {worst} rad off the exact motion (limit {limit}) at {where}"),
    (_RATE, "rel", "the body rate is {worst} of the largest one off the exact motion (limit {limit}) at {where}"),
    ("unit norm", "1", "the norm of the quaternion is {worst} off 1 (limit {limit}) at {where}"),
    ("sign continuity", "1", "the quaternion has not the sign with which it goes on, at {where} ({count})"),
    ("kinetic energy", "rel", ""),
    ("world momentum", "rel", ""),
)
"""Name of each law, unit of its residuals, and the message where it is broken. The last two are reported, not judged:
they follow from the first two."""


@dataclass(frozen=True)
class SegmentResults:
    """Results of the laws of a segment.

    Parameters
    ----------
    laws : tuple of LawResult
    is_exact : bool
        Whether all attitudes and body rates are equal to those of the closed form, to the bit.
    """

    laws: tuple[LawResult, ...]
    is_exact: bool


class SegmentLaws:
    """The laws of one segment, to which its samples are added in order.

    Parameters
    ----------
    segment : Segment
    max_attitude : float, optional
        Limit of the attitude's error, rad, in place of that of the declared motion.
    watch : Watch, optional
        Receiver of all residuals.
    """

    def __init__(self, segment: Segment, max_attitude: float | None = None, watch: Watch | None = None) -> None:
        self._segment = segment
        scenario = segment.scenario
        self._body = scenario.body()
        self._motion = scenario.exact_motion()
        self._limit = max_attitude_error(scenario) if max_attitude is None else max_attitude
        start = scenario.start()
        self._energy = float(self._body.kinetic_energy(start))
        self._momentum = self._body.angular_momentum(start)
        self._largest_rate = 0.0
        self._tallies = [LawTally(*law, watch=watch) for law in _LAWS]
        self._is_exact = True

    def add(self, block: Block) -> None:
        """Hold the laws against the samples that come next."""
        for first in range(0, len(block.stamps_ns), _BLOCK):
            part = block[first : first + _BLOCK]
            elapsed_ns = part.stamps_ns - self._segment.start_ns
            exact = self._motion.at(elapsed_ns)
            limits = (self._limit, RATE_FACTOR * self._limit, MAX_NORM_ERROR, 1.0, np.inf, np.inf)
            residuals = self._residuals(part.states, exact, elapsed_ns)
            for tally, own, limit in zip(self._tallies, residuals, limits, strict=True):
                tally.add(own, limit, part.samples, part.stamps_ns)

    def _residuals(self, recorded: State, exact: State, elapsed_ns: Integers) -> tuple[Array, ...]:
        """Residuals in the order of `_LAWS`, shape (N,) each."""
        self._is_exact &= same_bits(recorded.attitude_xyzw, exact.attitude_xyzw)
        self._is_exact &= same_bits(recorded.body_rate, exact.body_rate)
        norm = quaternion.norm(recorded.attitude_xyzw)
        unit = State.trusted(recorded.attitude_xyzw / norm[:, np.newaxis], recorded.body_rate)
        x, y, z, cosine = quaternion.product(quaternion.conjugate(exact.attitude_xyzw).T, unit.attitude_xyzw.T)
        angle = 2.0 * np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(cosine))
        # the largest rate so far, so that one pass through the bag is enough
        speeds = np.maximum(np.maximum.accumulate(vectors.norm(exact.body_rate)), self._largest_rate)
        self._largest_rate = float(speeds[-1])
        momentum = self._body.angular_momentum(unit)
        return (
            angle + closed_form_error(speeds, elapsed_ns),
            _relative(vectors.norm(recorded.body_rate - exact.body_rate), speeds),
            np.abs(norm - 1.0),
            np.where(cosine < 0.0, 2.0, 0.0),
            _relative(np.abs(self._body.kinetic_energy(unit) - self._energy), self._energy),
            _relative(vectors.norm(momentum - self._momentum), vectors.norm(self._momentum)),
        )

    def results(self) -> SegmentResults:
        """Results of the laws, after all samples of the segment."""
        laws = [tally.result() for tally in self._tallies]
        broken = next((i for i in range(2) if not laws[i].holds), None)
        if broken is not None:
            law = laws[broken]
            laws[broken] = replace(law, message=law.message + remedy(self._segment.scenario, law.worst, law.limit))
        return SegmentResults(tuple(laws), self._is_exact)


def _relative(residuals: Array, scale: Array | float) -> Array:
    """Residuals over their scale; where the scale is 0 (a body at rest) any residual is infinitely large."""
    return np.where(residuals == 0.0, 0.0, residuals / scale)
