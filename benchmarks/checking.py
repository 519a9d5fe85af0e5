"""What checking a bag costs, beside reading its messages by the `mcap` library alone.

    python benchmarks/checking.py                     # ten minutes at 1 kHz
    python benchmarks/checking.py --duration 3600

Processor times of all threads. The bag is recorded before; compiling, or loading what was compiled, is over before.
"""

from __future__ import annotations

import argparse
import resource
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from mcap.reader import make_reader

from lie_rigid_body.certificate import certify
from lie_rigid_body.certificate.residuals import WORK
from lie_rigid_body.motion.closed_form.evaluation import compile_all
from lie_rigid_body.motion.moser_veselov.loop import LOOP
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import BagWriter, write_run
from lie_rigid_body.recording.message_loops import FIND, TAKE
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from recording import RATE

MICROSECONDS: Final = 1e6


def record(path: Path, duration: int) -> int:
    """Record a run, and return the number of its samples."""
    simulation = Simulation(Scenario.from_parameters({"rate": RATE}))
    with BagWriter(path, stamped_twist=True) as bag:
        for _ in write_run(bag, simulation, duration * NS - 1):
            pass
        return bag.sample_count


def main() -> None:
    """Print the costs of a sample, and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--duration", type=int, default=600, metavar="SECONDS", help="of the simulated run")
    given = parser.parse_args()
    LOOP.compile()
    compiled = all([FIND.compile(), TAKE.compile(), WORK.compile(), compile_all()])
    with TemporaryDirectory() as folder:
        path = Path(folder, "bag.mcap")
        samples = record(path, given.duration)
        start = time.process_time()
        assert certify(Bag(path)).passed
        ours = (time.process_time() - start) / samples * MICROSECONDS
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        start = time.process_time()
        with path.open("rb") as stream:
            for _ in make_reader(stream).iter_messages(log_time_order=False):
                pass
        plain = (time.process_time() - start) / samples * MICROSECONDS
    print(f"{samples} samples of pose and twist, {'compiled' if compiled else 'on arrays'}")
    print(f"check {ours:.3f} µs a sample ({MICROSECONDS / ours:.0f} a second), messages by mcap alone {plain:.3f} µs")
    print(f"ratio {plain / ours:.1f}; largest memory {memory:.0f} MiB")


if __name__ == "__main__":
    main()
