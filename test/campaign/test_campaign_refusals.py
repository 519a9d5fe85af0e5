"""What ``campaign`` refuses: status 2, one line on stderr, and folders left as they were."""

from __future__ import annotations

from pathlib import Path

import pytest
from campaigns import CAMPAIGN, NEEDS_DASK, written

from lie_rigid_body.cli.campaign import main

pytestmark = NEEDS_DASK


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("runs: 0\nseed: 1\nduration: 1.0", "runs: 0 is not an integer from 1"),
        ("runs: 1\nseed: -1\nduration: 1.0", "seed"),
        ("runs: 1\nseed: 1\nduration: .inf", "duration"),
        ("runs: 1\nseed: 1", "has no 'duration:'"),
        ("runs: 1\nseed: 1\nduration: 1.0\nvaries: {}", "there is no 'varies' in a campaign"),
        ("runs: 1\nseed: 1\nduration: 1.0\nscenario: none", "'none' is unknown"),
        ("runs: 1\nseed: 1\nduration: 1.0\nscenario: 5", "scenario: 5 is no name"),
        ("runs: 1\nseed: 1\nduration: 1.0\nscenario: [x]", "scenario: ['x'] is no name"),
        ("runs: 1\nseed: 1\nduration: 1.0\nparameters: {world_frame: !!binary aGk=}", "give numbers, texts, lists"),
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
    assert f"{Path('out', taken)} is no folder: move it away, or give another folder" in line
