"""``record`` as its users meet it, in a process of its own wherever that may matter, and what it refuses."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from lie_rigid_body.cli.record import main
from lie_rigid_body.recording.bag_reader import Recording, read_bag
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment, Simulation
from said import numbers

RECORD = [sys.executable, "-m", "lie_rigid_body", "record"]
PLAIN = """
import sys
sys.modules["numba"] = None  # as where it is not installed: for what is endless it would be loaded, which takes longest
from lie_rigid_body.__main__ import main
sys.argv.insert(1, "record")
sys.exit(main())
"""
RECORD_PLAIN = [sys.executable, "-c", PLAIN]
FAST = ["-p", "motion:=closed_form"]
ENDLESS = [*FAST, "--duration", "200000"]
SLOW_STEPS = ["-p", "rate:=0.01", "-p", "max_step:=1e-6", "--duration", "1000"]
DEADLINE = 60.0
"""s, far less than the slow steps take."""


def recorded(path: Path, *arguments: str | Path) -> Recording:
    assert main([*map(str, (path, *arguments)), "--quiet"]) == 0
    return read_bag(path)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out.mcap"


def test_a_summary_says_what_was_recorded_and_how_to_certify_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "my bag.mcap"
    assert main([str(out), *FAST, "--duration", "2", "-p", "epoch_ns:=1500000000"]) == 0
    said, complained = capsys.readouterr()
    first, second = said.splitlines()
    assert numbers(first)[:3] == [200, 1.5, 3.49]
    assert f" {out} (" in first
    assert second.endswith(f": lie-rigid-body check '{out}'")
    assert complained == ""


@pytest.mark.parametrize("motion", ["closed_form", "moving_chart"])
def test_the_bag_holds_the_simulation(out: Path, motion: str) -> None:
    parameters = {"motion": motion, "rate": 33.3, "inertia": [2.0, 3.0, 4.0], "initial_body_rate": [1.0, 2.0, 3.0]}
    assignments = [f"-p{name}:={value}" for name, value in parameters.items()]
    recording = recorded(out, *assignments, "--duration", "3.0")
    samples = Simulation(Scenario.from_parameters(parameters)).take(100)
    np.testing.assert_array_equal(recording.poses.stamps_ns, samples.stamps_ns)
    np.testing.assert_array_equal(recording.poses.values[:, 3:], samples.states.attitude_xyzw)
    np.testing.assert_array_equal(recording.twists.values[:, 3:], samples.states.body_rate)
    [(start, text)] = recording.scenario_texts
    assert start == 0
    assert Segment.from_json(text).scenario == Scenario.from_parameters(parameters)


@pytest.mark.parametrize(
    ("rate", "duration", "count"),
    [
        ("100.0", "1", 100),
        ("100.0", "1.000000001", 101),
        ("100.0", "0.999999999", 100),
        ("100.0", "1e-9", 1),
        ("10.0", "0.3", 3),
        ("0.1", "10", 1),
        ("0.1", "10.0000000000000000001", 2),
        ("3.0", "1", 3),
        ("1e9", "0.000001", 1000),
    ],
)
def test_every_sample_before_the_duration_is_recorded(out: Path, rate: str, duration: str, count: int) -> None:
    assert len(recorded(out, *FAST, "-p", f"rate:={rate}", "--duration", duration).poses.stamps_ns) == count


def test_later_parameters_win(tmp_path: Path, out: Path) -> None:
    low, high = tmp_path / "low.yaml", tmp_path / "high.yaml"
    low.write_text("/**: {ros__parameters: {rate: 10.0, body_frame: low, world_frame: low, record_path: /no/where}}")
    high.write_text("lie_rigid_body: {ros__parameters: {rate: 20.0, body_frame: high}}")
    files = ["--params-file", str(low), "--params-file", str(high)]
    recording = recorded(out, "-p", "rate:=40.0", *files, "--scenario", "slow_dzhanibekov", "--duration", "1")
    scenario = Segment.from_json(recording.scenario_texts[0][1]).scenario
    assert (scenario.rate, scenario.body_frame, scenario.world_frame) == (40.0, "high", "low")
    assert scenario.initial_body_rate == (1e-6, 1.0, 1e-6)
    assert os.listdir(tmp_path).count("out.mcap") == 1


@pytest.mark.parametrize(("name", "mcap_name"), [("zstd", "zstd"), ("lz4", "lz4"), ("none", "")])
def test_compression_and_chunk_size_change_the_file_and_no_message(out: Path, name: str, mcap_name: str) -> None:
    sensors = ["-p", "imu_rate:=50.0", "-p", "magnetometer_rate:=20.0", "--duration", "3"]
    plain = recorded(out.with_name("plain.mcap"), *FAST, *sensors)
    found = recorded(out, *FAST, *sensors, "--compression", name, "--chunk-size", "5000")
    np.testing.assert_array_equal(found.poses.values[:, 3:], plain.poses.values[:, 3:])
    with open(out, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        decoded = list(reader.iter_decoded_messages())
    assert summary is not None
    assert {index.compression for index in summary.chunk_indexes} == {mcap_name}
    assert max(index.uncompressed_size for index in summary.chunk_indexes) < 10_000
    with AnyReader([out]) as bag:
        topics = [connection.topic for connection, _, _ in bag.messages()]
    assert len(topics) == len(decoded) == 1 + 2 * 300 + 2 * 150 + 60
    assert topics.count("/imu/data_raw") == topics.count("/imu/bias") == 150


def test_a_fault_of_a_sensor_that_is_off_is_one_line_on_stderr(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [str(out), *FAST, "--duration", "1", "-p", "gyro_spike_probability:=0.1"]
    assert main(arguments) == 0
    [line] = capsys.readouterr().err.splitlines()
    assert "gyro_spike_probability" in line
    assert main([*arguments, "--force", "--quiet"]) == 0
    assert capsys.readouterr().err == ""


def running(
    out: Path, *arguments: str, size: int = 300_000, command: Sequence[str] = RECORD_PLAIN
) -> subprocess.Popen[str]:
    """A recording that has already written something."""
    process = subprocess.Popen([*command, out, *arguments], stdout=-1, stderr=-1, text=True)
    deadline = time.monotonic() + 30
    while sum(file.stat().st_size for file in out.parent.iterdir()) < size and time.monotonic() < deadline:
        assert process.poll() is None
        time.sleep(0.01)
    return process


def test_a_signal_finishes_the_file(out: Path) -> None:
    """That of Ctrl-C, and of `kill`, where the file is to replace another one."""
    for number, more in ((signal.SIGINT, []), (signal.SIGTERM, ["--force"])):
        process = running(out, *ENDLESS, *more)
        process.send_signal(number)
        stdout, stderr = process.communicate(timeout=DEADLINE)
        recording = read_bag(out)
        count = len(recording.poses.stamps_ns)
        assert (process.returncode, stdout, stderr.count("\n")) == (130, "", 1)
        assert f" {count} of 20000000 " in stderr
        assert recording.expected_samples == count == len(recording.twists)
        assert 0 < count < 20_000_000
        assert os.listdir(out.parent) == [out.name]
        out.write_text("precious")


@pytest.mark.slow
def test_a_signal_during_long_steps_is_heeded_at_once(out: Path) -> None:
    process = running(out, *SLOW_STEPS, size=0, command=RECORD)
    while not out.exists():
        assert process.poll() is None
        time.sleep(0.01)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=DEADLINE)[1].count("\n") == 1
    assert process.returncode == 130
    assert out.stat().st_size > 0


def test_a_terminal_that_closes_leaves_a_whole_file(out: Path) -> None:
    ours, theirs = pty.openpty()
    with subprocess.Popen([*RECORD_PLAIN, out, *ENDLESS], stdout=theirs, stderr=theirs) as process:
        os.close(theirs)
        while not (out.exists() and out.stat().st_size > 300_000):
            assert process.poll() is None
            time.sleep(0.01)
        os.close(ours)
        process.send_signal(signal.SIGHUP)
        assert process.wait(20) == 130
    assert read_bag(out).expected_samples


def on_terminal(*arguments: str | Path, size: tuple[int, int] = (24, 80)) -> str:
    """What a terminal of so many rows and columns shows of stderr."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", *size, 0, 0))
    with subprocess.Popen([*RECORD, *arguments], stderr=theirs, stdout=subprocess.DEVNULL) as process:
        os.close(theirs)
        shown = b""
        while select.select([ours], [], [], 30)[0]:
            try:
                shown += os.read(ours, 4096)
            except OSError:  # the other side is closed
                break
    os.close(ours)
    assert process.returncode == 0
    return shown.decode()


