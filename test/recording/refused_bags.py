"""Wording of what is refused on the way into a bag and out of it, one line an error: other tests give its name."""

from __future__ import annotations

from lie_rigid_body.foundation.errors import BagError, InputError
from said import refusals

FAULTS = {
    "no topic": "x.mcap has {scenario} and no topic {topic}: record it as well",
    "no message": "x.mcap has no message on {topic}: record it while the body is published",
    "several topics": "x.mcap has several topics {kind}: ",
}
"""What one of several bodies lacks, and how that is said."""
KEPT = "; the older file of that name is kept: "

refused = refusals(
    {
        BagError: {
            # what a bag is
            "name too long": "File name too long",
            "pipe": "{name} is a pipe: give a regular file",
            "several bags": " holds {count} bags, not one recording: give one of them",
            "changed": "changed while it was read",
            # its metadata
            "null": "embedded null",
            "metadata": "is not the metadata",
            # its content
            "cut off": r"(cut off.* holds? (at least \d+ )?whole messages|breaks off in its summary).* recover",
            "killed": "it holds at least {count} whole messages: .*lie-rigid-body recover",
            # its topics
            "topics of a type": "no topic .*{name}.*/rosout",
            "no topic": "no topic {name}: ",
            "no topic, but one like it": "no topic {name}: did you mean {like}",
            "no topic of the type": "no topic {name}: no topic is of {kind}",
            "no topic of the body": "no topic {name}: record it",
            "no scenario": r"has no topic \.\.\./scenario \(String: body, motion, frames\): record it; there are /",
            "topic of another type": "{name} is of {kind}, not {wanted}: the topics of {wanted} are {those}",
            "no message": "no message on {topic}",
            "bodies": "holds 2 bodies, /a, /b: say which, as by topics=..pose.: .{pose}.",
            "several topics": "several topics.*{choice}",
            # its messages
            "size of a message": r"topic {topic}: message {number} has \d+ bytes where",
            "message cut": "topic {topic}: message {number} has {size} bytes.*: record the bag again",
            "no CDR": "topic {topic}: message {number} begins with {begin} .* not plain CDR",
            "compressed messages": "record without '--compression-mode message'",
            "field": "ends after|where its fields|where its type",
            "no fault": "tells of no fault",
            "no scenario text": "does not explain itself",
            # writing
            "exists": "exists and is kept: .*--force",
            "dangling link": "{name} is a link that leads to no file: remove it",
            "folder": "is a folder",
            "no folder": "folder .*none does not exist",
            "file as folder": "Not a directory",
            "not regular": "not a regular file",
            "no place": "cannot be created: No such file",
            "cannot be created": "cannot be created: {why}",
            "disk": "{name} cannot be written: {why}; {advice}.* rescue it",
            "slow disk": "{name} cannot be written: the disk does not keep up.*look after.* recover",
            "type of the twist": "stamped_twist cannot change",
            "finished": "already finished",
        },
        InputError: {
            "no JSON": "not readable as JSON",
        },
    }
)
