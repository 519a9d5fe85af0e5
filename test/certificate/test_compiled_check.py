"""A bag that is read and judged by compiled loops gets the certificate that it gets in Python, to the bit."""

from __future__ import annotations

import os

import numpy as np
import pytest
from tampering import at, flipped, on, rotated, scaled_rate, tamper
from test_streaming import honest  # noqa: F401

from lie_rigid_body.certificate import certify, residuals
from lie_rigid_body.certificate.residuals import Residuals
from lie_rigid_body.errors import BagError
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.recording import message_loops, message_scan
from lie_rigid_body.recording.bag_reader import Bag, read_bag
from lie_rigid_body.recording.message_loops import FIND, TAKE

pytest.importorskip("numba")
KERNELS = {message_loops: ("FIND", "TAKE"), residuals: ("WORK",)}


@pytest.fixture(scope="module", autouse=True)
def compiled():
    assert all(getattr(module, name).compile() for module, names in KERNELS.items() for name in names)


@pytest.fixture
def in_python(monkeypatch):
    """A function after which nothing runs compiled."""

    def forget() -> None:
        for module, names in KERNELS.items():
            for name in names:
                monkeypatch.setattr(getattr(module, name), "_compiled", None)
                monkeypatch.setattr(getattr(module, name), "_may_compile", False)

    return forget


def renamed_frame(message):
    return message._replace(data=message.data.replace(b"world", b"wurld"))


CHANGES = {
    "honest": lambda ms: ms,
    "gap": on("/pose", lambda ms: [*ms[:300], *ms[317:]]),
    "doubled": on("/twist", lambda ms: [*ms[:301], *ms[300:]]),
    "flipped": on("/pose", at(511, flipped)),
    "turned": on("/pose", at(4, rotated(1e-6, np.array([1.0, 2.0, 3.0])))),
    "scaled": on("/twist", at(77, scaled_rate(1 + 1e-12))),
    "not a number": on("/twist", at(78, scaled_rate(np.nan))),
    "another frame": on("/pose", at(300, renamed_frame)),
}


@pytest.mark.parametrize("change", CHANGES)
def test_the_certificate_is_that_of_python(honest, tmp_path, in_python, change):  # noqa: F811
    path = tamper(honest, tmp_path / "changed.mcap", CHANGES[change])
    quick = certify(Bag(path))
    assert repr(Bag(path).load().poses) == repr(read_bag(path).poses)
    in_python()
    assert certify(Bag(path)) == quick or change == "not a number"
    assert [law.message for s in certify(Bag(path)).segments for law in s.laws] == [
        law.message for s in quick.segments for law in s.laws
    ]


def test_files_that_continue_each_other_are_one_bag(honest, tmp_path, in_python):  # noqa: F811
    folder = tmp_path / "walk"
    folder.mkdir()
    for i, part in enumerate((slice(0, 900), slice(900, 901), slice(901, None))):
        tamper(honest, folder / f"walk_{i}.mcap", lambda ms, part=part: ms[part])  # type: ignore[misc]
    whole = tamper(honest, tmp_path / "whole.mcap", lambda ms: ms)
    quick = certify(Bag(folder))
    assert quick.passed
    assert quick.segments == certify(Bag(whole)).segments
    in_python()
    assert certify(Bag(folder)) == quick


def test_a_message_that_is_no_pose_is_named(honest, tmp_path):  # noqa: F811
    short = on("/pose", at(700, lambda message: message._replace(data=message.data[:-1])))
    bag = Bag(tamper(honest, tmp_path / "short.mcap", short))
    with pytest.raises(BagError, match=r"topic /pose: message 700 has \d+ bytes where"):
        list(bag.batches())


def test_a_bag_that_changes_between_two_readings_is_refused(honest, tmp_path):  # noqa: F811
    path = tmp_path / "bag.mcap"
    path.write_bytes(honest.read_bytes())
    bag = Bag(path)
    list(bag.batches())
    with path.open("r+b") as stream:
        stream.seek(5000)
        stream.write(b"changed")
    with pytest.raises(BagError, match="changed while it was read"):
        list(bag.batches())
    os.replace(tamper(honest, tmp_path / "other.mcap", lambda ms: ms), path)
    with pytest.raises(BagError, match="changed while it was read"):
        list(bag.batches())


def test_residuals_have_the_bits_of_arrays(in_python):
    rng = np.random.default_rng(3)
    attitude = rng.normal(size=(50, 4))
    states = State.trusted(attitude / np.linalg.norm(attitude, axis=1)[:, None], rng.normal(size=(50, 3)))
    other = State.trusted(np.roll(states.attitude_xyzw, 1, axis=0), states.body_rate)
    body, spans = RigidBody([1.0, 0.05, 0.02, 1.4, 0.1, 1.9]), rng.uniform(0.0, 0.4, 49)
    found = [Residuals.of(body, states, other, spans, 5.0, 0.4)]
    in_python()
    found.append(Residuals.of(body, states, other, spans, 5.0, 0.4))
    for name, value in vars(found[0]).items():
        np.testing.assert_array_equal(value, getattr(found[1], name), err_msg=name)


def test_messages_are_found_as_they_lie(honest):  # noqa: F811
    outline = Bag(honest)._outlines[0]
    assert len(outline.chunks) > 10
    data = b"".join(_record(5, b"\1\0" + bytes(4) + (7).to_bytes(8, "little") * 2 + b"payload") for _ in range(3))
    found = message_scan.FoundMessages(FIND.compiled_for(0), data + _record(4, b"a channel") + data)
    table = found.at(0)
    assert table is not None
    assert (table.starts.tolist(), table.ends.tolist()) == ([0, 38, 76], [38, 76, 114])
    for column in (table.log_times, table.publish_times):
        assert column.tolist() == [7] * 3
    assert found.at(114) is None
    assert message_scan.FoundMessages(FIND.compiled_for(0), data[:-1]).at(76) is None
    assert TAKE.compiled_for(0) is not None


def _record(opcode: int, content: bytes) -> bytes:
    return bytes([opcode]) + len(content).to_bytes(8, "little") + content
