"""Mutated bags, parameter files and campaigns into every verb that reads them, with laws that hold whatever they are.

`make fuzz ARGS='--minutes 10'`. Each case is a small honest input, changed in one to four places that its structure
knows, and a verb; some are sent a signal at a random moment. The laws:

- no traceback, no "this is a bug", no warning of a library, one line on stderr where the status is 2;
- a status that is documented: 0, 1, 2, and 130 after a signal;
- at most 20 s on the processor and 512 MiB;
- no file changed or written but the one that was asked for;
- nothing certified in which a pose, a twist or a reading differs from the honest one, as the `mcap` library and rosbags
  read it.

What breaks one is made smaller and kept in test/fuzzed, where `test_fuzzed.py` tries it again.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import json
import os
import resource
import shutil
import signal
import struct
import sys
import tempfile
import time
import traceback
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import yaml
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

KEPT = Path(__file__).parent / "fuzzed"
SECONDS = 20
MIB = 2**20
MEMORY = 512 * MIB
LONGEST_LINE = 200
ALLOWED = {0, 1, 2}
INTERRUPTED = 130
EARLY = 99
"""Status of a child that the signal met before the verb began."""
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)
SCENARIO = "/lie_rigid_body/scenario"
KINDS = {
    "/pose": "geometry_msgs/msg/PoseStamped",
    "/twist": "geometry_msgs/msg/TwistStamped",
    "/imu/data_raw": "sensor_msgs/msg/Imu",
    "/imu/mag": "sensor_msgs/msg/MagneticField",
}
"""Types, by topic, of the messages that are compared with the honest ones."""
TOLERANCE = 1e-9
"""What a certified number may be off the honest one: the limits of attitudes and rates are a thousandth of it."""
WORDS = (0, 1, 2, 3, 37, 255, 256, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)
FLOATS = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-9,
    1e9,
    1e-308,
    5e-324,
    1e154,
    1e308,
    -1e308,
    float("inf"),
    float("-inf"),
    float("nan"),
)
VALUES: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 2**31, 2**63, -(2**63), 10**30, 0.5, 1e-300, 1e300, float("nan"), float("inf"), "",
    "x", "/", "a/b", "\x1b[2J", "\u202e", "é" * 300, [], [0], [1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0], [1e200] * 3, {},
    {"a": 1}, [[1.0]], "moving_chart", "closed_form", "nan", "1e5", "0x10", "1:30", "2001-01-01",
)  # fmt: skip


class Message(NamedTuple):
    """A message as the `mcap` library reads it."""

    topic: str
    kind: str
    definition: bytes
    log_time: int
    publish_time: int
    data: bytes


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


def messages_of(content: bytes) -> list[Message]:
    """Messages of a whole file, read by the `mcap` library."""
    reader = make_reader(BytesIO(content), validate_crcs=False)
    return [
        Message(
            channel.topic,
            schema.name if schema else "",
            schema.data if schema else b"",
            m.log_time,
            m.publish_time,
            m.data,
        )
        for schema, channel, m in reader.iter_messages(log_time_order=False)
    ]


def rewritten(messages: list[Message], library: str, compression: CompressionType = CompressionType.ZSTD) -> bytes:
    """A file of messages by the writer of the `mcap` library, whole in itself."""
    out = BytesIO()
    writer = Writer(out, compression=compression, chunk_size=4096)
    writer.start("ros2", library)
    channels: dict[tuple[str, str], int] = {}
    for number, message in enumerate(messages):
        key = message.topic, message.kind
        if key not in channels:
            schema = writer.register_schema(message.kind, "ros2msg", message.definition)
            channels[key] = writer.register_channel(message.topic, "cdr", schema)
        times = message.log_time & (2**64 - 1), message.publish_time & (2**64 - 1)
        writer.add_message(channels[key], times[0], message.data, times[1], number)
    writer.finish()
    return out.getvalue()


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
    records, at = list[tuple[int, bytes]](), 8
    while at + 9 <= len(data) - 8:
        opcode, length = struct.unpack_from("<BQ", data, at)
        records.append((opcode, data[at + 9 : at + 9 + length]))
        at += 9 + length
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
    return data[:8] + b"".join(struct.pack("<BQ", code, len(c)) + c for code, c in records) + data[-8:]


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
    """A bag that is changed as bytes, as records or as messages."""
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


# running a case in a child of this process, which has loaded everything


class Outcome(NamedTuple):
    """What became of a case, and which law it breaks, if one."""

    status: int
    broken: str
    seconds: float = 0.0
    memory: int = 0
    words: str = ""


def outcome(case: Case, bags: dict[str, bytes]) -> Outcome:
    """Run a case, and hold it against the laws."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    try:
        work, told = folder / "work", folder / "told"
        for path in (work, told):
            path.mkdir()
        for name, data in case.files.items():
            (work / name).parent.mkdir(exist_ok=True)
            (work / name).write_bytes(data)
        status, used = ended(case, work, told)
        said = [(told / name).read_text(errors="replace") for name in ("out", "err")]
        seconds = used.ru_utime + used.ru_stime
        found = Outcome(status, "", seconds, used.ru_maxrss * 1024, said[1][-400:])
        return found._replace(broken=next(broken_laws(case, found, said[0], said[1], work, bags), ""))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def ended(case: Case, work: Path, told: Path) -> tuple[int, Any]:
    """Exit status of the verb, negative where a signal ended it, and what it took."""
    reader, writer = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(reader)
        _child(case, work, told, writer)
    os.close(writer)
    os.read(reader, 1)
    os.close(reader)
    if case.signal:
        time.sleep(case.after_s)
        with suppress(OSError):
            os.kill(pid, case.signal)
    end = time.monotonic() + 10 * SECONDS  # of a loaded machine; the child's own limit is of the processor
    while True:
        found, status, used = os.wait4(pid, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status), used
        if time.monotonic() > end:
            os.kill(pid, signal.SIGKILL)
            _, _, used = os.wait4(pid, 0)
            return -signal.SIGALRM, used
        time.sleep(0.002)


