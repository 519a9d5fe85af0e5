"""The words of the verbs: what each refuses, in one line on stderr with status 2, and what it says of what it found.

All other tests of this folder assert on statuses, codes and numbers.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader
from test_check import write_bag
from test_check_many import merged

from lie_rigid_body.__main__ import main
from lie_rigid_body.system.console import status_of

PARAMETERS = {
    "inertia:=[1.0, -2.0, 3.0]": "inertia: .*-2",
    "inertia:=[1.0, 0.0, 3.0]": "inertia: ",
    "inertia:=[1.0, 2.0, 3.1]": "inertia: .*triangle",
    "inertia:=[1.0, 2.0]": "inertia: .*has 2 numbers: give 3 or 6",
    "inertia:=[1.0, 2.0, .nan]": "inertia: nan is not finite",
    "inertia:=[1.0, 2.0, inf]": "inertia: inf is not finite",
    "inertia:=[1.0, 2.0, 1e400]": "inertia: inf is not finite",
    "inertia:=heavy": "inertia: 'heavy' is not a list",
    "inertia:=[a, b, c]": "inertia: 'a' is not a number",
    "inertia:={a: 1}": "inertia: .*is not a list",
    "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 0.0]": "initial_attitude_xyzw: norm 0 is not 1",
    "initial_attitude_xyzw:=[0.0, 0.0, 0.0, 1.1]": "initial_attitude_xyzw: norm 1.1 is not 1",
    "initial_body_rate:=[0.0, 0.0]": "initial_body_rate: ",
    "rate:=0.0": "rate: 0 is outside",
    "rate:=-5.0": "rate: -5 is outside",
    "rate:=.inf": "rate: inf is not finite",
    "rate:=fast": "rate: 'fast' is not a number",
    "method:=euler": "method: 'euler' is unknown: choose one of",
    "motion:=flying": "motion: 'flying' is unknown: choose one of moving_chart, closed_form",
    "max_step:=0.0": "max_step: 0 is outside",
    "inertia:=[1e-320, 1e-320, 1e-320]": "inertia: principal moments .* are beyond double precision",
    "inertia:=[1e308, 1e308, 1e308]": "inertia: principal moments .* are beyond double precision",
    "initial_body_rate:=[1e200, 0.0, 0.0]": "initial_body_rate: 1e.200, 0, 0 rad/s gives an energy of inf",
    "initial_body_rate:=[1e308, 1e308, 1e308]": "initial_body_rate: .*a momentum of inf",
    "initial_body_rate:=[1e-160, 2e-161, 0.0]": "initial_body_rate: .* beyond double precision",
    "initial_body_rate:=[1e140, 0.0, 0.0]": "initial_body_rate: .* steps between samples, .*: .* or use closed_form",
    "world_frame:=/world": "world_frame: '/world' is not a frame name",
    "body_frame:=''": "body_frame: '' is not a frame name",
    "stamped_twist:=1": "stamped_twist: 1 is not a bool",
    "epoch_ns:=1.5": "epoch_ns: 1.5 is not an integer",
    "epoch_ns:=-1": "epoch_ns: -1 is outside",
    "epoch_ns:=2147483647000000000": "epoch_ns: sample 999 would be stamped .* start earlier",
    "inertai:=[1.0, 2.0, 3.0]": "inertai: no such parameter: did you mean inertia?",
    "use_sim_time:=true": "-p use_sim_time: every ROS 2 node has it, and no scenario: give it to sim after --ros-args",
    "rate=5": "'rate=5' is not NAME:=VALUE",
    "rate:=[1.0": "not readable as YAML",
}
"""Values of parameters, and what is said of each."""

RECORD = {
    "": "the following arguments are required: OUT.mcap, --duration",
    "out.mcap": "required: --duration",
    "--duration 1": "required: OUT.mcap",
    "out.mcap --duration": "argument --duration: expected one argument",
    "out.mcap --duration 1 --fast": "unrecognized arguments: --fast",
    "out.mcap --dur 1": "required: --duration",
    "out.mcap other.mcap --duration 1": "unrecognized arguments: other.mcap",
    "out.mcap --duration 0": "--duration 0 is not a time from",
    "out.mcap --duration -1": "--duration -1 is not a time from",
    "out.mcap --duration nan": "--duration nan is not a time from",
    "out.mcap --duration inf": "--duration inf is not a time from",
    "out.mcap --duration 1_0": "--duration 1_0 is not a time from",
    "out.mcap --duration ٣": "--duration ٣ is not a time from",
    "out.mcap --duration soon": "--duration soon is not a time from",
    "out.mcap --duration 1e999999999": "--duration 1e999999999 is not a time from",
    "out.mcap --duration 1e-999999999": "--duration 1e-999999999 is not a time from",
    "out.mcap --duration 5e9": "epoch_ns: sample .* would be stamped .* sample for a shorter time",
    "out.mcap --duration 1 --compression gzip": "argument --compression: invalid choice: 'gzip'",
    "out.mcap --duration 1 --chunk-size 0": "--chunk-size 0 is not a number of bytes from 1 to 16777216: give for",
    "out.mcap --duration 1 --chunk-size 1e6": "--chunk-size 1e6 is not a number of bytes",
    "out.mcap --duration 1 --chunk-size 16777217": "--chunk-size 16777217 is not a number of bytes",
    "out.mcap --duration 1 --scenario none": "scenario 'none' is unknown: the scenarios are asymmetric_top, ",
    "out.mcap --duration 1 --scenario dzanibekov": "did you mean dzhanibekov?",
    "out.mcap --duration 1 --params-file none.yaml": "none.yaml does not exist",
    "out.mcap --duration 1 --params-file .": "is a folder",
    "out.mcap --duration 1 --params-file bad.yaml": "bad.yaml, line 2, column 1: not readable as YAML",
    "out.mcap --duration 1 --params-file other.yaml": "no section for the node /lie_rigid_body, only for /talker",
    "out.mcap --duration 1 --params-file flat.yaml": "error: flat.yaml: inertia: ",
    "out.mcap --duration 1 --params-file flat.yaml -p rate:=0.0": "error: rate: ",
    "out.mcap --duration 1 --params-file flat.yaml --params-file unknown.yaml": "error: unknown.yaml: speed: ",
    "none/out.mcap --duration 1": "folder none does not exist: make it",
    ". --duration 1": "error: . is a folder: give the name of a file, or move it away",
    "bad.yaml --duration 1": "bad.yaml exists and is kept: give another name, or --force",
    "bad.yaml/out.mcap --duration 1": "Not a directory",
    "/proc/out.mcap --duration 1": "/proc/out.mcap cannot be created: No such file",
    "fifo --duration 1 --force": "fifo is not a regular file",
}
"""Arguments of ``record``."""

TOO_LONG = "2e9 -p motion:=closed_form -p rate:=1e6"
"""Duration, s, and rate for which no disk has room."""
REFUSED = {
    **{f"record out.mcap --duration 10 -p {shlex.quote(given)}": said for given, said in PARAMETERS.items()},
    **{f"record {given}": said for given, said in RECORD.items()},
    "check": "the following arguments are required: BAG",
    "check ''": "BAG: '' names no file",
    "check -": "BAG: '-' stands for no stream here: give a name, ./-",
    "check bag.mcap 'a\0b.mcap'": "argument BAG: 'a.x00b.mcap' is the name of no file",
    "check absent.mcap": "absent.mcap does not exist",
    "check empty.mcap": "empty.mcap is empty",
    "check text.mcap": "MCAP",
    "check cut.mcap": "cut.mcap was cut off, or is still being written: .* rescue them with ",
    "check bag.mcap --inertia '1;2;3'": "not numbers between commas",
    "check bag.mcap --inertia 1_0,20,30": "not numbers between commas",
    "check bag.mcap --inertia 1,1,3": "triangle inequality",
    "check bag.mcap --inertia 1,2": "3 principal moments",
    "check two.mcap --prove 3": "--prove 3: more than one body",
    "check bag.mcap run.mcap --prove 3": "--prove 3: more than one body",
    "check bag.mcap --prove=0": "--prove 0: not a number of samples: give 1 to 10000",
    "check bag.mcap --prove=-1": "--prove -1: not a number of samples",
    "check bag.mcap --prove=10001": "--prove 10001: not a number of samples",
    "check bag.mcap --prove=many": "argument --prove: invalid int value: 'many'",
    "check bag.mcap --topic pose=/x": "not NAME:=/TOPIC",
    "check bag.mcap --topic :=/x": "not NAME:=/TOPIC",
    "check bag.mcap --topic pos:=/x": "did you mean pose?",
    "check bag.mcap --topic odometry:=/x": "the topics of a body are pose, twist, scenario",
    "check bag.mcap --topic pose:=/attitude": "there is no topic /attitude: the topics of PoseStamped are /pose",
    "check bag.mcap --topic twist:=/pose": "topic /pose is of PoseStamped, not TwistStamped or Twist",
    "check bag.mcap --topic pose:=/a --topic pose:=/b": "pose is /a already",
    "check absent.mcap --report page.html": "page.html exists and is kept: .* --force to replace it",
    "check absent.mcap --report no/a.html": "does not exist: make it",
    "check absent.mcap --report a.pdf": "only HTML is written",
    "plot absent.mcap -o picture.png": "--force",
    "plot bag.mcap -o out.pdf": "only PNG is written: let the name end in .png",
    "plot .": "give -o OUT.png",
    "plot absent.mcap -o nowhere/out.png": "make it, or give another",
    "plot absent.mcap -o out.png": "absent.mcap does not exist",
    "plot two.mcap -o out.png": "holds 2 bodies, /a, /b: say which, as by --topic pose:=/a/pose",
    "evaluate bag.mcap": "the following arguments are required: --estimate",
    "evaluate run.mcap --estimate /imu/data": "topics of types with attitudes are /pose, /imu/data_raw, /imu/bias",
    "evaluate run.mcap --estimate /imu/data_raw": "has no orientation",
    "evaluate run.mcap --estimate /twist": "is of TwistStamped: give PoseStamped, ",
    "evaluate absent.mcap --estimate /pose": "does not exist",
    "evaluate bag.mcap --estimate /pose --truth absent.mcap": "does not exist",
    "evaluate bag.mcap --estimate /pose --max-rms 1": "is not an angle such as 1deg",
    "evaluate bag.mcap --estimate /pose --max-rms -1deg": "'-1deg' is not an angle",
    "evaluate bag.mcap --estimate /pose --max-rms 1deg --max-rms 2deg": "--max-rms is given 2 times, 1deg, 2deg",
    "evaluate bag.mcap --estimate /pose --max-after 10s": "give for example 10s:2deg",
    "evaluate bag.mcap --estimate /pose --max-after -1s:1deg": "'-1s' is not a time",
    "evaluate bag.mcap --estimate /pose --covariance-axes map": "invalid choice: 'map'",
    "evaluate bag.mcap --estimate /pose --plot a.svg": "only PNG is written",
    "evaluate bag.mcap --estimate /pose --report a.pdf": "only HTML is written",
    "evaluate absent.mcap --estimate /pose --plot picture.png": "exists and is kept",
    "evaluate absent.mcap --estimate /pose --report page.html": "exists and is kept",
    "evaluate bag.mcap --estimate /pose --plot page.png --report page.html --force": "is the output page.png itself",
    "evaluate absent.mcap --estimate /pose --out bag.mcap": "bag.mcap exists and is kept",
    "evaluate bag.mcap --estimate /pose --out out.bag": "end in .mcap",
    "evaluate bag.mcap --estimate /pose --out none/out.mcap": "folder none does not exist",
    "evaluate --out out.mcap": "--out goes only with a bag",
    "evaluate bag.mcap --estimate /pose --topic pose:=/pose": "that is the estimate: name the topic of the truth",
    "evaluate run.mcap --estimate /pose --topic pose:=/poes": "there is no topic /poes: did you mean /pose",
    "evaluate run.mcap --estimate /pose --topic pose:=/imu/data_raw": "topic /imu/data_raw is of Imu, not PoseStamped",
    "evaluate bag.mcap --estimate /pose --topic twist:=/twist": "the topics of a body are pose, scenario",
    "explain --scenario dzanibekov": "did you mean dzhanibekov or ",
    "explain -p 'inertia:=[1.0, 1.0, 3.0]'": "triangle inequality",
    "explain -p 'inertia:=[1.0, 2.0]'": "give 3 or 6 finite numbers",
    "explain -p 'intertia:=[1.0, 2.0, 3.0]'": "did you mean inertia?",
    "explain --params-file absent.yaml": "does not exist",
    "explain dzhanibekov --scenario flat_plate": "two scenarios, dzhanibekov and --scenario flat_plate",
    "scenarios all": "unrecognized arguments: all; 'lie-rigid-body scenarios --help' explains the arguments",
    "recover cut.mcap -o cut.mcap": "cut.mcap is the input cut.mcap itself, which would be lost: give another name",
    "recover cut.mcap -o page.html": "exists and is kept: give another name, or --force",
    "recover . -o fixed.mcap": "not one recording: give one of them",
    "recover nothing -o fixed.mcap": "is a folder without MCAP files",
    "recover absent.mcap -o fixed.mcap": "does not exist",
    "recover text.mcap -o fixed.mcap": "does not begin as an MCAP file",
    "recover empty.mcap -o fixed.mcap": "does not begin as an MCAP file",
    "recover head.mcap -o fixed.mcap": "holds no whole message",
    "recover walk -o nothing --force": "exists and is kept: give the name of a new folder",
    "recover walk -o fixed.mcap --force": "is to be one: give a name that does not end in .mcap",
    "recover walk -o walk/fixed --force": "is in the broken folder itself",
    "recover walk -o none/fixed --force": "cannot be created: No such file or directory",
    f"record out.mcap --duration {TOO_LONG}": r"\d+ samples need about .* and .* are free there: ",
}
"""Commands, and what is said of each."""

SEPARATRIX = "explain -p 'inertia:=[3.0, 4.0, 6.0]' -p 'initial_body_rate:=[-2.0, 3.0, 1.0]'"
IMU = "-p imu_rate:=100.0 -p sensor_grade:=mems -p gyro_turn_on_bias:=0.125"
FAULTS = "-p magnetometer_rate:=10.0 -p magnetometer_stuck_interval:=5.0"
SAID = {
    "check bag.mcap": (0, ["CERTIFIED: attitude within", " closed form ", " world momentum y ", "who wrote it"]),
    "check run.mcap": (
        0,
        [
            "It is equal to the bit to what is computed here.",
            "Every reading is what its scenario determines: /imu/data_raw, /imu/bias.",
        ],
    ),
    "check poor.mcap": (
        1,
        [
            "NOT CERTIFIED - ",
            "BROKEN",
            "rad off the exact solution (limit 1e-07) at 48 ",
            "note: the declared motion errs by up to ",
        ],
    ),
    "check bag.mcap run.mcap": (0, ["CERTIFIED: all 2 bags, attitude within"]),
    "check one": (0, ["CERTIFIED: 1 bag, attitude within"]),
    "check bag.mcap poor.mcap": (1, ["NOT CERTIFIED: of 2 bags 1 are certified, 1 broken, 0 unusable."]),
    "check two.mcap": (0, ["CERTIFIED: all 2 bodies, attitude within"]),
    "check two.mcap --topic pose:=/a/pose": (0, ["body /b (/b/pose and what goes with it), which was not asked for"]),
    "check bag.mcap --prove 3": (0, ["proved: within "]),
    "check poor.mcap --prove 3": (1, ["samples are beyond their limit; the attitude is at least"]),
    "evaluate bag.mcap --estimate /pose --truth run.mcap --max-rms 1deg": (0, ["PASSED: every limit is kept."]),
    "evaluate bag.mcap --estimate /pose --truth run.mcap": (
        0,
        ["no findings", "the truth (poses and scenario)"],
    ),
    "evaluate poor.mcap --estimate /pose --truth other.mcap --max-rms 1deg": (1, ["BROKEN: the error is "]),
    "explain": (
        0,
        [
            "inertia [1, 2, 3] kg m², initial body rate [0.01, 1, 0.01] rad/s Body, with its principal axes",
            "Motion In the body, the body rate and the momentum circle axis 3",
            "Spinning about each principal axis with this angular momentum",
            "Conserved kinetic energy: 1.0002 J",
        ],
    ),
    "explain --scenario dzhanibekov": (
        0,
        ["asymmetric top", "It is flat", "every 19.5529 s, the first 10.9169 s after the start", "as exp(0.577422 t)"],
    ),
    "explain --scenario symmetric_top": (0, ["momentum in the body along [0, 0, 1]: 3.6 kg m²/s", "no nutation"]),
    "explain --scenario spherical_top": (0, ["momentum in the body, all components: [0.3, -0.8, 1.1]"]),
    "explain --scenario asymmetric_top": (0, ["not suddenly"]),
    "explain --scenario tossed_phone": (0, ["circle axis 1 (smallest), on a closed curve"]),
    "explain --scenario tumbling_cubesat": (0, ["circle axis 3 (largest), on a closed curve"]),
    "explain --scenario prolate_top": (0, ["circle axis 1 (axis of symmetry), on a circle"]),
    SEPARATRIX: (0, ["one, 0.935881 s after the start"]),
    f"{SEPARATRIX} -p 'initial_body_rate:=[2.0, 3.0, 1.0]'": (0, ["none any more"]),
    "explain -p 'initial_body_rate:=[0.0, 0.0, 0.0]'": (0, ["The body is at rest"]),
    "explain -p 'initial_body_rate:=[0.0, 1.0, 0.0]'": (0, ["rotation about axis 2 (intermediate). It is unstable"]),
    "explain --scenario symmetric_top -p 'initial_body_rate:=[1.0, 0.0, 0.0]'": (
        0,
        ["A steady rotation about [1, 0, 0] in the body. It is neutral"],
    ),
    f"explain {IMU}": (
        0,
        ["Sensors, of the grade mems", "gyro_turn_on_bias 0.125", "accelerometer_misalignment [0.005, -0.005, 0.005]"],
    ),
    f"explain {FAULTS}": (0, ["magnetometer_stuck_interval 5"]),
    "record recorded.mcap --duration 0.5": (
        0,
        ["50 samples, stamps 0.000000000 to 0.490000000 s, in ", "certify them with: lie-rigid-body check "],
    ),
    "recover cut.mcap -o rescued.mcap": (
        0,
        ["cut.mcap breaks off in the record at byte ", "which gave 0 messages", "certify them with: lie-rigid-body "],
    ),
    "recover between.mcap -o whole.mcap": (0, ["between.mcap breaks off behind a whole record"]),
    "recover walk -o rescued": (0, [" messages on 3 topics, stamps 0.000000000 to ", "walk_1.mcap breaks off "]),
    "recover walk/walk_1.mcap -o part.mcap": (0, ["recover all with: recover walk -o FIXED"]),
    "evaluate bag.mcap --estimate /pose --truth run.mcap --out scored.mcap": (0, ["wrote scored.mcap"]),
    "scenarios": (0, ["inertia 0.6 0.8 1 kg m², 100 samples/s, moving_chart"]),
}
"""Commands, each with its status and parts of what it prints, of which white space counts as one space."""


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with good, poor and damaged bags, and with what is no bag."""
    folder = tmp_path_factory.mktemp("words")
    good = write_bag(folder / "bag.mcap", 50)
    write_bag(folder / "poor.mcap", 50, method="rkmk1")
    write_bag(folder / "other.mcap", 50, initial_body_rate=[1.0, 0.5, 2.0])
    given = ["--duration", "0.5", "-p", "imu_rate:=50.0", "-p", "motion:=closed_form", "--quiet"]
    assert main(["record", str(folder / "run.mcap"), *given]) == 0
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
    return folder


