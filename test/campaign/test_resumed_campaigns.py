"""A campaign that is given again: what is finished is not done twice, and what is missing is made."""

from __future__ import annotations

import json
import os
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from campaigns import CAMPAIGN, ESTIMATED, NEEDS_DASK, bytes_of, finished, table_of, written

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.journal import Journal
from lie_rigid_body.cli.campaign import main
from lie_rigid_body.foundation.errors import InputError

pytestmark = [NEEDS_DASK, pytest.mark.usefixtures("asked_here")]


def test_what_is_finished_is_not_done_again(out: Path, tmp_path: Path) -> None:
    before = {path: path.stat().st_mtime_ns for path in (out / "bags").iterdir()}
    assert main([str(written(tmp_path)), "--out", str(out)]) == 0
    assert {path: path.stat().st_mtime_ns for path in (out / "bags").iterdir()} == before
    assert sorted(finished(out)) == list(range(6))


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


@pytest.mark.parametrize(("happen", "runs"), [(bags_cut, [1, 2]), (of_before, [2]), (made_without, list(range(6)))])
def test_a_bag_that_is_missing_or_cut_is_made_again(
    out: Path, scheduler: str, tmp_path: Path, happen: Any, runs: list[int]
) -> None:
    copy = shutil.copytree(out, tmp_path / "copy")
    happen(copy)
    assert main([str(written(tmp_path)), "--out", str(copy), "--scheduler", scheduler]) == 0
    assert sorted(finished(copy)[6:]) == runs
    assert bytes_of(copy) == bytes_of(out)
    assert table_of(copy).equals(table_of(out))
    assert main([str(written(tmp_path)), "--out", str(copy)]) == 0
    assert sorted(finished(copy)[6:]) == runs


def test_bags_that_are_there_are_kept_where_none_are_wanted(out: Path, tmp_path: Path) -> None:
    before = bytes_of(out)
    assert main([str(written(tmp_path)), "--out", str(out), "--no-bags"]) == 0
    assert bytes_of(out) == before


@pytest.mark.parametrize(
    ("written_once", "written_now"),
    [("mass: 8.0", "mass: 8"), ("rate: 100.0", "rate: 1.0e2"), ("low: 1e-5, high: 1.0e-3", "low: 0.1e-4, high: 0.001")],
)
def test_a_number_may_be_written_otherwise(
    out: Path, tmp_path: Path, written_once: str, written_now: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The table keeps the bytes that it had."""
    before = (out / "runs.parquet").read_bytes()
    path = written(tmp_path, ESTIMATED.replace(written_once, written_now))
    assert main([str(path), "--out", str(out)]) == 0, capsys.readouterr().err
    assert (out / "runs.parquet").read_bytes() == before


@pytest.mark.parametrize(
    ("one", "other"),
    [("2.0", "2.5"), ("9007199254740993", "9007199254740992"), ("1", "true"), ("0.0", "-0.0")],
)
def test_numbers_that_are_not_equal_are_of_another_campaign(one: str, other: str, tmp_path: Path) -> None:
    """Also those that are one to Python, or to a float."""
    values = [json.loads(text) for text in (one, other)]
    campaigns = [Campaign(1, 1, 1.0, parameters={"rate": value}) for value in values]
    with Journal(campaigns[0], tmp_path / "out"):
        (tmp_path / "out/bags/of_a_run").touch()
    assert [Journal.is_begun(campaign, tmp_path / "out") for campaign in campaigns] == [True, False]
    with pytest.raises(InputError), Journal(campaigns[1], tmp_path / "out"):
        pass


def test_a_folder_without_a_run_is_free_for_another_campaign(
    scheduler: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As that of one whose scheduler could not be reached: here for want of a certificate."""
    given = [str(written(tmp_path, CAMPAIGN)), "--out", str(tmp_path / "out"), "--scheduler"]
    assert main([*given, "tls://127.0.0.1:1"]) == 2
    written(tmp_path, CAMPAIGN.replace("runs: 6", "runs: 2"))
    assert main([*given, scheduler]) == 0, capsys.readouterr().err
    assert sorted(finished(tmp_path / "out")) == [0, 1]
    written(tmp_path, CAMPAIGN)
    assert main([*given, scheduler]) == 2
