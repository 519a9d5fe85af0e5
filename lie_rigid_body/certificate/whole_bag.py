"""A bag as a whole: its laws beside those of the segments, and the parts that no law covers."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.sensors import SensorFindings
from lie_rigid_body.certificate.survey import Survey
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.recording.bag_reader import Bag, Recording


def laws(bag: Bag | Recording, surveyed: Survey, sensors: SensorFindings) -> tuple[LawResult, ...]:
    """The laws of a bag: declared frames, zero translation, scenarios that agree, log times and the count of samples.

    And those of its sensors that are of no segment with samples.

    Parameters
    ----------
    bag : Bag or Recording
    surveyed : Survey
    sensors : SensorFindings
        Of the same bag.
    """
    counts = surveyed.counts
    faults = [*_clock_faults(surveyed), *_twist_faults(bag, surveyed), *_contradictions(surveyed)]
    laws = [
        _frames(surveyed),
        _flag(
            "position and linear velocity",
            counts.moved,
            f"{counts.moved} components of position or linear velocity are not 0",
        ),
        _flag("declaration", len(faults), "; ".join(faults)),
    ]
    if surveyed.as_written:  # this package logs and publishes every message at its stamp: by that they are replayed
        off = bag.published_otherwise + counts.logged_otherwise + sensors.logged_otherwise
        laws.append(_flag("log times", off, f"{off} messages are not logged, or not published, at their stamps"))
    if bag.expected_samples is not None:
        found = max(counts.messages)
        message = f"the bag's end counts {bag.expected_samples} samples, the bag holds {found}"
        laws.append(_flag("sample count", abs(bag.expected_samples - found), message))
    return (*laws, *sensors.whole)


def _frames(surveyed: Survey) -> LawResult:
    scenarios = [segment.scenario for segment in surveyed.declared]
    declared = sorted({frame for scenario in scenarios for frame in (scenario.world_frame, scenario.body_frame)})
    others = sorted(surveyed.counts.foreign_frames)
    message = f"frames {', '.join(map(repr, others))} are not those declared: {', '.join(declared)}"
    return _flag("frames", len(others), message)


def _clock_faults(surveyed: Survey) -> Iterator[str]:
    """Faults of resets that are not at a sample of the clock before, or whose clock neither goes on nor begins anew."""
    segments = surveyed.declared
    if surveyed.as_written and segments[0].first_sample > 0:
        yield f"the first scenario begins with sample {segments[0].first_sample}: those before it are not in the bag"
    for before, after in itertools.pairwise(segments):
        number = before.clock().count_until(after.start_ns) - 1
        goes_on = (before.scenario.epoch_ns, number) if before.scenario.rate == after.scenario.rate else None
        if before.clock().stamp_ns(number) != after.start_ns or (after.scenario.epoch_ns, after.first_sample) not in (
            goes_on,
            (after.start_ns, 0),
        ):
            yield f"the scenario that starts at {after.start_ns} ns does not follow the clock of the one before it"


def _twist_faults(bag: Bag | Recording, surveyed: Survey) -> Iterator[str]:
    stamped = bag.stamped
    if any(segment.scenario.stamped_twist != stamped for segment in surveyed.declared):
        yield f"a scenario declares stamped_twist {str(not stamped).lower()}, the twists are otherwise"


def _contradictions(surveyed: Survey) -> Iterator[str]:
    for start_ns in surveyed.counts.contradicted_ns:
        yield f"a scenario that starts at {start_ns} ns contradicts the one whose samples came before it"


def _flag(name: str, faults: int, message: str) -> LawResult:
    """The result of a law of the bag as a whole, which holds where there are no faults."""
    return LawResult(name, "", float(faults), 0.0, None, None, faults, 1, message if faults else "")


def impossible(error: ParameterError) -> LawResult:
    """Broken law of a bag that declares an impossible body, which has no motion to be compared with."""
    return _flag("declaration", 1, f"the bag declares an impossible scenario: {error}")


def not_certified(
    bag: Bag | Recording, surveyed: Survey, sensors: SensorFindings, inertia: Sequence[float] | None = None
) -> tuple[str, ...]:
    """Parts of a bag that are not certified, in words.

    Parameters
    ----------
    bag : Bag or Recording
    surveyed : Survey
    sensors : SensorFindings
        Of the same bag.
    inertia : sequence of float, optional
        That which was used in place of the declared one, kg m².
    """
    return (
        f"who wrote it (it says {bag.library!r:.50})",
        f"the names of topics ({bag.pose_topic}, {bag.twist_topic})",
        "with which stepper (motion, method and max_step set the limits)",
        "the scale of the inertia, which no torque-free motion shows",
        *_ends(bag, surveyed),
        *_unshown(surveyed),
        *uncovered(bag, surveyed, sensors, inertia),
        *_unread(bag),
        "and what stands beside the messages: attachments, sequence numbers, qualities of service, padding",
    )


def uncovered(
    bag: Bag | Recording, surveyed: Survey, sensors: SensorFindings, inertia: Sequence[float] | None = None
) -> tuple[str, ...]:
    """Parts of a bag that are not certified, though a bag as its scenarios determine it has no such parts.

    Topics that no scenario determines, those that the scenarios have and the bag has not, and the like. See
    `not_certified` for the parameters.
    """
    unused = len(surveyed.declared) - len({found.segment.start_ns for found in surveyed.segments})
    repeated = len(bag.scenario_texts) - len(surveyed.declared)
    alone = sum(surveyed.counts.messages) - 2 * sum(found.count for found in surveyed.segments)
    return (
        *([f"the inertia that it declares: {', '.join(f'{v:g}' for v in inertia)} is used instead"] if inertia else []),
        *([f"scenarios without a sample: {unused}"] if unused else []),
        *([f"scenario messages that repeat another one: {repeated}"] if repeated else []),
        *([f"poses and twists without the other of their stamp: {alone}"] if alone else []),
        *sensors.not_certified,
        *bag.others,
    )


def _ends(bag: Bag | Recording, surveyed: Survey) -> Iterator[str]:
    if not surveyed.as_written:
        yield "log times: a recorder's"
        yield "what came before its first sample"
        if not bag.stamped:
            yield "which twist is of which pose: without stamps they are paired in their order"
    yield "what came after its last sample" + (
        "" if bag.expected_samples is None else ": whoever cuts samples off can lower their count"
    )


def _unshown(surveyed: Survey) -> Iterator[str]:
    if any(segment.scenario.has_sensors for segment in surveyed.declared):
        yield "parameters of the sensors that no reading shows"


def _unread(bag: Bag | Recording) -> Iterator[str]:
    for topic in bag.undefined:
        yield f"the definition of {topic}: none that is compared"
    if bag.without_checksum:
        yield f"bytes that no law reads: parts without a checksum: {bag.without_checksum}"
