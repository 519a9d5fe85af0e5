"""The certificate of a bag: which laws its samples keep, and how far its attitudes may be from the true motion."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import itemgetter
from pathlib import Path

import numpy as np

from lie_rigid_body.certificate import whole_bag
from lie_rigid_body.certificate.law_result import LawResult, Laws, Watch
from lie_rigid_body.certificate.laws import SegmentLaws, SegmentResults
from lie_rigid_body.certificate.limits import CLOSED_FORM_ERROR
from lie_rigid_body.certificate.sensors import SensorFindings, SensorLaws, other_software
from lie_rigid_body.certificate.stamps import GAP
from lie_rigid_body.certificate.survey import Survey, SurveyedSegment, Surveyor
from lie_rigid_body.certificate.transforms import transforms
from lie_rigid_body.foundation.arrays import as_double
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.showing import Shown
from lie_rigid_body.foundation.wording import counted, listed, shown
from lie_rigid_body.recording.bag_reader import NO_TOPICS, AnyBag, Bag, Recording
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment


@short_dataclass
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
    laws: Laws
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        """The verdict, and of what; no call, as only `certify` makes one."""
        verdict = _verdict(self.laws, self.law("attitude").worst + CLOSED_FORM_ERROR)
        return f"<SegmentCertificate: {verdict}; {counted(self.samples, 'sample')} from {self.segment.start_ns} ns>"

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


@short_dataclass
class Certificate(Shown):
    """The certificates of all segments of a bag, and the laws of the bag as a whole.

    Parameters
    ----------
    segments : tuple of SegmentCertificate
    whole : tuple of LawResult
    not_certified : tuple of str
        What of the bag no law speaks of, in words.
    sensors : tuple of str
        Topics of the sensors that laws of the segments speak of.
    uncovered : tuple of str
        Those of ``not_certified`` that are of this bag, such as topics that no scenario determines.
    to_the_bit : bool or None
        Whether all states and readings are equal to the bit to those that are computed here. None: the bag is not of
        the closed form and of this version, so that they need not be.
    """

    segments: tuple[SegmentCertificate, ...]
    whole: Laws = ()
    not_certified: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()
    uncovered: tuple[str, ...] = ()
    to_the_bit: bool | None = None

    def __repr__(self) -> str:
        """The verdict, and of what; no call, as only `certify` makes one."""
        samples = sum(segment.samples for segment in self.segments)
        segments = len(self.segments)
        what = f"{counted(samples, 'sample')} in {counted(segments, 'segment')}"
        return f"<Certificate: {_verdict(self.laws, self.attitude_accuracy)}; {what}>"

    @property
    def passed(self) -> bool:
        """Whether every law holds in every segment."""
        return all(s.passed for s in self.segments) and all(law.holds for law in self.whole)

    @property
    def laws(self) -> Laws:
        """Each law where it went farthest beyond its limit, or came nearest, and those of the bag as a whole."""
        worst: dict[str, LawResult] = {}
        for law in (*itertools.chain.from_iterable(segment.laws for segment in self.segments), *self.whole):
            worst[law.name] = max(worst.get(law.name, law), law, key=lambda one: (one.broken > 0, one.share))
        return tuple(worst.values())

    @property
    def messages(self) -> tuple[str, ...]:
        """One sentence for each broken law."""
        prefix = "segment {}: " if len(self.segments) > 1 else ""
        laws = [(prefix.format(i), law) for i, segment in enumerate(self.segments, 1) for law in segment.laws]
        laws += [("", law) for law in self.whole]
        return tuple(f"{where}{law.message}" for where, law in laws if not law.holds)

    @property
    def attitude_accuracy(self) -> float:
        """Bound of the attitude's error, rad: the largest angle to the closed form, and the closed form's own error."""
        return self.accuracy("attitude") + CLOSED_FORM_ERROR

    def accuracy(self, name: str) -> float:
        """The worst residual of a law over all segments that it is held against; 0 if there is none."""
        return max((law.worst for segment in self.segments for law in segment.laws if law.name == name), default=0.0)

    @property
    def is_prescribed(self) -> bool:
        """Whether all segments follow paths, so that no law of mechanics was judged."""
        return bool(self.segments) and all(each.segment.scenario.motion == "path" for each in self.segments)

    @property
    def farthest(self) -> tuple[int, SegmentCertificate]:
        """The segment with the largest attitude error: its number from 1, and its certificate."""
        return max(enumerate(self.segments, 1), key=lambda item: item[1].law("attitude").worst)


def _verdict(laws: Iterable[LawResult], accuracy: float) -> str:
    broken = dict.fromkeys(law.name for law in laws if not law.holds)
    return f"broken: {listed(broken)}" if broken else f"certified, attitude within {accuracy:.2g} rad"


def certify(
    bag: AnyBag | str | Path,
    inertia: Sequence[float] | None = None,
    watch: Watch | None = None,
    max_attitude: float | None = None,
    topics: Mapping[str, str] = NO_TOPICS,
) -> Certificate:
    """Hold every law against every segment of a bag.

    It is read once.

    Parameters
    ----------
    bag : Bag, Recording, str or Path
        A bag, or the name of its file or folder.
    inertia : sequence of float, optional
        To be used in place of the declared one, kg m².
    watch : Watch, optional
        It is told of the residuals of all samples, and of all readings of sensors.
    max_attitude : float, optional
        Limit L of the attitude's error, rad, in place of that of the declared motion; see `limits`.
    topics : mapping of str to str, optional
        Topics of the one of several bodies, by relative names, such as ``{"pose": "/a/pose"}``, if ``bag`` is a name.

    Returns
    -------
    Certificate

    Raises
    ------
    BagError
        If the bag does not explain itself, or has no sample.
    ParameterError
        If the given inertia is that of no body, or the given limit is not finite or not above 0.
    """
    inertia = None if inertia is None else Scenario(inertia=inertia).inertia
    if max_attitude is not None and not 0.0 < as_double(max_attitude) < np.inf:
        raise ParameterError("max_attitude", f"{shown(max_attitude)} is no angle above 0, rad: give for example 1e-9")
    if not isinstance(bag, Bag | Recording):
        bag = Bag(bag, topics=topics)
    try:
        surveyor = Surveyor(bag, inertia)
    except ParameterError as error:
        fault = f"the bag declares an impossible scenario: {error}"  # which has no motion to be compared with
        return Certificate((), (LawResult.of_faults("declaration", 1, fault),))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # recorded numbers may be anything
        of_sensors = SensorLaws(bag, surveyor.segments, watch, max_attitude)
        results = _results(surveyor, of_sensors, max_attitude, watch)
        surveyed = surveyor.result()
        sensors = of_sensors.findings(surveyed)
        of_transforms, other_frames = transforms(bag, surveyor.segments, max_attitude, watch)
        held = [results.get(found.place) or SegmentLaws(found.segment).results() for found in surveyed.segments]
    uncovered = whole_bag.uncovered(bag, surveyed, (*sensors.not_certified, *other_frames), inertia)
    return Certificate(
        tuple(
            SegmentCertificate(
                found.segment,
                found.count,
                (found.stamps, *laws.laws, *of_its_sensors),
                (*_notes(found, laws, is_original=surveyed.is_original), *notes),
            )
            for found, laws, of_its_sensors, notes in zip(
                surveyed.segments, held, sensors.laws, sensors.notes, strict=True
            )
        ),
        (*whole_bag.laws(bag, surveyed, sensors), *of_transforms),
        whole_bag.not_certified(bag, surveyed, uncovered),
        sensors.topics,
        uncovered,
        _to_the_bit(bag, surveyed, held, sensors),
    )


def _to_the_bit(bag: AnyBag, surveyed: Survey, held: Iterable[SegmentResults], sensors: SensorFindings) -> bool | None:
    """Whether a bag of the closed form and of this version is equal to the bit to what is computed here."""
    motions = {segment.scenario.motion for segment in surveyed.declared}
    if motions != {"closed_form"} or other_software(bag) is not None:
        return None
    return all(laws.is_exact for laws in held) and sensors.are_exact


def _results(
    surveyor: Surveyor, sensors: SensorLaws, max_attitude: float | None, watch: Watch | None
) -> dict[int, SegmentResults]:
    """Results of the laws by the places of segments, which are judged one after the other."""
    results = dict[int, SegmentResults]()
    for place, blocks in itertools.groupby(surveyor.blocks(sensors.wanted, sensors.add), key=itemgetter(0)):
        laws = SegmentLaws(surveyor.segments[place], max_attitude, watch)
        for _, block in blocks:
            laws.add(block)
        results[place] = laws.results()
    return results


def _notes(found: SurveyedSegment, held: SegmentResults, *, is_original: bool) -> Iterator[str]:
    segment = found.segment
    broken = any(not law.holds for law in held.laws)
    if found.first is not None and found.first > segment.first_sample and found.begins_late:
        late = (segment.clock().stamp_ns(found.first) - segment.start_ns) * 1e-9
        yield f"the recording begins at sample {found.first}, {late:.6g} s after the segment's start"
    if found.stamps.unit == GAP and not is_original and not broken:  # all go on as if none were missing
        yield (
            f"messages missing: {found.stamps.worst:.0f}; those that follow are numbered and move on as if they were "
            "there: the node published them, and the recorder or the network lost them: give the recorder "
            "config/rosbag2/qos.yaml of this package, by --qos-profile-overrides-path"
        )
