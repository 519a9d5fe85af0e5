"""What ``check`` says of several bags, of folders of bags, and of bags of several bodies."""
# mypy: ignore-errors

from __future__ import annotations

import os
import shutil

from mcap.reader import make_reader
from test_check import write_bag
from test_check_many import merged, with_messages

from lie_rigid_body.__main__ import main as run

NO_KEYS = b"\0\1\0\0\3\0\0\0{}\0"
UNUSABLE = {
    "no_twist": ("/b/twist", None),
    "no_keys": ("/b/lie_rigid_body/scenario", NO_KEYS),
    "no_text": ("/b/lie_rigid_body/scenario", b"\0\1"),
    "no_pose": ("/b/pose", b"\0\1\0\0\0\0\0\0"),
}
"""Bags of two bodies, of which one has other messages on a topic, or none."""


def prepare(folder):
    for name in ("runs/poor", "runs/.hidden", "empty", "walk", "renamed", "split", "gaps", "lines"):
        (folder / name).mkdir(parents=True)
    good = write_bag(folder / "good.mcap", 40)
    poor = write_bag(folder / "runs/poor/run.mcap", method="rkmk1")
    late = write_bag(folder / "late", 3, epoch_ns=10**18)
    short = write_bag(folder / "short", 3)
    imu = write_bag(folder / "without_readings", 40, imu_rate=10.0)
    for name in ("runs/r9.mcap", "runs/r10.mcap", "runs/.hidden/x.mcap", "walk/walk_0.mcap", "renamed/other_0.mcap"):
        os.link(good, folder / name)
    os.link(good, folder / "split/walk_0.mcap")
    (folder / "runs/cut.mcap").write_bytes(good.read_bytes()[:-100])
    (folder / "runs/runs.parquet").write_bytes(b"PAR1")
    (folder / "circle.mcap").symlink_to("circle.mcap")
    merged(folder / "split/walk_2.mcap")  # without the scenario, which the first file has
    merged(folder / "gaps/gaps.mcap", a=imu)
    merged(folder / "two.mcap", a=good, b=poor)
    given = ["--duration", "0.2", "-p", "imu_rate:=50.0", "--quiet"]
    assert run(["record", str(folder / "imu.mcap"), *given]) == 0
    renamed = ("/b/imu/data_raw", "/b/imu/raw")
    merged(folder / "stray.mcap", renamed=renamed, late_ns=1000, a=good, b=folder / "imu.mcap")
    shutil.copy(folder / "stray.mcap", folder / "other.mcap")
    with late.open("rb") as content:
        ((_, _, scenario),) = make_reader(content).iter_messages(topics=["/lie_rigid_body/scenario"])
    with_messages(folder / "lines/a.mcap", short, "/scenario", scenario.data)
    with_messages(folder / "lines/b.mcap", short, "/scenario", NO_KEYS)
    (folder / "lines/c.mcap").write_bytes(short.read_bytes()[:-9])
    both = merged(folder / "both", a=good, b=good)
    for name, (topic, message) in UNUSABLE.items():
        with_messages(folder / f"{name}.mcap", both, topic, message)
    with_messages(folder / "half", both, "/a/pose", None)
    with_messages(folder / "abtb.mcap", folder / "half", "/b/twist", None)
