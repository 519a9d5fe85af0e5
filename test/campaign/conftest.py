"""A campaign that is done once for all the files that read it, and a cluster for one that is carried out elsewhere."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from campaigns import ESTIMATOR, written

from lie_rigid_body.cli.campaign import main
from one_python import asked_here


@pytest.fixture(autouse=True)
def own_estimator() -> Iterator[None]:
    """The estimator of another test, of the same name and already imported, would be taken for a test's own."""
    yield
    sys.modules.pop("estimator_of_a_campaign", None)


@pytest.fixture(scope="session")
def campaign_done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a campaign, with an estimator beside it that fails in one run."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "estimator_of_a_campaign.py").write_text(ESTIMATOR)
    with pytest.MonkeyPatch.context() as patch, asked_here(folder):
        patch.chdir(folder)
        assert main([str(written(folder)), "--out", str(folder / "out"), "--workers", "1"]) == 0
    return folder


@pytest.fixture
def out(campaign_done: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of what `campaign_done` has written, with its estimator in the working directory."""
    shutil.copytree(campaign_done, tmp_path / "done")
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.chdir(tmp_path / "done")
    return tmp_path / "done" / "out"
