"""The ``campaign`` command on real workers: the same bytes whatever their number, and nothing lost or done twice."""

from __future__ import annotations

import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from lie_rigid_body.campaign import Campaign, run
from lie_rigid_body.campaign.cluster import MOST_FAILURES, RUNS_AHEAD
from lie_rigid_body.campaign.definition import OF_TABLE
from lie_rigid_body.campaign.journal import Journal
from lie_rigid_body.campaign.run import Row, carry_out
from lie_rigid_body.cli import campaign as campaign_verb
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.recording import bag_reader
from lie_rigid_body.runs import simulate

# not loaded here: the process that only collects these tests does without
pytestmark = pytest.mark.skipif(
    not (find_spec("distributed") and find_spec("pyarrow")), reason="distributed or pyarrow is not installed"
)
COMMAND = [sys.executable, "-m", "lie_rigid_body", "campaign"]
DEADLINE = 120.0
MANY = 9
CAMPAIGN = """
runs: 6
seed: 7
duration: 0.25
scenario: tumbling_cubesat
parameters: {rate: 100.0, imu_rate: 100.0}
vary:
  initial_attitude_xyzw: {distribution: uniform_rotation}
  initial_body_rate: {distribution: direction, norm: {distribution: uniform, low: 0.01, high: 0.5}}
  inertia: {distribution: box, mass: 8.0, edges: [[0.1, 0.3], [0.1, 0.3], [0.1, 0.4]]}
  gyro_noise_density: {distribution: loguniform, low: 1e-5, high: 1.0e-3}
  motion: {distribution: choice, values: [moving_chart, closed_form]}
  sensor_seed: {distribution: run}
"""
ESTIMATED = CAMPAIGN + "estimator: estimator_of_a_campaign:from_truth\n"
ESTIMATOR = """
def from_truth(run):
    if dict(run.scenario.sensor_parameters)["sensor_seed"] == 2:
        raise RuntimeError("it is lost")
    return run.truth.attitude_xyzw
"""
SCORES = ["total_rms_deg", "heading_rms_deg", "inclination_rms_deg", "converged_s"]


def written(folder: Path, text: str = ESTIMATED) -> Path:
    path = folder / "campaign.yaml"
    path.write_text(text)
    return path


def table_of(out: Path) -> Any:
    from pyarrow import parquet

    return parquet.read_table(out / "runs.parquet")


def bytes_of(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted((out / "bags").iterdir())}


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A campaign on two workers, with an estimator in the working directory that fails in one run."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "estimator_of_a_campaign.py").write_text(ESTIMATOR)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [*sys.path])
        patch.chdir(folder)
        assert main([str(written(folder)), "--out", str(folder / "out"), "--workers", "2"]) == 0
        yield folder / "out"


def test_the_table_has_a_row_for_each_run(out: Path) -> None:
    table = table_of(out)
    vary = ["initial_attitude_xyzw", "initial_body_rate", "inertia", "gyro_noise_density", "motion", "sensor_seed"]
    assert table.column_names == ["run", *vary, "certified", "attitude_accuracy_rad", "bag", *SCORES, "estimator_error"]
    assert table["run"].to_pylist() == list(range(6))
    assert table["certified"].to_pylist() == [True] * 6
    assert all(0.0 < accuracy < 1e-13 for accuracy in table["attitude_accuracy_rad"].to_pylist())
    assert [(out / bag).is_file() for bag in table["bag"].to_pylist()] == [True] * 6
    of_truth = pytest.approx(0.0, abs=1e-12)
    for name in SCORES:
        assert table[name].to_pylist() == [of_truth, of_truth, None, of_truth, of_truth, of_truth]
    assert table["estimator_error"].to_pylist() == [None, None, "RuntimeError: it is lost", None, None, None]
    assert list(bytes_of(out)) == [f"{run:06d}.mcap" for run in range(6)]


