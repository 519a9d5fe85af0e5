"""What is said of files that are no bags, are cut off or damaged, or hold more than is read."""
# mypy: ignore-errors

from __future__ import annotations

import struct
from pathlib import Path

import zstandard
from bags import rewrite, write_bag
from forged import CHANNELS, chunk, flipped, forged, framed, inserted, left_out, message, plain
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC as MAGIC

from foreign_bags import record, text
from lie_rigid_body import simulate
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.recording.logs import read_log
from lie_rigid_body.recording.mcap_contents import nothing
from lie_rigid_body.recording.poses import with_path
from lie_rigid_body.recording.recovered_folder import recover_folder
from lie_rigid_body.recording.recovery import recover
from lie_rigid_body.simulation import Segment
from lie_rigid_body.system.bounded_input import load_yaml

CHANNEL = record(Opcode.CHANNEL, struct.pack("<HH", 1, 0) + text("/x") + text("cdr") + bytes(4))
JSON_CHANNEL = record(Opcode.CHANNEL, struct.pack("<HH", 2, 0) + text("/x") + text("json") + bytes(4))
CHANGES = {
    "profile": flipped(Opcode.HEADER, 4),
    "no end of data": left_out(Opcode.DATA_END),
    "crc of the data": flipped(Opcode.DATA_END, 0),
    "schema": inserted(Opcode.DATA_END, Opcode.SCHEMA, struct.pack("<H", 1) + text("a") + text("b") + text("c")),
    "channel of no schema": inserted(
        Opcode.CHUNK, Opcode.CHANNEL, struct.pack("<HH", 1, 9) + text("/x") + text("cdr") + bytes(4)
    ),
    "size of a chunk": flipped(Opcode.CHUNK, 16),
    "crc of a chunk": flipped(Opcode.CHUNK, 24),
}
RECORDS = {
    "no channel": plain(message(999)),
    "no channel, no chunk": message(999),
    "no text": record(Opcode.SCHEMA, struct.pack("<HI", 1, 1) + b"\xf5" + text("ros2msg") + text("")),
    "short message": plain(record(5, bytes(21))),
    "zeros": plain(bytes(9)),
    "unfinished": plain(record(3, b""), record(3, b"x")[:-1]),
    "two encodings": plain(CHANNEL, JSON_CHANNEL, message(CHANNELS[0]), message(CHANNELS[1])),
    "brotli": chunk("brotli", 9, b"packed"),
    "large chunk": chunk("zstd", 2**29, b""),
    "beyond the end": struct.pack("<BQ", 4, 2**63),
}
NO_SCENARIOS = [
    "[" * 1_100_000,
    "[" * 60_000,
    "[]",
    '{"first_sample": 0}',
    f'{{"epoch_ns": 1{"0" * 4000}}}',
]
WHOLE = forged(lambda records: None)
FILES = {
    "no footer": WHOLE[: WHOLE.rindex(record(Opcode.FOOTER, b"")[:2])],
    "no magic": WHOLE[: -len(MAGIC)],
    "no messages, no end": framed()[:40],
    "zeros behind": WHOLE + bytes(9),
    "nothing": b"",
    "text": b"hello",
    "half a magic": MAGIC[:-1],
    "ROS 1": b"#ROSBAG V2.0\n",
    "SQLite": b"SQLite format 3\x00...",
    "zstd": zstandard.compress(framed()),
}


def read(content):
    """Read a file of such a content."""
    Path("x.mcap").write_bytes(content)
    return BagFiles("x.mcap").contents(nothing)


def change(how):
    return read(forged(CHANGES[how]))


def records(what):
    return read(framed(RECORDS[what]))


def file(what):
    return read(FILES[what])


def folder(*names, metadata=""):
    """Read a folder of empty files of such names, with metadata."""
    Path("run").mkdir()
    for name in names:
        Path("run", name).touch()
    if metadata:
        Path("run/metadata.yaml").write_text(f"rosbag2_bagfile_information: {metadata}")
    return BagFiles("run")


def rescued(content):
    """Recover a file of such a content, which makes none where it is refused."""
    Path("x.mcap").write_bytes(content)
    try:
        recover(Path("x.mcap"), Path("y.mcap"), overwrite=False)
    finally:
        assert not Path("y.mcap").exists()


def own(**options):
    """Read a bag of this package as another recorder, or recorder's option, would have written it."""
    return read_bag(rewrite(write_bag(Path("own.mcap"), 3), Path("x.mcap"), **options))


def rescued_folder(fixed):
    Path("run").mkdir()
    Path("run/run_0.mcap").touch()
    return recover_folder(Path("run"), Path(fixed))