def times(folder: Path) -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*")}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("command", REFUSED)
def test_a_refusal_is_one_line_and_changes_nothing(
    command: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if "--report" in command:
        pytest.importorskip("plotly")
    monkeypatch.chdir(here)
    monkeypatch.setattr(sys, "argv", ["lie-rigid-body"])
    before = times(here)
    assert main(shlex.split(command)) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n"), err[-1:]) == ("", 1, "\n")
    assert err.startswith(f"lie-rigid-body {command.split()[0]}: error: ")
    assert re.search(REFUSED[command], err)
    assert times(here) == before


@pytest.mark.usefixtures("asked_here")
@pytest.mark.parametrize("command", SAID)
def test_what_is_found_is_said(
    command: str, here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(here)
    if "--prove" in command:
        pytest.importorskip("flint")
    status, words = SAID[command]
    assert main(shlex.split(command)) == status
    out, err = capsys.readouterr()
    said = " ".join(out.split())
    assert [part for part in words if part.strip() not in said] == []
    assert err == ""


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("yaml.nodes", "the Python library yaml is not installed: pip install PyYAML"),
        ("lie_rigid_body.nowhere", "install the requirements of the package again"),
    ],
)
def test_what_python_lacks_is_said(name: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    def lacking() -> int:
        raise ModuleNotFoundError(f"No module named {name}", name=name)

    assert status_of("verb", lacking) == 2
    assert said in capsys.readouterr().err
