"""Campaigns at a scheduler elsewhere, a process of its own, that is killed, or has no worker for a while."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from campaigns import CAMPAIGN, ESTIMATED, NEEDS_DASK, WITHOUT_A_WORKER, bytes_of, finished, table_of, written

from lie_rigid_body.campaign.journal import RESUMED, Journal
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.system import console

pytestmark = [NEEDS_DASK, pytest.mark.slow]
DEADLINE = 120.0
PARTS = ("cert", "key")
WAITING = """
import pathlib, time
def from_truth(run):
    while dict(run.scenario.sensor_parameters)["sensor_seed"] == 2 and not pathlib.Path("killed").exists():
        time.sleep(0.02)
    return run.truth.attitude_xyzw
"""
"""An estimator with which run 2 waits for the end of the scheduler."""


def until(happened: Callable[[], object]) -> None:
    end = time.monotonic() + DEADLINE
    while not happened() and time.monotonic() < end:
        time.sleep(0.02)
    assert happened()


class Cluster:
    """A scheduler of its own, without a worker at first."""

    def __init__(self, folder: Path, environment: Mapping[str, str] | None = None) -> None:
        self.folder, self.processes = folder, list[subprocess.Popen[bytes]]()
        self._environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        self._environment |= environment or {}
        where = folder / "scheduler.json"
        self.scheduler = self._started("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", where)
        until(lambda: where.exists() and where.read_text().endswith("}"))
        self.address = json.loads(where.read_text())["address"]

    def worker(self, threads: int) -> subprocess.Popen[bytes]:
        options = ["--no-nanny", "--nthreads", f"{threads}", "--local-directory", self.folder / "workers"]
        return self._started("worker", self.address, *options)

    def _started(self, kind: str, *options: Any) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", "--no-dashboard", *map(str, options)]
        self.processes.append(subprocess.Popen(command, cwd=self.folder, env=self._environment, stdout=-3, stderr=-3))
        return self.processes[-1]

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    cluster = Cluster(tmp_path)
    yield cluster
    cluster.close()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_scheduler_that_goes_costs_the_runs_on_their_way(
    cluster: Cluster, scheduler: str, tmp_path: Path, number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The end of the campaign is one line, and another scheduler does the rest."""
    (tmp_path / "estimator_of_a_campaign.py").write_text(WAITING)
    path, out = written(tmp_path, ESTIMATED), tmp_path / "out"
    cluster.worker(threads=2)
    command = [sys.executable, "-m", "lie_rigid_body", "campaign", str(path), "--out", "out", "--scheduler"]
    campaign = subprocess.Popen([*command, cluster.address], cwd=tmp_path, stdout=-1, stderr=-1, text=True)
    try:
        until(lambda: campaign.poll() is not None or len(finished(out)) == 5)
        cluster.scheduler.send_signal(number)
        said, complained = campaign.communicate(timeout=DEADLINE)
    finally:
        campaign.kill()
        (tmp_path / "killed").touch()
    assert (campaign.returncode, said) == (2, ""), complained
    _, line = complained.splitlines()
    assert cluster.address in line
    assert line.endswith(RESUMED)
    before = {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in finished(out)}
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    assert main([str(path), "--out", str(out), "--scheduler", scheduler]) == 0
    assert {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in before} == before
    assert table_of(out)["run"].to_pylist() == list(range(6))
    assert len(bytes_of(out)) == 6


def test_a_cluster_of_tls_is_open_to_who_has_the_keys(out: Path, tmp_path: Path) -> None:
    """As the page about clusters says, by Dask's own configuration; the bags are those of a cluster of this machine."""
    from distributed import Security

    keys = Security.temporary()
    tls = {"ca-file": tmp_path / "ca.pem"}
    tls |= {f"{role}.{part}": tmp_path / f"{part}.pem" for role in ("scheduler", "worker", "client") for part in PARTS}
    (tmp_path / "ca.pem").write_text(str(keys.tls_ca_file))
    (tmp_path / "cert.pem").write_text(str(keys.tls_client_cert))
    (tmp_path / "key.pem").write_text(str(keys.tls_client_key))
    said = {"require-encryption": "True", "default-scheme": "tls", **{f"tls.{name}": f"{tls[name]}" for name in tls}}
    environment = {
        f"DASK_DISTRIBUTED__COMM__{name.upper().replace('.', '__').replace('-', '_')}": said[name] for name in said
    }
    cluster = Cluster(tmp_path, environment)
    try:
        assert cluster.address.startswith("tls://")
        cluster.worker(threads=1)
        shutil.copy(out.parent / "estimator_of_a_campaign.py", tmp_path)
        given = [str(written(tmp_path)), "--out", "other", "--scheduler", cluster.address]
        command = [sys.executable, "-m", "lie_rigid_body", "campaign", *given]
        for more, status, lines in (({}, 2, 1), (environment, 0, 0)):
            done = subprocess.run(
                command,
                cwd=tmp_path,
                env=os.environ | more,
                capture_output=True,
                text=True,
                timeout=DEADLINE,
                check=False,
            )
            assert (done.returncode, done.stderr.count("\n")) == (status, lines), done.stderr
    finally:
        cluster.close()
    assert bytes_of(tmp_path / "other") == bytes_of(out)
    assert table_of(tmp_path / "other").equals(table_of(out))


def test_a_cluster_without_a_worker_is_told_once_whenever_it_has_none(
    cluster: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first worker comes when this is told, and is killed after a run; then comes another."""
    workers, complain, add = list[Any](), console.complain, Journal.add

    def told(*given: str) -> None:
        complain(*given)
        if given[1] == WITHOUT_A_WORKER.format(address=cluster.address):
            workers.append(cluster.worker(threads=1))

    def kept(journal: Journal, row: Any) -> None:
        add(journal, row)
        if len(journal) == 1:
            workers[0].kill()

    monkeypatch.setattr("lie_rigid_body.campaign.cluster.WITHOUT_RESULT_S", 0.0)
    monkeypatch.setattr(console, "complain", told)
    monkeypatch.setattr(Journal, "add", kept)
    path = written(tmp_path, CAMPAIGN.replace("runs: 6", "runs: 9"))
    assert main([str(path), "--out", str(tmp_path / "out"), "--scheduler", cluster.address]) == 0
    _, *lines = (line.partition(" campaign: ")[2] for line in capsys.readouterr().err.splitlines())
    assert all(line.startswith("warning: ") and cluster.address in line for line in lines)
    assert len(lines) in (2, 3)  # of dozens of times that it is asked; a result may come when its worker is gone
    assert len(finished(tmp_path / "out")) == 9
