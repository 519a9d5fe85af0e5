"""What ``campaign`` refuses: status 2, one line on stderr, and folders left as they were."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from campaigns import CAMPAIGN, NEEDS_DASK, written

from lie_rigid_body.campaign.cluster import is_open
from lie_rigid_body.cli.campaign import main

pytestmark = [NEEDS_DASK, pytest.mark.usefixtures("asked_here")]


@pytest.mark.parametrize("text", ["[]", f"{CAMPAIGN}\nestimator: math:pi", CAMPAIGN.replace("runs: 6", "runs: 0")])
def test_bad_campaigns_are_refused_in_one_line(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([written(tmp_path, text).name, "--out", "out"]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "campaign.yaml" in line or "estimator" in line
    assert not (tmp_path / "out").exists()


def test_what_has_no_effect_in_any_run_is_told_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    noise = "gyro_noise_density: {distribution: uniform, low: 0.0, high: 0.1}"
    rates = ("", ", imu_rate: {distribution: choice, values: [0.0, 9.0]}")
    for i, rate in enumerate(rates):
        text = f"runs: 20\nseed: 1\nduration: 1\nestimator: no:such\nvary: {{{noise}{rate}}}\n"
        assert main([str(written(tmp_path, text)), "--out", str(tmp_path / "out")]) == 2
        assert ("warning: " in (err := capsys.readouterr().err)) == (i == 0)
        assert ("gyro_noise_density" in err) == (i == 0)


@pytest.mark.parametrize(
    "address", ["nonsense", "", "http://127.0.0.1:1", "tcp://127.0.0.1", "tcp://:8786", "tcp://h:0", "tcp://h:65536"]
)
def test_what_is_no_address_is_refused_before_a_folder_is_made(
    address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(written(tmp_path, CAMPAIGN)), "--out", str(tmp_path / "out"), "--scheduler", address]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("protocol", "asks_nobody"), [("tcp://", True), ("", True), ("ws://", True), ("tls://", False), ("wss://", False)]
)
def test_a_protocol_without_tls_is_open(protocol: str, asks_nobody: bool) -> None:
    assert is_open(f"{protocol}host:8786") == asks_nobody


def test_workers_of_this_machine_and_a_scheduler_elsewhere_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [str(written(tmp_path)), "--out", str(tmp_path / "out"), "--workers", "2", "--scheduler", "tcp://h:1"]
    assert main(given) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_folder_in_one_that_does_not_exist_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(written(tmp_path, CAMPAIGN)), "--out", str(tmp_path / "none" / "out")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "none").exists()


def test_a_folder_of_something_else_is_left_alone(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "precious").write_text("precious")
    assert main([str(written(tmp_path)), "--out", str(tmp_path)]) == 2
    assert {path.name for path in tmp_path.iterdir()} == {"precious", "campaign.yaml"}
    assert main([str(written(tmp_path, CAMPAIGN.replace("seed: 7", "seed: 8"))), "--out", str(out)]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 2


@pytest.mark.parametrize("name", ["bags/000001.mcap", "bags", "runs.parquet", "runs.jsonl"])
def test_nothing_is_written_through_a_link(
    name: str, out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder that somebody else has sent would replace a file of whoever resumes its campaign."""
    begun, target = tmp_path / "begun", tmp_path / "precious"
    shutil.copytree(out, begun)
    (begun / name).rename(target)
    (begun / name).symlink_to(target)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert main([str(written(tmp_path)), "--out", str(begun)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert f"begun/{name}" in line  # a long path loses its middle
    before[tmp_path / "campaign.yaml"] = (tmp_path / "campaign.yaml").read_bytes()
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize("taken", ["bags", ""])
@pytest.mark.parametrize("dangling", [False, True])
def test_what_is_no_folder_is_named(
    taken: str, dangling: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    (out / taken).parent.mkdir(exist_ok=True)
    (out / taken).symlink_to("nowhere") if dangling else (out / taken).write_text("precious")
    if taken:
        (out / "runs.jsonl").touch()
    assert main([str(written(tmp_path, CAMPAIGN)), "--out", str(out)]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert str(Path("out", taken)) in line


def test_a_cluster_of_its_own_needs_the_library_of_keys(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A scheduler elsewhere does without, whatever else is wrong with it."""
    monkeypatch.setattr("lie_rigid_body.cli.campaign.find_spec", lambda name: name != "cryptography")
    given = [str(written(tmp_path, CAMPAIGN)), "--out", str(tmp_path / "out")]
    for more, named in (([], True), (["--scheduler", "nonsense"], False)):
        assert main([*given, *more]) == 2
        assert ("cryptography" in capsys.readouterr().err) == named