def _child(case: Case, work: Path, told: Path, writer: int) -> None:
    """Run the verb of a case in this process, and end it."""
    status = EARLY
    try:
        os.chdir(work)
        for descriptor, name in ((1, "out"), (2, "err")):
            os.dup2(os.open(told / name, os.O_CREAT | os.O_WRONLY), descriptor)
        sys.stdin = open(os.devnull)  # noqa: SIM115
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        sys.argv = ["lie-rigid-body", *case.command]
        from lie_rigid_body.__main__ import main
        from lie_rigid_body.errors import LieRigidBodyError
        from lie_rigid_body.runs import Run

        os.write(writer, b"\0")
        if case.command[0] == "campaign":  # its workers are other processes, which end with this one
            os.execv(sys.executable, [sys.executable, "-m", "lie_rigid_body", *case.command])
        if case.command[0] == "Run.from_bag":
            try:
                Run.from_bag(case.command[1])
                status = 0
            except LieRigidBodyError as error:
                print(f"error: {error}", file=sys.stderr)
                status = 2
            except KeyboardInterrupt:
                status = EARLY
        else:
            status = main()
    except KeyboardInterrupt:
        status = EARLY
    except BaseException:
        traceback.print_exc()
        status = 98
    finally:
        try:
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            os._exit(status)


