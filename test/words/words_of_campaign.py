"""What campaigns say where they refuse or fail, and of estimators that they compare."""
# mypy: ignore-errors

from __future__ import annotations

import argparse
import math
import os
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.comparison import Point
from lie_rigid_body.campaign.definition import EstimatorSpec
from lie_rigid_body.campaign.distributions import Uniforms, distribution
from lie_rigid_body.campaign.results import Results
from lie_rigid_body.campaign.run import Row, carry_out
from lie_rigid_body.cli import campaign_runs
from lie_rigid_body.evaluation.differences import of_pairs, of_runs
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.report import campaign_scores

SHORT = "runs: 1\nseed: 1\nduration: 1.0\n"
ONE = Campaign(1, 1, 1.0)
CAMPAIGNS = [
    "runs: 0\nseed: 1\nduration: 1.0",
    "runs: 1\nseed: -1\nduration: 1.0",
    "runs: 1\nseed: 1\nduration: .inf",
    "runs: 1\nseed: 1",
    "runs: 9\nseed: 1\nduration: 1.0\nvary: {rate: {distribution: choice, values: [1.0, -1.0]}}",
    "[]",
    "{",
]
"""Whole files."""
MORE = [
    "varies: {}",
    "scenario: none",
    "scenario: 5",
    "scenario: [x]",
    "parameters: {world_frame: !!binary aGk=}",
    "vary: {speed: {distribution: run}}",
    "vary: {rate: 3.0}",
    "vary: {record_path: {distribution: choice, values: [a.mcap, b.mcap]}}",
    "vary: {paused: {distribution: choice, values: [true]}}",
    "parameters: {record_path: a.mcap}",
    "parameters: {rate: -3.0}",
    "vary: {initial_body_rate: {distribution: direction, norm: -1}}",
    "parameters: {rate: 3.0}\nvary: {rate: {distribution: run}}",
    "estimator: math",
    "estimator: 'nowhere.at:all'",
    "estimator: math:pi",
    "estimators: 5",
    "estimator: 'math:sin'\nestimators: {a: {command: ls}}",
    "estimators: {'': {command: ls}}",
    "estimators: {a: 'math:sin'}",
    "estimators: {a: {gain: 1}}",
    "estimators: {a: {}}",
    "estimators: {a: {function: math}}",
    "estimators: {a: {function: 'no:such'}}",
    "estimators: {a: {command: ls, grid: {x: [1]}}}",
    "estimators: {a: {command: ''}}",
    "estimators: {a: {command: a 'b}}",
    "estimators: {a: {command: no_such}}",
    "estimators: {a: {function: 'a:b', grid: {x: []}}}",
    "estimators: {a: {function: 'a:b', parameters: [1]}}",
    "estimators: {a: {function: 'a:b', parameters: {x: 1}, grid: {x: [1]}}}",
    "estimators: {a: {function: 'a:b', parameters: {x: .nan}}}",
    "estimators: {a: {function: 'a:b', parameters: {x: !!binary aGk=}}}",
    "estimators: {a: {function: 'a:b', grid: {x: [1]}}}",
    "estimators: {a: {function: 'statistics:quantiles', parameters: {methods: 1}}}",
    "estimators: {a: {function: 'bisect:bisect'}}",
    "estimator: 'bisect:bisect'",
    "gives: [initial_body_rate]",
    f"estimators: {{a: {{function: 'a:b', grid: {{x: {[*range(101)]}}}}}}}",
]
"""What is wrong below the number of runs, the seed and the duration."""
DISTRIBUTIONS = [
    3.0,
    {"distribution": "cauchy"},
    {"distribution": "uniform", "low": 1.0},
    {"distribution": "uniform", "low": 1.0, "high": 2.0, "mean": 3.0},
    {"distribution": "run", "low": 1.0},
    {"distribution": "uniform", "low": 2.0, "high": 1.0},
    {"distribution": "uniform", "low": -1e308, "high": 1e308},
    {"distribution": "uniform", "low": 0, "high": 10**400},
    {"distribution": "uniform", "low": "a", "high": 1.0},
    {"distribution": "uniform", "low": 0, "high": math.inf},
    {"distribution": "loguniform", "low": 0.0, "high": 1.0},
    {"distribution": "normal", "mean": 0.0, "std": -1.0},
    {"distribution": "choice", "values": []},
    {"distribution": "box", "edges": [1, 1, 1]},
    {"distribution": "box", "mass": 1, "density": 1, "edges": [1, 1, 1]},
    {"distribution": "box", "mass": 1, "edges": [1, 1]},
    {"distribution": "direction", "norm": [1, 2, 3]},
    {"distribution": "direction", "norm": {"distribution": "none"}},
    {"distribution": "direction", "norm": {"distribution": "uniform_rotation"}},
    {"distribution": "box", "mass": 1.0, "edges": [[-1.0, -0.5], 1.0, 1.0]},
    {"distribution": "direction", "norm": -1},
    {"distribution": "direction", "norm": {"distribution": "choice", "values": ["a"]}},
    {"distribution": "direction", "norm": {"distribution": "choice", "values": [math.inf]}},
    {"distribution": "random_kicks", "interval": 0},
    {"distribution": "random_kicks", "interval": [1, 2]},
]


