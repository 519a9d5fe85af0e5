"""Bags that rosbag2 wrote with SQLite, by the library that reads them."""

from __future__ import annotations

import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from bags import MakeBag
from mcap.reader import make_reader
from refused_bags import refused

from lie_rigid_body.certificate import certify
from lie_rigid_body.errors import BagError
from lie_rigid_body.recording.bag_reader import Bag, read_bag
from lie_rigid_body.runs import simulate
from said import Error

rosbag2 = pytest.importorskip("rosbags.rosbag2")


def converted(source: Path, target: Path) -> Path:
    """The same messages as a folder of rosbag2 with an SQLite file."""
    from rosbags.interfaces import MessageDefinitionFormat as Format
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_JAZZY)
    assert Format.MSG
    with rosbag2.Writer(target, version=9, storage_plugin=rosbag2.StoragePlugin.SQLITE3) as writer:
        connections = {}
        with source.open("rb") as stream:
            for schema, channel, message in make_reader(stream).iter_messages():
                assert schema is not None
                if channel.topic not in connections:
                    connections[channel.topic] = writer.add_connection(channel.topic, schema.name, typestore=types)
                writer.write(connections[channel.topic], message.log_time, message.data)
    return target


@pytest.fixture
def folder(make_bag: MakeBag, tmp_path: Path) -> Path:
    return converted(make_bag(count=300), tmp_path / "walk")


def test_a_folder_of_sqlite_holds_what_its_messages_are(folder: Path, tmp_path: Path) -> None:
    own, found = read_bag(tmp_path / "bag.mcap"), read_bag(folder)
    np.testing.assert_array_equal(found.poses.values[:, 3:], own.poses.values[:, 3:])
    np.testing.assert_array_equal(found.twists.log_times_ns, own.twists.log_times_ns)
    certificate = certify(Bag(folder))
    assert certificate.passed
    assert certificate.attitude_accuracy == certify(own).attitude_accuracy
    assert "bytes that no law reads: parts without a checksum: 1" in certificate.not_certified
    (folder / "metadata.yaml").unlink()
    assert certify(Bag(folder)).passed


def test_its_metadata_must_fit(folder: Path) -> None:
    metadata = folder / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("storage_identifier: sqlite3", "storage_identifier: mcap"))
    with refused("storage", said="mcap", found="sqlite3"):
        Bag(folder)


def test_a_damaged_database_is_one_line(folder: Path) -> None:
    (file,) = folder.glob("*.db3")
    content = file.read_bytes()
    for damaged in (b"", content[: len(content) // 2], content[:100] + bytes(len(content) - 100), b"hello"):
        file.write_bytes(damaged)
        with pytest.raises(BagError) as caught:
            Bag(folder)
        assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ("data = 'hello' where id = 9", refused("type of a value", kind="text", column="data", wanted="a blob")),
        (
            "timestamp = 'x' where id = 9",
            refused("type of a value", kind="text", column="timestamp", wanted="an integer"),
        ),
        (
            "timestamp = 0.5 where id = 9",
            refused("type of a value", kind="a real number", column="timestamp", wanted="an integer"),
        ),
        ("timestamp = 'x'", refused("type of a column")),
    ],
)
def test_a_value_of_another_type_is_named(folder: Path, change: str, error: Error) -> None:
    (file,) = folder.glob("*.db3")
    with closing(sqlite3.connect(file)) as database:
        database.execute(f"update messages set {change}")
        database.commit()
    with error:
        Bag(folder)


def test_without_the_library_it_says_what_to_install(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    with refused("no library"):
        Bag(folder)


def test_its_sensors_are_held_against_the_scenario(tmp_path: Path) -> None:
    run = simulate("tumbling_cubesat", duration=1.0, imu_rate=50.0, magnetometer_rate=10.0, gyro_noise_density=1e-4)
    run.to_bag(tmp_path / "run.mcap")
    folder = converted(tmp_path / "run.mcap", tmp_path / "walk")
    certificate = certify(Bag(folder))
    assert certificate.passed
    assert not any("imu" in text for text in certificate.not_certified)
    with closing(sqlite3.connect(next(folder.glob("*.db3")))) as database, database:
        of_topic = "select min(m.id), m.data from messages m join topics t on m.topic_id = t.id where t.name = ?"
        number, data = database.execute(of_topic, ["/imu/data_raw"]).fetchone()
        changed = bytearray(data)
        changed[-192 + 5] ^= 1  # of the angular velocity about x; two triads and two covariances end the message
        database.execute("update messages set data = ? where id = ?", [bytes(changed), number])
    assert not certify(Bag(folder)).passed
