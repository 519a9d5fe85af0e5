"""Honest bags, parameter files and campaigns, and cases of them that are changed in the places that they have."""

from __future__ import annotations

import json
import signal
import struct
import tempfile
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from random import Random
from typing import Any

import yaml
from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC as MAGIC
from mcap.writer import CompressionType

from foreign_bags import Message, bag_of, messages_of, record, records_of

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)
WORDS = (0, 1, 2, 3, 37, 255, 256, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)
INFINITE, NAN = float("inf"), float("nan")
FLOATS = (0.0, -0.0, 1.0, -1.0, 1e-9, 1e9, 1e-308, 5e-324, 1e154, 1e308, -1e308, INFINITE, -INFINITE, NAN)
VALUES: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 2**31, 2**63, -(2**63), 10**30, 10**400,
    0.5, 1e-300, 1e300, float("nan"), float("inf"), "",
    "x", "/", "a/b", "\x1b[2J", "\u202e", "é" * 300, [], [0], [1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0], [1e200] * 3, {},
    {"a": 1}, [[1.0]], "moving_chart", "closed_form", "nan", "1e5", "0x10", "1:30", "2001-01-01",
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """Files, the command line of a verb that reads them, and the signal that it gets after some time, s."""

    files: dict[str, bytes]
    command: tuple[str, ...]
    signal: int = 0
    after_s: float = 0.0
    original: str = ""


# honest inputs


def honest() -> dict[str, bytes]:
    """Small honest bags by their names."""
    from lie_rigid_body import simulate

    found = {}
    sensors = {"imu_rate": 10.0, "magnetometer_rate": 5.0, "gyro_noise_density": 1e-4}
    scenarios: dict[str, dict[str, Any]] = {
        "exact": {"motion": "closed_form", "rate": 20.0, **sensors},
        "steps": {"rate": 10.0, "inertia": [1.0, 0.1, 0.0, 2.0, 0.2, 2.5]},
        "faults": {
            "motion": "closed_form",
            "rate": 10.0,
            "imu_rate": 50.0,
            "imu_dropout_probability": 0.2,
            "imu_latency": 0.001,
        },
    }
    for name, parameters in scenarios.items():
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "bag.mcap")
            simulate(duration=0.5, **parameters).to_bag(path)
            found[name] = path.read_bytes()
            if name == "exact":
                found["lz4"] = rewritten(messages_of(found[name]), "lie_rigid_body", CompressionType.LZ4)
                found["recorder"] = rewritten(messages_of(found[name]), "libmcap 1.0", CompressionType.NONE)
                poses = [m for m in messages_of(found[name]) if m.topic == "/pose"]
                estimates = [m._replace(topic="/estimate") for m in poses]
                found["estimate"] = rewritten([*messages_of(found[name]), *estimates], "libmcap 1.0")
    return found


def rewritten(
    messages: list[Message],
    library: str,
    compression: CompressionType = CompressionType.ZSTD,
    *,
    checksums: bool = True,
) -> bytes:
    """A file of messages that is whole in itself."""
    return bag_of(
        messages, library, compression=compression, chunk_size=4096, enable_crcs=checksums, enable_data_crcs=False
    )


# mutations: functions of a random state and of what is mutated


def mutated_bytes(random: Random, data: bytes) -> bytes:
    """Bytes with a piece flipped, overwritten, left out, doubled, moved or cut off."""
    at = random.randrange(len(data) + 1)
    size = random.choice((1, 1, 2, 4, 8, 9, 31, random.randrange(1, 300)))
    piece, rest = data[at : at + size], data[at + size :]
    match random.randrange(7):
        case 0:
            return data[:at] + bytes(b ^ 1 << random.randrange(8) for b in piece[:1]) + data[at + 1 :]
        case 1:
            return data[:at] + random.choice(WORDS).to_bytes(8, "little")[: len(piece)] + rest
        case 2:
            return data[:at] + rest
        case 3:
            return data[:at] + 2 * piece + rest
        case 4:
            return data[:at]
        case 5:
            return data[:at] + random.randbytes(len(piece)) + rest
        case _:
            to = random.randrange(len(rest) + 1)
            return data[:at] + rest[:to] + piece + rest[to:]


def mutated_records(random: Random, data: bytes) -> bytes:
    """An MCAP file with one record left out, doubled, moved, of another kind, or with other content."""
    records = records_of(data)
    if not records:
        return mutated_bytes(random, data)
    i = random.randrange(len(records))
    opcode, content = records[i]
    match random.randrange(6):
        case 0:
            records[i : i + 1] = []
        case 1:
            records.insert(random.randrange(len(records)), records[i])
        case 2:
            records.insert(random.randrange(len(records)), records.pop(i))
        case 3:
            records[i] = random.randrange(16), content
        case 4:
            width = random.choice((1, 2, 4, 8))
            place = random.randrange(max(1, len(content) - width + 1))
            value = random.choice(WORDS).to_bytes(8, "little")[:width]
            records[i] = opcode, content[:place] + value + content[place + width :]
        case _:
            records[i] = opcode, mutated_bytes(random, content)
    return data[:8] + b"".join(record(*one) for one in records) + data[-8:]


