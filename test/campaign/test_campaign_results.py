"""What a finished ``campaign`` leaves: the table, the bags and the page; and what it refuses before it begins."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from campaigns import CAMPAIGN, LOST, NEEDS_DASK, NEEDS_PARQUET, SCORES, bytes_of, table_of, written

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.definition import OF_TABLE
from lie_rigid_body.campaign.results import Results
from lie_rigid_body.campaign.workers import on_a_cluster
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.runs import simulate

pytestmark = [NEEDS_PARQUET, pytest.mark.usefixtures("asked_here")]


def test_the_table_has_a_row_for_each_run(out: Path) -> None:
    table = table_of(out)
    vary = ["initial_attitude_xyzw", "initial_body_rate", "inertia", "gyro_noise_density", "motion"]
    vary += ["sensor_seed", "epoch_ns"]
    assert table.column_names == ["run", *vary, "certified", "attitude_accuracy_rad", "bag", *SCORES, "estimator_error"]
    assert table["run"].to_pylist() == list(range(6))
    assert table["certified"].to_pylist() == [True] * 6
    assert all(0.0 < accuracy < 1e-13 for accuracy in table["attitude_accuracy_rad"].to_pylist())
    assert [(out / bag).is_file() for bag in table["bag"].to_pylist()] == [True] * 6
    of_truth = pytest.approx(0.0, abs=1e-12)
    for name in SCORES:
        assert table[name].to_pylist() == [of_truth, of_truth, None, of_truth, of_truth, of_truth]
    assert table["estimator_error"].to_pylist() == [None, None, LOST, None, None, None]
    assert list(bytes_of(out)) == [f"{run:06d}.mcap" for run in range(6)]


def test_each_bag_is_that_of_record_with_the_parameters_of_its_row(out: Path, tmp_path: Path) -> None:
    campaign = Campaign.from_table(shutil.copy(out / "runs.parquet", tmp_path))
    assert campaign == Campaign.from_file(written(tmp_path))
    for row in table_of(out).to_pylist():
        given = {name: row[name] for name in list(row)[1:8]}
        given |= dict.fromkeys(("rate", "imu_rate", "attitude_sensor_rate"), 100.0)
        assignments = [f"-p{name}:={value}" for name, value in given.items()]
        again = tmp_path / "again.mcap"
        options = ["--scenario", "tumbling_cubesat", "--duration", "0.25", "--force", "--quiet"]
        assert record([str(again), *options, *assignments]) == 0
        assert again.read_bytes() == (out / row["bag"]).read_bytes()
        simulate(campaign.scenario_of(row["run"]), duration=campaign.duration).to_bag(again, overwrite=True)
        assert again.read_bytes() == (out / row["bag"]).read_bytes()


def test_the_name_of_a_folder_need_not_be_unicode(out: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(out, tmp_path / os.fsdecode(b"out\xff"))
    assert main([str(written(tmp_path)), "--out", str(copy)]) == 0


def test_what_is_no_table_of_a_campaign_is_refused(tmp_path: Path) -> None:
    import pyarrow
    from pyarrow import parquet

    path = tmp_path / "runs.parquet"
    whole = pyarrow.table({"run": [0]})
    for said in ("", "3", "{}", '{"campaign": 3}', '{"campaign": {"runs": 1}}', "[" * 100_000):
        parquet.write_table(whole.replace_schema_metadata({OF_TABLE: said}), path)
        with pytest.raises(InputError):
            Campaign.from_table(path)
    parquet.write_table(whole, tmp_path / "other.parquet")
    with pytest.raises(InputError):
        Campaign.from_table(tmp_path / "other.parquet")


def test_a_folder_elsewhere_and_two_workers_give_the_same_bytes(out: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    assert main([str(written(tmp_path)), "--out", str(other), "--workers", "2"]) == 0
    assert bytes_of(other) == bytes_of(out)
    assert (other / "runs.parquet").read_bytes() == (out / "runs.parquet").read_bytes()


@pytest.mark.slow
@NEEDS_DASK
@pytest.mark.long
@pytest.mark.parametrize("bags", [True, False])
def test_a_cluster_elsewhere_gives_the_same_bytes(out: Path, tmp_path: Path, bags: bool) -> None:
    """Here of one worker, a thread of this process."""
    from distributed import LocalCluster

    other = tmp_path / "other"
    options: dict[str, Any] = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "protocol": "tcp"}
    with LocalCluster(**options, dashboard_address=":0", local_directory=str(tmp_path / "workers")) as cluster:
        given = [str(written(tmp_path)), "--out", str(other), "--scheduler", cluster.scheduler_address]
        assert main([*given, *([] if bags else ["--no-bags"])]) == 0
    assert bytes_of(other) == (bytes_of(out) if bags else {})
    assert table_of(other).drop_columns("bag").equals(table_of(out).drop_columns("bag"))


@NEEDS_DASK
@pytest.mark.parametrize("address", ["nonsense://1", "tcp://127.0.0.1:1"])
def test_where_no_scheduler_answers_the_campaign_ends(address: str, tmp_path: Path) -> None:
    import dask

    pytest.importorskip("distributed")  # which loads the settings of which one is changed
    with dask.config.set({"distributed.comm.timeouts.connect": "0.1s"}), pytest.raises(BagError):
        next(on_a_cluster(Campaign(1, 1, 1.0), [0], tmp_path, address, keep=True))


def test_a_page_shows_the_runs_and_how_many_are_certified(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = tmp_path / "report.html"
    given = [str(written(tmp_path)), "--out", str(out), "--report", str(report)]
    assert main(given) == 0
    assert str(report) in capsys.readouterr().out
    text = report.read_text(encoding="utf-8")
    assert report.stat().st_size <= 100_000
    assert re.search("6 of 6 .*CERTIFIED", text)
    rows = table_of(out).to_pylist()
    for row in rows:
        assert f"<td>{row['run']}</td>" in text
        assert f"<td>{row['gyro_noise_density']:.4g}</td>" in text
    assert "<h3>" not in text
    assert main(given) == 2


def test_what_has_no_effect_in_any_run_is_told_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    noise = "gyro_noise_density: {distribution: uniform, low: 0.0, high: 0.1}"
    rates = ("", ", imu_rate: {distribution: choice, values: [0.0, 9.0]}")
    for i, rate in enumerate(rates):
        text = f"runs: 20\nseed: 1\nduration: 1\nestimator: no:such\nvary: {{{noise}{rate}}}\n"
        assert main([str(written(tmp_path, text)), "--out", str(tmp_path / "out")]) == 2
        assert ("warning: " in (err := capsys.readouterr().err)) == (i == 0)
        assert ("gyro_noise_density" in err) == (i == 0)


@pytest.mark.parametrize("taken", ["bags", ""])
@pytest.mark.parametrize("dangling", [False, True])
def test_what_is_no_folder_is_named(
    taken: str, dangling: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    (out / taken).parent.mkdir(exist_ok=True)
    (out / taken).symlink_to("nowhere") if dangling else (out / taken).write_text("precious")
    if taken:
        Results(Campaign.from_file(written(tmp_path, CAMPAIGN)), tmp_path / "other")
        (tmp_path / "other/campaign.json").rename(out / "campaign.json")
    assert main([str(written(tmp_path, CAMPAIGN)), "--out", str(out)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert str(Path("out", taken)) in line


def test_a_library_that_is_missing_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("lie_rigid_body.cli.campaign.find_spec", lambda name: name == "pyarrow")
    given = [str(written(tmp_path, CAMPAIGN.replace("runs: 6", "runs: 0"))), "--out", str(tmp_path / "out")]
    for more, named in (([], False), (["--scheduler", "tcp://h:1"], True)):
        assert main([*given, *more]) == 2
        assert ("distributed" in capsys.readouterr().err) == named