def broken_laws(case: Case, found: Outcome, out: str, err: str, work: Path, bags: dict[str, bytes]) -> Iterator[str]:
    """What a case breaks, in words."""
    status = found.status
    signalled = {INTERRUPTED, EARLY, -case.signal} if case.signal else set()
    is_late = status in (-signal.SIGXCPU, -signal.SIGALRM)
    if is_late and case.command[0] in ("record", "campaign"):
        return  # small steps are work that was asked for
    if is_late:
        yield f"took more than {SECONDS} s"
    if status not in ALLOWED | signalled:
        yield f"status {status}"
    for words in ("Traceback", "this is a bug", "Warning", "Exception ignored", "not enough memory"):
        if words in err or (words == "Traceback" and words in out):
            yield f"says {words!r}"
    errors = [line for line in err.splitlines() if "error:" in line]
    if status == 2 and (len(errors) != 1 or not err.rstrip("\n").endswith(errors[-1])) and case.command[1:] != ("b",):
        yield f"{len(errors)} lines of errors"
    if any(len(line) > LONGEST_LINE + 1 for line in errors):
        yield "a long line"
    if any(not (c.isprintable() or c in "\n\r") for c in out + err):
        yield "a character that controls the terminal"
    if found.memory > MEMORY:
        yield f"took {found.memory // MIB} MiB"
    now = {str(path.relative_to(work)): path for path in work.rglob("*") if path.is_file()}
    for name, data in case.files.items():
        if name not in now or now[name].read_bytes() != data:
            yield f"changed {name}"
    asked = [word for word in case.command if word.startswith("out")]
    for name in now.keys() - case.files.keys():
        is_rest = case.signal == signal.SIGKILL and name.endswith(".part")
        if not is_rest and not any(name == word or name.startswith(f"{word}/") for word in asked):
            yield f"wrote {name}"
    if status == 0 and case.command[0] == "check":
        yield from forged(case, bags)


def forged(case: Case, bags: dict[str, bytes]) -> Iterator[str]:
    """Messages of a certified bag that are not in the honest one."""
    content = next(data for name, data in case.files.items() if name.endswith(".mcap"))
    try:
        messages = messages_of(content)
    except Exception as error:
        yield f"certified what the mcap library cannot read: {type(error).__name__}: {error}"[:200]
        return
    honest_messages = messages_of(bags[case.original])
    kinds = {topic: kind for topic, kind in KINDS.items() if topic in ("/pose", "/twist")}
    scenarios = [{m.data for m in found if m.topic == SCENARIO} for found in (messages, honest_messages)]
    if scenarios[0] == scenarios[1]:  # else a sensor may be one that the scenario has not, which is said
        kinds = KINDS
    truth: dict[tuple[Any, ...], list[tuple[float, ...]]] = {}
    for topic, said, numbers in contents(honest_messages, kinds):
        truth.setdefault((topic, said), []).append(numbers)
    for topic, said, numbers in contents(messages, kinds):
        if not any(_near(numbers, known) for known in truth.get((topic, said), [])):
            yield f"certified another {topic}: {said}: {numbers}"[:300]


def contents(
    messages: list[Message], kinds: dict[str, str]
) -> Iterator[tuple[str, tuple[bytes, ...], tuple[float, ...]]]:
    """Topic, stamp and frame, and float64 fields of the messages of some topics and types."""
    for message in messages:
        if kinds.get(message.topic) == message.kind:
            data, length = message.data, int.from_bytes(message.data[12:16], "little")
            start = 4 + (12 + length + 7) // 8 * 8
            count = max(0, len(data) - start) // 8
            yield (
                message.topic,
                (data[:2], data[4:12], data[16 : 15 + length]),
                struct.unpack_from(f"<{count}d", data, start),
            )


def _near(numbers: tuple[float, ...], others: tuple[float, ...]) -> bool:
    """Whether numbers are the same but for what the limits of the certificate allow."""
    return len(numbers) == len(others) and all(abs(a - b) <= TOLERANCE for a, b in zip(numbers, others, strict=True))


# making a failing case smaller, and keeping it


