"""A campaign that is done once for all the files that read it, and a cluster for those that go on with one."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from campaigns import ESTIMATOR, written

from lie_rigid_body.cli.campaign import main
from lie_rigid_body.system.portable import lock


@pytest.fixture(autouse=True)
def own_estimator() -> Iterator[None]:
    """The estimator of another test, of the same name and already imported, would be taken for a test's own."""
    yield
    sys.modules.pop("estimator_of_a_campaign", None)


@pytest.fixture(scope="session")
def campaign_done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a campaign on one worker, with an estimator beside it that fails in one run.

    Of several processes of pytest one does the campaign, and each has a copy.
    """
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "campaign_done"
    with folder.with_suffix(".lock").open("w") as file, lock(file, wait=True):
        if not folder.exists():
            _do(tmp_path_factory.mktemp("campaign")).rename(folder)
    return Path(shutil.copytree(folder, own / "campaign"))


def _do(folder: Path) -> Path:
    (folder / "estimator_of_a_campaign.py").write_text(ESTIMATOR)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [*sys.path])
        patch.chdir(folder)
        assert main([str(written(folder)), "--out", str(folder / "out"), "--workers", "1"]) == 0
    return folder


@pytest.fixture(scope="module")
def out(campaign_done: Path) -> Iterator[Path]:
    """What `campaign_done` has written, with its estimator in the working directory."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [*sys.path])
        patch.chdir(campaign_done)
        yield campaign_done / "out"


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a cluster of one worker, a thread of this process, reached by TCP: it starts at once."""
    from distributed import LocalCluster

    options: dict[str, Any] = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "protocol": "tcp"}
    folder = str(tmp_path_factory.mktemp("workers"))
    with LocalCluster(**options, dashboard_address="127.0.0.1:0", local_directory=folder) as cluster:
        yield cluster.scheduler_address
