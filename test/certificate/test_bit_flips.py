"""One bit of a bag flipped, anywhere: it is caught, or what the certificate speaks of is still the same."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.records import Channel, DataEnd, Message, Schema
from mcap.stream_reader import StreamReader

from foreign_bags import PLAIN, bag_of, messages_of
from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import LIBRARY, BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

COUNT = 100
FLIPS = 1000
"""Of each kind of bag."""
WITHIN = 1e-10
"""By how much, relative to its vector, a number may differ in bags that are both certified: some limits of the laws."""
UNCERTIFIED = {"software", "motion", "method", "max_step", "gravity"}
"""Names of the scenario that docs/reference/fields.md says are not certified, or that no reading of this one shows."""
OUTCOMES = {"refused", "a law is broken", "nothing that is certified changes"}
Content = dict[str, list[list[Any]]]
TEXTS: dict[str, bytes] = {}
"""Texts of the schemas, by name, of whole bags, which are read first: a certificate does not speak of schemas."""


def own(compression: str, folder: Path) -> Path:
    """A headless bag with pose, twist, IMU, bias and magnetometer."""
    path = folder / f"own-{compression}.mcap"
    sensors = {"imu_rate": 50.0, "magnetometer_rate": 20.0, "gyro_noise_density": 1e-3, "gyro_bias_random_walk": 1e-3}
    simulation = Simulation(Scenario.from_parameters({"motion": "closed_form", "epoch_ns": 10**18, **sensors}))
    with BagWriter(path, stamped_twist=True, compression=compression, chunk_size=30_000) as bag:
        bag.begin_segment(simulation.segment)
        last = simulation.clock.stamp_ns(COUNT - 1)
        bag.write(BatchEncoder(simulation.segment.scenario).encode(simulation.take_until(last, COUNT)))
    return path


def recorded(folder: Path) -> Path:
    """The same messages as rosbag2 writes them: a checksum of each chunk, and none of what is between them."""
    path = folder / "recorded.mcap"
    late = [m._replace(log_time=m.log_time + 1000) for m in messages_of(own("", folder))]
    path.write_bytes(bag_of(late, "libmcap 1.1.0", compression=PLAIN, chunk_size=30_000))
    return path


def bare(folder: Path) -> Path:
    """What a forger makes who leaves no checksum."""
    path = folder / "bare.mcap"
    messages = messages_of(own("", folder))
    path.write_bytes(bag_of(messages, LIBRARY, samples=COUNT, compression=PLAIN, enable_crcs=False))
    return path


def live(folder: Path) -> Path:
    """What the node records, with everything that it has to read."""
    path = folder / "live.mcap"
    given = {"rate": 100.0, "imu_rate": 50.0, "magnetometer_rate": 20.0, "record_path": path}
    arguments = [part for name, value in given.items() for part in ("-p", f"{name}:={value}")]
    with subprocess.Popen([sys.executable, "-m", "lie_rigid_body", "sim", *arguments], stdout=-1, text=True) as node:
        while not path.exists() or path.stat().st_size < 40_000:
            assert node.poll() is None
            time.sleep(0.01)
        node.send_signal(signal.SIGINT)
        assert node.communicate(timeout=120.0)[0]
    return path


BAGS: dict[str, Callable[[Path], Path]] = {
    "zstd": lambda folder: own("zstd", folder),
    "lz4": lambda folder: own("lz4", folder),
    "none": lambda folder: own("", folder),
    "of a recorder": recorded,
    "without checksums": bare,
}


def content(path: Path) -> Content:
    """What the messages say, by the `mcap` library and its decoder, by type: in a bag of one body names may differ."""
    from mcap_ros2.decoder import DecoderFactory

    schemas, channels, found = dict[int, Schema](), dict[int, Channel](), Content()
    factory = DecoderFactory()
    with path.open("rb") as stream:
        for record in StreamReader(stream).records:
            if isinstance(record, Schema):
                text = TEXTS.setdefault(record.name, record.data)
                schemas[record.id] = replace(record, data=text, encoding="ros2msg")
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, DataEnd):  # what follows are hints
                break
            elif isinstance(record, Message):
                channel = channels[record.channel_id]
                schema = schemas[channel.schema_id]
                decode = factory.decoder_for("cdr", schema)
                assert decode is not None
                kind = f"{schema.name} {record.channel_id}"
                found.setdefault(kind, []).append(list(values(decode(record.data))))
    return found


def values(message: Any) -> Iterator[Any]:
    """The primitive values of a message; arrays of numbers as tuples, as a vector's scale is that of its largest."""
    if isinstance(message, (int, float, str)):
        yield message
    elif isinstance(message, (list, tuple, np.ndarray)):
        yield tuple(message)
    else:
        parts = [getattr(message, name) for name in message.__slots__ if not name.startswith("_")]
        if all(isinstance(part, float) for part in parts):
            yield tuple(parts)
        else:
            for part in parts:
                yield from values(part)


