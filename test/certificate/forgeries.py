"""Ways to alter one field of a bag: in its records and bytes, its payloads and texts, or beside it in a folder."""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml
from forging import copy, forge
from mcap.writer import CompressionType

from lie_rigid_body.messages import encode_string
from lie_rigid_body.recording.bag_reader import read_bag

RATE = 8.0
COUNT = 12
Forgery = Callable[[Path, Path], Path]
"""Makes an altered bag in a folder from the honest one."""


def in_records(**kinds: Callable[[Any], dict[str, object]]) -> Forgery:
    return lambda honest, folder: forge(copy(honest, folder / "forged.mcap"), **kinds)


def in_one(field: str, by: int = 1, **options: Any) -> Callable[[Any], dict[str, object]]:
    """Changes a number in the first record of a kind."""
    seen: list[int] = []

    def change(record: Any) -> dict[str, object]:
        seen.append(1)
        return {field: getattr(record, field) + by} if len(seen) == 1 else {}

    return change


def number(kind: str, field: str, by: int = 1) -> Forgery:
    def forgery(honest: Path, folder: Path) -> Path:
        return in_records(**{kind: in_one(field, by)})(honest, folder)

    return forgery


def text(kind: str, field: str, old: str, new: str) -> Forgery:
    """Changes a text wherever it is, in the record and its repeats and indexes."""
    changes = {}
    for name in (kind, f"{kind}Index"):
        if name == kind or kind in ("Attachment", "Metadata"):
            changes[name] = lambda r: {field: getattr(r, field).replace(old, new)} if hasattr(r, field) else {}
    return in_records(**changes)


def in_bytes(old: bytes, new: bytes, which: int = 0, compression: CompressionType = CompressionType.NONE) -> Forgery:
    """Changes the bytes where they occur for a given time, -1 the last."""

    def forgery(honest: Path, folder: Path) -> Path:
        path = copy(honest, folder / "forged.mcap", compression=compression)
        data = path.read_bytes()
        places = [m.start() for m in re.finditer(re.escape(old), data)]
        at = places[which]
        path.write_bytes(data[:at] + new + data[at + len(old) :])
        return path

    return forgery


def in_payload(topic: str, change: Callable[[bytes], bytes], index: int = 5) -> Forgery:
    def forgery(honest: Path, folder: Path) -> Path:
        numbers = iter(range(10**6))
        return copy(
            honest,
            folder / "forged.mcap",
            lambda name, data: change(data) if name == topic and next(numbers) == index else data,
        )

    return forgery


def shortened(count: int | None = None) -> Forgery:
    """The last four samples cut off, and the counts with them unless that of the samples is given."""
    last = 10**18 + round((COUNT - 5) / RATE * 1e9)
    return lambda honest, folder: copy(honest, folder / "forged.mcap", last=last, count=count)


def patched(at: int, code: str, change: Callable[[Any], Any]) -> Callable[[bytes], bytes]:
    """Changes a number in a payload, counted from its end where ``at`` is negative."""

    def patch(data: bytes) -> bytes:
        begin = at % len(data)
        size = struct.calcsize(code)
        [value] = struct.unpack(code, data[begin : begin + size])
        return data[:begin] + struct.pack(code, change(value)) + data[begin + size :]

    return patch


def renamed(frame: bytes) -> Callable[[bytes], bytes]:
    return lambda data: data.replace(frame, frame[::-1])


def in_json(change: Callable[[dict[str, Any]], object]) -> Forgery:
    def altered(data: bytes) -> bytes:
        content = json.loads(data[8:-1])
        change(content)
        return encode_string(json.dumps(content))

    return in_payload("/lie_rigid_body/scenario", altered, 0)


def json_value(name: str, value: object) -> Forgery:
    return in_json(lambda content: content.update({name: value}))


def in_yaml(change: Callable[[dict[str, Any]], object]) -> Forgery:
    """A rosbag2 folder with one entry of its metadata changed."""

    def forgery(honest: Path, folder: Path) -> Path:
        copy(honest, folder / "a.mcap")
        recording = read_bag(folder / "a.mcap")
        times = {
            "duration": {"nanoseconds": int((COUNT - 1) / RATE * 1e9)},
            "starting_time": {"nanoseconds_since_epoch": 10**18},
        }
        counts = {
            "/pose": ("geometry_msgs/msg/PoseStamped", len(recording.poses.stamps_ns)),
            "/twist": ("geometry_msgs/msg/TwistStamped", len(recording.twists)),
            "/lie_rigid_body/scenario": ("std_msgs/msg/String", 1),
            "/lie_rigid_body/faults": ("std_msgs/msg/String", 3),
            "/imu/data_raw": ("sensor_msgs/msg/Imu", 6),
            "/imu/bias": ("sensor_msgs/msg/Imu", 6),
            "/imu/mag": ("sensor_msgs/msg/MagneticField", 3),
            "/attitude/pose": ("geometry_msgs/msg/PoseWithCovarianceStamped", 6),
            "/sun/direction": ("geometry_msgs/msg/Vector3Stamped", 3),
        }
        total = sum(count for _, count in counts.values())
        content: dict[str, Any] = {
            "version": 9,
            "storage_identifier": "mcap",
            **times,
            "message_count": total,
            "topics_with_message_count": [
                {
                    "topic_metadata": {
                        "name": name,
                        "type": kind,
                        "serialization_format": "cdr",
                        "offered_qos_profiles": "",
                    },
                    "message_count": count,
                }
                for name, (kind, count) in counts.items()
            ],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": ["a.mcap"],
            "files": [{"path": "a.mcap", **json.loads(json.dumps(times)), "message_count": total}],
            "custom_data": None,
            "ros_distro": "jazzy",
        }
        change(content)
        (folder / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": content}))
        return folder

    return forgery


def hidden_file(honest: Path, folder: Path) -> Path:
    (folder / "b.mcap").write_bytes(honest.read_bytes())
    return in_yaml(lambda y: None)(honest, folder)
