"""Bags that are laid out in bulk are those of the `mcap` library's own writer, to the byte."""

from __future__ import annotations

from functools import cache
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import zstandard
from bags import COMPRESSIONS, PlainBag
from numpy.typing import NDArray

from lie_rigid_body.foundation.arrays import Integers
from lie_rigid_body.messages.batch import Batch, BatchEncoder
from lie_rigid_body.messages.layout import Template
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.recording.mcap_writer import ZSTD_LEVEL
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment, Simulation
from sampled import sampled

SENSORS = {
    "imu_rate": 250.0,
    "magnetometer_rate": 33.3,
    "gyro_noise_density": 1e-3,
    "gyro_bias_random_walk": 1e-4,
    "accelerometer_mode": "pivot_gravity",
}
SCENARIOS: dict[str, list[dict[str, object]]] = {
    "truth": [{}],
    "sensors": [SENSORS],
    "slow truth": [{**SENSORS, "rate": 7.0}],
    "faults": [{"rate": 20.0, "imu_rate": 50.0, "imu_latency_jitter": 0.03, "imu_dropout_probability": 0.1}],
    "sensors that come and go": [{}, SENSORS, {"magnetometer_rate": 300.0}, {}],
}


@pytest.fixture(autouse=True)
def _same_level(monkeypatch: pytest.MonkeyPatch) -> None:
    """The library's writer gives no choice of the level."""
    monkeypatch.setattr("mcap.writer.zstandard.compress", zstandard.ZstdCompressor(ZSTD_LEVEL).compress)


@cache
def batches(name: str, size: int) -> list[Segment | Batch]:
    """What a run of some seconds in each segment records."""
    run: list[Segment | Batch] = []
    simulation: Simulation | None = None
    for parameters in SCENARIOS[name]:
        scenario = Scenario.from_parameters({"motion": "closed_form", "epoch_ns": 5, **parameters})
        if simulation is None:
            simulation = Simulation(scenario)
        else:
            simulation.reset(scenario)
        encoder, end = BatchEncoder(scenario), simulation.next_stamp_ns + 4_000_000_000
        run.append(simulation.segment)
        while simulation.next_stamp_ns <= end:
            run.append(encoder.encode(simulation.take_until(end, size)))
    return run


def samples(run: list[Segment | Batch]) -> int:
    return sum(len(part.samples) for part in run if isinstance(part, Batch))


def plain(run: list[Segment | Batch], chunk_size: int, compression: str) -> bytes:
    stream = BytesIO()
    bag = PlainBag(stream, chunk_size=chunk_size, compression=COMPRESSIONS[compression])
    for part in run:
        bag.write(part) if isinstance(part, Batch) else bag.begin_segment(part)
    bag.finish(samples(run))
    return stream.getvalue()


def in_bulk(run: list[Segment | Batch], chunk_size: int, compression: str, path: Path) -> bytes:
    with BagWriter(path, stamped_twist=True, chunk_size=chunk_size, compression=compression) as bag:
        for part in run:
            bag.write(part) if isinstance(part, Batch) else bag.begin_segment(part)
    return path.read_bytes()


CHUNKS = [(256 * 1024, "zstd"), (1024, "zstd"), (5000, "lz4"), (777, ""), (1, "")]


@pytest.mark.parametrize(
    ("name", "chunk_size", "compression"),
    sampled(
        [(name, *chunks) for i, name in enumerate(SCENARIOS) for j, chunks in enumerate(CHUNKS) if (i + j) % 2], every=3
    ),
)
def test_every_byte_is_that_of_the_plain_writer(tmp_path: Path, name: str, chunk_size: int, compression: str) -> None:
    run = batches(name, 1024)
    assert in_bulk(run, chunk_size, compression, tmp_path / "a.mcap") == plain(run, chunk_size, compression)


@pytest.mark.parametrize(("name", "size"), [("sensors", 1), ("sensors", 37), ("sensors", 100_000), ("faults", 1)])
def test_where_batches_begin_changes_no_byte(tmp_path: Path, name: str, size: int) -> None:
    expected = plain(batches(name, 1024), 5000, "zstd")
    assert in_bulk(batches(name, size), 5000, "zstd", tmp_path / "a.mcap") == expected


@pytest.mark.parametrize("name", ["truth", "faults"])
def test_samples_that_come_one_by_one_are_laid_out_many_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """A live node has no time to lay out each alone."""
    put, laid_out = Template.put, list[int]()

    def counted(template: Template, data: NDArray[np.uint8], places: Integers, words: Integers) -> None:
        laid_out.append(len(words))
        put(template, data, places, words)

    monkeypatch.setattr(Template, "put", counted)
    run = batches(name, 1)
    in_bulk(run, 256 * 1024, "zstd", tmp_path / "a.mcap")
    assert len(laid_out) < len(run) / 4


def test_the_samples_of_a_bag_are_counted_as_they_are_written(tmp_path: Path) -> None:
    first, *run = batches("sensors", 1)[:20]
    assert isinstance(first, Segment)
    with BagWriter(tmp_path / "a.mcap", stamped_twist=True) as bag:
        bag.begin_segment(first)
        for i, part in enumerate(run):
            assert isinstance(part, Batch)
            bag.write(part)
            assert bag.sample_count == samples(run[: i + 1])