def same(one: Any, other: Any) -> bool:
    if isinstance(one, tuple):
        size = max(map(abs, one), default=0.0)
        return len(one) == len(other) and all(abs(a - b) <= WITHIN * size for a, b in zip(one, other, strict=True))
    if isinstance(one, str) and one.startswith("{"):
        first, second = (
            {name: value for name, value in json.loads(text).items() if name not in UNCERTIFIED}
            for text in (one, other)
        )
        return first == second
    return bool(one == other)


def changes_nothing(path: Path, before: Content) -> bool:
    now = content(path)
    return now.keys() == before.keys() and all(
        len(now[kind]) == len(rows)
        and all(same(a, b) for row, new in zip(rows, now[kind], strict=True) for a, b in zip(row, new, strict=True))
        for kind, rows in before.items()
    )


def verdict(path: Path, before: Content) -> str:
    try:
        certificates = [certify(bag) for bag in Bag.all_of(path).values() if isinstance(bag, Bag)]
    except LieRigidBodyError as error:
        return "refused" if "\n" not in str(error) else "refused in several lines"
    if not all(certificate.passed for certificate in certificates):
        return "a law is broken"
    assert changes_nothing(path, before)
    return "nothing that is certified changes"


def flipped(whole: Path, folder: Path, count: int, seed: int) -> Counter[str]:
    """What becomes of a bag of which one bit is flipped, so many times at random places."""
    data, before, path = bytearray(whole.read_bytes()), content(whole), folder / "flipped.mcap"
    assert verdict(whole, before) == "nothing that is certified changes"
    found: Counter[str] = Counter()
    for place in np.random.default_rng(seed).integers(0, 8 * len(data), count).tolist():
        at, bit = divmod(place, 8)
        data[at] ^= 1 << bit
        path.write_bytes(data)
        data[at] ^= 1 << bit
        try:
            found[verdict(path, before)] += 1
        except Exception as error:
            raise AssertionError(f"bit {bit} of byte {at}") from error
    return found


@pytest.mark.parametrize("kind", BAGS)
def test_a_flipped_bit_is_caught_or_changes_nothing_that_is_certified(kind: str, tmp_path: Path) -> None:
    found = flipped(BAGS[kind](tmp_path), tmp_path, 30, 1)
    assert set(found) <= OUTCOMES
    assert kind == "without checksums" or found["refused"] >= 15


@pytest.mark.slow
@pytest.mark.parametrize("kind", [*BAGS, pytest.param("live", marks=pytest.mark.ros)])
def test_each_of_thousands_of_flips(kind: str, tmp_path: Path, record_property: Callable[[str, object], None]) -> None:
    whole = BAGS.get(kind, live)(tmp_path)
    found = flipped(whole, tmp_path, FLIPS, 2)
    assert set(found) <= OUTCOMES
    for said, count in sorted(found.items()):
        record_property(said, count)
