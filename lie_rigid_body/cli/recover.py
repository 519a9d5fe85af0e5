"""``recover``: what is whole of a bag that was cut off, as a bag that is whole."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lie_rigid_body import console
from lie_rigid_body.wording import counted

if TYPE_CHECKING:
    from lie_rigid_body.recording.recovery import Recovery


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)

    from lie_rigid_body.recording.recovery import recover

    recovery = recover(Path(given.broken), Path(given.out), overwrite=given.force)
    first, last = map(console.seconds, recovery.log_times_ns)
    size = console.size(os.path.getsize(given.out))
    console.say(
        f"{counted(recovery.messages, 'message')} on {counted(recovery.topics, 'topic')}, stamps {first} to {last} s, "
        f"in {given.out} ({size})\n"
        f"{_what_was_wrong(given.broken, recovery)}\n"
        f"{console.how_to_certify(given.out)}",
        done=f"{given.out} is written and whole",
    )
    return console.SUCCESS


def _parser() -> console.Parser:
    parser = console.Parser("recover", "Write every whole message of an MCAP file that was cut off into a new one.")
    parser.add_argument(
        "broken", metavar="BROKEN", type=console.path, help="the file that was cut off; it is only read"
    )
    parser.add_argument("-o", "--out", metavar="FIXED", type=console.path, required=True, help="the file to write")
    parser.add_argument("--force", action="store_true", help="replace FIXED if it exists, when the new one is whole")
    return parser


def _what_was_wrong(broken: str, recovery: Recovery) -> str:
    found = []
    if recovery.broken_at is not None:
        gave = counted(recovery.of_the_last, "message")
        found.append(f"breaks off in the record at byte {recovery.broken_at}, which gave {gave}")
    if recovery.damaged:
        damaged = counted(len(recovery.damaged), "damaged record")
        found.append(f"has {damaged}, left out, the first at byte {recovery.damaged[0]}")
    return f"{broken} {' and '.join(found) or 'was whole'}"
