"""Mutated bags, parameter files and campaigns into every verb that reads them, with laws that hold whatever they are.

`make fuzz ARGS='--minutes 10'`. Each case is a small honest input, changed in one to four places that its structure
knows, and a verb; some are sent a signal at a random moment. The laws:

- no traceback, no "this is a bug", no warning of a library, one line on stderr where the status is 2;
- a status that is documented: 0, 1, 2, and 130 after a signal;
- at most 20 s on the processor and 512 MiB;
- no file changed or written but the one that was asked for;
- nothing certified in which a pose, a twist or a reading differs from the honest one, as the `mcap` library and rosbags
  read it.

What breaks one is kept in test/fuzzed, where `test_fuzzed.py` tries it again.
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
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from foreign_bags import Message, messages_of
from mutations import Case, drawn, honest

KEPT = Path(__file__).parent / "fuzzed"
SECONDS = 20
MIB = 2**20
MEMORY = 512 * MIB
MAX_LINE = 1000
ALLOWED = {0, 1, 2}
INTERRUPTED = 130
EARLY = 99
"""Status of a child that the signal met before the verb began."""
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
        sys.warnoptions.append("default")  # a verb then shows the warnings of numpy
        from lie_rigid_body.__main__ import main
        from lie_rigid_body.foundation.errors import LieRigidBodyError
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
    if any(len(line) > MAX_LINE + 1 for line in errors):
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
    if case.command[0] == "recover" and not case.signal and (status == 0) != ("out.mcap" in now):
        yield f"status {status}, and the file that was to be written is {'not ' * (status == 0)}there"
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
    found = list(contents(messages, kinds))
    stamps = {topic: {said[:2] for each, said, _ in found if each == topic} for topic in ("/pose", "/twist")}
    alone = stamps["/pose"] ^ stamps["/twist"]  # of a recorder that began or ended amid a sample: told, and not held
    for topic, said, numbers in found:
        is_alone = topic in stamps and said[:2] in alone
        if not is_alone and not any(_near(numbers, known) for known in truth.get((topic, said), [])):
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


# keeping a failing case


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


def warmed(*, draw: bool = True) -> None:
    """Load what the verbs load, so that children have it; what draws takes a second."""
    from lie_rigid_body.cli import campaign, check, checking, evaluate, explain, plot, record, recover  # noqa: F401
    from lie_rigid_body.report import certificates, scores  # noqa: F401

    if draw:
        import matplotlib.figure
        import matplotlib.pyplot  # noqa: F401

        from lie_rigid_body.report import figures, recording_picture  # noqa: F401


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
            path = kept(case, found.broken) if keep else "not kept"
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
