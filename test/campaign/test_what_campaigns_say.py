"""What campaigns say where they refuse or fail: the one table of their words. Other tests hold statuses and values."""

from __future__ import annotations

import math
import os
import socket
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from campaigns import CAMPAIGN, NEEDS_DASK, written

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.cluster import client_of
from lie_rigid_body.campaign.definition import Contender
from lie_rigid_body.campaign.distributions import Uniforms, distribution
from lie_rigid_body.campaign.journal import RESUMED, Journal
from lie_rigid_body.campaign.run import Row, carry_out
from lie_rigid_body.cli import campaign, campaign_runs
from lie_rigid_body.foundation.errors import BagError, InputError, LieRigidBodyError
from lie_rigid_body.foundation.wording import LONGEST_LINE
from lie_rigid_body.report import campaign_scores
from said import refusals

pytestmark = [NEEDS_DASK, pytest.mark.usefixtures("asked_here")]
refused = refusals(
    {
        BagError: {
            "not written": f"cannot be written: {{why}}: .*{RESUMED}",
            "not read": "runs.jsonl cannot be read: {why}",
            "no file": "runs.jsonl is no regular file: move it away, or give another folder",
            "moved": "was deleted or moved meanwhile",
            "another user": "another user's",
            "no row": "byte [0-9]+ begins no row of this campaign",
            "changed bags": rf"{{count}} of {{of}} bags were deleted or changed meanwhile \({{which}}\): .*{RESUMED}",
        },
        InputError: {"distribution": "^{name}", "another campaign": "holds the runs of another campaign or version"},
    }
)
"""Errors that other tests name."""
WITHOUT_A_WORKER = "no worker at {address}: waiting for one; Ctrl-C ends it"
"""What is said while a scheduler has none."""
Scene = Callable[[Path], object]
"""Is called in an empty folder, and raises an error."""


def given(*options: str, text: str = CAMPAIGN) -> Scene:
    """The verb with a campaign file of such a text."""

    def scene(folder: Path) -> int:
        out = [] if "--out" in options else ["--out", "out"]
        return campaign.main([written(folder, text).name, *out, *options])

    return scene


def of_another(folder: Path) -> None:
    with Journal(Campaign(1, 1, 1.0), folder / "out"):
        (folder / "out/bags/of_a_run").touch()
    with Journal(Campaign(1, 2, 1.0), folder / "out"):
        pass


def of_others(folder: Path) -> None:
    (folder / "precious").touch()
    with Journal(Campaign(1, 1, 1.0), folder):
        pass


def at_work(folder: Path) -> None:
    with Journal(Campaign(1, 1, 1.0), folder / "out"), Journal(Campaign(1, 1, 1.0), folder / "out"):
        pass


def no_folder(folder: Path) -> None:
    (folder / "out").touch()
    with Journal(Campaign(1, 1, 1.0), folder / "out"):
        pass


def damaged(folder: Path) -> None:
    with Journal(Campaign(1, 1, 1.0), folder / "out") as journal:
        heading = journal.path.read_bytes()
    journal.path.write_bytes(heading + b"nonsense\n")
    with Journal(Campaign(1, 1, 1.0), folder / "out"):
        pass


def taken_away(folder: Path) -> None:
    with Journal(Campaign(1, 1, 1.0), folder / "out") as journal:
        journal.path.unlink()
        journal.add(Row(0))


def failed(folder: Path) -> None:
    campaign = Campaign(runs=40, seed=1, duration=0.02)
    with Journal(campaign, folder / "out") as journal:
        (folder / "out/bags/000002.mcap").mkdir()
        try:
            carry_out(campaign, 2, journal.bags)
        except LieRigidBodyError as error:
            raise campaign_runs._failure(campaign, journal, {2: error}) from None


def without_a_score(reason: str) -> Scene:
    return lambda folder: campaign_runs._require_scores(Campaign(1, 1, 1.0, estimator="a:b"), [[reason]], "any run")


def table_of_another(folder: Path) -> None:
    (folder / "runs.parquet").write_text("other")
    Campaign.from_table(folder / "runs.parquet")


def no_table(folder: Path) -> None:
    os.mkfifo(folder / "runs.parquet")
    Campaign.from_table(folder / "runs.parquet")


