"""``plot``: one PNG, and nothing overwritten."""

from __future__ import annotations

import os
import subprocess
import sys

import matplotlib
import pytest
from test_check import write_bag

from lie_rigid_body.cli.plot import main


@pytest.fixture
def bag(tmp_path):
    return write_bag(tmp_path / "bag.mcap", 40)


@pytest.mark.slow
def test_a_picture_is_kept_and_replaced_by_the_same_whatever_a_matplotlibrc_says(bag, tmp_path, capsys):
    out = tmp_path / "out.png"
    assert main([str(bag), "-o", str(out)]) == 0
    picture = out.read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 50_000
    capsys.readouterr()
    assert main(["absent.mcap", "-o", str(out)]) == 2
    assert out.read_bytes() == picture
    with matplotlib.rc_context({"text.usetex": True, "font.size": 30.0, "savefig.bbox": "tight"}):
        assert main([str(bag), "-o", str(out), "--force"]) == 0
        assert matplotlib.rcParams["font.size"] == 30.0
    assert out.read_bytes() == picture


@pytest.mark.slow
def test_matplotlib_without_a_folder_of_its_own_says_nothing(bag, tmp_path):
    """As where there is no home folder; it logs where it keeps its caches instead."""
    (tmp_path / "file").touch()
    command = [sys.executable, "-m", "lie_rigid_body", "plot", str(bag), "-o", str(tmp_path / "a.png")]
    done = subprocess.run(
        command, env={**os.environ, "MPLCONFIGDIR": str(tmp_path / "file" / "x")}, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
