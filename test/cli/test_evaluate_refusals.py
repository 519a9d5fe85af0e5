"""What ``evaluate`` refuses: status 2, and one line on stderr that says of which topic."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from estimate_messages import Make, beside, messages, write
from evaluating import HOW, ODOMETRY, POSE, TF, P, refused

from lie_rigid_body.cli.evaluate import main

BAD: dict[str, Any] = {
    "not a number": lambda t, q: (t, np.where(np.arange(len(t))[:, None] == 7, np.nan, q)),
    "zero": lambda t, q: (t, np.where(np.arange(len(t))[:, None] == 7, 0.0, q)),
    "another clock": lambda t, q: (t + 10**18, q),
    "empty": lambda t, q: (t[:0], q[:0]),
}


@pytest.mark.parametrize("case", BAD)
def test_unusable_estimates_are_refused_in_one_line(case, own, stamps, noisy, tmp_path, capsys):
    bag = beside(own, tmp_path / "bad.mcap", (POSE, HOW[POSE], "/estimate", *BAD[case](stamps, noisy)))
    assert "estimate" in refused(capsys, bag, "--estimate", "/estimate")


def alternating(one: Make, other: Make) -> Make:
    return lambda stamp, q: (one if stamp % 80_000_000 else other)(stamp, q)


def test_two_bodies_are_refused(own, stamps, noisy, tmp_path, capsys):
    other = messages(P, world="b/world", body="b/base_link")
    for kind in (POSE, ODOMETRY):
        topic = (kind, alternating(messages(P, world="a/world")[kind], other[kind]), "/estimate", stamps, noisy)
        bag = beside(own, tmp_path / f"{kind.rpartition('/')[2]}.mcap", topic)
        assert "b/world" in refused(capsys, bag, "--estimate", "/estimate")
    transforms = (TF, other[TF], "/tf", stamps, noisy)
    assert "b/base_link" in refused(capsys, beside(own, tmp_path / "tf.mcap", transforms), "--estimate", "/tf")
    truths = [(POSE, HOW[POSE], f"/{name}/pose", stamps, noisy) for name in "ab"]
    two = beside(own, tmp_path / "two.mcap", *truths, without="/lie_rigid_body/scenario /pose")
    assert "/a/pose, /b/pose" in refused(capsys, own, "--estimate", "/pose", "--truth", two)


def test_damaged_messages_are_refused(own, stamps, noisy, tmp_path, capsys):
    for kind in (TF, ODOMETRY):
        good = write(tmp_path / "good.mcap", kind, HOW[kind], "/estimate", stamps[:1], noisy[:1])
        assert main([str(good), "--estimate", "/estimate", "--truth", str(own)]) == 0
        from mcap.reader import make_reader
        from mcap.writer import Writer

        with good.open("rb") as stream:
            [(_, _, message)] = make_reader(stream).iter_messages()
        for data in (message.data[:-20], message.data + bytes(16), message.data[:30], b"\x07\x07\x00\x00", b""):
            with (tmp_path / "bad.mcap").open("wb") as out:
                writer = Writer(out)
                writer.start(profile="ros2")
                channel = writer.register_channel("/estimate", "cdr", writer.register_schema(kind, "ros2msg", b""))
                writer.add_message(channel, 0, data, 0)
                writer.finish()
            assert "/estimate" in refused(capsys, tmp_path / "bad.mcap", "--estimate", "/estimate", "--truth", own)


def test_one_topic_with_its_slash_and_without_is_refused(own, stamps, noisy, tmp_path, capsys):
    bag = beside(own, tmp_path / "twice.mcap", (POSE, HOW[POSE], "/estimate", stamps, noisy))
    assert "/estimate" in refused(capsys, bag, "--estimate", "/estimate", "--estimate", "estimate")