def smaller(case: Case, broken: str, bags: dict[str, bytes], tries: int = 150) -> Case:
    """A case of fewer bytes that breaks the same law: pieces are left out while it does, at most so many times."""

    def breaks(changed: Case) -> bool:
        return outcome(changed, bags).broken[:12] == broken[:12]

    if case.signal and breaks(replace(case, signal=0)):
        case = replace(case, signal=0)
    if case.signal:
        return case
    for name in case.files:
        size = max(1, len(case.files[name]) // 2)
        while size and tries > 0:
            at = 0
            while at < len(case.files[name]) and tries > 0:
                data = case.files[name]
                changed = replace(case, files={**case.files, name: data[:at] + data[at + size :]})
                tries -= 1
                if breaks(changed):
                    case = changed
                else:
                    at += size
            size //= 2
    return case


def kept(case: Case, broken: str) -> Path:
    """Keep a case as a file, from which `read` makes it."""
    content = {
        "broken": broken,
        "command": case.command,
        "signal": case.signal,
        "after_s": case.after_s,
        "original": case.original,
        "files": {name: base64.b85encode(zlib.compress(data, 9)).decode() for name, data in case.files.items()},
    }
    text = json.dumps(content, indent=1)
    KEPT.mkdir(exist_ok=True)
    path = KEPT / f"{case.command[0].replace('.', '_')}_{hashlib.sha256(text.encode()).hexdigest()[:10]}.json"
    path.write_text(text + "\n")
    return path


def read(path: Path) -> Case:
    """A case that was kept."""
    content = json.loads(path.read_text())
    files = {name: zlib.decompress(base64.b85decode(data)) for name, data in content["files"].items()}
    return Case(files, tuple(content["command"]), content["signal"], content["after_s"], content["original"])


def warmed() -> None:
    """Load what the verbs load, so that children have it."""
    import matplotlib.figure
    import matplotlib.pyplot  # noqa: F401

    from lie_rigid_body.cli import campaign, check, checking, evaluate, explain, plot, record, recover  # noqa: F401
    from lie_rigid_body.report import certificates, figures, recording_picture, scores  # noqa: F401


def fuzz(
    minutes: float, seed: int, *, keep: bool = True, say: Callable[[str], object] = print
) -> tuple[Counter[str], list[str]]:
    """Try cases for some time; return how many of each verb had which status, and what was broken."""
    bags = honest()
    warmed()
    counts, broken = Counter[str](), list[str]()
    end = time.monotonic() + 60 * minutes
    number, last = 0, time.monotonic()
    largest, longest = 0, 0.0
    while time.monotonic() < end:
        case = drawn(Random(f"{seed} {number}"), bags)
        number += 1
        found = outcome(case, bags)
        largest, longest = max(largest, found.memory), max(longest, found.seconds)
        counts[f"{case.command[0]} {found.status}"] += 1
        if found.broken and found.broken[:40] not in {words.partition(": ")[2][:40] for words in broken}:
            say(f"case {number - 1} of seed {seed}, {' '.join(case.command)}: {found.broken}\n{found.words}")
            least = smaller(case, found.broken, bags)
            path = kept(least, found.broken) if keep else "not kept"
            broken.append(f"{path}: {found.broken}")
            say(broken[-1])
        if time.monotonic() > last + 60:
            last = time.monotonic()
            say(f"{number} cases, {len(broken)} broken; at most {largest // MIB} MiB, {longest:.1f} s")
    counts["cases"], counts["MiB at most"], counts["s at most"] = number, largest // MIB, round(longest)
    return counts, broken


def main() -> int:
    """Fuzz for some minutes, and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0, help="how long (default 10)")
    parser.add_argument("--seed", type=int, default=None, help="of all that is drawn; another one each day by default")
    given = parser.parse_args()
    seed = int(time.time()) // 86400 if given.seed is None else given.seed
    counts, broken = fuzz(given.minutes, seed, say=lambda text: print(text, flush=True))
    for name, count in sorted(counts.items()):
        print(f"{name:24} {count}")
    print("\n".join(broken) or "no law is broken")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