def silent(folder: Path) -> None:
    """Something else than a scheduler listens, which accepts and says nothing."""
    with socket.create_server(("127.0.0.1", 0)) as server, pytest.MonkeyPatch.context() as patch:
        patch.setattr("lie_rigid_body.campaign.cluster._ANSWERING_S", 0.5)
        with client_of(None, f"tcp://127.0.0.1:{server.getsockname()[1]}"):
            pass


SHORT = "runs: 1\nseed: 1\nduration: 1.0\n"
SAID: list[tuple[Scene, str]] = [
    (
        given("--scheduler", "nonsense"),
        "--scheduler 'nonsense' is not the address of a Dask scheduler: ",
    ),
    (given("--scheduler", "tls://127.0.0.1:1"), "no Dask scheduler answers at 'tls://127.0.0.1:1': TLS "),
    (given("--scheduler", "tls://127.0.0.1:1"), ": start one there, or name its certificates in Dask's tls.yaml"),
    (silent, "nothing came within 1 s: start one there"),
    (given("--workers", "2", "--scheduler", "tcp://h:1"), "--scheduler: not allowed with argument --workers"),
    (given("--workers", "none"), "'none' is not a number of processes from 1 to 9999"),
    (given("--out", "none/out"), "none does not exist: make it, or give another one"),
    (of_another, "holds the runs of another campaign or version: give another folder"),
    (of_others, "holds other files and no campaign: give a new folder, or an empty one"),
    (at_work, "another process works on "),
    (no_folder, "out is no folder: move it away, or give another folder"),
    (damaged, "begins no row of this campaign: delete that line"),
    (taken_away, "runs.jsonl was deleted or moved meanwhile: keep others away, and begin anew"),
    (failed, "1 of 40 runs failed (2), first: "),
    (
        failed,
        "000002.mcap is a folder: give the name of a file, or move it away; 0 are kept: mend that, and "
        "the same command does the rest",
    ),
    *(
        (without_a_score(reason), "estimator a:b gave no score in any run: a:b is lost: mend it, and give a new folder")
        for reason in ("a:b is lost", "a:b is lost: mend it")
    ),
    (table_of_another, "runs.parquet is no table of a campaign: give its runs.parquet"),
    (no_table, "is a pipe: give a regular file"),
    (lambda folder: Campaign.from_table(folder), "cannot be read: Is a directory: give its runs.parquet"),
    (lambda folder: Campaign.from_table(folder / "none"), "none cannot be read: No such file or directory"),
    (lambda folder: Campaign.from_table("\ud800"), r"\ud800 is no table of a campaign"),
    (lambda folder: Campaign(3, 1, 1.0).drawn(3), "run 3 is none of this campaign: give a number from 0 to 2"),
]
CAMPAIGNS = [
    ("runs: 0\nseed: 1\nduration: 1.0", "runs: 0 is outside [1, 1000000]: give for example 100"),
    ("runs: 1\nseed: -1\nduration: 1.0", "seed"),
    ("runs: 1\nseed: 1\nduration: .inf", "duration"),
    ("runs: 1\nseed: 1", "has no 'duration:'"),
    ("runs: 1\nseed: 1\nduration: 1.0\nvaries: {}", "there is no 'varies' in a campaign"),
    ("runs: 1\nseed: 1\nduration: 1.0\nscenario: none", "'none' is unknown"),
    ("runs: 1\nseed: 1\nduration: 1.0\nscenario: 5", "scenario: 5 is no name"),
    ("runs: 1\nseed: 1\nduration: 1.0\nscenario: [x]", "scenario: ['x'] is no name"),
    (
        "runs: 1\nseed: 1\nduration: 1.0\nparameters: {world_frame: !!binary aGk=}",
        "parameters and vary: NaN, infinity, dates and bytes",
    ),
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
    (f"{SHORT}estimators: 5", "estimators is to be a mapping of names: "),
    (
        f"{SHORT}estimator: 'math:sin'\nestimators: {{a: {{command: ls}}}}",
        "estimator and estimators are given: give one",
    ),
    (f"{SHORT}estimators: {{'': {{command: ls}}}}", "estimators: '' is no name: give 1 to 40 printable characters"),
    (f"{SHORT}estimators: {{a: 'math:sin'}}", 'estimators.a is to be a mapping: give {function: "module:function"}'),
    (f"{SHORT}estimators: {{a: {{gain: 1}}}}", "estimators.a: there is no 'gain': give function, command, "),
    (f"{SHORT}estimators: {{a: {{}}}}", "estimators.a: give function or command, one of them"),
    (f"{SHORT}estimators: {{a: {{function: math}}}}", "estimators.a.function: 'math' names no function"),
    (f"{SHORT}estimators: {{a: {{function: 'no:such'}}}}", "cannot be imported: ModuleNotFoundError"),
    (f"{SHORT}estimators: {{a: {{command: ls, grid: {{x: [1]}}}}}}", "a program takes its parameters in its line"),
    (f"{SHORT}estimators: {{a: {{command: ''}}}}", "estimators.a.command: '': "),
    (f"{SHORT}estimators: {{a: {{command: a 'b}}}}", 'estimators.a.command: "a \'b": a program takes its parameters'),
    (f"{SHORT}estimators: {{a: {{command: no_such}}}}", "estimators.a.command 'no_such' cannot be started: No such"),
    (f"{SHORT}estimators: {{a: {{function: 'a:b', grid: {{}}}}}}", "estimators.a.grid is of nothing: "),
    (f"{SHORT}estimators: {{a: {{function: 'a:b', grid: {{x: []}}}}}}", "estimators.a.grid.x: [] is no list of values"),
    (f"{SHORT}estimators: {{a: {{function: 'a:b', parameters: [1]}}}}", "estimators.a.parameters: [1] is no mapping"),
    (
        f"{SHORT}estimators: {{a: {{function: 'a:b', parameters: {{x: 1}}, grid: {{x: [1]}}}}}}",
        "estimators.a: x is in parameters and in grid: leave it out of one of them",
    ),
    (
        f"{SHORT}estimators: {{a: {{function: 'a:b', grid: {{x: {[*range(101)]}}}}}}}",
        "estimators: 101 with the points of their grids: give at most 100",
    ),
    (f"{SHORT}estimators: {{a: {{function: 'a:b', parameters: {{x: .nan}}}}}}", "estimators.a: NaN, infinity, dates"),
    (f"{SHORT}estimators: {{a: {{function: 'a:b', parameters: {{x: !!binary aGk=}}}}}}", "estimators.a: NaN, infinity"),
    (f"{SHORT}estimators: {{a: {{function: 'a:b', grid: {{x: [1]}}}}}}", "runs: 1: the best point of a grid is scored"),
    (
        f"{SHORT}estimators: {{a: {{function: 'statistics:quantiles', parameters: {{methods: 1}}}}}}",
        "statistics:quantiles takes no 'methods': did you mean method?",
    ),
    (f"{SHORT}estimators: {{}}", "estimators are none: write 'name: {function: …}' below, or leave it out"),
    (
        f"{SHORT}estimators: {{a: {{function: 'bisect:bisect'}}}}",
        "estimators.a: bisect:bisect needs x: give it in 'parameters'",
    ),
    (f"{SHORT}estimator: 'bisect:bisect'", "estimator: bisect:bisect needs x: give it in 'parameters', or a default"),
]
NO_DISTRIBUTIONS: list[tuple[object, str]] = [
    (3.0, "not a distribution"),
    ({"distribution": "cauchy"}, "there is no distribution 'cauchy'"),
    ({"distribution": "uniform", "low": 1.0}, "uniform takes low, high, and high is missing: add it"),
    (
        {"distribution": "uniform", "low": 1.0, "high": 2.0, "mean": 3.0},
        "uniform takes low, high, and mean is none of that: leave it out",
    ),
    ({"distribution": "run", "low": 1.0}, "run takes nothing more, and low is none of that: leave it out"),
    ({"distribution": "uniform", "low": 2.0, "high": 1.0}, "low 2 is above high 1: exchange them"),
    ({"distribution": "uniform", "low": -1e308, "high": 1e308}, "is beyond double precision: bring them nearer"),
    ({"distribution": "uniform", "low": 0, "high": 10**400}, "is not a finite number"),
    ({"distribution": "uniform", "low": "a", "high": 1.0}, "'a' is not a finite number"),
    ({"distribution": "uniform", "low": 0, "high": float("inf")}, "not a finite number"),
    ({"distribution": "loguniform", "low": 0.0, "high": 1.0}, "no logarithm"),
    ({"distribution": "normal", "mean": 0.0, "std": -1.0}, "below 0"),
    ({"distribution": "choice", "values": []}, "at least one"),
    ({"distribution": "box", "edges": [1, 1, 1]}, "takes density or mass, edges, and density or mass is missing"),
    ({"distribution": "box", "mass": 1, "density": 1, "edges": [1, 1, 1]}, "density and mass are given: leave one"),
    ({"distribution": "box", "mass": 1, "edges": [1, 1]}, "three lengths"),
    ({"distribution": "direction", "norm": [1, 2, 3]}, "no range"),
    ({"distribution": "direction", "norm": {"distribution": "none"}}, "there is no distribution"),
    (
        {"distribution": "direction", "norm": {"distribution": "uniform_rotation"}},
        "uniform_rotation draws several numbers: give a distribution of one",
    ),
]
DRAWN: list[tuple[dict[str, Any], str]] = [
    ({"distribution": "box", "mass": 1.0, "edges": [[-1.0, -0.5], 1.0, 1.0]}, "finite number above 0: draw"),
    ({"distribution": "direction", "norm": -1}, "-1.0 was drawn in run 0 and is not a finite number of at"),
    ({"distribution": "direction", "norm": {"distribution": "choice", "values": ["a"]}}, "'a' was drawn in run 0"),
    ({"distribution": "direction", "norm": {"distribution": "choice", "values": [math.inf]}}, "inf was drawn"),
]


