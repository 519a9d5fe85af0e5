"""Comparison of the metadata.yaml of a rosbag2 folder with the files in it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from lie_rigid_body.errors import BagError
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.inflation import COMPRESSED_ONE_BY_ONE
from lie_rigid_body.recording.mcap_contents import FileSpan, McapContents

_TOLERANCE_NS: Final = NS
"""A recorder notes start and duration beside its messages; they are off by what it drops or sorts anew."""


def hold(metadata: Path, information: Mapping[str, Any], contents: McapContents) -> None:
    """Refuse metadata that do not fit the files; what they leave out is not missed.

    Parameters
    ----------
    metadata : Path
        The metadata.yaml.
    information : mapping
        What it says under ``rosbag2_bagfile_information``.
    contents : McapContents
        Of all files.

    Raises
    ------
    BagError
        Naming the first entry that does not fit.
    """
    if str(information.get("compression_mode")).upper() == "MESSAGE":
        raise BagError(f"{metadata.parent}: {COMPRESSED_ONE_BY_ONE}")
    try:
        found = dict(_faults(metadata.parent, information, contents))
    except (TypeError, LookupError, AttributeError, ValueError):
        found = {"structure": "not that of a rosbag2 bag"}
    if found:
        what, how = next(iter(found.items()))
        raise BagError(f"{metadata} does not fit its files: {what}: {how}: remake it with 'ros2 bag reindex'")


def _faults(folder: Path, said: Mapping[str, Any], contents: McapContents) -> list[tuple[str, str]]:
    spans = contents.files
    whole = FileSpan("", sum(s.count for s in spans), min(s.first_ns for s in spans), max(s.last_ns for s in spans))
    listed = {str(name) for name in said["relative_file_paths"]}
    faults = [
        ("relative_file_paths", f"{path.name} is left out")
        for path in sorted([*folder.glob("*.mcap"), *folder.glob("*.db3")])
        if path.name not in listed
    ]
    storage = "sqlite3" if spans[0].name.endswith(".db3") else "mcap"
    faults += _differs("storage_identifier", said.get("storage_identifier", storage), storage)
    faults += _differs("compression_mode", str(said.get("compression_mode") or "NONE").upper(), "NONE")
    faults += _span_faults("", said, whole)
    if "topics_with_message_count" in said:
        faults += _topic_faults(said["topics_with_message_count"], contents)
    if said.get("files"):
        by_name = {Path(file["path"]).name: file for file in said["files"]}
        faults += _differs("files", sorted(by_name), sorted(span.name for span in spans))
        for span in spans:
            faults += _span_faults(f"{span.name}: ", by_name.get(span.name, {}), span)
    return faults


def _span_faults(whose: str, said: Mapping[str, Any], found: FileSpan) -> list[tuple[str, str]]:
    faults = _differs(f"{whose}message_count", said.get("message_count", found.count), found.count)
    if found.count and "starting_time" in said:
        start = said["starting_time"]["nanoseconds_since_epoch"]
        faults += _differs(f"{whose}starting_time", start, found.first_ns, _TOLERANCE_NS)
    if found.count and "duration" in said:
        span = said["duration"]["nanoseconds"]
        faults += _differs(f"{whose}duration", span, found.last_ns - found.first_ns, _TOLERANCE_NS)
    return faults


def _topic_faults(said: list[Mapping[str, Any]], contents: McapContents) -> list[tuple[str, str]]:
    topics = {
        (t["topic_metadata"]["name"], t["topic_metadata"]["type"], t["topic_metadata"]["serialization_format"]): t[
            "message_count"
        ]
        for t in said
        if t["message_count"]
    }
    found = {(t.topic, t.message_type, t.encoding): t.count for t in contents.tracks.values() if t.count}
    odd = [topic for topic in {**topics, **found} if topics.get(topic) != found.get(topic)]
    return [
        (f"topic {name}", f"{topics.get(key, 0)} messages said, {found.get(key, 0)} found")
        for key in odd
        for name in key[:1]
    ]


def _differs(what: str, said: Any, found: Any, by: int = 0) -> list[tuple[str, str]]:
    same = abs(said - found) <= by if by else said == found
    return [] if same else [(what, f"{said!r:.40} said, {found!r:.40} found")]
