"""Any file at all into `check`, `recover` and `plot`: one line or an answer, in bounded time; never a traceback."""

from __future__ import annotations

import signal
import struct
import warnings
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import partial
from io import StringIO
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import lz4.frame
import pytest
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import MCAP0_MAGIC as MAGIC
from mcap.writer import CompressionType

import mutations
from foreign_bags import Message, messages_of
from lie_rigid_body import simulate
from lie_rigid_body.cli.check import main as check
from lie_rigid_body.cli.evaluate import main as evaluate
from lie_rigid_body.cli.plot import main as plot
from lie_rigid_body.cli.recover import main as recover
from lie_rigid_body.messages.batch import POSE, TWIST
from lie_rigid_body.system import console
from lie_rigid_body.system.console import UNUSABLE
from sampled import sampled

SECONDS = 60
"""Time on the processor after which a verb is taken to hang."""
EXAMPLES = 1000
"""Of each kind."""
DRAWN = 100
"""One in so many of the bags that can be read is drawn, which takes far longer than to read it."""
PACK: dict[str, Callable[[bytes], bytes]] = {"": bytes, "zstd": zstandard.compress, "lz4": lz4.frame.compress}


class HangError(BaseException):
    """A verb has taken too long; no handler of errors takes it for one of its own."""


@contextmanager
def in_time() -> Iterator[None]:
    """A context that ends after some time on the processor, whatever else the machine does."""

    def hang(number: int, frame: object) -> None:
        raise HangError

    before = signal.signal(signal.SIGVTALRM, hang)
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def run(main: Callable[[list[str]], int], *arguments: str) -> int:
    """The status of a verb that keeps its promises, whatever it is given."""
    out, err = StringIO(), StringIO()
    with in_time(), redirect_stdout(out), redirect_stderr(err), warnings.catch_warnings():
        warnings.simplefilter("error")
        status = main([*arguments])
    said = err.getvalue()
    assert console.DEBUG not in said, said
    assert status in (0, 1, 2)
    assert said.count("\n") == (status == 2), said
    assert len(said) <= 300
    return status


def answers(content: bytes, drawn: bool) -> Counter[str]:
    """The statuses of the verbs for a file of this content; `plot` is left out where it would draw and is not to."""
    with TemporaryDirectory() as folder:
        path, fixed = Path(folder, "x.mcap"), Path(folder, "fixed.mcap")
        path.write_bytes(content)
        statuses = {"check": run(check, str(path)), "recover": run(recover, str(path), "-o", str(fixed))}
        if statuses["check"] == UNUSABLE or (drawn and zlib.crc32(content) % DRAWN == 0):
            statuses["plot"] = run(plot, str(path), "-o", str(Path(folder, "x.png")))
        assert path.read_bytes() == content
        assert (statuses["recover"] == 0) == fixed.exists()
        if fixed.exists():
            statuses["check of what is recovered"] = run(check, str(fixed))
    return Counter(f"{verb} {status}" for verb, status in statuses.items())


def record(opcode: int, content: bytes, length: int | None = None) -> bytes:
    return struct.pack("<BQ", opcode, len(content) if length is None else length) + content


def text(value: str) -> bytes:
    data = value.encode("utf-8", "surrogatepass")
    return struct.pack("<I", len(data)) + data


NUMBERS = st.sampled_from([0, 1, 2, 3, 255, 2**15, 2**16 - 1]) | st.integers(0, 2**16 - 1)
WORDS = st.sampled_from([0, 1, 37, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1]) | st.integers(0, 2**64 - 1)
TYPES = ["PoseStamped", "TwistStamped", "Twist", "Vector3Stamped"]
TEXTS = st.sampled_from(
    ["", "/pose", "/twist", "/lie_rigid_body/scenario", "/imu/data_raw", "cdr", "ros2", "ros2msg", "zstd", "lz4"]
) | st.sampled_from([*(f"geometry_msgs/msg/{name}" for name in TYPES), "std_msgs/msg/String", "sensor_msgs/msg/Imu"])
TEXTS |= st.text(st.characters(), max_size=8)
DATA = st.binary(max_size=60)
MAPS = st.lists(st.tuples(TEXTS, TEXTS), max_size=2).map(lambda pairs: b"".join(text(k) + text(v) for k, v in pairs))


def shorts(value: int) -> bytes:
    return struct.pack("<H", value)


def longs(value: int) -> bytes:
    return struct.pack("<Q", value)


