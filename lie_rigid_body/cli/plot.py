"""``plot``: a bag as one picture."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from lie_rigid_body.command_line import TOPIC_OPTION, argument, file_name, require_suffix, topic_names, verb
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import printable
from lie_rigid_body.system import console
from lie_rigid_body.system.output_file import require_room, write_file


@verb(
    "Draw body rate, drifts and polhode of a bag into one PNG.",
    argument("bag", metavar="BAG", type=file_name, help="an MCAP file, or a folder that 'ros2 bag record' made"),
    TOPIC_OPTION,
    argument(
        "-o",
        "--out",
        metavar="OUT.png",
        type=file_name,
        help="by default BAG's name with .png",
    ),
    argument("--force", action="store_true", help="replace OUT.png if it exists"),
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    if not (given.out or Path(given.bag).name):
        raise InputError(f"{given.bag}: a folder without a name gives the picture none: give -o OUT.png")
    out = given.out or str(Path(given.bag).with_suffix(".png"))
    require_suffix("-o", out, ".png")

    from lie_rigid_body.recording.bag_files import files_of
    from lie_rigid_body.recording.topic_discovery import TOPIC_TYPES

    topics = topic_names(given.topic, TOPIC_TYPES)
    require_room(out, files_of(given.bag), overwrite=given.force)

    from lie_rigid_body.recording.bag_reader import Bag
    from lie_rigid_body.report.drawing import png
    from lie_rigid_body.report.recorded_motion import recorded_segments

    with console.progress_of_bags([given.bag]) as bar:
        pieces = recorded_segments(Bag(given.bag, bar.update, topics))

    os.environ["MPLBACKEND"] = "agg"  # no window is needed, and the one that Jupyter names may not be installed
    from lie_rigid_body.report.recording_picture import draw  # only now: it loads Matplotlib

    write_file(out, png(lambda: draw(pieces)), overwrite=given.force)
    console.say(f"wrote {printable(out)}", done=f"{out} is written")
    return console.SUCCESS