@pytest.mark.parametrize(
    "size", [(24, 80), *(pytest.param(size, marks=pytest.mark.slow) for size in [(24, 0), (0, 80), (0, 0)])]
)
def test_a_terminal_shows_whole_bars_also_if_it_tells_no_size(tmp_path: Path, size: tuple[int, int]) -> None:
    shown = on_terminal(tmp_path / "a.mcap", *FAST, "--duration", "50", size=size)
    *_, last = filter(None, shown.replace("\n", "\r").split("\r"))
    assert re.fullmatch(r"100%\|.{20,}\| 5.00k/5.00k \[.* samples/s\]", last)
    assert 79 <= len(last) <= 80


def test_quiet_shows_no_bar(tmp_path: Path) -> None:
    assert on_terminal(tmp_path / "b.mcap", *FAST, "--duration", "50", "--quiet") == ""


def test_a_disk_with_too_little_room(
    out: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda path: (10**9, 10**9 - 52_000, 52_000))
    assert main([str(out), "--duration", "5"]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert numbers(line.replace(str(out.parent), "")) == [500, 52.5, 52]
    assert not out.exists()
    assert main([str(out), "--duration", "4", "--quiet"]) == 0


def test_a_disk_that_fills_up_is_told_in_one_line(tmp_path: Path) -> None:
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000)); "
        "from lie_rigid_body.__main__ import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, "record", str(tmp_path / "out.mcap"), *FAST, "--duration", "100"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)


def test_the_remedy_for_too_long_a_step_is_a_remedy(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [str(out), "--duration", "0.01", "-p", "initial_body_rate:=[6000.0, 2.0, 0.0]", "-p", "method:=rkmk4"]
    assert main(arguments) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert main([*arguments, "-p", f"max_step:={numbers(line)[-1]}", "--quiet"]) == 0


@pytest.mark.parametrize("rate", ["[1e-300, 2e-300, 0.0]", "[1e140, 2e140, 1.0]", "[0.0, 0.0, 0.0]"])
@pytest.mark.filterwarnings("error")
def test_extreme_rates_that_can_be_computed_are_allowed(out: Path, rate: str) -> None:
    assert main([str(out), *FAST, "--duration", "0.1", "-p", f"initial_body_rate:={rate}", "--quiet"]) == 0
