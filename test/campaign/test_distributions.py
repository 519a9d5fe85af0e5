"""Parameters are drawn from the distributions that are named, and depend on seed, run and name alone."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import tplquad

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.distributions import Uniforms, distribution
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.lie import quaternion

COUNT = 2000
LEAST_P = 1e-4
"""Of the Kolmogorov–Smirnov test: the draws are the same in every run, so it fails always or never."""


def drawn(name: str = "x", count: int = COUNT, **given: object) -> np.ndarray:
    draw = distribution("vary.x", given)
    return np.array([draw(Uniforms(5, run, name)) for run in range(count)])


@pytest.mark.parametrize(
    ("given", "law"),
    [
        ({"distribution": "uniform", "low": -2.0, "high": 3.0}, stats.uniform(-2.0, 5.0)),
        ({"distribution": "loguniform", "low": 1e-5, "high": 1e-3}, stats.loguniform(1e-5, 1e-3)),
        ({"distribution": "normal", "mean": 4, "std": 0.5}, stats.norm(4.0, 0.5)),
    ],
)
def test_numbers_follow_their_law(given: dict[str, Any], law: Any) -> None:
    assert stats.kstest(drawn(**given), law.cdf).pvalue > LEAST_P


def test_logarithms_are_uniform_also_where_the_quotient_of_the_limits_is_no_double() -> None:
    exponents = np.log10(drawn(distribution="loguniform", low=1e-300, high=1e300))
    assert stats.kstest(exponents, stats.uniform(-300.0, 600.0).cdf).pvalue > LEAST_P


def test_rotations_are_uniform() -> None:
    """The half angle θ/2 of a uniform rotation has the density (4/π) sin²; every component is distributed alike."""
    q = drawn(distribution="uniform_rotation")
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, rtol=1e-15)
    half = np.arccos(np.clip(np.abs(q[:, 3]), 0.0, 1.0))
    assert stats.kstest(half, lambda x: (4.0 / math.pi) * (x / 2.0 - np.sin(2.0 * x) / 4.0)).pvalue > LEAST_P
    for vector in np.eye(3):
        assert stats.kstest(quaternion.rotate(q, vector)[:, 1], stats.uniform(-1.0, 2.0).cdf).pvalue > LEAST_P


def test_directions_are_uniform_and_norms_as_drawn() -> None:
    v = drawn(distribution="direction", norm={"distribution": "uniform", "low": 0.5, "high": 2.0})
    norms = np.linalg.norm(v, axis=1)
    assert stats.kstest(norms, stats.uniform(0.5, 1.5).cdf).pvalue > LEAST_P
    for axis in range(3):
        assert stats.kstest(v[:, axis] / norms, stats.uniform(-1.0, 2.0).cdf).pvalue > LEAST_P


def test_choices_are_all_made_equally_often() -> None:
    values = [1.5, "word", [1, 2, 3]]
    found = [str(value) for value in map(distribution("x", {"distribution": "choice", "values": values}), many())]
    counts = [found.count(str(value)) for value in values]
    assert sum(counts) == COUNT
    assert stats.chisquare(counts).pvalue > LEAST_P


def many() -> list[Uniforms]:
    return [Uniforms(5, run, "x") for run in range(COUNT)]


def moments_of(density: float, bounds: Any, jacobian: Any, point: Any) -> list[float]:
    """Moments about x, y and z of a body, as integrals over three coordinates of its points."""

    def integrand(*at: float, axis: int) -> float:
        xyz = np.array(point(*at))
        return float(density * jacobian(*at) * (xyz @ xyz - xyz[axis] ** 2))

    return [tplquad(partial(integrand, axis=axis), *bounds)[0] for axis in range(3)]


def test_bodies_have_the_moments_of_their_integrals() -> None:
    a, b, c = edges = (0.2, 0.3, 0.5)
    [box] = drawn(count=1, distribution="box", density=700.0, edges=list(edges))
    bounds = (-a / 2, a / 2, -b / 2, b / 2, -c / 2, c / 2)
    assert box == pytest.approx(moments_of(700.0, bounds, lambda z, y, x: 1.0, lambda z, y, x: (x, y, z)), rel=1e-12)
    [by_mass] = drawn(count=1, distribution="box", mass=700.0 * a * b * c, edges=list(edges))
    assert by_mass == pytest.approx(box, rel=1e-15)
    radius, height = 0.4, 0.7
    [cylinder] = drawn(count=1, distribution="cylinder", density=900.0, radius=radius, height=height)
    bounds = (0.0, radius, 0.0, 2.0 * math.pi, -height / 2, height / 2)
    found = moments_of(900.0, bounds, lambda z, t, r: r, lambda z, t, r: (r * math.cos(t), r * math.sin(t), z))
    assert cylinder == pytest.approx(found, rel=1e-10)


def test_edges_stay_in_their_ranges() -> None:
    a = np.array([[0.1, 0.3], [0.2, 0.2], [0.1, 0.4]])
    moments = drawn(distribution="box", mass=12.0, edges=a.tolist())
    squares = (np.sum(moments, axis=1)[:, np.newaxis] / 2.0) - moments  # a², b², c²
    assert (np.sqrt(squares) > a[:, 0] - 1e-12).all()
    assert (np.sqrt(squares) < a[:, 1] + 1e-12).all()


def test_what_is_drawn_depends_on_seed_run_and_name() -> None:
    draw = distribution("x", {"distribution": "uniform", "low": 0.0, "high": 1.0})
    keys = [(seed, run, name) for seed in (0, 1, 2**64 - 1) for run in (0, 1, 999_999) for name in ("rate", "inertia")]
    assert len({draw(Uniforms(*key)) for key in keys}) == len(keys)
    assert [draw(Uniforms(*key)) for key in keys] == [draw(Uniforms(*key)) for key in keys]
    assert draw(Uniforms(7, 0, "rate")) == FIRST_OF_SEED_7


FIRST_OF_SEED_7 = 0.289175079078131
"""Written down once: it must be the same with every version of every library."""


def test_the_run_is_its_number() -> None:
    assert drawn(count=5, distribution="run").tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("run", [-1, 3, 10**30, "x", "1", 1.5, 1.0, None, True, np.bool_(False), np.int64(3), math.nan])
def test_a_run_that_there_is_not_is_refused(run: Any) -> None:
    campaign = Campaign(runs=3, seed=7, duration=1.0, vary={"sensor_seed": {"distribution": "run"}})
    for refuse in (campaign.scenario_of, campaign.drawn):
        with pytest.raises(InputError):
            refuse(run)


@pytest.mark.parametrize("kind", [np.int64, np.int32, np.uint8])
def test_the_number_of_a_run_may_be_one_of_numpy(kind: Any) -> None:
    vary = {"sensor_seed": {"distribution": "run"}, "rate": {"distribution": "uniform", "low": 1.0, "high": 9.0}}
    campaign = Campaign(runs=3, seed=7, duration=1.0, vary=vary)
    assert campaign.scenario_of(kind(2)) == campaign.scenario_of(2)
    assert type(campaign.drawn(kind(2))["sensor_seed"]) is int


def test_lengths_may_be_drawn_as_integers_and_a_norm_may_be_0() -> None:
    [moments] = drawn(count=1, distribution="box", mass={"distribution": "choice", "values": [12]}, edges=[1, 1, 1])
    assert moments == pytest.approx([2.0, 2.0, 2.0])
    assert not drawn(count=1, distribution="direction", norm=0).any()


def test_numbers_of_numpy_are_those_of_python() -> None:
    of_numpy: dict[str, Any] = {"runs": np.int64(3), "seed": np.uint64(2**64 - 1), "duration": np.float32(0.5)}
    campaign = Campaign(**of_numpy)
    own = Campaign(runs=3, seed=2**64 - 1, duration=0.5)
    assert campaign == own
    assert campaign.to_json() == own.to_json()
    assert campaign.exact_duration == own.exact_duration
    refused: list[dict[str, Any]] = [{"runs": np.bool_(True)}, {"runs": np.float64(3.0)}, {"seed": np.int64(-1)}]
    for given in refused:
        with pytest.raises(InputError):
            Campaign(**{**of_numpy, **given})