def sized(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


def joined(*parts: st.SearchStrategy[bytes]) -> st.SearchStrategy[bytes]:
    return st.tuples(*parts).map(b"".join)


CONTENTS: dict[int, st.SearchStrategy[bytes]] = {
    1: joined(TEXTS.map(text), TEXTS.map(text)),
    2: joined(WORDS.map(longs), WORDS.map(longs), st.just(bytes(4))),
    3: joined(NUMBERS.map(shorts), TEXTS.map(text), TEXTS.map(text), DATA.map(sized)),
    4: joined(NUMBERS.map(shorts), NUMBERS.map(shorts), TEXTS.map(text), TEXTS.map(text), MAPS.map(sized)),
    5: joined(NUMBERS.map(shorts), st.binary(min_size=4, max_size=4), WORDS.map(longs), WORDS.map(longs), DATA),
    7: joined(NUMBERS.map(shorts), DATA.map(sized)),
    8: joined(*[WORDS.map(longs)] * 4, MAPS.map(sized), WORDS.map(longs), TEXTS.map(text), *[WORDS.map(longs)] * 2),
    9: joined(WORDS.map(longs), WORDS.map(longs), TEXTS.map(text), TEXTS.map(text), WORDS.map(longs), DATA),
    10: joined(*[WORDS.map(longs)] * 5, TEXTS.map(text), TEXTS.map(text)),
    11: joined(WORDS.map(longs), *[NUMBERS.map(shorts)] * 9, WORDS.map(longs), WORDS.map(longs), MAPS.map(sized)),
    12: joined(TEXTS.map(text), MAPS.map(sized)),
    13: joined(WORDS.map(longs), WORDS.map(longs), TEXTS.map(text)),
    14: joined(st.binary(min_size=1, max_size=1), WORDS.map(longs), WORDS.map(longs)),
    15: st.just(bytes(4)) | st.binary(min_size=4, max_size=4),
}
ANY_RECORD = st.one_of(
    *[content.map(partial(record, opcode)) for opcode, content in CONTENTS.items()],
    st.builds(record, st.integers(0, 255), DATA, st.none() | WORDS),
)


def chunk(compression: str, inner: list[bytes], size: int | None, with_crc: bool) -> bytes:
    data = b"".join(inner)
    packed, crc = PACK[compression](data), zlib.crc32(data) if with_crc else 0
    head = struct.pack("<QQQI", 0, 0, len(data) if size is None else size, crc)
    return record(6, head + text(compression) + struct.pack("<Q", len(packed)) + packed)


CHUNKS = st.builds(chunk, st.sampled_from([*PACK]), st.lists(ANY_RECORD, max_size=6), st.none() | WORDS, st.booleans())
END = record(15, bytes(4)) + record(2, bytes(20))
RECORDS = st.builds(
    lambda records, end: MAGIC + record(1, text("ros2") + text("")) + b"".join(records) + end,
    st.lists(ANY_RECORD | CHUNKS, max_size=8),
    st.sampled_from([b"", MAGIC, END + MAGIC, END]),
)
RANDOM = st.builds(
    lambda begin, data, end: begin + data + end,
    st.sampled_from([b"", MAGIC, b"SQLite format 3\x00"]),
    st.binary(max_size=400),
    st.sampled_from([b"", MAGIC]),
)


with TemporaryDirectory() as folder:
    path = Path(folder, "x.mcap")
    simulate(duration=0.35, motion="closed_form", rate=20.0, imu_rate=10.0, magnetometer_rate=5.0).to_bag(path)
    MESSAGES = messages_of(path.read_bytes())


def bag(messages: list[Message]) -> bytes:
    """A file without checksums, so that what is changed in it is read."""
    return mutations.rewritten(messages, "lie_rigid_body", CompressionType.NONE, checksums=False)


HONEST = bag(MESSAGES)


def changed(seed: int, times: int) -> bytes:
    random, content = Random(seed), HONEST
    for _ in range(times):
        content = mutations.mutated_bag(random, content)
    return content


def replaced(topic: str, number: int | None, at: int, piece: bytes) -> bytes:
    """The bag with a piece of the payload of one message of a topic, or of each, overwritten."""
    messages, count = [*MESSAGES], 0
    for i, message in enumerate(MESSAGES):
        if message.topic == f"/{topic}":
            if number in (count, None):
                begin = at % len(message.data)
                data = message.data[:begin] + piece + message.data[begin + len(piece) :]
                messages[i] = message._replace(data=data)
            count += 1
    return bag(messages)


CHANGED = st.builds(changed, st.integers(0, 2**64 - 1), st.integers(1, 3))
KINDS = {
    "random": RANDOM,
    "records": RECORDS,
    "changed": CHANGED,
}


def examples(kind: str, count: int, *, drawn: bool) -> Counter[str]:
    found: Counter[str] = Counter()

    @settings(max_examples=count)
    @given(KINDS[kind])
    def each(content: bytes) -> None:
        found.update(["files"])
        found.update(answers(content, drawn))

    each()
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_no_file_gives_a_traceback(kind: str) -> None:
    assert examples(kind, 10, drawn=False)["files"] >= 10


def test_a_quaternion_whose_norm_underflows_breaks_laws_without_a_warning() -> None:
    assert answers(replaced(POSE, 0, 76, longs(1)), drawn=True)["check 1"] == 1


@pytest.mark.slow
@pytest.mark.parametrize("value", sampled([float("nan"), float("inf"), -1e308, 1e308, 5e-324], every=3))
@pytest.mark.parametrize(("topic", "fields"), [(POSE, 7), (TWIST, 6)])
def test_numbers_at_the_edges_of_float64_are_judged_and_drawn_without_a_warning(
    topic: str, fields: int, value: float, tmp_path: Path
) -> None:
    path = tmp_path / "x.mcap"
    for number in (3, None):
        path.write_bytes(replaced(topic, number, -8 * fields, fields * struct.pack("<d", value)))
        assert run(check, str(path)) == 1
        if (number is None) == (topic == POSE):  # to draw takes far longer than to judge
            assert run(plot, str(path), "-o", str(tmp_path / "x.png")) in (0, 2)
        assert run(evaluate, str(path), "--estimate", "/pose") in (0, 1, 2)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_thousand_files_of_each_kind(kind: str, record_property: Callable[[str, object], None]) -> None:
    for said, count in sorted(examples(kind, EXAMPLES, drawn=True).items()):
        record_property(said, count)
