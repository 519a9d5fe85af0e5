"""The runs that bags are recorded and checked of, the `mcap` library's way beside it, and how a cost is measured."""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, TypeVar

from mcap.reader import make_reader
from mcap.writer import Writer

from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.messages.batch import Batch, BatchEncoder
from lie_rigid_body.recording.bag_writer import CHUNK_BYTES, BagWriter, write_run
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from peers.table import exchanged, markdown

T = TypeVar("T")

PAGE: Final = Path(__file__).resolve().parent.parent / "docs" / "reference" / "costs.md"
NOISE: Final = {
    "gyro_noise_density": 1e-3,
    "gyro_bias_random_walk": 1e-4,
    "accelerometer_noise_density": 1e-3,
    "accelerometer_bias_random_walk": 1e-4,
    "magnetometer_noise_density": 1e-8,
}
MINUTE, HOUR = 60, 3600
_PLAIN_SECONDS: Final = MINUTE
"""Of the run that the library writes or reads: what a message costs it does not depend on how many there are."""
_BATCH: Final = 8192


@dataclass(frozen=True)
class Run:
    """A run to be recorded: its sensors by name, samples per second, and simulated seconds."""

    sensors: str
    rate: float
    duration: int

    @property
    def parameters(self) -> dict[str, object]:
        """Of its scenario. The IMU reads at the rate of the truth, the magnetometer ten times less often."""
        own: dict[str, object] = {"rate": self.rate}
        if self.sensors == "pose, twist":
            return own
        own |= {"imu_rate": self.rate, "magnetometer_rate": self.rate / 10, "accelerometer_mode": "pivot_gravity"}
        return own | NOISE if self.sensors == NOISY else own

    @property
    def text(self) -> str:
        """Its length in words."""
        lengths = {MINUTE: "a minute", 10 * MINUTE: "ten minutes", HOUR: "an hour"}
        return f"{lengths.get(self.duration, f'{self.duration} s')} at {self.rate:g} Hz"


NOISY: Final = "and IMU, bias, magnetometer with noise"
SENSORS: Final = ("pose, twist", "and IMU, bias, magnetometer", NOISY)
LENGTHS: Final = ((1000.0, 10 * MINUTE), (1000.0, HOUR))


def runs(longest: int) -> Iterator[Run]:
    """Ten minutes of all, and how the least and the most grow, up to a length in s."""
    for sensors in SENSORS:
        for rate, duration in LENGTHS:
            if duration <= longest and (sensors != SENSORS[1] or duration == 10 * MINUTE):
                yield Run(sensors, rate, duration)


@dataclass
class Spent:
    """A context that adds up wall time and processor time of all threads, s."""

    wall: float = 0.0
    cpu: float = 0.0

    def __enter__(self) -> Spent:
        self.wall -= time.perf_counter()
        self.cpu -= time.process_time()
        return self

    def __exit__(self, *_: object) -> None:
        self.wall += time.perf_counter()
        self.cpu += time.process_time()

    def each(self, count: int) -> Spent:
        """The same for one of so many, in µs."""
        return Spent(1e6 * self.wall / count, 1e6 * self.cpu / count)


def mean(*spent: Spent) -> Spent:
    """The mean times."""
    return Spent(*(sum(values) / len(spent) for values in zip(*((s.wall, s.cpu) for s in spent), strict=True)))


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


def write_plainly(scenario: Scenario, last_ns: int, path: Path) -> PlainBag:
    """The messages of a scenario up to a stamp, by the library's writer."""
    simulation, encoder, plain = Simulation(scenario), BatchEncoder(scenario), PlainBag(path)
    while simulation.next_stamp_ns <= last_ns:
        plain.write(encoder.encode(simulation.take_until(last_ns, _BATCH)))
    plain.finish()
    return plain


def plain_writing(run: Run) -> Spent:
    """What a message of a run costs the library's writer, µs."""
    with TemporaryDirectory() as folder:
        last_ns = min(run.duration, _PLAIN_SECONDS) * NS - 1
        plain = write_plainly(Scenario.from_parameters(run.parameters), last_ns, Path(folder, "plain.mcap"))
    return plain.spent.each(plain.messages)


def plain_reading(run: Run) -> Spent:
    """What a message of a run costs the library's reader, which looks into none, µs."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "bag.mcap")
        record(run.parameters, min(run.duration, _PLAIN_SECONDS), path)
        with Spent() as spent, path.open("rb") as stream:
            count = sum(1 for _ in make_reader(stream).iter_messages(log_time_order=False))
    return spent.each(count)


def record(parameters: dict[str, object], duration: int, path: Path) -> None:
    """Record a run as ``record`` does."""
    simulation = Simulation(Scenario.from_parameters(parameters))
    with BagWriter(path, stamped_twist=True) as bag:
        for _ in write_run(bag, simulation, duration * NS - 1):
            pass


def messages_of(path: Path) -> int:
    """How many messages a bag counts."""
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    return summary.statistics.message_count


def alone(function: Callable[..., T], *given: Any) -> tuple[T, float]:
    """The result of a function in a process of its own, and the largest memory of that, MiB."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(_with_memory, function, given).result()


def _with_memory(function: Callable[..., T], given: tuple[Any, ...]) -> tuple[T, float]:
    result = function(*given)
    peak = re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text(encoding="ascii"))
    assert peak is not None
    return result, int(peak[1]) / 1024  # that of getrusage is at least the parent's


def arguments(about: str | None, *, longest: int = HOUR) -> argparse.Namespace:
    """The arguments that these benchmarks have in common."""
    parser = argparse.ArgumentParser(description=(about or "").partition("\n")[0])
    parser.add_argument("--save", action="store_true", help="write the table of docs/reference/costs.md")
    parser.add_argument("--longest", type=int, default=longest, metavar="SECONDS", help="leave out longer runs")
    return parser.parse_args()


def tell(name: str, lines: list[tuple[str, ...]], *, save: bool) -> None:
    """Print a table, and write it into the page if that is asked for."""
    print(markdown(lines), flush=True)
    if save:
        PAGE.write_text(exchanged(PAGE.read_text(encoding="utf-8"), name, markdown(lines)), encoding="utf-8")
