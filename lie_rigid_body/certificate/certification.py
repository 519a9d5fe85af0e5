"""The certificate of a bag: which laws its samples keep, and how far its attitudes may be from the true motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.certificate import laws, whole_bag
from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.segments import RecordedSegment, as_written, recorded_segments, seconds_since_start
from lie_rigid_body.certificate.stamps import GAP
from lie_rigid_body.certificate.tolerance import ATTITUDE_CAP, CLOSED_FORM, Tolerance, tolerance
from lie_rigid_body.certificate.uncertified import not_certified
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import ClosedForm
from lie_rigid_body.motion.taylor_flow import LONGEST_TURN
from lie_rigid_body.recording.bag_reader import Recording
from lie_rigid_body.simulation import Segment


@dataclass(frozen=True)
class SegmentCertificate:
    """The laws held against the samples of one segment.

    Parameters
    ----------
    segment : Segment
        The segment that the bag declares.
    samples : int
        Number of samples that were checked.
    laws : tuple of LawResult
    notes : tuple of str
        Remarks for the reader, such as a late start.
    """

    segment: Segment
    samples: int
    laws: tuple[LawResult, ...]
    notes: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether every law holds."""
        return all(law.holds for law in self.laws)

    def law(self, name: str) -> LawResult:
        """The law of that name."""
        return next(law for law in self.laws if law.name == name)

    def time_s(self, law: LawResult) -> float | None:
        """Time of a law's worst sample since the segment's start, s, if it has one."""
        return None if law.stamp_ns is None else (law.stamp_ns - self.segment.start_ns) / 1e9


@dataclass(frozen=True)
class Certificate:
    """The certificates of all segments of a bag, and the laws of the bag as a whole.

    Parameters
    ----------
    segments : tuple of SegmentCertificate
    whole : tuple of LawResult
    not_certified : tuple of str
        What of the bag no law speaks of, in words.
    """

    segments: tuple[SegmentCertificate, ...]
    whole: tuple[LawResult, ...] = ()
    not_certified: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether every law holds in every segment."""
        return all(s.passed for s in self.segments) and all(law.holds for law in self.whole)

    @property
    def messages(self) -> tuple[str, ...]:
        """One sentence for each broken law."""
        broken = []
        for i, segment in enumerate(self.segments, 1):
            prefix = f"segment {i}: " if len(self.segments) > 1 else ""
            broken += [prefix + law.message for law in segment.laws if not law.holds]
        return (*broken, *(law.message for law in self.whole if not law.holds))

    @property
    def attitude_accuracy(self) -> float:
        """Bound of the attitude's error, rad: the largest angle to the closed form, and the closed form's own error."""
        return self.accuracy("closed form") + CLOSED_FORM

    def accuracy(self, name: str) -> float:
        """The worst residual of a law over all segments."""
        return max((s.law(name).worst for s in self.segments), default=0.0)

    @property
    def farthest(self) -> tuple[int, SegmentCertificate]:
        """The segment with the largest attitude error: its number from 1, and its certificate."""
        return max(enumerate(self.segments, 1), key=lambda item: item[1].law("closed form").worst)


def certify(recording: Recording, inertia: Sequence[float] | None = None) -> Certificate:
    """Hold every law against every segment of a recording.

    Parameters
    ----------
    recording : Recording
    inertia : sequence of float, optional
        To be used in place of the declared one, kg m².

    Returns
    -------
    Certificate

    Raises
    ------
    BagError
        If the recording does not explain itself, or has no sample.
    """
    try:
        segments = recorded_segments(recording, inertia)
    except ParameterError as error:
        # a body that cannot be has no motion to hold the bag against
        return Certificate((), (whole_bag.impossible(error),))
    with np.errstate(invalid="ignore", over="ignore"):  # recorded numbers may be anything; NaN breaks every law
        return Certificate(
            tuple(_certify_segment(segment, as_written(recording)) for segment in segments),
            whole_bag.laws(recording, segments),
            not_certified(recording, segments),
        )


def _certify_segment(recorded: RecordedSegment, as_written: bool) -> SegmentCertificate:
    scenario = recorded.segment.scenario
    t = seconds_since_start(recorded.segment, recorded.stamps_ns)
    limits = tolerance(scenario, float(t.max(initial=0.0)))
    body, start = scenario.body(), scenario.start()
    exact = ClosedForm(body, start).at(recorded.stamps_ns - recorded.segment.start_ns)
    compared = laws.Comparison(recorded, body, start, limits, t, _unit(recorded.states), exact)
    attitude = laws.closed_form(compared)
    found = (
        recorded.stamps,
        laws.unit_norm(compared),
        laws.kinetic_energy(compared),
        *laws.world_momentum(compared),
        *laws.neighbours(compared),
        attitude,
    )
    notes = _notes(recorded, limits, t, attitude_holds=attitude.holds)
    if recorded.stamps.unit == GAP and not as_written and all(law.holds for law in found[1:]):
        notes.append(_loss(recorded))
    return SegmentCertificate(recorded.segment, len(t), found, tuple(notes))


def _unit(states: State) -> State:
    """The states with their quaternions normalised; one of norm 0 becomes NaN, which breaks every law it enters."""
    norms = quaternion.norm(states.attitude_xyzw)[:, np.newaxis]
    with np.errstate(divide="ignore"):
        return State.trusted(states.attitude_xyzw / norms, states.body_rate)


def _notes(recorded: RecordedSegment, limits: Tolerance, t: Array, *, attitude_holds: bool) -> list[str]:
    notes = []
    if len(t) and recorded.samples[0] > recorded.segment.first_sample and recorded.begins_late:
        notes.append(f"the recording begins at sample {recorded.samples[0]}, {t[0]:.6g} s after the segment's start")
    turn = float(np.max(np.diff(t), initial=0.0)) * limits.fastest
    if turn > LONGEST_TURN:
        notes.append(f"the body may turn {turn:.3g} rad between samples: neighbours are not held against each other")
    expected = float(limits.attitude_uncapped(t[-1:]).max(initial=0.0))
    if expected > ATTITUDE_CAP and not attitude_holds:
        notes.append(
            f"the declared stepper errs by up to {expected:.2g} rad here, a ground truth by {ATTITUDE_CAP:g} at most: "
            "record with motion closed_form, a higher order or a smaller max_step"
        )
    return notes


def _loss(recorded: RecordedSegment) -> str:
    """Who lost the messages of a gap, after which all go on as if none were missing."""
    return (
        f"{recorded.stamps.worst:.0f} messages are missing ({recorded.unpaired} samples are on one topic only); those "
        "that follow are numbered and move on as if they were there: the node published them, and the recorder or the "
        "network lost them: give the recorder a deeper history (docs/ros.md)"
    )