def mutated_messages(random: Random, data: bytes) -> bytes:
    """A file whose messages are changed, and which is then written anew, whole in itself."""
    try:
        messages = messages_of(data)
        library = make_reader(BytesIO(data)).get_header().library
    except Exception:
        return mutated_bytes(random, data)
    if not messages:
        return mutated_bytes(random, data)
    i = random.randrange(len(messages))
    if random.random() < 0.3:  # there are few of them
        i = next((k for k, m in enumerate(messages) if m.topic.endswith("scenario")), i)
    message = messages[i]
    match random.randrange(9):
        case 0:
            messages[i : i + 1] = []
        case 1:
            messages.insert(random.randrange(len(messages)), message)
        case 2:
            messages.insert(random.randrange(len(messages)), messages.pop(i))
        case 3:
            topic = random.choice(
                [m.topic for m in messages] + ["", "x", "/a/pose", "/scenario", "/tf", "/" + "n" * 5000]
            )
            messages[i] = message._replace(topic=topic)
        case 4:
            messages[i] = message._replace(
                kind=random.choice([m.kind for m in messages] + ["", "nav_msgs/msg/Odometry"])
            )
        case 5:
            delta = random.choice((1, -1, 10**6, 10**9, 2**62, 2**63))
            messages[i] = message._replace(log_time=abs(message.log_time + delta) % 2**64)
        case _:
            messages[i] = message._replace(data=mutated_payload(random, message.data))
    try:
        return rewritten(messages, library)
    except Exception:
        return mutated_bytes(random, data)


