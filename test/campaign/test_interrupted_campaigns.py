"""Campaigns that are interrupted or killed, and those whose workers die: nothing is lost or done twice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from campaigns import CAMPAIGN, NEEDS_PARQUET, bytes_of, finished, table_of, written

from lie_rigid_body.cli.campaign import main
from said import numbers

pytestmark = NEEDS_PARQUET
COMMAND = [sys.executable, "-m", "lie_rigid_body", "campaign"]
DEADLINE = 120.0
MANY = 9


@pytest.fixture
def slow(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """A process with a campaign that has finished a run and has many before it."""
    path, out = written(tmp_path, CAMPAIGN.replace("runs: 6", f"runs: {MANY}").replace("0.25", "8.0")), tmp_path / "out"
    (tmp_path / "temporary").mkdir()
    process = subprocess.Popen(
        [*COMMAND, str(path), "--out", str(out), "--workers", "2"],
        stdout=-1,
        stderr=-1,
        text=True,
        start_new_session=True,
        env={**os.environ, "TMPDIR": str(tmp_path / "temporary")},
    )
    end = time.monotonic() + DEADLINE
    while len(finished(out)) < 1 and process.poll() is None and time.monotonic() < end:
        time.sleep(0.02)
    try:
        yield process, out
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate(timeout=DEADLINE)


def times(out: Path) -> dict[str, int]:
    return {bag.name: bag.stat().st_mtime_ns for bag in (out / "bags").glob("0*")}


def require_resumed(out: Path, before: dict[str, int]) -> None:
    """The same command does the rest, and nothing twice."""
    assert main([str(out.parent / "campaign.yaml"), "--out", str(out), "--workers", "2"]) == 0
    assert finished(out) == list(range(MANY))
    assert list(bytes_of(out)) == [f"{run:06d}.mcap" for run in range(MANY)]
    assert times(out).items() >= before.items()
    assert table_of(out)["certified"].to_pylist() == [True] * MANY


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interruption_keeps_what_is_finished(slow: tuple[subprocess.Popen[str], Path], number: int) -> None:
    """A signal that reaches the workers as well, as Ctrl-C does: they say nothing, and leave nothing."""
    process, out = slow
    os.killpg(process.pid, number)
    said, complained = process.communicate(timeout=DEADLINE)
    assert (process.returncode, said, complained.count("\n")) == (130, "", 1), complained
    done = finished(out)
    assert f" {len(done)} of {MANY} " in complained
    assert len(done) >= 1
    assert sorted(times(out)) == [f"{run:06d}.mcap" for run in done] == sorted(os.listdir(out / "bags"))
    assert [*(out.parent / "temporary").iterdir()] == []
    require_resumed(out, times(out))


@pytest.mark.slow
def test_another_process_works_in_another_folder(slow: tuple[subprocess.Popen[str], Path]) -> None:
    """Else each would remove what the other has begun."""
    process, out = slow
    before = sorted(os.listdir(out / "bags"))
    assert process.poll() is None
    assert main([str(out.parent / "campaign.yaml"), "--out", str(out), "--workers", "1"]) == 2
    assert set(before) <= set(os.listdir(out / "bags"))
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=DEADLINE)
    require_resumed(out, times(out))


@pytest.mark.slow
def test_a_kill_costs_the_runs_at_work_and_nothing_is_done_twice(slow: tuple[subprocess.Popen[str], Path]) -> None:
    process, out = slow
    process.kill()
    process.communicate(timeout=DEADLINE)
    require_resumed(out, {f"{run:06d}.mcap": times(out)[f"{run:06d}.mcap"] for run in finished(out)})


@pytest.mark.slow
def test_a_worker_that_dies_costs_nothing_but_its_run(slow: tuple[subprocess.Popen[str], Path]) -> None:
    process, out = slow
    workers = [pid for pid in children(process.pid) if "serve()" in command(pid)]
    before = {f"{run:06d}.mcap": times(out)[f"{run:06d}.mcap"] for run in finished(out)}
    os.kill(workers[0], signal.SIGKILL)
    said, complained = process.communicate(timeout=DEADLINE)
    assert (process.returncode, said, complained.count("\n")) == (2, "", 1), complained
    assert f" 1 of {MANY} " in complained
    require_resumed(out, before)


DEADLY = """
import os, signal
def right(run):
    if run.t_ns[0] == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return run.attitude_sensor.t_ns, run.attitude_sensor.attitude_xyzw
"""


@pytest.mark.slow
def test_an_estimator_that_kills_its_process_costs_the_score_of_its_run_only(tmp_path: Path) -> None:
    (tmp_path / "estimator_of_a_campaign.py").write_text(DEADLY)
    command = [*COMMAND, str(written(tmp_path)), "--out", "out", "--workers", "2"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    table = table_of(tmp_path / "out")
    assert table["certified"].to_pylist() == [True] * 6
    errors = table["estimator_error"].to_pylist()
    assert [error and numbers(error) for error in errors] == [*[None] * 2, [-9], *[None] * 3]


def children(pid: int) -> list[int]:
    return [
        int(child) for task in Path(f"/proc/{pid}/task").iterdir() for child in (task / "children").read_text().split()
    ]


def command(pid: int) -> str:
    return Path(f"/proc/{pid}/cmdline").read_text().replace("\0", " ")
