"""The ``record`` command: simulate a scenario and write it to an MCAP bag, without ROS."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Sequence
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lie_rigid_body import console
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.parameters import NS

if TYPE_CHECKING:
    from lie_rigid_body.recording.bag_writer import BagWriter
    from lie_rigid_body.scenario import Scenario
    from lie_rigid_body.simulation import Simulation

BYTES_PER_SAMPLE: Final = 105
"""Bytes of a pose and a twist in a bag, compressed."""
BYTES_PER_READING: Final = 130
"""Bytes of a reading in a bag, compressed: a little more than an IMU with noise takes, its bias included."""
LARGEST_DURATION: Final = 10**10
"""Longest duration, s: more is beyond every stamp of builtin_interfaces/Time."""
_NUMBER: Final = re.compile(r"[-+.0-9eE]+")
"""Characters of a finite decimal number: Decimal alone would take spaces, underscores and words."""
_LARGEST_BATCH: Final = 1024
"""Largest number of samples computed and written at once."""
_STEPS_PER_BATCH: Final = 10_000
"""Number of steps of the moving chart that a batch may take, if it holds more than one sample."""


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    given = _parser().parse_args(argv)
    duration = _duration(given.duration)

    # only now: numpy takes longer to load than a usage error to find
    from lie_rigid_body.recording.bag_writer import BagWriter
    from lie_rigid_body.simulation import Simulation

    scenario = console.scenario(given)
    simulation = Simulation(scenario)
    count = simulation.clock.count_before(duration)
    last_ns = simulation.clock.last_ns_before(duration)
    out = Path(given.out)
    simulation.clock.stamps_ns(count - 1, 1)  # refuses stamps beyond the range before a file is made
    _require_room(out, count, _readings(scenario, duration))
    with Interruption() as interruption:
        with BagWriter(out, stamped_twist=scenario.stamped_twist, overwrite=given.force) as bag:
            _record(simulation, bag, count, last_ns, interruption, quiet=given.quiet)
        return _report(bag, simulation, count, interruption, quiet=given.quiet)


def _parser() -> console.Parser:
    parser = console.Parser("record", "Write a bag of a scenario, without ROS.")
    parser.add_argument("out", metavar="OUT.mcap", help="the file to write")
    console.add_scenario_arguments(parser)
    parser.add_argument(
        "--duration", metavar="SECONDS", required=True, help="record every sample before this time after the first"
    )
    parser.add_argument("--force", action="store_true", help="replace OUT.mcap if it exists, when the new one is whole")
    parser.add_argument("--quiet", action="store_true", help="print errors only")
    return parser


def _duration(text: str) -> Fraction:
    try:
        value = Decimal(text) if _NUMBER.fullmatch(text) else Decimal("nan")
    except InvalidOperation:
        value = Decimal("nan")
    # compared before it becomes a fraction, which 1e999999999 would fill the memory with
    if not (value.is_finite() and Decimal("1e-9") <= value <= LARGEST_DURATION):
        raise InputError(f"--duration {text} is not a time from 1e-9 to 1e10 seconds: give for example --duration 60")
    return Fraction(value)


def _readings(scenario: Scenario, duration: Fraction) -> int:
    """The number of readings of all sensors in a time, s."""
    from lie_rigid_body.simulation import SampleClock

    sensors = (scenario.sensors.imu, scenario.sensors.magnetometer)
    return sum(SampleClock(0, sensor.rate).count_before(duration) for sensor in sensors if sensor is not None)


def _require_room(out: Path, count: int, readings: int) -> None:
    try:
        total, _, free = shutil.disk_usage(out.parent)
    except OSError:
        return  # opening the file will say what is wrong with the folder
    needed = count * BYTES_PER_SAMPLE + readings * BYTES_PER_READING
    if needed > free and total:  # /proc and its like have no size at all
        raise BagError(
            f"{out}: {count} samples need about {_size(needed)} and {_size(free)} are free there: "
            "record a shorter time, a lower rate, or elsewhere"
        )


def _record(
    simulation: Simulation, bag: BagWriter, count: int, last_ns: int, interruption: Interruption, *, quiet: bool
) -> None:
    from tqdm import tqdm

    from lie_rigid_body.messages.batch import BatchEncoder

    encoder = BatchEncoder(simulation.segment.scenario)
    # few samples when each takes many steps, so that an interruption loses little
    batch = simulation.segment.scenario.batch_size(_LARGEST_BATCH, _STEPS_PER_BATCH)
    bag.begin_segment(simulation.segment)
    # disable=None: shown on a terminal only
    with tqdm(total=count, unit=" samples", unit_scale=True, file=sys.stderr, disable=quiet or None) as bar:
        while simulation.next_stamp_ns <= last_ns and not interruption.requested:
            try:
                with interruption.allowed():
                    taken = simulation.take_until(last_ns, batch)
            except KeyboardInterrupt:
                return
            bag.write(encoder.encode(taken))
            bag.require_intact()
            bar.update(len(taken.samples))


def _report(bag: BagWriter, simulation: Simulation, count: int, interruption: Interruption, *, quiet: bool) -> int:
    done = bag.sample_count
    size = _size(os.path.getsize(bag.path))
    if done < count and interruption.requested:
        console.complain(
            console.program("record"), f"interrupted after {done} of {count} samples; {bag.path} is whole ({size})"
        )
        return console.INTERRUPTED
    if not quiet:
        clock = simulation.clock
        first, last = (int(clock.stamps_ns(k, 1)[0]) for k in (0, done - 1))
        console.say(
            f"{done} samples, stamps {_seconds(first)} to {_seconds(last)} s, in {bag.path} ({size})\n"
            f"{console.how_to_certify(bag.path)}",
            done=f"{bag.path} is written and whole",
        )
    return console.SUCCESS


def _seconds(stamp_ns: int) -> str:
    return f"{stamp_ns // NS}.{stamp_ns % NS:09d}"


def _size(count: int) -> str:
    value = float(count)
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if value < 1000.0 or unit == "TB":
            break
        value /= 1000.0
    return f"{value:.4g} {unit}"