def test_each_bag_is_that_of_record_with_the_parameters_of_its_row(out: Path, tmp_path: Path) -> None:
    campaign = Campaign.from_table(shutil.copy(out / "runs.parquet", tmp_path))
    assert campaign == Campaign.from_file(written(tmp_path))
    for row in table_of(out).to_pylist():
        given = {name: row[name] for name in list(row)[1:7]} | {"rate": 100.0, "imu_rate": 100.0}
        assignments = [f"-p{name}:={value}" for name, value in given.items()]
        again = tmp_path / "again.mcap"
        options = ["--scenario", "tumbling_cubesat", "--duration", "0.25", "--force", "--quiet"]
        assert record([str(again), *options, *assignments]) == 0
        assert again.read_bytes() == (out / row["bag"]).read_bytes()
        simulate(campaign.scenario_of(row["run"]), duration=campaign.duration).to_bag(again, overwrite=True)
        assert again.read_bytes() == (out / row["bag"]).read_bytes()


def test_what_is_no_table_of_a_campaign_is_refused(tmp_path: Path) -> None:
    import pyarrow
    from pyarrow import parquet

    path = tmp_path / "runs.parquet"
    whole = pyarrow.table({"run": [0]})
    for said in ("", "3", "{}", '{"campaign": 3}', '{"campaign": {"runs": 1}}', "[" * 100_000):
        parquet.write_table(whole.replace_schema_metadata({OF_TABLE: said}), path)
        with pytest.raises(InputError, match=r"is no table of a campaign: give its runs\.parquet"):
            Campaign.from_table(path)
    parquet.write_table(whole, tmp_path / "other.parquet")
    path.write_text("other")
    for other in (path, tmp_path / "other.parquet", tmp_path / "none", tmp_path):
        with pytest.raises(InputError, match="is no table of a campaign"):
            Campaign.from_table(other)


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a cluster of one worker, a thread of this process, reached by TCP: it starts at once."""
    from distributed import LocalCluster

    options: dict[str, Any] = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "protocol": "tcp"}
    folder = str(tmp_path_factory.mktemp("workers"))
    with LocalCluster(**options, dashboard_address="127.0.0.1:0", local_directory=folder) as cluster:
        yield cluster.scheduler_address


def test_a_scheduler_elsewhere_gives_the_same_bytes(out: Path, scheduler: str, tmp_path: Path) -> None:
    other = tmp_path / "other"
    assert main([str(written(tmp_path)), "--out", str(other), "--scheduler", scheduler]) == 0
    assert bytes_of(other) == bytes_of(out)
    assert table_of(other).equals(table_of(out))


def test_what_is_finished_is_not_done_again(out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path: path.stat().st_mtime_ns for path in (out / "bags").iterdir()}
    assert main([str(written(tmp_path)), "--out", str(out)]) == 0
    assert {path: path.stat().st_mtime_ns for path in (out / "bags").iterdir()} == before
    said = capsys.readouterr().out
    assert "6 runs, 6 certified" in said
    assert "5 scored, median " in said
    assert "° rms; run 2 is not: RuntimeError: it is lost" in said


def bags_cut(out: Path) -> None:
    (out / "bags/000002.mcap").unlink()
    os.truncate(out / "bags/000001.mcap", 5000)


def of_before(out: Path) -> None:
    """As journals were before they had sizes."""
    (out / "bags/000002.mcap").unlink()
    journal = out / "runs.jsonl"
    journal.write_text(re.sub(r'"bag_bytes": \d+, ', "", journal.read_text()))


def made_without(out: Path) -> None:
    shutil.rmtree(out / "bags")
    journal = out / "runs.jsonl"
    journal.write_text(re.sub(r'"bag": ".*?", "bag_bytes": \d+', '"bag": null, "bag_bytes": null', journal.read_text()))


@pytest.mark.parametrize(
    ("happen", "runs"), [(bags_cut, "1, 2"), (of_before, "2"), (made_without, "0, 1, 2, 3, 4 and 1 more")]
)
def test_a_bag_that_is_missing_or_cut_is_made_again(
    out: Path, scheduler: str, tmp_path: Path, happen: Any, runs: str, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = shutil.copytree(out, tmp_path / "copy")
    happen(copy)
    assert main([str(written(tmp_path)), "--out", str(copy), "--scheduler", scheduler]) == 0
    said = capsys.readouterr().out
    assert f"of 6 finished runs, which had no bag, or one of another size: {runs}\n6 runs, 6 certified" in said
    assert bytes_of(copy) == bytes_of(out)
    assert table_of(copy).equals(table_of(out))
    assert main([str(written(tmp_path)), "--out", str(copy)]) == 0
    assert "again" not in capsys.readouterr().out


def test_bags_that_are_there_are_kept_where_none_are_wanted(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = bytes_of(out)
    assert main([str(written(tmp_path)), "--out", str(out), "--no-bags"]) == 0
    assert "--no-bags: the bags of 6 of 6 finished runs are kept, and not looked at\n6 runs" in capsys.readouterr().out
    assert bytes_of(out) == before


def test_a_row_that_a_kill_cut_off_is_done_anew(out: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(out, tmp_path / "copy")
    whole = (copy / "runs.jsonl").read_text()
    (copy / "runs.jsonl").write_text(whole[:-9])
    campaign, rows, last = Campaign.from_file(written(tmp_path)), list[Row](), finished(out)[-1]
    with Journal(campaign, out) as journal:
        rows += journal.rows()
    with Journal(campaign, copy) as journal:
        assert list(journal.rows()) == rows[:last] + rows[last + 1 :]
        journal.add(rows[last])
    assert (copy / "runs.jsonl").read_text() == whole


@pytest.fixture
def journal(out: Path, tmp_path: Path) -> Iterator[Journal]:
    copy = shutil.copytree(out, tmp_path / "copy")
    with Journal(Campaign.from_file(written(tmp_path)), copy) as journal:
        yield journal


def test_a_row_that_does_not_fit_on_the_disk_is_told_and_done_anew(journal: Journal, tmp_path: Path) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    whole, rows = journal.path.read_text(), list(journal.rows())
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) + 20, before[1]))
    try:
        with pytest.raises(BagError, match=r"runs\.jsonl cannot be written: File too large: make room, and the same"):
            journal.add(rows[0])
        journal.__exit__(None, None, None)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert len(journal.path.read_text()) == len(whole) + 20
    with Journal(Campaign.from_file(written(tmp_path)), journal.folder) as again:
        assert list(again.rows()) == rows
    assert journal.path.read_text() == whole


@pytest.mark.parametrize("put", ["nothing", "another file"])
def test_a_folder_that_is_taken_away_is_told(journal: Journal, put: str) -> None:
    """Else all further rows would go where nobody finds them."""
    [first, *_] = journal.rows()
    journal.path.unlink()
    if put != "nothing":
        journal.path.write_text("other")
    with pytest.raises(BagError, match=r"runs\.jsonl was deleted or moved meanwhile: keep others away"):
        journal.add(first)


@pytest.mark.parametrize("line", ["nonsense", "3", '{"run": 6}', '{"run": 1, "speed": 2}'])
def test_a_damaged_row_is_told(out: Path, tmp_path: Path, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    copy = shutil.copytree(out, tmp_path / "copy")
    place = (copy / "runs.jsonl").stat().st_size
    with (copy / "runs.jsonl").open("a") as file:
        file.write(f"{line}\n")
    assert main([str(written(tmp_path)), "--out", str(copy)]) == 2
    assert f"runs.jsonl is damaged: byte {place} begins no row of this campaign" in capsys.readouterr().err


def test_runs_that_fail_one_after_another_end_a_campaign(
    scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of a million too, as where the disk is full: here of what no run can be, found as late as that."""
    monkeypatch.setattr(campaign_verb, "MOST_TRIED", 0)
    path = written(tmp_path, "runs: 1000000\nseed: 1\nduration: 1.0\nparameters: {rate: -3.0}")
    given = [str(path), "--out", str(tmp_path / "out"), "--scheduler", scheduler]
    assert main(given) == 2
    [line] = capsys.readouterr().err.splitlines()
    most = MOST_FAILURES + RUNS_AHEAD
    assert f"{most} of 1000000 runs failed, first: run 0: rate: -3 is outside" in line
    assert line.endswith("; 0 are kept: mend that, and the same command does the rest")
    assert not finished(tmp_path / "out")


