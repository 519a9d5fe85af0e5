"""``recover``: what is whole of a bag that was cut off, as a bag that is whole."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lie_rigid_body import console
from lie_rigid_body.wording import counted, printable

if TYPE_CHECKING:
    from lie_rigid_body.recording.recovery import Recovery


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)

    from lie_rigid_body.recording.recovery import Recovery, recover, recover_folder

    broken, out = Path(given.broken), Path(given.out)
    if broken.is_dir():
        found = recover_folder(broken, out)
        wrong = [printable(str(each)) for each in found.values() if not isinstance(each, Recovery)]
    else:
        found, wrong = {broken: recover(broken, out, overwrite=given.force)}, []
    parts = {path: each for path, each in found.items() if isinstance(each, Recovery)}
    wrong = [text for path, each in parts.items() if (text := _what_was_wrong(path, each))] + wrong
    console.say(
        "\n".join(
            [
                _how_much(given.out, [*parts.values()]),
                *(wrong or [f"{printable(given.broken)} was whole"]),
                *_what_next(given),
            ]
        ),
        done=f"{given.out} is written and whole",
    )
    return console.SUCCESS


def _parser() -> console.Parser:
    return console.Parser(
        "recover",
        "Write every whole message of a bag that was cut off into a new one.",
        console.argument(
            "broken",
            metavar="BROKEN",
            type=console.path,
            help="the MCAP file that was cut off, or the folder that 'ros2 bag record' made of it; it is only read",
        ),
        console.argument(
            "-o",
            "--out",
            metavar="FIXED",
            type=console.path,
            required=True,
            help="the file to write, or the folder to make",
        ),
        console.argument(
            "--force", action="store_true", help="replace the file FIXED if it exists, when the new one is whole"
        ),
    )


def _how_much(out: str, parts: Sequence[Recovery]) -> str:
    path = Path(out)
    files = [path] if path.is_file() else [*path.iterdir()]
    times_ns = [time for part in parts for time in part.log_times_ns]
    first, last = console.seconds(min(times_ns)), console.seconds(max(times_ns))
    messages = counted(sum(part.messages for part in parts), "message")
    topics = counted(max(part.topics for part in parts), "topic")
    where = f"{printable(out)} ({console.size(sum(map(os.path.getsize, files)))})"
    return f"{messages} on {topics}, stamps {first} to {last} s, in {where}"


def _what_was_wrong(broken: Path, recovery: Recovery) -> str:
    """Sentence about what was wrong with a file; empty if it was whole."""
    found = []
    if recovery.broken_at is not None:
        gave = counted(recovery.of_the_last, "message")
        is_between = recovery.broken_at == broken.stat().st_size
        where = (
            "behind a whole record" if is_between else f"in the record at byte {recovery.broken_at}, which gave {gave}"
        )
        found.append(f"breaks off {where}")
    if recovery.damaged:
        damaged = counted(len(recovery.damaged), "damaged record")
        found.append(f"has {damaged}, left out, the first at byte {recovery.damaged[0]}")
    if recovery.rewritten:
        chunks = counted(len(recovery.rewritten), "chunk")
        found.append(f"has {chunks} of more than one compressed frame, written anew, at byte {recovery.rewritten[0]}")
    return f"{printable(str(broken))} {' and '.join(found)}" if found else ""


def _what_next(given: argparse.Namespace) -> list[str]:
    from lie_rigid_body.recording.bag_files import whole_of

    if os.path.isdir(given.broken):
        return [
            console.how_to_certify(given.out),
            f"'ros2 bag play' wants metadata; make them with: ros2 bag reindex {console.quoted(given.out)}",
        ]
    whole = whole_of(Path(given.broken))
    if whole is not None:
        return [f"it is one file of a bag that was split; recover all with: recover {console.quoted(whole)} -o FIXED"]
    return [console.how_to_certify(given.out)]
