"""What the verbs print: one table of commands, by status."""
# mypy: ignore-errors

from __future__ import annotations

import os

from mcap.reader import make_reader
from test_check import write_bag
from test_check_many import merged

from lie_rigid_body.__main__ import main as run


def prepare(folder):
    good = write_bag(folder / "bag.mcap", 50)
    write_bag(folder / "poor.mcap", 50, method="rkmk1")
    write_bag(folder / "other.mcap", 50, initial_body_rate=[1.0, 0.5, 2.0])
    given = ["--duration", "0.5", "-p", "imu_rate:=50.0", "-p", "motion:=closed_form", "--quiet"]
    assert run(["record", str(folder / "run.mcap"), *given]) == 0
    merged(folder / "two.mcap", a=good, b=good)
    for name in ("nothing", "one"):
        (folder / name).mkdir()
    os.link(good, folder / "one" / "bag.mcap")
    (folder / "cut.mcap").write_bytes(good.read_bytes()[:-100])
    (folder / "head.mcap").write_bytes(good.read_bytes()[:60])
    with good.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    chunk = summary.chunk_indexes[0]
    (folder / "between.mcap").write_bytes(good.read_bytes()[: chunk.chunk_start_offset + chunk.chunk_length])
    (folder / "walk").mkdir()
    for name, of in (("walk_0.mcap", "bag.mcap"), ("walk_1.mcap", "between.mcap")):
        os.link(folder / of, folder / "walk" / name)
    (folder / "empty.mcap").touch()
    (folder / "text.mcap").write_text("not a bag\n" * 20)
    (folder / "page.html").write_text("precious")
    (folder / "picture.png").write_text("precious")
    os.link(folder / "page.html", folder / "page.png")
    (folder / "flat.yaml").write_text("/**: {ros__parameters: {inertia: [1.0, 2.0, 3.1]}}")
    (folder / "unknown.yaml").write_text("/**: {ros__parameters: {speed: 10.0}}")
    (folder / "own.yaml").write_text("/**: {ros__parameters: {inertia: [2.0, 3.0, 4.0]}}")
    (folder / "bad.yaml").write_text("/**: [1,\n")
    (folder / "other.yaml").write_text("talker: {ros__parameters: {rate: 1.0}}")
    os.mkfifo(folder / "fifo")