def test_a_run_that_fails_leaves_no_part_of_its_bag(tmp_path: Path) -> None:
    campaign, before = Campaign(runs=1, seed=1, duration=1.0), resource.getrlimit(resource.RLIMIT_FSIZE)
    (tmp_path / "bags").mkdir()
    resource.setrlimit(resource.RLIMIT_FSIZE, (8192, before[1]))
    try:
        with pytest.raises(BagError, match=r"000000\.mcap cannot be written: File too large"):
            carry_out(campaign, 0, str(tmp_path))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not list((tmp_path / "bags").iterdir())


def test_an_estimator_without_any_score_is_an_error(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy, scores = shutil.copytree(out, tmp_path / "copy"), dict.fromkeys(SCORES)
    with Journal(Campaign.from_file(written(tmp_path)), out) as journal:
        rows = [replace(row, scores={**scores, "estimator_error": "it is lost"}) for row in journal.rows()]
    heading = (copy / "runs.jsonl").read_text().partition("\n")[0]
    (copy / "runs.jsonl").write_text("\n".join([heading, *(json.dumps(row.to_dict()) for row in rows), ""]))
    assert main([str(written(tmp_path)), "--out", str(copy)]) == 2
    said = capsys.readouterr()
    assert "0 scored; run 0 is not: it is lost" in said.out
    assert "gave no score in any run: it is lost: mend it" in said.err
    assert table_of(copy)["estimator_error"].to_pylist() == ["it is lost"] * 6


def test_an_estimator_without_a_score_in_the_first_runs_ends_a_campaign(
    scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "always_lost.py").write_text("def estimate(run): raise RuntimeError('it is lost')")
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path, "runs: 99\nseed: 1\nduration: 0.02\nestimator: always_lost:estimate")
    assert main([str(path), "--out", "out", "--no-bags", "--scheduler", scheduler]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert f"always_lost:estimate gave no score in {MOST_FAILURES} runs: RuntimeError: it is lost: mend it" in line
    assert len(finished(tmp_path / "out")) == MOST_FAILURES


def test_a_page_shows_the_runs_and_their_residuals(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("plotly")
    report = tmp_path / "report.html"
    given = [str(written(tmp_path)), "--out", str(out), "--report", str(report)]
    assert main(given) == 0
    assert f"wrote {report}" in capsys.readouterr().out
    text = report.read_text(encoding="utf-8")
    assert report.stat().st_size <= 6_000_000
    assert "6 of 6 runs CERTIFIED" in text
    rows = table_of(out).to_pylist()
    for row in rows:
        assert f"<td>{row['run']}</td>" in text
        assert f"<td>{row['gyro_noise_density']:.4g}</td>" in text
    drawn = re.findall(r'<h3>(.*?)</h3>(?:(?!<h3>).)*?<script type="application/json">(.*?)</script>', text, re.DOTALL)
    counts = {name: sum(json.loads(content)["data"][0]["y"]) for name, content in drawn}
    assert {"kinetic energy [rel]", "world momentum x [rel]", "closed form [rad]"} <= counts.keys()
    assert counts["closed form [rad]"] == 6
    assert main(given) == 2
    assert "--force to replace it" in capsys.readouterr().err


def test_a_long_bag_is_certified_in_batches_and_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    campaign = Campaign(runs=1, seed=1, duration=1.0, parameters={"imu_rate": 100.0})
    kept = carry_out(campaign, 0, None)
    assert kept.certified
    monkeypatch.setattr(run, "LARGEST_IN_MEMORY", 0)
    monkeypatch.setattr(bag_reader, "read_bag", None)
    assert carry_out(campaign, 0, None) == kept


@pytest.fixture
def slow(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """A process with a campaign that has finished a run and has many before it."""
    path, out = written(tmp_path, CAMPAIGN.replace("runs: 6", f"runs: {MANY}").replace("0.25", "8.0")), tmp_path / "out"
    process = subprocess.Popen(
        [*COMMAND, str(path), "--out", str(out), "--workers", "2"],
        stdout=-1,
        stderr=-1,
        text=True,
        start_new_session=True,
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


def finished(out: Path) -> list[int]:
    journal = out / "runs.jsonl"
    lines = journal.read_text().split("\n")[1:-1] if journal.exists() else []
    return [json.loads(line)["run"] for line in lines]


def test_an_interruption_keeps_what_is_finished(slow: tuple[subprocess.Popen[str], Path], scheduler: str) -> None:
    """Ctrl-C reaches the workers as well: they say nothing."""
    process, out = slow
    os.killpg(process.pid, signal.SIGINT)
    said, complained = process.communicate(timeout=DEADLINE)
    assert (process.returncode, said) == (130, ""), complained
    assert complained.count("\n") == 1, complained
    [line] = complained.splitlines()
    done = finished(out)
    assert f"interrupted after {len(done)} of {MANY} runs" in line
    assert len(done) == len({*done}) >= 1
    before = {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in done}
    assert main([str(out.parent / "campaign.yaml"), "--out", str(out), "--scheduler", scheduler]) == 0
    assert sorted(finished(out)) == list(range(MANY))
    assert {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in done} == before


@pytest.fixture
def handlers() -> Iterator[None]:
    """Signals are handled afterwards as before: a process that was asked to end ignores them."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("handlers")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_while_the_cluster_starts_lets_it_start_and_closes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], number: int
) -> None:
    """Half of a cluster cannot be closed. This one is of threads, which start at once."""
    import distributed

    started, make = [], distributed.LocalCluster

    def interrupted(**options: Any) -> Any:
        os.kill(os.getpid(), number)
        started.append(make(**{**options, "processes": False}))
        return started[0]

    monkeypatch.setattr(distributed, "LocalCluster", interrupted)
    assert main([str(written(tmp_path, CAMPAIGN)), "--out", str(tmp_path / "out"), "--workers", "1"]) == 130
    said = capsys.readouterr()
    assert said.out == ""
    [line] = said.err.splitlines()
    assert "interrupted after 0 of 6 runs, which are kept; the same command does the rest" in line
    assert [cluster.status for cluster in started] == [distributed.Status.closed]


@pytest.mark.slow
def test_a_kill_costs_the_runs_at_work_and_nothing_is_done_twice(slow: tuple[subprocess.Popen[str], Path]) -> None:
    process, out = slow
    process.kill()
    process.communicate(timeout=DEADLINE)
    done = finished(out)
    before = {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in done}
    assert main([str(out.parent / "campaign.yaml"), "--out", str(out), "--workers", "1"]) == 0
    assert finished(out)[: len(done)] == done
    assert sorted(finished(out)) == list(range(MANY))
    assert list(bytes_of(out)) == [f"{run:06d}.mcap" for run in range(MANY)]
    assert {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in done} == before
    assert table_of(out)["certified"].to_pylist() == [True] * MANY


@pytest.mark.slow
def test_a_worker_that_dies_costs_nothing_but_its_run(slow: tuple[subprocess.Popen[str], Path]) -> None:
    process, out = slow
    workers = [
        pid for pid in children(process.pid) if "multiprocessing" in command(pid) and "spawn_main" in command(pid)
    ]
    done = finished(out)
    before = {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in done}
    os.kill(workers[0], signal.SIGKILL)
    said, complained = process.communicate(timeout=DEADLINE)
    assert (process.returncode, complained) == (0, "")
    assert f"{MANY} runs, {MANY} certified" in said
    assert sorted(finished(out)) == list(range(MANY))
    assert {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in done} == before
    assert list(bytes_of(out)) == [f"{run:06d}.mcap" for run in range(MANY)]
    assert table_of(out)["run"].to_pylist() == list(range(MANY))
    assert table_of(out)["certified"].to_pylist() == [True] * MANY


DEADLY = """
import os, signal
def from_truth(run):
    if dict(run.scenario.sensor_parameters)["sensor_seed"] == 2 and not os.path.exists("mended"):
        os.kill(os.getpid(), signal.SIGKILL)
    return run.truth.attitude_xyzw
"""


@pytest.mark.slow
def test_a_run_that_kills_every_worker_is_told_and_costs_no_other(tmp_path: Path) -> None:
    """It is done when what kills it is mended, and the others are not done again."""
    (tmp_path / "estimator_of_a_campaign.py").write_text(DEADLY)
    command = [*COMMAND, str(written(tmp_path)), "--out", "out", "--workers", "2"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path])}
    out, others = tmp_path / "out", [0, 1, 3, 4, 5]
    broken = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert (broken.returncode, broken.stdout) == (2, "")
    [line] = broken.stderr.splitlines()
    assert "1 of 6 runs failed (2), first: every process that tried it died; 5 are kept, in runs.parquet: " in line
    assert sorted(finished(out)) == table_of(out)["run"].to_pylist() == others
    before = {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in others}
    (tmp_path / "mended").touch()
    mended = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert mended.returncode == 0, mended.stderr
    assert {run: (out / f"bags/{run:06d}.mcap").stat().st_mtime_ns for run in others} == before
    assert table_of(out)["run"].to_pylist() == list(range(6))


def children(pid: int) -> list[int]:
    return [
        int(child) for task in Path(f"/proc/{pid}/task").iterdir() for child in (task / "children").read_text().split()
    ]


def command(pid: int) -> str:
    return Path(f"/proc/{pid}/cmdline").read_text().replace("\0", " ")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("runs: 0\nseed: 1\nduration: 1.0", "runs: 0 is not an integer from 1"),
        ("runs: 1\nseed: -1\nduration: 1.0", "seed"),
        ("runs: 1\nseed: 1\nduration: .inf", "duration"),
        ("runs: 1\nseed: 1", "has no 'duration:'"),
        ("runs: 1\nseed: 1\nduration: 1.0\nvaries: {}", "there is no 'varies' in a campaign"),
        ("runs: 1\nseed: 1\nduration: 1.0\nscenario: none", "'none' is unknown"),
        ("runs: 1\nseed: 1\nduration: 1.0\nvary: {speed: {distribution: run}}", "there is no parameter 'speed'"),
        ("runs: 1\nseed: 1\nduration: 1.0\nvary: {rate: 3.0}", "vary.rate is not a distribution"),
        (
            "runs: 1\nseed: 1\nduration: 1.0\nvary: {record_path: {distribution: choice, values: [a.mcap, b.mcap]}}",
            "vary.record_path is for the node: leave it out",
        ),
        (
            "runs: 1\nseed: 1\nduration: 1.0\nvary: {paused: {distribution: choice, values: [true]}}",
            "vary.paused is for",
        ),
        ("runs: 1\nseed: 1\nduration: 1.0\nparameters: {record_path: a.mcap}", "record_path is for the node"),
        ("runs: 1\nseed: 1\nduration: 1.0\nparameters: {rate: -3.0}", "run 0: rate: -3 is outside"),
        (
            "runs: 1\nseed: 1\nduration: 1.0\nvary: {initial_body_rate: {distribution: direction, norm: -1}}",
            "vary.initial_body_rate.norm: -1.0 was drawn in run 0",
        ),
        (
            "runs: 1\nseed: 1\nduration: 1.0\nparameters: {rate: 3.0}\nvary: {rate: {distribution: run}}",
            "in parameters and in vary",
        ),
        (
            "runs: 9\nseed: 1\nduration: 1.0\nvary: {rate: {distribution: choice, values: [1.0, -1.0]}}",
            "rate: -1 is outside",
        ),
        ("runs: 1\nseed: 1\nduration: 1.0\nestimator: math", "'math' names no function"),
        ("runs: 1\nseed: 1\nduration: 1.0\nestimator: 'nowhere.at:all'", "cannot be imported: ModuleNotFoundError"),
        ("runs: 1\nseed: 1\nduration: 1.0\nestimator: math:pi", "'math' has no function 'pi'"),
        ("[]", "no campaign"),
        ("{", "not readable as YAML"),
    ],
)
def test_bad_campaigns_are_refused_in_one_line(
    text: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([written(tmp_path, text).name, "--out", "out"]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert words in line
    assert "campaign.yaml" in line or "estimator '" in line
    assert not (tmp_path / "out").exists()


def test_what_has_no_effect_in_any_run_is_told_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    noise = "gyro_noise_density: {distribution: uniform, low: 0.0, high: 0.1}"
    rates = ("", ", imu_rate: {distribution: choice, values: [0.0, 9.0]}")
    for i, rate in enumerate(rates):
        text = f"runs: 20\nseed: 1\nduration: 1\nestimator: no:such\nvary: {{{noise}{rate}}}\n"
        assert main([str(written(tmp_path, text)), "--out", str(tmp_path / "out")]) == 2
        assert ("warning: " in (err := capsys.readouterr().err)) == (i == 0)
        assert ("campaign.yaml: gyro_noise_density has no effect, as imu_rate is 0" in err) == (i == 0)


@pytest.mark.parametrize(
    "address", ["nonsense", "", "http://127.0.0.1:1", "tcp://127.0.0.1", "tcp://:8786", "tcp://h:0", "tcp://h:65536"]
)
def test_what_is_no_address_is_refused_before_a_folder_is_made(
    address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(written(tmp_path, CAMPAIGN)), "--out", str(tmp_path / "out"), "--scheduler", address]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert f"--scheduler '{address}' is not the address of a Dask scheduler: give protocol, host and port" in line
    assert not (tmp_path / "out").exists()


def test_workers_of_this_machine_and_a_scheduler_elsewhere_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [str(written(tmp_path)), "--out", str(tmp_path / "out"), "--workers", "2", "--scheduler", "tcp://h:1"]
    assert main(given) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "argument --scheduler: not allowed with argument --workers" in line
    assert not (tmp_path / "out").exists()


def test_what_no_scheduler_can_be_reached_by_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """TLS without a certificate."""
    given = [str(written(tmp_path, CAMPAIGN)), "--out", str(tmp_path / "out"), "--scheduler", "tls://127.0.0.1:1"]
    assert main(given) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "no Dask scheduler answers at 'tls://127.0.0.1:1': TLS expects" in line


def test_a_folder_in_one_that_does_not_exist_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(written(tmp_path, CAMPAIGN)), "--out", str(tmp_path / "none" / "out")]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "none does not exist: make it, or give another one" in line
    assert not (tmp_path / "none").exists()


def test_a_folder_of_something_else_is_left_alone(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "precious").write_text("precious")
    assert main([str(written(tmp_path)), "--out", str(tmp_path)]) == 2
    assert "holds other files" in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"precious", "campaign.yaml"}
    assert main([str(written(tmp_path, CAMPAIGN.replace("seed: 7", "seed: 8"))), "--out", str(out)]) == 2
    assert "another campaign" in capsys.readouterr().err