def campaign(text=SHORT, **options):
    """The verb with a campaign file of such a text; it makes no folder where it refuses."""
    Path("campaign.yaml").write_text(text)
    given = {"out": "out", "no_bags": False, "report": None, "force": False, "workers": None, "scheduler": None}
    try:
        campaign_runs.run_campaign(argparse.Namespace(campaign="campaign.yaml", **{**given, **options}))
    finally:
        assert not Path("out").exists()


def begun(campaign=ONE, folder="out"):
    return Results(campaign, Path(folder))


def of_another():
    begun().add(Row(0))
    begun(Campaign(1, 2, 1.0))


def of_others():
    Path("precious").touch()
    begun(folder=".")


def at_work():
    first = begun()
    try:
        begun()
    finally:
        first.held.close()


def no_folder():
    Path("out").touch()
    begun()


def damaged():
    begun().add(Row(0))
    Path("out/runs/000000.json").write_text("nonsense")
    begun().write_table()


def taken_away():
    results = begun()
    Path("out").rename("elsewhere")
    results.add(Row(0))


def failed():
    many = Campaign(runs=40, seed=1, duration=0.02)
    results = begun(many)
    Path("out/bags/000002.mcap").mkdir()
    try:
        carry_out(many, 2, Path("out"), keep=True)
    except LieRigidBodyError as error:
        raise campaign_runs._failure(many, results, {2: error}) from None


def without_a_score(reason):
    campaign_runs._require_scores(Campaign(1, 1, 1.0, estimator="a:b"), [[reason]], "any run")


def table_of_another():
    Path("runs.parquet").write_text("other")
    Campaign.from_table("runs.parquet")


def no_table():
    os.mkfifo("runs.parquet")
    Campaign.from_table("runs.parquet")


def drawn(one):
    """Draw from a distribution, if it is one."""
    return distribution("vary.x", one)(Uniforms(0, 0, "x"))


REFUSED = {
    LieRigidBodyError: [
        *(lambda text=text: campaign(text) for text in CAMPAIGNS),
        *(lambda more=more: campaign(SHORT + more) for more in MORE),
        *(lambda one=one: drawn(one) for one in DISTRIBUTIONS),
        lambda: campaign(out="none/out"),
        of_another,
        at_work,
        of_others,
        no_folder,
        damaged,
        taken_away,
        failed,
        lambda: without_a_score("a:b is lost"),
        lambda: without_a_score("a:b is lost: correct it"),
        table_of_another,
        no_table,
        lambda: Campaign.from_table("."),
        lambda: Campaign.from_table("none"),
        lambda: Campaign.from_table("\ud800"),
        lambda: Campaign(3, 1, 1.0).drawn(3),
    ],
}


def summary(**given):
    """An estimator that is compared, of which nothing is told but what is given."""
    entry = EstimatorSpec("tuned", "a:b", parameters={"gain": 1.0}, grid={"gain": [0.1, 1.0]})
    nothing = {
        "points": (),
        "reason": "",
        "covariance": None,
        "gyro_bias": None,
        "bias_claimed_exact": 0,
        "failed": np.zeros(4, dtype=bool),
    }
    return SimpleNamespace(name="tuned", entry=entry, runs=np.arange(4), **{**nothing, **given})


def compared(**given):
    """What is told below the table of estimators that are compared."""
    nothing = {"differences": (), "summaries": (), "bound": None, "has_covariances": False, "independent": True}
    return "\n".join(campaign_scores._sentences(SimpleNamespace(**{**nothing, **given})))


HONEST = SimpleNamespace(message="it is honest", covered="95 % are below it")
POINTS = [
    Point({"gain": 1.0}, 1.0, 0, ""),
    Point({"gain": 0.1}, 2.0, 2, "x", of_runs(np.linspace(1.0, 1.2, 9), np.full(9, 2.0))),
]
ALIKE = [POINTS[0], replace(POINTS[1], difference=of_runs(np.linspace(1.0, 1.2, 9), np.full(9, 1.1)), failures=0)]
BEST = SimpleNamespace(run=3, rms_deg=0.5)


def pairs(names, runs, failed=False):
    """What is said beside the matrix of the pairs of some names."""
    summaries = [SimpleNamespace(name=name, failed=np.array([failed])) for name in names]
    found = of_pairs([(np.ones(runs), np.ones(runs))] * (len(names) * (len(names) - 1) // 2))
    differences = [(*pair, one) for pair, one in zip(combinations(summaries, 2), found, strict=True)]
    *_, last = campaign_scores._pairs(SimpleNamespace(summaries=summaries, differences=differences))
    return "\n".join(last.lines)


TWICE = {"total_rms_deg": np.full(4, 2.0)}
SAID = [
    lambda: compared(summaries=[summary(points=POINTS)]),
    lambda: compared(summaries=[summary(points=ALIKE)]),
    lambda: pairs("ab", 9),
    lambda: pairs("abc", 9, failed=True),
    lambda: pairs("abcd", 7),
    lambda: compared(summaries=[summary(bias_claimed_exact=3)]),
    lambda: compared(bound=BEST, summaries=[summary(scores=TWICE)]),
    lambda: compared(has_covariances=True, summaries=[summary(covariance=HONEST)]),
]
