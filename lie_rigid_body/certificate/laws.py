"""The laws of a segment: its samples beside the exact motion from the declared start, block by block."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.certificate.law_result import Laws, LawTally, Watch
from lie_rigid_body.certificate.limits import (
    MAX_NORM_ERROR,
    PATH_ERROR,
    RATE_FACTOR,
    TRANSLATION_ERROR,
    LargestSoFar,
    closed_form_error,
    max_attitude_error,
    remedy,
)
from lie_rigid_body.foundation.arrays import Array, Integers, same_bits
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion, vectors
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion.mass_centre import MassCentre
from lie_rigid_body.recording.samples import Block
from lie_rigid_body.scenario.arcs import arc_changes
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
    ("position", "m", "the position is {worst} m off that of the scenario (limit {limit}) at {where}"),
    ("velocity", "m/s", "the linear velocity is {worst} m/s off that of the scenario (limit {limit}) at {where}"),
    ("kinetic energy", "rel", ""),
    ("world momentum", "rel", ""),
)
"""Name of each law, unit of its residuals, and the message where it is broken. The last two are reported, not judged:
they follow from the first two. Both are those of the arc between two kicks, and relative to the largest of all arcs so
far. A path has neither."""
_OF_MECHANICS: Final = 2
"""Number of laws, the last ones, that a path need not keep."""


_Judged: TypeAlias = tuple[Array, "Array | float"]
"""Residuals of a law, shape (N,), and their limits."""


@short_dataclass
class SegmentResults:
    """Results of the laws of a segment.

    Parameters
    ----------
    laws : tuple of LawResult
    is_exact : bool
        Whether all attitudes and body rates are equal to those of the closed form, to the bit.
    """

    laws: Laws
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
        self._motion = scenario.exact_motion()
        self._limit = max_attitude_error(scenario) if max_attitude is None else max_attitude
        self._mass_centre = scenario.mass_centre()
        self._largest = LargestSoFar()
        self._slack = PATH_ERROR if scenario.path() else 0.0
        laws = _LAWS[:-_OF_MECHANICS] if scenario.path() else _LAWS
        self._tallies = [LawTally(*law, watch=watch) for law in laws]
        self._is_exact = True

    def add(self, block: Block) -> None:
        """Hold the laws against the samples that come next."""
        for first in range(0, len(block.stamps_ns), _BLOCK):
            part = block[first : first + _BLOCK]
            elapsed_ns = part.stamps_ns - self._segment.start_ns
            exact = self._motion.at(elapsed_ns)
            norm = quaternion.norm(part.states.attitude_xyzw)
            unit = State.trusted(part.states.attitude_xyzw / norm[:, np.newaxis], part.states.body_rate)
            self._is_exact &= same_bits(part.states.attitude_xyzw, exact.attitude_xyzw)
            self._is_exact &= same_bits(part.states.body_rate, exact.body_rate)
            judged = (
                *self._attitude_and_rate(unit, norm, exact, elapsed_ns),
                *self._position_and_velocity(part, exact, elapsed_ns),
                *(self._energy_and_momentum(unit, elapsed_ns) if not self._slack else ()),
            )
            for tally, (residuals, limits) in zip(self._tallies, judged, strict=True):
                tally.add(residuals, limits, part.samples, part.stamps_ns)

    def poses(self, stamps_ns: Integers, attitude_xyzw: Array, position: Array) -> tuple[_Judged, _Judged]:
        """Errors of attitudes and of positions that come next, and their limits, for poses that stand elsewhere."""
        elapsed_ns = stamps_ns - self._segment.start_ns
        exact = self._motion.at(elapsed_ns)
        angle, _ = _angle_and_cosine(exact.attitude_xyzw, attitude_xyzw)
        speeds = self._largest.with_more("body rate", vectors.norm(exact.body_rate))
        return self._attitude(angle, speeds, elapsed_ns), self._place(position, self._mass_centre.at(elapsed_ns))

    def _attitude(self, angle: Array, speeds: Array, elapsed_ns: Integers) -> _Judged:
        angle[elapsed_ns > self._segment.scenario.last_ns] = np.inf  # where there is no motion any more
        return angle + closed_form_error(speeds, elapsed_ns), self._limit

    def _place(self, position: Array, centre: MassCentre) -> _Judged:
        distance = self._largest.with_more("position", vectors.norm(centre.position))
        return vectors.norm(position - centre.position), TRANSLATION_ERROR * distance + self._slack

    def _attitude_and_rate(self, recorded: State, norm: Array, exact: State, elapsed_ns: Integers) -> Iterator[_Judged]:
        """Attitude and rate, and the norm and the sign of the quaternions, which are recorded with that norm."""
        angle, cosine = _angle_and_cosine(exact.attitude_xyzw, recorded.attitude_xyzw)
        speeds = self._largest.with_more("body rate", vectors.norm(exact.body_rate))
        yield self._attitude(angle, speeds, elapsed_ns)
        # a rest between kicks is exact by every method: any other rate is infinitely far; one on a path is computed
        speeds[~exact.body_rate.any(axis=1)] *= self._slack > 0.0
        yield _relative(vectors.norm(recorded.body_rate - exact.body_rate), speeds), RATE_FACTOR * self._limit
        yield np.abs(norm - 1.0), MAX_NORM_ERROR
        yield np.where(cosine < 0.0, 2.0, 0.0), 1.0

    def _position_and_velocity(self, recorded: Block, exact: State, elapsed_ns: Integers) -> Iterator[_Judged]:
        centre = self._mass_centre.at(elapsed_ns)
        velocity = centre.body_velocity(exact)
        self._is_exact &= same_bits(recorded.position, centre.position)
        self._is_exact &= same_bits(recorded.body_velocity, velocity)
        yield self._place(recorded.position, centre)
        speed = self._largest.with_more("velocity", vectors.norm(velocity))
        yield vectors.norm(recorded.body_velocity - velocity), (TRANSLATION_ERROR + self._limit) * speed + self._slack

    def _energy_and_momentum(self, recorded: State, elapsed_ns: Integers) -> Iterator[_Judged]:
        """Changes since the begin of each sample's arc."""
        changes = arc_changes(self._segment.scenario, elapsed_ns, recorded)
        for name, (change, wanted) in zip(("energy", "momentum"), changes, strict=True):
            largest = self._largest.with_more(name, np.linalg.norm(wanted, axis=1))
            yield _relative(np.linalg.norm(change, axis=1), largest), np.inf

    def results(self) -> SegmentResults:
        """Results of the laws, after all samples of the segment."""
        laws = [tally.result() for tally in self._tallies]
        broken = next((i for i in range(2) if not laws[i].holds), None)
        if broken is not None:
            law = laws[broken]
            laws[broken] = replace(law, message=law.message + remedy(self._segment.scenario, law.worst, law.limit))
        return SegmentResults(tuple(laws), self._is_exact)


def _angle_and_cosine(exact_xyzw: Array, recorded_xyzw: Array) -> tuple[Array, Array]:
    """Angles between attitudes, rad, and cosines of half of them, which are negative where the signs differ: (N,)."""
    x, y, z, cosine = quaternion.product(quaternion.conjugate(exact_xyzw).T, recorded_xyzw.T)
    return 2.0 * np.arctan2(np.sqrt(x * x + y * y + z * z), np.abs(cosine)), cosine


def _relative(residuals: Array, scale: Array | float) -> Array:
    """Residuals over their scale; where the scale is 0 (a body at rest) any residual is infinitely large."""
    return np.where(residuals == 0.0, 0.0, residuals / scale)