def mutated_payload(random: Random, data: bytes) -> bytes:
    """A CDR message with one float, word or text of it changed; a scenario with one value."""
    if b'"inertia"' in data:
        try:
            text = mutated_json(random, data[8:-1].decode())
            return data[:4] + struct.pack("<I", len(text.encode()) + 1) + text.encode() + b"\0"
        except ValueError:
            return mutated_bytes(random, data)
    width = random.choice((4, 8, 8, 8))
    if len(data) < 4 + width or random.random() < 0.15:
        return mutated_bytes(random, data)
    at = 4 + width * random.randrange((len(data) - 4) // width) + (len(data) - 4) % width * (width == 8)
    if width == 8:
        (before,) = struct.unpack_from("<d", data, at)
        value = random.choice((*FLOATS, before * (1 + 1e-12), before + 1e-9, -before, before * 2))
        return data[:at] + struct.pack("<d", value) + data[at + 8 :]
    return data[:at] + random.choice(WORDS).to_bytes(8, "little")[:4] + data[at + 4 :]


def mutated_tree(random: Random, tree: Any) -> Any:
    """A value of JSON or YAML in which one value is another one, left out, doubled or nested."""
    if isinstance(tree, dict) and tree and random.random() < 0.9:
        key = random.choice([*tree])
        if random.random() < 0.15:
            return {k: v for k, v in tree.items() if k != key}
        if random.random() < 0.1:
            return {**tree, random.choice((f"{key}x", "", "inertia", "rate", "imu_rate", "<<")): tree[key]}
        return {**tree, key: mutated_tree(random, tree[key])}
    if isinstance(tree, list) and tree and random.random() < 0.7:
        i = random.randrange(len(tree))
        return [*tree[:i], *([] if random.random() < 0.2 else [mutated_tree(random, tree[i])]), *tree[i + 1 :]]
    if isinstance(tree, int | float) and not isinstance(tree, bool) and random.random() < 0.5:
        return random.choice((tree * 2, -tree, tree + 1, tree * 1e6, tree * (1 + 1e-12), tree * 1e-6, 1e9, 1e-9, 2**62))
    return random.choice(VALUES)


def mutated_json(random: Random, text: str) -> str:
    """A JSON text with one value changed, or a name given twice."""
    tree = mutated_tree(random, json.loads(text))
    again = json.dumps(tree)
    return again.replace("{", '{"rate": 5.0, ', 1) if random.random() < 0.05 else again


def mutated_yaml(random: Random, data: bytes) -> bytes:
    """A YAML text with one value or some bytes changed."""
    if random.random() < 0.2:
        return mutated_bytes(random, data)
    try:
        return yaml.safe_dump(mutated_tree(random, yaml.safe_load(data)), allow_unicode=True).encode()
    except Exception:
        return mutated_bytes(random, data)


def mutated_bag(random: Random, data: bytes) -> bytes:
    """A bag that is changed as bytes, as records or as messages, or another file of that beginning."""
    if random.random() < 0.06:
        return random.choice((b"", MAGIC)) + random.randbytes(400)
    return random.choice((mutated_bytes, mutated_records, mutated_messages, mutated_messages))(random, data)


PARAMETERS = b"""/**:
  ros__parameters: {inertia: [1.0, 2.0, 3.0], initial_body_rate: [0.1, 1.0, 0.2], rate: 20.0, motion: closed_form,
    max_step: 0.001, epoch_ns: 5, world_frame: w, imu_rate: 10.0, imu_dropout_probability: 0.1,
    gyro_noise_density: 0.001}
"""
CAMPAIGN = b"""{runs: 2, seed: 7, duration: 0.2, scenario: tumbling_cubesat, parameters: {rate: 20.0, imu_rate: 20.0},
  vary: {
  initial_attitude_xyzw: {distribution: uniform_rotation},
  inertia: {distribution: box, mass: 8.0, edges: [[0.1, 0.3], [0.1, 0.3], [0.1, 0.4]]},
  gyro_noise_density: {distribution: loguniform, low: 0.00001, high: 0.001},
  motion: {distribution: choice, values: [moving_chart, closed_form]}}}
"""
METADATA = b"""rosbag2_bagfile_information: {version: 5, storage_identifier: mcap, relative_file_paths: [b_0.mcap],
  duration: {nanoseconds: 450000000}, starting_time: {nanoseconds_since_epoch: 0}, compression_mode: ''}
"""
VERBS: dict[str, tuple[float, tuple[str, ...]]] = {
    "check": (4, ("check", "x.mcap")),
    "check --json": (1, ("check", "x.mcap", "--json")),
    "check --report": (0.3, ("check", "x.mcap", "--report", "out.html")),
    "check of a folder": (1, ("check", "b")),
    "recover": (2, ("recover", "x.mcap", "-o", "out.mcap")),
    "evaluate": (2, ("evaluate", "x.mcap", "--estimate", "/estimate")),
    "evaluate of the truth": (0.5, ("evaluate", "x.mcap", "--estimate", "/pose", "--json")),
    "plot": (0.3, ("plot", "x.mcap", "-o", "out.png")),
    "Run.from_bag": (2, ("Run.from_bag", "x.mcap")),
    "record": (1.5, ("record", "out.mcap", "--params-file", "p.yaml", "--duration", "0.3", "--quiet")),
    "explain": (1, ("explain", "--params-file", "p.yaml")),
    "campaign": (0.02, ("campaign", "c.yaml", "--out", "out", "--workers", "1")),
}
"""Verbs by what they are called in the counts: how often each is tried, and its command line."""


def of_verb(name: str, content: bytes, original: str) -> Case:
    """A case of a verb whose other files are honest."""
    return _case(VERBS[name][1], content, original, PARAMETERS, CAMPAIGN, METADATA)


def _case(
    command: tuple[str, ...], content: bytes, original: str, parameters: bytes, campaign: bytes, metadata: bytes
) -> Case:
    found = {"x.mcap": content, "p.yaml": parameters, "c.yaml": campaign}
    found |= {"b/b_0.mcap": content, "b/metadata.yaml": metadata}
    used = {file: data for file, data in found.items() if {file, file.partition("/")[0]} & {*command}}
    return Case(used, command, original=original)


def drawn(random: Random, bags: dict[str, bytes]) -> Case:
    """A case, drawn at random."""
    name = random.choices([*VERBS], [weight for weight, _ in VERBS.values()])[0]
    command = VERBS[name][1]
    times = random.choice((1, 1, 1, 2, 3, 4))
    original = random.choice([*bags])
    if name == "evaluate" or random.random() < 0.1:
        original = "estimate"
    content, parameters, campaign, metadata = bags[original], PARAMETERS, CAMPAIGN, METADATA
    for _ in range(times):
        if command[0] == "campaign":
            campaign = mutated_yaml(random, campaign)
        elif "p.yaml" in command:
            parameters = mutated_yaml(random, parameters)
        elif command[1:] == ("b",) and random.random() < 0.5:
            metadata = mutated_yaml(random, metadata)
        else:
            content = mutated_bag(random, content)
    case = _case(command, content, original, parameters, campaign, metadata)
    if random.random() < 0.1 and command[0] != "campaign":
        case = replace(
            case, signal=random.choice(SIGNALS), after_s=random.choice((0.0, 0.001, 0.02, random.random() * 0.5))
        )
    return case
