"""What of a bag no law speaks of: a certificate says so, lest anyone take it for certified."""

from __future__ import annotations

from collections.abc import Iterator

from lie_rigid_body.certificate.sensors import SensorFindings
from lie_rigid_body.certificate.survey import Survey
from lie_rigid_body.recording.bag_reader import Bag, Recording


def not_certified(bag: Bag | Recording, surveyed: Survey, sensors: SensorFindings) -> tuple[str, ...]:
    """What of a bag is not certified, in words.

    Parameters
    ----------
    bag : Bag or Recording
    surveyed : Survey
    sensors : SensorFindings
        Of the same bag.
    """
    return (
        f"who wrote it (it says {bag.library!r:.50})",
        f"the names of topics ({bag.pose_topic}, {bag.twist_topic})",
        "with which stepper (motion, method and max_step set the limits)",
        "the scale of the inertia, which no torque-free motion shows",
        *_ends(bag, surveyed),
        *_unshown(surveyed),
        *uncovered(bag, surveyed, sensors),
        *_unread(bag),
        "and the fields that docs/certificate.md says are not",
    )


def uncovered(bag: Bag | Recording, surveyed: Survey, sensors: SensorFindings) -> tuple[str, ...]:
    """What is not certified of this bag, and would be, or would not be there, in one that its scenarios determine.

    Topics that no scenario determines, those that the scenarios have and the bag has not, and the like. See
    `not_certified` for the parameters.
    """
    followed = {found.segment.start_ns for found in surveyed.segments}
    unused = sum(segment.start_ns not in followed for segment in surveyed.declared)
    return (*([f"scenarios without a sample: {unused}"] if unused else []), *sensors.not_certified, *bag.others)


def _ends(bag: Bag | Recording, surveyed: Survey) -> Iterator[str]:
    if not surveyed.as_written:
        yield "log times: a recorder's"
        yield "what came before its first sample"
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
