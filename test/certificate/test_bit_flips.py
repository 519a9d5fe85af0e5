"""One bit of a bag flipped, anywhere: it is caught, or what the certificate speaks of is still the same."""

from __future__ import annotations

import json
import signal
import struct
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sensor_bags import write

import fuzzing
from foreign_bags import PLAIN, bag_of, messages_of
from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.messages.definitions import STRING
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import LIBRARY

COUNT = 100
WITHIN = 1e-11
"""By how much, relative to the largest of its message, a number may differ where both bags are certified."""
UNCERTIFIED = {"software", "motion", "method", "max_step", "gravity", "fault_begin", "fault_end", "sensor_grade"}
IDLE = ("_size", "_duration", "_level", "_burst_density", "_inclination_noise", "_heading_noise")
"""Names of the scenario that docs/reference/fields.md says are not certified, or that no reading of this one shows."""
OUTCOMES = {"refused", "a law is broken", "nothing that is certified changes", "the library cannot read it"}


def own(compression: str, folder: Path) -> Path:
    """A headless bag with pose, twist, IMU, bias and magnetometer."""
    sensors = {"imu_rate": 50.0, "magnetometer_rate": 20.0, "gyro_noise_density": 1e-3, "gyro_bias_random_walk": 1e-3}
    given = {"motion": "closed_form", "rate": 100.0, **sensors}
    path = folder / f"own-{compression}.mcap"
    return write(path, (given, (COUNT - 1) / 100.0), compression=compression, chunk_size=30_000)


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


def content(path: Path) -> list[tuple[str, object, np.ndarray]]:
    """Type, stamp and frame or text, and numbers of each message: in a bag of one body names of topics may differ."""
    found = list[tuple[str, object, np.ndarray]]()
    for message in messages_of(path):
        if message.kind == STRING:
            text = {
                n: v for n, v in json.loads(message.data[8:-1]).items() if not (n in UNCERTIFIED or n.endswith(IDLE))
            }
            found.append((message.kind, text, np.empty(0)))
        else:
            [(_, head, numbers)] = fuzzing.contents([message], {message.topic: message.kind})
            found.append((message.kind, head, np.array(numbers)))
    return found


def same(one: tuple[str, object, np.ndarray], other: tuple[str, object, np.ndarray]) -> bool:
    numbers, others = one[2], other[2]
    is_near = len(numbers) == len(others) and (abs(numbers - others) <= WITHIN * abs(numbers).max(initial=0.0)).all()
    return one[:2] == other[:2] and bool(is_near)


def verdict(path: Path, before: list[Any]) -> str:
    try:
        certificates = [certify(bag) for bag in Bag.all_of(path).values() if isinstance(bag, Bag)]
    except LieRigidBodyError as error:
        return "refused" if "\n" not in str(error) else "refused in several lines"
    if not all(certificate.passed for certificate in certificates):
        return "a law is broken"
    try:
        now = content(path)
    except struct.error:  # of indexes, which are hints to us
        return "the library cannot read it"
    assert len(now) == len(before)
    assert all(map(same, before, now))
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


@pytest.mark.parametrize("count", [30, pytest.param(400, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", [*BAGS, pytest.param("live", marks=[pytest.mark.ros, pytest.mark.slow])])
def test_a_flipped_bit_is_caught_or_changes_nothing_that_is_certified(kind: str, count: int, tmp_path: Path) -> None:
    found = flipped(BAGS.get(kind, live)(tmp_path), tmp_path, count, count)
    assert set(found) <= OUTCOMES
    assert kind in ("without checksums", "live") or found["refused"] >= count // 2
