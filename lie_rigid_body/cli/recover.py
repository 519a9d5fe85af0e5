"""``recover``: what is whole of a bag that was cut off, as a bag that is whole."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lie_rigid_body.command_line import argument, file_name, verb
from lie_rigid_body.foundation.wording import counted, printable
from lie_rigid_body.system import console

if TYPE_CHECKING:
    from lie_rigid_body.recording.recovery import Recovery


@verb(
    "Write every whole message of a bag that was cut off into a new one.",
    argument(
        "broken",
        metavar="BROKEN",
        type=file_name,
        help="the MCAP file that was cut off, or the folder that 'ros2 bag record' made of it; it is only read",
    ),
    argument(
        "-o",
        "--out",
        metavar="FIXED",
        type=file_name,
        required=True,
        help="the file to write, or the folder to make",
    ),
    argument("--force", action="store_true", help="replace the file FIXED if it exists, when the new one is whole"),
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    from lie_rigid_body.recording.recovered_folder import recover_folder
    from lie_rigid_body.recording.recovery import Recovery, recover

    broken = Path(given.broken)
    out = Path(given.out)
    is_folder = broken.is_dir()
    found = recover_folder(broken, out) if is_folder else {broken: recover(broken, out, overwrite=given.force)}
    parts = {path: each for path, each in found.items() if isinstance(each, Recovery)}
    wrong = [text for path, each in parts.items() if (text := _what_was_wrong(path, each))]
    wrong += [printable(str(each)) for each in found.values() if not isinstance(each, Recovery)]
    lines = [
        _how_much(out, [*parts.values()]),
        *(wrong or [f"{printable(given.broken)}: its messages were all whole"]),
        *_what_next(given, is_folder),
    ]
    console.say("\n".join(lines), done=f"{given.out} is written and whole")
    return console.SUCCESS


def _how_much(out: Path, parts: Sequence[Recovery]) -> str:
    files = [out] if out.is_file() else [*out.iterdir()]
    times_ns = [time for part in parts for time in part.log_times_ns]
    first = console.seconds(min(times_ns))
    last = console.seconds(max(times_ns))
    messages = sum(part.messages for part in parts)
    topics = max(part.topics for part in parts)
    where = f"{printable(str(out))} ({console.size(sum(file.stat().st_size for file in files))})"
    return f"{counted(messages, 'message')} on {counted(topics, 'topic')}, stamps {first} to {last} s, in {where}"


def _what_was_wrong(broken: Path, recovery: Recovery) -> str:
    """Sentence about what was wrong with a file; empty if it was whole."""
    at = recovery.broken_at
    found = list[str]()
    if recovery.in_summary:
        found.append(f"breaks off in its summary at byte {at}: all messages are whole")
    elif at is not None:
        gave = f"in the record at byte {at}, which gave {counted(recovery.of_the_last, 'message')}"
        found.append(f"breaks off {'behind a whole record' if at == broken.stat().st_size else gave}")
    if recovery.damaged:
        left_out = f"has {counted(len(recovery.damaged), 'damaged record')}, left out"
        found.append(f"{left_out}, the first at byte {recovery.damaged[0]}")
    if recovery.is_altered:
        found.append("has another checksum than it says: some messages may be altered")
    return f"{printable(str(broken))} {' and '.join(found)}" if found else ""


def _what_next(given: argparse.Namespace, is_folder: bool) -> Iterator[str]:
    from lie_rigid_body.recording.bag_files import whole_of

    whole = None if is_folder else whole_of(Path(given.broken))
    if whole is None:
        yield console.how_to_certify(given.out)
    else:
        yield f"it is one file of a bag that was split; recover all with: recover {console.quoted(whole)} -o FIXED"
    if is_folder:
        yield f"'ros2 bag play' wants metadata; make them with: ros2 bag reindex {console.quoted(given.out)}"
