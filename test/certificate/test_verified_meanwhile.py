"""A bag that is verified while it is certified gets the verdict, or the error, of one that is verified before."""

from __future__ import annotations

import pytest
from mcap.reader import make_reader
from mcap.writer import IndexType, Writer
from tampering import on, tamper
from test_compiled_check import CHANGES, compiled, sensed  # noqa: F401
from test_streaming import honest  # noqa: F401

from lie_rigid_body.certificate import certified, certify
from lie_rigid_body.errors import BagError
from lie_rigid_body.recording import bag_files
from lie_rigid_body.recording.bag_reader import Bag

CHUNK_BYTES = 20_000


@pytest.fixture(autouse=True)
def short_ones_too(monkeypatch):
    monkeypatch.setattr(bag_files, "_SHORT", 0)


@pytest.fixture
def told():
    return []


@pytest.mark.parametrize("change", ["honest", "gap", "another frame"])
def test_the_certificate_is_the_same(honest, tmp_path, told, change):  # noqa: F811
    path = tamper(honest, tmp_path / "changed.mcap", CHANGES[change], CHUNK_BYTES)
    (bag,), (certificate,) = certified(path, progress=told.append)
    assert repr(certificate) == repr(certify(Bag(path)))
    assert certificate.messages == certify(Bag(path)).messages
    assert bag.is_verified
    again = change == "gap"  # its survey is another than was foreseen
    assert round(sum(told) / path.stat().st_size) == 1 + again


def test_sensors_are_judged_the_same(sensed, tmp_path):  # noqa: F811
    lost = on("/imu/data_raw", lambda ms: [*ms[:100], *ms[103:]])
    for path in (sensed, tamper(sensed, tmp_path / "changed.mcap", lost, CHUNK_BYTES)):
        _, (certificate,) = certified(path)
        assert certificate == certify(Bag(path))
        assert certificate.passed == (path == sensed)


@pytest.mark.parametrize(("change", "place"), [("bit", 0.5), ("bit", 0.97), ("bit", 0.999), ("cut", 0.5)])
def test_what_is_damaged_is_refused(honest, tmp_path, change, place):  # noqa: F811
    content = bytearray(honest.read_bytes())
    at = int(place * len(content))
    content[at] ^= 4
    path = tmp_path / "damaged.mcap"
    path.write_bytes(content[:at] if change == "cut" else content)
    with pytest.raises(BagError) as before:
        Bag(path)
    with pytest.raises(BagError) as meanwhile:
        certified(path)
    assert str(meanwhile.value) == str(before.value)


def test_a_summary_that_leaves_something_out_is_not_believed(honest, tmp_path):  # noqa: F811
    """That the bag counts its samples decides on laws."""
    path = tmp_path / "left_out.mcap"
    with honest.open("rb") as source, path.open("wb") as stream:
        writer = Writer(stream, chunk_size=CHUNK_BYTES, index_types=IndexType.ALL & ~IndexType.METADATA)
        writer.start(profile="ros2", library="someone else")
        channels = {}
        reader = make_reader(source)
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            if channel.topic not in channels:
                assert schema is not None
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, "cdr", number)
            writer.add_message(channels[channel.topic], message.log_time, message.data, message.log_time)
        for record in reader.iter_metadata():
            writer.add_metadata(record.name, record.metadata)
        writer.finish()
    foreseen = Bag.foreseen(path)
    assert foreseen is not None
    assert foreseen.expected_samples is None
    for _ in foreseen.batches():
        pass
    assert not foreseen.is_verified
    (bag,), (certificate,) = certified(path)
    assert bag.is_verified
    assert certificate == certify(Bag(path))
