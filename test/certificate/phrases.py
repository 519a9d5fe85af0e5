"""Wording of what certificates tell of a bag, and refuse: other tests give its name."""

from __future__ import annotations

from lie_rigid_body.certificate import Certificate
from lie_rigid_body.foundation.errors import BagError
from said import refusals

PHRASES = {
    # what is not certified
    "before": "what came before its first sample",
    "after": "what came after its last sample",
    "bare twists": "which twist is of which pose",
    "recorder's log times": "log times: a recorder's",
    "beside the messages": "what stands beside the messages: attachments, sequence numbers, ",
    "stray": "topic {topic} ({count} messages), which the scenarios of the body do not determine",
    "another type": "topic {topic} (as {kind}, 0 messages), which the scenarios of the body do not determine",
    "another version": "the scenario is of '{software}'",
    "scenarios again": "scenario messages that repeat another one: {count}",
    "samples in half": "poses and twists without the other of their stamp: {count}",
    "scenarios without a sample": "scenarios without a sample: {count}",
    "faults again": "messages about faults that come again: {count}",
    "which clock": "{topic}: a reset changes the sensor's clock",
    "not to the bit": "It is not equal to the bit to what is computed here",
    # notes
    "silent": "no reading on {topic}: ",
    "all lost": "no reading on {topic}: the scenario loses all {count} of this segment",
    "none arrives": "no reading on {topic}: none arrives within this segment",
    "recorder lacks": "no reading on {topic}: what a recorder lacks",
    "ends": "readings on {topic} end with ",
    # what is wrong
    "lost": ", which the scenario loses",
    "late beginning": "begins with sample {sample}: those before it are not in the bag",
    "another clock": "does not follow the clock of the one before it",
    "fault missing": "{topic}: 1 missing, the first: ",
    "fault unknown": "{topic}: 1 of which the scenario makes none, the first: message {message} (",
    "fault twice": "{topic}: 1 twice, the first: message {message} (",
    "faults out of order": "{topic}: 1 out of order, the first: message ",
    "no fault": "{topic}: 1 that tell of no fault, the first: message {message};",
}
refused = refusals(
    {
        BagError: {
            "unpaired": "{twists} twists without stamps cannot be paired with {poses} poses",
            "too many missing": "{topic}: {count} readings are missing before reading {number}",
            "too early": "before the first scenario message",
        }
    }
)


def telling(found: Certificate, name: str, **values: object) -> list[str]:
    """What a certificate tells that has a phrase in it."""
    notes = [note for segment in found.segments for note in segment.notes]
    phrase = PHRASES[name].format_map(values)
    return [text for text in (*found.messages, *found.not_certified, *notes) if phrase in text]
