"""What of a bag no law speaks of: a certificate says so, lest anyone take it for certified."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lie_rigid_body.certificate.segments import RecordedSegment, as_written, declared_segments
from lie_rigid_body.recording.bag_reader import Recording


def not_certified(recording: Recording, segments: Sequence[RecordedSegment]) -> tuple[str, ...]:
    """What of a recording is not certified, in words.

    Parameters
    ----------
    recording : Recording
    segments : sequence of RecordedSegment
        Of the same recording.
    """
    return (
        f"who wrote it (it says {recording.library!r:.50})",
        f"the names of topics ({recording.poses.topic}, {recording.twists.topic})",
        "with which stepper (motion, method and max_step set the limits)",
        "the scale of the inertia, which no torque-free motion shows",
        *_ends(recording),
        *_declared_only(recording, segments),
        *_unread(recording),
        "and the fields that docs/certificate.md says are not",
    )


def _ends(recording: Recording) -> Iterator[str]:
    if not as_written(recording):
        yield "log times: a recorder's"
        yield "what came before its first sample"
    if recording.expected_samples is None:
        yield "what came after its last sample"


def _declared_only(recording: Recording, segments: Sequence[RecordedSegment]) -> Iterator[str]:
    declared = declared_segments(recording)
    followed = {recorded.segment.start_ns for recorded in segments}
    if unused := sum(segment.start_ns not in followed for segment in declared):
        yield f"scenarios without a sample: {unused}"
    if any(segment.scenario.has_sensors for segment in declared):
        yield "parameters of the sensors"


def _unread(recording: Recording) -> Iterator[str]:
    yield from recording.others
    for topic in recording.undefined:
        yield f"the definition of {topic}: none that is compared"
    if recording.without_checksum:
        yield f"bytes that no law reads: parts without a checksum: {recording.without_checksum}"
