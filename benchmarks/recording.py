"""What recording in bulk costs, simulation included, beside the `mcap` library's writer alone on the same messages.

    python benchmarks/recording.py                          # two minutes of each task
    python benchmarks/recording.py --duration 3600 --runs 1

Both write a file, in turns of one minute of the run. Times are wall times; the last ratio is that of the processor
times of all threads. Neither the simulation nor the encoding of messages is charged to the library's `add_message`. The
simulation runs compiled where numba is installed, and compiling is over before.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from mcap.writer import Writer

from lie_rigid_body.messages.batch import Batch, BatchEncoder
from lie_rigid_body.motion.moser_veselov.loop import LOOP
from lie_rigid_body.parameters import NS
from lie_rigid_body.recording.bag_writer import CHUNK_BYTES, BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

RATE: Final = 1000.0
NOISE: Final = {
    "gyro_noise_density": 1e-3,
    "gyro_bias_random_walk": 1e-4,
    "accelerometer_noise_density": 1e-3,
    "accelerometer_bias_random_walk": 1e-4,
    "magnetometer_noise_density": 1e-8,
}
SENSORS: Final = {"imu_rate": RATE, "magnetometer_rate": 100.0, "accelerometer_mode": "pivot_gravity"}
TASKS: Final[dict[str, dict[str, object]]] = {
    "pose, twist": {},
    "and IMU, bias, magnetometer": SENSORS,
    "and their noise": SENSORS | NOISE,
}
BATCH: Final = 8192
TURN_NS: Final = 60 * NS


@dataclass
class Spent:
    """A context that adds up wall time and processor time of all threads, s."""

    wall: float = 0.0
    cpu: float = 0.0

    def __enter__(self) -> None:
        self.wall -= time.perf_counter()
        self.cpu -= time.process_time()

    def __exit__(self, *_: object) -> None:
        self.wall += time.perf_counter()
        self.cpu += time.process_time()


def best(runs: Sequence[Spent]) -> Spent:
    """The smallest times of several runs."""
    return Spent(min(run.wall for run in runs), min(run.cpu for run in runs))


def costs(messages: int, ours: Spent, plain: Spent) -> str:
    """Microseconds a message, and ratios."""
    each = 1e6 / messages
    return (
        f"{each * ours.wall:>10.3f}{each * plain.wall:>11.3f}{plain.wall / ours.wall:>8.1f}{plain.cpu / ours.cpu:>8.1f}"
    )


class PlainBag:
    """The library's writer, message by message; only its own time is counted."""

    def __init__(self, path: Path) -> None:
        self.spent = Spent()
        self.messages = 0
        self._stream = path.open("wb")
        self._writer = Writer(self._stream, chunk_size=CHUNK_BYTES, enable_data_crcs=True)
        self._writer.start("ros2")
        self._schema = self._writer.register_schema("any", "ros2msg", b"")
        self._channels: dict[str, int] = {}

    def write(self, batch: Batch) -> None:
        messages = list(batch.in_order())
        for topic in {topic for _, topic, _ in messages} - set(self._channels):
            self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schema)
        channels, add = self._channels, self._writer.add_message
        with self.spent:
            for stamp, topic, payload in messages:
                add(channels[topic], log_time=stamp, data=payload, publish_time=stamp)
        self.messages += len(messages)

    def finish(self) -> None:
        with self.spent:
            self._writer.finish()
            self._stream.close()


def measure(parameters: dict[str, object], duration: int, folder: Path) -> tuple[int, Spent, Spent]:
    """Messages, and what either way took."""
    scenario = Scenario.from_parameters({"rate": RATE, **parameters})
    simulation, again, encoder = Simulation(scenario), Simulation(scenario), BatchEncoder(scenario)
    plain, ours = PlainBag(folder / "plain.mcap"), Spent()
    with ours:
        bag = BagWriter(folder / "bulk.mcap", stamped_twist=True, overwrite=True)
        bag.begin_segment(simulation.segment)
    for end in range(0, duration * NS, TURN_NS):
        last = min(end + TURN_NS, duration * NS) - 1
        with ours:
            run(simulation, last, bag.write, encoder)
            bag.wait()
        run(again, last, plain.write, encoder)
    with ours:
        bag.finish()
    plain.finish()
    return plain.messages, ours, plain.spent


def run(simulation: Simulation, last_ns: int, write: Callable[[Batch], object], encoder: BatchEncoder) -> None:
    while simulation.next_stamp_ns <= last_ns:
        write(encoder.encode(simulation.take_until(last_ns, BATCH)))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--duration", type=int, default=120, metavar="SECONDS", help="of the simulated run")
    parser.add_argument("--runs", type=int, default=3, help="of each, of which the best counts")
    given = parser.parse_args()
    LOOP.compile()
    print(f"{'':<32}{'messages':>12}{'bulk, µs':>10}{'plain, µs':>11}{'ratio':>8}{'of CPU':>8}")
    with TemporaryDirectory() as folder:
        for name, parameters in TASKS.items():
            counts, ours, plain = zip(
                *(measure(parameters, given.duration, Path(folder)) for _ in range(given.runs)), strict=True
            )
            print(f"{name:<32}{counts[0]:>12}" + costs(counts[0], best(ours), best(plain)), flush=True)
    print(f"largest memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB")


if __name__ == "__main__":
    main()
