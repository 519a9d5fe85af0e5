"""The ``record`` command: simulate a scenario and write it to an MCAP bag, without ROS."""

from __future__ import annotations

import argparse
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Final

from lie_rigid_body.command_line import argument, file_name, scenario_of, verb
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.parameters import exact_duration
from lie_rigid_body.foundation.wording import counted, printable
from lie_rigid_body.system import console
from lie_rigid_body.system.interruption import Interruption

_COMPRESSIONS: Final = {"zstd": ("zstd", 105), "lz4": ("lz4", 130), "none": ("", 260)}
"""Compressions by their names for users: the name in MCAP files, and how many bytes a sample, pose and twist, takes."""
_MAX_CHUNK: Final = 16 * 1024**2
"""Largest number of bytes of a chunk, uncompressed."""


@verb(
    "Write a bag of a scenario, without ROS.",
    argument("out", metavar="OUT.mcap", type=file_name, help="the file to write"),
    argument(
        "--duration", metavar="SECONDS", required=True, help="record every sample before this time after the first"
    ),
    argument("--compression", choices=_COMPRESSIONS, default="zstd", help="of the bag's chunks (default: %(default)s)"),
    argument(
        "--chunk-size",
        metavar="BYTES",
        default=str(512 * 1024),
        help="end a chunk of the bag after so many bytes, uncompressed (default: %(default)s)",
    ),
    argument("--force", action="store_true", help="replace OUT.mcap if it exists, when the new one is whole"),
    argument("--quiet", action="store_true", help="print errors only"),
    scenario=True,
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    duration = exact_duration(given.duration, "--duration", "--duration 60", is_text=True)
    chunk_size = _chunk_size(given.chunk_size)

    # only now: numpy takes longer to load than a usage error to find
    from lie_rigid_body.recording.bag_writer import BagWriter, write_run
    from lie_rigid_body.scenario.parameter_file import files_read
    from lie_rigid_body.simulation import Simulation
    from lie_rigid_body.system.output_file import require_other

    require_other(given.out, files_read(given.scenario, given.params_file))
    scenario = scenario_of(given)
    for sentence in scenario.without_effect if not given.quiet else ():
        console.complain(console.program("record"), sentence, "warning")
    simulation = Simulation(scenario)
    out = Path(given.out)
    clock = simulation.clock
    count = clock.count_before(duration)
    last_ns = clock.last_ns_before(duration)
    simulation.require_stamps(last_ns)  # before a file is made
    compression, per_sample = _COMPRESSIONS[given.compression]
    _require_room(out, count, count * per_sample)
    with Interruption.current().noted() as interruption:
        with (
            suppress(KeyboardInterrupt),
            BagWriter(
                out,
                stamped_twist=scenario.stamped_twist,
                overwrite=given.force,
                compression=compression,
                chunk_size=chunk_size,
            ) as bag,
            console.progress(total=count, unit=" samples", unit_scale=True, leave=True, quiet=given.quiet) as bar,
        ):
            for written in write_run(bag, simulation, last_ns, interruption.allowed):
                bar.update(written)
        done = bag.sample_count
        size = console.size(bag.path.stat().st_size)
        if done < count and interruption.requested:
            state = f"is whole ({size})" if done else "holds no sample of it"
            told = f"interrupted after {done} of {count} samples; {bag.path} {state}"
            console.complain(console.program("record"), told)
            return console.INTERRUPTED
        if not given.quiet:
            first, last = (console.seconds(clock.stamp_ns(k)) for k in (0, done - 1))
            console.say(
                f"{counted(done, 'sample')}, stamps {first} to {last} s, in {printable(str(bag.path))} ({size})\n"
                f"{console.how_to_certify(bag.path)}",
                done=f"{bag.path} is written and whole",
            )
        return console.SUCCESS


def _chunk_size(text: str) -> int:
    if not (text.isdecimal() and text.isascii() and len(text) < 12 and 0 < int(text) <= _MAX_CHUNK):
        raise InputError(
            f"--chunk-size {text} is not a number of bytes from 1 to {_MAX_CHUNK}: give for example 524288"
        )
    return int(text)


def _require_room(out: Path, count: int, needed: int) -> None:
    """Refuse samples that need more bytes than are free where they are to be written."""
    try:
        total, _, free = shutil.disk_usage(out.parent)
    except OSError:
        return  # opening the file will say what is wrong with the folder
    if needed > free and total:  # /proc and its like have no size at all
        raise BagError(
            f"{out}: {count} samples need {console.size(needed)} at least and {console.size(free)} are free there: "
            "record a shorter time, a lower rate, or elsewhere"
        )
