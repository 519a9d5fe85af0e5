"""A second signal at once changes nothing, wherever a verb is; a later one ends what closes."""

from __future__ import annotations

import os
import shutil
import signal
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from random import Random

import pytest

from lie_rigid_body.cli.record import main as record
from lie_rigid_body.recording.bag_reader import read_bag
from said import numbers
from two_signals import PAIRS, STRUCK, STRUCK_WITHOUT_NUMBA, VERB, ended_by_the_second, full_pipe, started, struck

INT, TERM = signal.SIGINT, signal.SIGTERM
CAMPAIGN = "{runs: 500, seed: 7, duration: 8.0, vary: {initial_attitude_xyzw: {distribution: uniform_rotation}}}"
MAGIC = b"\x89MCAP0\r\n"
"""Last bytes of a bag that is whole."""
LONG_WORK = {
    "record": "record new.mcap -p motion:=closed_form --duration 200000",
    "record by steps": "record new.mcap -p rate:=0.01 -p max_step:=1e-6 --duration 1000",
    "check": "check bags",
    "evaluate": "evaluate bags/0.mcap --estimate /pose",
    "campaign": "campaign campaign.yaml --out runs --workers 2",
}
"""Verbs with work for longer than a test."""
ENDS_WITH = {"evaluate": "no findings"}
"""Last lines of verbs that a fast machine may have done before."""
WITH_PARQUET = pytest.mark.skipif(not find_spec("pyarrow"), reason="pyarrow is not installed")
SEEDS = {name: seed for seed, name in enumerate(LONG_WORK)}
VERBS = [pytest.param(name, marks=WITH_PARQUET) if name == "campaign" else name for name in LONG_WORK]
LONGEST_S = {"campaign": 6.0, "evaluate": 1.0}
"""Time, s, in which the first signal comes, other than 2 s."""
pytestmark = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="there is no /proc")


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bag") / "bag.mcap"
    assert record([str(path), "-p", "motion:=closed_form", "-p", "rate:=1000.0", "--duration", "400", "--quiet"]) == 0
    return path


def prepared(folder: Path, name: str, request: pytest.FixtureRequest) -> Path:
    (folder / "bags").mkdir()
    if "bags" in LONG_WORK[name]:
        for i in range(30):
            os.link(request.getfixturevalue("bag"), folder / f"bags/{i}.mcap")
    (folder / "campaign.yaml").write_text(CAMPAIGN)
    return folder


def tried(name: str, folder: Path, seed: int, *, numba: bool) -> None:
    """Strike one verb once, and look at what it leaves."""
    random = Random(f"{name} {seed}")
    command = [sys.executable, "-c", STRUCK if numba else STRUCK_WITHOUT_NUMBA, *LONG_WORK[name].split()]
    pair = PAIRS[seed % len(PAIRS)]
    status, out, err = struck(command, folder, random, LONGEST_S.get(name, 2.0), pair)
    if name in ENDS_WITH and status == 0:  # done before the first signal came
        assert (err, out.splitlines()[-1]) == ("", ENDS_WITH[name])
        return
    assert (status, err.count("\n"), out) == (130, 1, ""), (pair, err)
    assert err.startswith(f"lie-rigid-body {name.split()[0]}: error: "), err
    made = folder / "new.mcap"
    if made.exists():
        count = numbers(err)[0]
        assert made.read_bytes()[-8:] == MAGIC
        assert count == 0 or count == len(read_bag(made).poses.stamps_ns)
        made.unlink()
    shutil.rmtree(folder / "runs", ignore_errors=True)
    assert sorted(os.listdir(folder)) == ["bags", "campaign.yaml"]


@pytest.mark.slow
@pytest.mark.parametrize("numba", [True, False])
@pytest.mark.parametrize("name", VERBS)
def test_a_second_signal_changes_nothing_at_any_moment(
    name: str, tmp_path: Path, numba: bool, request: pytest.FixtureRequest
) -> None:
    prepared(tmp_path, name, request)
    for seed in range(4):
        tried(name, tmp_path, seed, numba=numba)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["record", *(pytest.param(name, marks=[pytest.mark.slow, WITH_PARQUET]) for name in LONG_WORK if name != "record")],
)
def test_a_later_signal_ends_what_closes_for_ever(name: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """It has a line to say on stderr, a pipe that is full and that nobody reads."""
    numbers = [(INT, TERM, INT), (TERM, INT, TERM)][SEEDS[name] % 2]
    with full_pipe() as write:
        process = started([*VERB, *LONG_WORK[name].split()], prepared(tmp_path, name, request), write)
        try:
            if name not in ENDS_WITH:  # its work would be done before
                time.sleep(1.0)
            assert ended_by_the_second(process, numbers) == -numbers[-1]
        finally:
            process.kill()
    process.communicate()
