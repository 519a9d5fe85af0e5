"""A bag as a whole: its laws beside those of the segments, and the parts that no law covers."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence

from lie_rigid_body.certificate.law_result import LawResult, Laws
from lie_rigid_body.certificate.sensors import SensorFindings
from lie_rigid_body.certificate.survey import Survey
from lie_rigid_body.recording.bag_reader import AnyBag


def laws(bag: AnyBag, surveyed: Survey, sensors: SensorFindings) -> Laws:
    """The laws of a bag: declared frames, scenarios that agree, log times and the count of samples.

    And those of its sensors that are of no segment with samples.

    Parameters
    ----------
    bag : Bag or Recording
    surveyed : Survey
    sensors : SensorFindings
        Both of the same bag.
    """
    counts = surveyed.counts
    faults = [*_declaration_faults(bag, surveyed)]
    laws = [
        _frames(surveyed),
        LawResult.of_faults("declaration", len(faults), "; ".join(faults)),
    ]
    if surveyed.is_original:  # this package logs and publishes every message at its stamp: by that they are replayed
        off = bag.publish_time_mismatches + counts.log_time_mismatches + sensors.log_time_mismatches
        message = f"{off} messages are not logged, or not published, at their stamps"
        laws.append(LawResult.of_faults("log times", off, message))
    if bag.expected_samples is not None:
        found = max(counts.messages)
        message = f"the bag's end counts {bag.expected_samples} samples, the bag holds {found}"
        laws.append(LawResult.of_faults("sample count", abs(bag.expected_samples - found), message))
    return (*laws, *sensors.whole)


def _frames(surveyed: Survey) -> LawResult:
    scenarios = [segment.scenario for segment in surveyed.declared]
    declared = sorted({frame for scenario in scenarios for frame in (scenario.world_frame, scenario.body_frame)})
    others = sorted(surveyed.counts.foreign_frames)
    message = f"frames {', '.join(map(repr, others))} are not those declared: {', '.join(declared)}"
    return LawResult.of_faults("frames", len(others), message)


def _declaration_faults(bag: AnyBag, surveyed: Survey) -> Iterator[str]:
    """Faults of the scenarios of a bag.

    Resets may not be at a sample of the clock before, or their clock neither goes on nor begins anew. The type of the
    twists may be another, and so may the scenario of samples that came before it.
    """
    segments = surveyed.declared
    if surveyed.is_original and segments[0].first_sample > 0:
        yield f"the first scenario begins with sample {segments[0].first_sample}: those before it are not in the bag"
    for before, after in itertools.pairwise(segments):
        number = before.clock().count_until(after.start_ns) - 1
        goes_on = (before.scenario.epoch_ns, number) if before.scenario.rate == after.scenario.rate else None
        if before.clock().stamp_ns(number) != after.start_ns or (after.scenario.epoch_ns, after.first_sample) not in (
            goes_on,
            (after.start_ns, 0),
        ):
            yield f"the scenario that starts at {after.start_ns} ns does not follow the clock of the one before it"
    if any(segment.scenario.stamped_twist != bag.stamped for segment in segments):
        yield f"a scenario declares stamped_twist {str(not bag.stamped).lower()}, the twists are otherwise"


def not_certified(bag: AnyBag, surveyed: Survey, uncovered: Iterable[str]) -> tuple[str, ...]:
    """Parts of a bag that are not certified, in words: those that any bag has, and those that are `uncovered`."""
    has_sensors = any(segment.scenario.has_sensors for segment in surveyed.declared)
    motions = {segment.scenario.motion for segment in surveyed.declared}
    return (
        f"who wrote it (it says {bag.library!r:.50})",
        f"the names of topics ({bag.pose_topic}, {bag.twist_topic})",
        "with which stepper (motion, method and max_step set the limits)",
        *(["the scale of the inertia, which no torque-free motion shows"] if motions != {"path"} else []),
        *_ends(bag, surveyed),
        *(["parameters of the sensors that no reading shows"] if has_sensors else []),
        *uncovered,
        "and what stands beside the messages: attachments, sequence numbers, qualities of service, padding",
    )


def uncovered(
    bag: AnyBag, surveyed: Survey, of_topics: Iterable[str], inertia: Sequence[float] | None = None
) -> tuple[str, ...]:
    """Parts of a bag that are not certified, though a bag as its scenarios determine it has no such parts.

    Parameters
    ----------
    bag : Bag or Recording
    surveyed : Survey
        Of the same bag.
    of_topics : iterable of str
        Such parts of its sensors and transforms: topics that no scenario determines, and the like.
    inertia : sequence of float, optional
        That which was used in place of the declared one, kg m².
    """
    unused = len(surveyed.declared) - len({found.segment.start_ns for found in surveyed.segments})
    repeated = len(bag.scenario_texts) - len(surveyed.declared)
    prescribed = any(segment.scenario.motion == "path" for segment in surveyed.declared)
    alone = sum(surveyed.counts.messages) - 2 * sum(found.count for found in surveyed.segments)
    return (
        *([f"the inertia that it declares: {', '.join(f'{v:g}' for v in inertia)} is used instead"] if inertia else []),
        *(["laws of mechanics: the motion is prescribed by a path"] if prescribed else []),
        *([f"scenarios without a sample: {unused}"] if unused else []),
        *([f"scenario messages that repeat another one: {repeated}"] if repeated else []),
        *([f"poses and twists without the other of their stamp: {alone}"] if alone else []),
        *of_topics,
        *bag.others,
    )


def _ends(bag: AnyBag, surveyed: Survey) -> Iterator[str]:
    if not surveyed.is_original:
        yield "log times: a recorder's"
        yield "what came before its first sample"
        if not bag.stamped:
            yield "which twist is of which pose: without stamps they are paired in their order"
    yield "what came after its last sample" + (
        "" if bag.expected_samples is None else ": whoever cuts samples off can lower their count"
    )
