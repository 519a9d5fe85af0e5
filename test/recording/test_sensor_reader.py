"""The sensors of a bag: the same numbers however the bag is cut, and refusals that name the topic."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard
from bags import rewrite
from refused_bags import refused

from lie_rigid_body import Run, simulate
from lie_rigid_body.foundation.wording import MAX_LINE
from lie_rigid_body.messages import encode_string
from said import Error

IMU, BIAS = "/imu/data_raw", "/imu/bias"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = simulate(
        duration=1.0, rate=10.0, imu_rate=50.0, magnetometer_rate=20.0, gyro_noise_density=1e-3, gyro_turn_on_bias=0.1
    )
    path = tmp_path_factory.mktemp("sensors") / "whole.mcap"
    run.to_bag(path)
    return path


def numbers(run: Run) -> list[bytes]:
    assert run.magnetometer is not None
    return [np.asarray(value).tobytes() for part in (run.imu, run.magnetometer) for value in vars(part).values()]


@pytest.mark.parametrize("chunk_size", [1, 2000])
def test_sensors_are_the_same_in_many_chunks_and_files(whole: Path, tmp_path: Path, chunk_size: int) -> None:
    for part in range(3):
        inside = range(70 * part, 1000 if part == 2 else 70 * (part + 1))
        rewrite(
            whole,
            tmp_path / f"{tmp_path.name}_{part}.mcap",
            keep=lambda number, topic, inside=inside: number in inside,  # type: ignore[misc]
            chunk_size=chunk_size,
        )
    cut = Run.from_bag(tmp_path)
    assert numbers(cut) == numbers(Run.from_bag(whole))
    assert len(cut.t_ns) == 10


@pytest.mark.parametrize(
    ("topic", "change", "error"),
    [
        (IMU, zstandard.compress, refused("compressed messages")),
        (IMU, lambda data: data[:100], refused("message cut", topic=IMU, number=0, size=100)),
        (BIAS, lambda data: b"\x07" + data[1:], refused("no CDR", topic=BIAS, number=0, begin="07")),
    ],
)
def test_messages_that_are_no_readings_are_refused_by_topic(
    whole: Path, tmp_path: Path, topic: str, change: Callable[[bytes], bytes], error: Error
) -> None:
    path = rewrite(
        whole, tmp_path / "x.mcap", change=lambda number, name, data: change(data) if name == topic else data
    )
    with error:
        Run.from_bag(path)


FAULTS = "/lie_rigid_body/faults"


@pytest.fixture(scope="module")
def faulty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sensors") / "faulty.mcap"
    simulate(duration=1.0, rate=10.0, imu_rate=50.0, imu_dropout_probability=0.3, imu_latency=0.01).to_bag(path)
    return path


def test_faults_are_read_beside_a_scenario_of_another_name(faulty: Path, tmp_path: Path) -> None:
    """Another recorder's log times are of its own clock, and a text of its own is no scenario."""
    renamed = rewrite(faulty, tmp_path / "x.mcap", lambda topic: topic.replace("scenario", "text"))
    read, whole = Run.from_bag(renamed), Run.from_bag(faulty)
    assert read.faults == whole.faults
    assert len(read.faults) > 5
    assert (whole.imu.arrival_ns - whole.imu.t_ns == 10_000_000).all()
    assert np.array_equal(read.imu.arrival_ns, read.imu.t_ns)


STUCK = '{"kind": "stuck", "sensor": "gyro", "axis": "x", "begin_ns": 7, "end_ns": null, "size": 0.1}'


NO_FAULTS = [STUCK.replace("7", "true"), STUCK.replace("0.1", "[]"), "{}", "[1]", '{"kind": "x"}', "{" * 500, ""]


@pytest.mark.parametrize("text", NO_FAULTS)
def test_what_tells_of_no_fault_is_refused_in_one_line(faulty: Path, tmp_path: Path, text: str) -> None:
    path = rewrite(
        faulty, tmp_path / "x.mcap", change=lambda number, name, data: encode_string(text) if name == FAULTS else data
    )
    with refused("no fault") as refusal:
        Run.from_bag(path)
    assert len(str(refusal.value)) <= MAX_LINE + len(str(path))