def drawn(one: object) -> Scene:
    """Drawing from a distribution, if it is one."""
    return lambda folder: distribution("vary.x", one)(Uniforms(0, 0, "x"))


SAID += [(given(text=text), words) for text, words in CAMPAIGNS]
SAID += [(drawn(one), words) for one, words in [*NO_DISTRIBUTIONS, *DRAWN]]


@pytest.mark.parametrize(("scene", "words"), SAID, ids=[words[:40] for _, words in SAID])
def test_what_is_said(
    scene: Scene, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    try:
        assert scene(tmp_path) == 2
        [line] = capsys.readouterr().err.splitlines()
    except LieRigidBodyError as error:
        line = str(error)
    assert words in line
    assert len(line) <= LONGEST_LINE


def standing(**given: Any) -> Any:
    """An estimator that is compared, of which nothing is told but what is given."""
    entry = Contender("tuned", "a:b", parameters={"gain": 1.0}, grid={"gain": [0.1, 1.0]})
    nothing: dict[str, Any] = {"points": (), "reason": "", "covariance": None, "gyro_bias": None}
    return SimpleNamespace(name="tuned", entry=entry, runs=np.arange(4), **{**nothing, **given})


def sentences(**given: Any) -> list[str]:
    """What is told below the table of estimators that are compared."""
    nothing = {"differences": (), "standings": (), "best": None, "has_covariances": False, "independent": True}
    compared: Any = SimpleNamespace(**{**nothing, **given})
    return [*campaign_scores._sentences(compared)]


HONEST: Any = SimpleNamespace(message="it is honest", covered="95 % are below it")
POINTS: Any = [
    SimpleNamespace(mean_deg=1.0, failures=0, reason=""),
    SimpleNamespace(mean_deg=2.0, failures=2, reason="x"),
]
SENTENCES: dict[str, Callable[[], list[str]]] = {
    "tuned: gain is best at the end of its grid: try larger ones than 1.": lambda: sentences(
        standings=[standing(points=POINTS)]
    ),
    "tuned: 1 of 2 points failed in runs of even number, first: x": lambda: sentences(
        standings=[standing(points=POINTS)]
    ),
    "The sensors of run 3 leave a filter 0.5° at best, over many such runs. In that run the errors are so many times "
    "as large: tuned 4.": lambda: sentences(
        best=SimpleNamespace(run=3, rms_deg=0.5), standings=[standing(scores={"total_rms_deg": np.full(4, 2.0)})]
    ),
    "The verdicts on covariances hold for these very sensors: gyro_scale_factor is the same in every run; vary what a "
    "filter counts as unknown.": lambda: sentences(
        has_covariances=True, standings=[standing(covariance=HONEST)], fixed_constants=["gyro_scale_factor"]
    ),
}
"""What is told of estimators that are compared, beside their differences."""


@pytest.mark.parametrize("said", SENTENCES)
def test_what_is_told_of_estimators(said: str) -> None:
    assert said in SENTENCES[said]()