POSE_LINES = "0.0 0 0 0 0 0 0 1\n0.1 0 0 0 0 0 0 1\n"
NO_POSES = [
    "",
    "0.0 1 2 3\n",
    "# nothing\n",
    *(f"{POSE_LINES}0.2 0 0 0 0 0 {word} 1\n" for word in ("one", "1_0", "nan", "inf")),
    *(f"{POSE_LINES}{word} 0 0 0 0 0 0 1\n" for word in ("later", "nan", "1e999999999", "0.0")),
    "1.5,0,0,0,1,0,0,0\n",
    f"{POSE_LINES}0.1 0 0 0 0 0 0 1\n",
    *(f"{POSE_LINES}0.2 0 0 0 0 0 0 {norm}\n" for norm in (0.9, 0.0)),
    "\udcff\udcfe",
]


def poses(text, name="hand.tum"):
    if text is not None:
        Path(name).write_text(text, errors="surrogateescape")
    return with_path({"motion": "path", "path_file": name, "path_interval": 0.0})


def poses_of_two():
    run = simulate(duration=0.1, motion="closed_form")
    attitude = Estimate(run.truth.attitude_xyzw, run.t_ns)
    run.to_bag("two.mcap", estimates={"/a/b": attitude, "/a/pose": attitude})
    return poses(None, "two.mcap")


ROWS = [f"{i / 100},1,2,3\n" for i in range(9)]
LOGS = (
    ("", {}),
    ("hello\n", {}),
    ("\0", {}),
    ("".join(ROWS), {}),
    ("t,ax,ay,az\n" + "".join(ROWS), {}),
    ("n,gx,gy,gz\n" + "".join(ROWS), {}),
    ("t,gx,gy,gz\n" + "5,1,2,3\n" * 9, {}),
    *((f"t,gx,gy,gz\n{ROWS[0]}{row}\n", {}) for row in ("1,2,3", "1,2,3,x", "1,2,3,nan", "1,2,3,", "x,1,2,3", '"' * 3)),
    *(
        ("t,gx,gy,gz\n" + "".join(ROWS), {"columns": columns})
        for columns in (["gx"], {"gyro": "gx"}, {"gyro_x": "hx"}, {"gyro_x": "gy"})
    ),
    *(
        ("t,gx,gy,gz\n" + "".join(ROWS), {"columns": {f"gyro_{axis}": f"g{axis}{unit}" for axis, unit in units}})
        for units in (zip("xyz", (":kg", ":kg", ":kg"), strict=True), zip("xyz", (":deg/s", "", ""), strict=True))
    ),
    ("t,gx,gy,gz\n" + "".join(ROWS), {"imu": "/imu"}),
)


def log(text, how, name="hand.csv"):
    Path(name).write_text(text)
    return read_log(name, **how)


def two_sensors():
    Path("hand").mkdir(exist_ok=True)
    for name, late in (("Gyroscope", 0), ("Magnetometer", 100)):
        Path("hand", f"{name}.csv").write_text(
            "Time (s),x,y,z\n" + "".join(f"{i / 100 + late},1,2,3\n" for i in range(9))
        )
    return read_log("hand")


REFUSED = {
    BagError: [
        lambda: log("SQLite", {}, "hand.db3"),
        lambda: read_log(write_bag(Path("own.mcap"), 3)),
        *(lambda how=how: change(how) for how in CHANGES),
        *(lambda what=what: records(what) for what in RECORDS),
        *(lambda what=what: file(what) for what in FILES),
        lambda: BagFiles("none.mcap").contents(nothing),
        lambda: folder(),
        lambda: folder("a.mcap", "b.mcap"),
        lambda: folder("run_0.mcap.zstd"),
        lambda: folder("run_0.mcap", metadata="3"),
        lambda: folder("run_0.mcap", metadata="{relative_file_paths: []}"),
        lambda: folder("new_0.mcap", metadata="{relative_file_paths: [old_0.mcap]}"),
        lambda: folder("x.mcap", metadata="{relative_file_paths: [x.mcap], compression_mode: MESSAGE}"),
        lambda: rescued(framed()),
        lambda: rescued(framed()[:-1]),
        lambda: rescued(framed(chunk("zstd", 2**29, b""))),
        lambda: rescued(b"hello"),
        lambda: own(encoding="json"),
        lambda: BagWriter(write_bag(Path("own.mcap"), 3), stamped_twist=True),
        lambda: own(change=lambda number, topic, data: zstandard.compress(data)),
        lambda: rescued_folder("run/fixed"),
        lambda: rescued_folder("fixed.mcap"),
        lambda: rescued_folder("run"),
        lambda: rescued_folder("fixed"),
    ],
    InputError: [
        *(lambda text=text: Segment.from_json(text) for text in NO_SCENARIOS),
        lambda: load_yaml("[" * 3000, "x"),
        *(lambda text=text: poses(text) for text in NO_POSES),
        lambda: poses(None),
        lambda: poses("".join(f"{k / 1000} 0 0 0 0 0 0 1\n" for k in range(6000))),
        poses_of_two,
        *(lambda text=text, how=how: log(text, how) for text, how in LOGS),
        lambda: log("PK\3\4", {}, "hand.zip"),
        lambda: log("#ROSBAG V2.0", {}, "hand.bag"),
        lambda: read_log("none.csv"),
        lambda: read_log("."),
        two_sensors,
    ],
}
