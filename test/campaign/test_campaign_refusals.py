"""What ``campaign`` refuses: status 2, one line on stderr, and folders left as they were."""

from __future__ import annotations

from pathlib import Path

import pytest
from campaigns import CAMPAIGN, NEEDS_PARQUET, written

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.results import Results
from lie_rigid_body.cli.campaign import main

pytestmark = [NEEDS_PARQUET, pytest.mark.usefixtures("asked_here")]


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
