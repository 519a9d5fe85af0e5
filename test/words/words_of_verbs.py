"""What the verbs print: one table of commands, by status."""
# mypy: ignore-errors

from __future__ import annotations

import os
import shlex

from mcap.reader import make_reader
from test_check import write_bag
from test_check_many import merged

from lie_rigid_body.__main__ import main as run

PARAMETERS = [
    "inertia:=[1.0, -2.0, 3.0]",
    "inertia:=[1.0, 0.0, 3.0]",
    "inertia:=[1.0, 2.0, 3.1]",
    "inertia:=[1.0, 2.0]",
    "inertia:=[1.0, 2.0, .nan]",
    "inertia:=[1.0, 2.0, inf]",
    "inertia:=[1.0, 2.0, 1e400]",
    "inertia:=heavy",
    "inertia:=[a, b, c]",
    "inertia:={a: 1}",
    "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 0.0]",
    "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 1.1]",
    "initial_body_rate:=[0.0, 0.0]",
    "rate:=0.0",
    "rate:=-5.0",
    "rate:=.inf",
    "rate:=fast",
    "method:=euler",
    "motion:=flying",
    "max_step:=0.0",
    "inertia:=[1e-320, 1e-320, 1e-320]",
    "inertia:=[1e308, 1e308, 1e308]",
    "initial_body_rate:=[1e200, 0.0, 0.0]",
    "initial_body_rate:=[1e308, 1e308, 1e308]",
    "initial_body_rate:=[1e-160, 2e-161, 0.0]",
    "initial_body_rate:=[1e140, 0.0, 0.0]",
    "world_frame:=/world",
    "body_frame:=''",
    "stamped_twist:=1",
    "epoch_ns:=1.5",
    "epoch_ns:=-1",
    "epoch_ns:=2147483647000000000",
    "inertai:=[1.0, 2.0, 3.0]",
    "use_sim_time:=true",
    "rate=5",
    "rate:=[1.0",
]
"""Values of parameters that are refused."""
COMMANDS = {
    0: [
        "check bag.mcap",
        "check run.mcap",
        "check bag.mcap run.mcap",
        "check one",
        "check two.mcap",
        "check two.mcap --topic pose:=/a/pose",
        "check bag.mcap --prove 3",
        "evaluate bag.mcap --estimate /pose --truth run.mcap --max-rms 1deg",
        "evaluate bag.mcap --estimate /pose --truth run.mcap",
        "explain",
        "explain --scenario dzhanibekov",
        "explain --scenario symmetric_top",
        "explain --scenario spherical_top",
        "explain --scenario asymmetric_top",
        "explain --scenario tossed_phone",
        "explain --scenario tumbling_cubesat",
        "explain --scenario prolate_top",
        "explain -p 'inertia:=[3.0, 4.0, 6.0]' -p 'initial_body_rate:=[-2.0, 3.0, 1.0]'",
        "explain -p 'inertia:=[3.0, 4.0, 6.0]' -p 'initial_body_rate:=[2.0, 3.0, 1.0]'",
        "explain -p 'initial_body_rate:=[0.0, 0.0, 0.0]'",
        "explain -p 'initial_body_rate:=[0.0, 1.0, 0.0]'",
        "explain --scenario symmetric_top -p 'initial_body_rate:=[1.0, 0.0, 0.0]'",
        "explain -p imu_rate:=100.0 -p sensor_grade:=mems -p gyro_turn_on_bias:=0.125",
        "explain -p magnetometer_rate:=10.0 -p magnetometer_stuck_interval:=5.0",
        "record recorded.mcap --duration 0.5",
        "recover cut.mcap -o rescued.mcap",
        "recover between.mcap -o whole.mcap",
        "recover walk -o rescued",
        "recover walk/walk_1.mcap -o part.mcap",
        "evaluate bag.mcap --estimate /pose --truth run.mcap --out scored.mcap",
        "scenarios",
    ],
    1: [
        "check poor.mcap",
        "check bag.mcap poor.mcap",
        "check poor.mcap --prove 3",
        "evaluate poor.mcap --estimate /pose --truth other.mcap --max-rms 1deg",
    ],
    2: [
        *(f"record out.mcap --duration 10 -p {shlex.quote(given)}" for given in PARAMETERS),
        "record ",
        "record out.mcap",
        "record --duration 1",
        "record out.mcap --duration",
        "record out.mcap --duration 1 --fast",
        "record out.mcap --dur 1",
        "record out.mcap other.mcap --duration 1",
        "record out.mcap --duration 0",
        "record out.mcap --duration -1",
        "record out.mcap --duration nan",
        "record out.mcap --duration inf",
        "record out.mcap --duration 1_0",
        "record out.mcap --duration ٣",
        "record out.mcap --duration soon",
        "record out.mcap --duration 1e999999999",
        "record out.mcap --duration 1e-999999999",
        "record out.mcap --duration 5e9",
        "record out.mcap --duration 1 --compression gzip",
        "record out.mcap --duration 1 --chunk-size 0",
        "record out.mcap --duration 1 --chunk-size 1e6",
        "record out.mcap --duration 1 --chunk-size 16777217",
        "record out.mcap --duration 1 --scenario none",
        "record out.mcap --duration 1 --scenario dzanibekov",
        "record out.mcap --duration 1 --params-file none.yaml",
        "record out.mcap --duration 1 --params-file .",
        "record out.mcap --duration 1 --params-file bad.yaml",
        "record out.mcap --duration 1 --params-file other.yaml",
        "record out.mcap --duration 1 --params-file flat.yaml",
        "record out.mcap --duration 1 --params-file flat.yaml -p rate:=0.0",
        "record out.mcap --duration 1 --params-file flat.yaml --params-file unknown.yaml",
        "record none/out.mcap --duration 1",
        "record . --duration 1",
        "record bad.yaml --duration 1",
        "record bad.yaml/out.mcap --duration 1",
        "record /proc/out.mcap --duration 1",
        "record fifo --duration 1 --force",
        "record out.mcap --duration 2e9 -p motion:=closed_form -p rate:=1e6",
        "check",
        "check ''",
        "check -",
        "check bag.mcap 'a\x00b.mcap'",
        "check absent.mcap",
        "check empty.mcap",
        "check text.mcap",
        "check cut.mcap",
        "check bag.mcap --inertia '1;2;3'",
        "check bag.mcap --inertia 1_0,20,30",
        "check bag.mcap --inertia 1,1,3",
        "check bag.mcap --inertia 1,2",
        "check two.mcap --prove 3",
        "check bag.mcap run.mcap --prove 3",
        "check bag.mcap --prove=0",
        "check bag.mcap --prove=-1",
        "check bag.mcap --prove=10001",
        "check bag.mcap --prove=many",
        "check bag.mcap --topic pose=/x",
        "check bag.mcap --topic :=/x",
        "check bag.mcap --topic pos:=/x",
        "check bag.mcap --topic odometry:=/x",
        "check bag.mcap --topic pose:=/attitude",
        "check bag.mcap --topic twist:=/pose",
        "check bag.mcap --topic pose:=/a --topic pose:=/b",
        "check absent.mcap --report page.html",
        "check absent.mcap --report no/a.html",
        "check absent.mcap --report a.pdf",
        "plot absent.mcap -o picture.png",
        "plot bag.mcap -o out.pdf",
        "plot .",
        "plot absent.mcap -o nowhere/out.png",
        "plot absent.mcap -o out.png",
        "plot two.mcap -o out.png",
        "evaluate bag.mcap",
        "evaluate run.mcap --estimate /imu/data",
        "evaluate run.mcap --estimate /imu/data_raw",
        "evaluate run.mcap --estimate /twist",
        "evaluate absent.mcap --estimate /pose",
        "evaluate bag.mcap --estimate /pose --truth absent.mcap",
        "evaluate bag.mcap --estimate /pose --max-rms 1",
        "evaluate bag.mcap --estimate /pose --max-rms -1deg",
        "evaluate bag.mcap --estimate /pose --max-rms 1deg --max-rms 2deg",
        "evaluate bag.mcap --estimate /pose --max-after 10s",
        "evaluate bag.mcap --estimate /pose --max-after -1s:1deg",
        "evaluate bag.mcap --estimate /pose --covariance-axes map",
        "evaluate bag.mcap --estimate /pose --plot a.svg",
        "evaluate bag.mcap --estimate /pose --report a.pdf",
        "evaluate absent.mcap --estimate /pose --plot picture.png",
        "evaluate absent.mcap --estimate /pose --report page.html",
        "evaluate bag.mcap --estimate /pose --plot page.png --report page.html --force",
        "evaluate absent.mcap --estimate /pose --out bag.mcap",
        "evaluate bag.mcap --estimate /pose --out out.bag",
        "evaluate bag.mcap --estimate /pose --out none/out.mcap",
        "evaluate --out out.mcap",
        "evaluate bag.mcap --estimate /pose --topic pose:=/pose",
        "evaluate run.mcap --estimate /pose --topic pose:=/poes",
        "evaluate run.mcap --estimate /pose --topic pose:=/imu/data_raw",
        "evaluate bag.mcap --estimate /pose --topic twist:=/twist",
        "explain --scenario dzanibekov",
        "explain -p 'inertia:=[1.0, 1.0, 3.0]'",
        "explain -p 'inertia:=[1.0, 2.0]'",
        "explain -p 'intertia:=[1.0, 2.0, 3.0]'",
        "explain --params-file absent.yaml",
        "explain dzhanibekov --scenario flat_plate",
        "scenarios all",
        "recover cut.mcap -o cut.mcap",
        "recover cut.mcap -o page.html",
        "recover . -o fixed.mcap",
        "recover nothing -o fixed.mcap",
        "recover absent.mcap -o fixed.mcap",
        "recover text.mcap -o fixed.mcap",
        "recover empty.mcap -o fixed.mcap",
        "recover head.mcap -o fixed.mcap",
        "recover walk -o nothing --force",
        "recover walk -o fixed.mcap --force",
        "recover walk -o walk/fixed --force",
        "recover walk -o none/fixed --force",
    ],
}
"""Commands by their status. Those of status 0 and 1 come first, as they may write files."""


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
    (folder / "bad.yaml").write_text("/**: [1,\n")
    (folder / "other.yaml").write_text("talker: {ros__parameters: {rate: 1.0}}")
    os.mkfifo(folder / "fifo")
