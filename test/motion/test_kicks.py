"""Kicked motions against proved enclosures, arc by arc, and the kicks that parameters give."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lie_rigid_body import RigidBody, State
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.motion.closed_form import kicked
from lie_rigid_body.motion.closed_form.rotation import rotation_of
from lie_rigid_body.motion.kicks import Kicks
from lie_rigid_body.scenario import Scenario

MOTIONS = ["closed_form", "moving_chart"]
TENSOR = [1.0, 0.1, -0.05, 1.6, 0.2, 2.1]


def kicked_scenario(seed: int, count: int, **parameters: object) -> Scenario:
    """Kicks at random times to random rates, of which some are rests."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.05, 3.0, count))
    rates = rng.normal(size=(count, 3)) * rng.choice([0.0, 0.3, 3.0], (count, 1))
    return Scenario.from_parameters(
        {
            "inertia": TENSOR if seed % 2 else [1.0, *rng.uniform(1.0, 1.6, 2)],
            "initial_attitude_xyzw": quaternion.normalize(rng.normal(size=4)),
            "initial_body_rate": rng.normal(size=3),
            "kicks": np.column_stack([times, rates]).ravel(),
            **parameters,
        }
    )


def truth_of(scenario: Scenario, last_ns: int) -> Any:
    proof = pytest.importorskip("lie_rigid_body.proof.kicked", reason="python-flint is not installed")
    times, rates = scenario.kick_schedule().until(last_ns)
    begins = [0, *times.tolist()]
    return proof.EnclosedMotion(
        scenario.inertia, scenario.initial_attitude_xyzw, begins, [scenario.initial_body_rate, *rates]
    )


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("seed", range(2))
def test_kicked_motions_are_the_truth_to_round_off(seed: int, motion: str) -> None:
    scenario = kicked_scenario(seed, 150, motion=motion)
    kicks = scenario.kick_schedule()
    rng = np.random.default_rng(seed)
    t_ns = np.sort(np.append(kicks.t_ns[::30], rng.integers(0, int(kicks.t_ns[-1]) + 10**9, 40)))
    states = scenario.make_motion().at(t_ns)
    truth = truth_of(scenario, int(t_ns[-1]))
    for i, t in enumerate(t_ns.tolist()):
        limit = 2e-15 + 1e-17 * int(kicks.arcs(t_ns[i]))
        true = truth.at(t)
        assert true.attitude_error(states.attitude_xyzw[i])[1] < limit
        assert true.rate_error(states.body_rate[i])[1] <= limit * np.linalg.norm(scenario.rate_bound())
        assert sum(x * y for x, y in zip(true.attitude_xyzw, states.attitude_xyzw[i].tolist(), strict=True)) > 0


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_kick_keeps_the_attitude_and_sets_the_rate(motion: str) -> None:
    scenario = Scenario(kicks=[1.5, 0.3, -2.0, 0.1, 2.5, 0.0, 0.0, 0.0], motion=motion)
    before, at, resting, later = (
        scenario.make_motion().at(t) for t in (1_499_999_999, 1_500_000_000, 2 * 10**9, 10**10)
    )
    np.testing.assert_allclose(at.attitude_xyzw, before.attitude_xyzw, rtol=0, atol=1e-8)
    assert at.body_rate.tolist() == [0.3, -2.0, 0.1]
    assert resting.body_rate.any()
    assert not later.body_rate.any()
    assert (later.attitude_xyzw == scenario.make_motion().at(2_500_000_000).attitude_xyzw).all()


def test_any_order_of_times_gives_the_same_bits() -> None:
    scenario = kicked_scenario(3, 40, kick_period=100.0)
    t_ns = np.random.default_rng(1).integers(-(10**9), 5 * 10**11, 300)
    together = scenario.exact_motion().at(t_ns)
    order = np.argsort(t_ns)
    in_order = kicked_scenario(3, 40, kick_period=100.0).exact_motion().at(t_ns[order])
    assert (together.attitude_xyzw[order] == in_order.attitude_xyzw).all()
    assert (together.body_rate[order] == in_order.body_rate).all()
    one_by_one = [scenario.exact_motion().at(int(t)).attitude_xyzw for t in t_ns[:20]]
    assert (together.attitude_xyzw[:20] == one_by_one).all()


def test_a_question_costs_a_thousand_arcs_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    kicks = Kicks.of([0.5, 0.3, 1.0, 0.2], 1.0)
    motion = kicked.KickedClosedForm(kicks, RigidBody([1.0, 2.0, 3.0]), State([0, 0, 0, 1], [0.1, 0.2, 0.3]))
    counted: list[int] = []

    def counting(inertia: Any, body_rate: Any, t_ns: int) -> Any:
        counted.append(t_ns)
        return rotation_of(inertia, body_rate, t_ns)

    monkeypatch.setattr(kicked, "KEPT_STARTS", 20)
    monkeypatch.setattr(kicked, "rotation_of", counting)
    motion.at(100 * 10**9)
    assert len(counted) == 100
    motion.at(10**9)
    counted.clear()
    motion.at(95 * 10**9)
    assert len(counted) == 15


@pytest.mark.parametrize("motion", MOTIONS)
def test_pieces_of_a_motion_are_the_whole(motion: str) -> None:
    scenario = kicked_scenario(5, 20, motion=motion)
    t_ns = np.arange(0, 30 * 10**9, 10**7)
    whole = scenario.make_motion().at(t_ns)
    pieces = scenario.make_motion()
    parts = [pieces.at(some) for some in np.array_split(t_ns, 17)]
    assert (np.concatenate([part.attitude_xyzw for part in parts]) == whole.attitude_xyzw).all()
    assert (np.concatenate([part.body_rate for part in parts]) == whole.body_rate).all()


def test_kicks_come_again_after_their_period() -> None:
    kicks = Kicks.of([1.0, 1.0, 0.0, 0.0, 2.0, 0.0, 1.0, 0.0], 4.0)
    times, rates = kicks.until(10 * 10**9)
    assert (times / 1e9).tolist() == [1.0, 2.0, 5.0, 6.0, 9.0, 10.0]
    assert (rates[:, 1] == [0.0, 1.0] * 3).all()
    assert kicks.arcs(np.array([-1, 0, 999_999_999, 10**9, 4 * 10**9, 5 * 10**9])).tolist() == [0, 0, 0, 1, 2, 3]
    assert [kicks.begin_ns(arc) for arc in range(4)] == kicks.begins_ns(np.arange(4)).tolist()


@pytest.mark.parametrize(
    ("given", "name", "told"),
    [
        ({"kicks": [1.0, 0.0, 0.0]}, "kicks", "multiple of 4"),
        ({"kicks": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]}, "kicks", "kick 2"),
        ({"kicks": [0.0, 0.0, 0.0, 0.0]}, "kicks", "above 0"),
        ({"kicks": [4e-10, 0.0, 0.0, 0.0]}, "kicks", "above 0"),
        ({"kicks": [-1.0, 0.0, 0.0, 0.0]}, "kicks", "-1"),
        ({"kicks": [5e9, 0.0, 0.0, 0.0]}, "kicks", "at most"),
        ({"kicks": [1.0, np.inf, 0.0, 0.0]}, "kicks", "finite"),
        ({"kicks": [1.0, 1e200, 0.0, 0.0]}, "kicks", "beyond double precision"),
        ({"kicks": [1.0, 0.0, 0.0, 0.0] * 1001}, "kicks", "4000"),
        ({"kicks": [1.0, 0.0, 0.0, 0.0], "kick_period": 1.0}, "kick_period", "longer"),
        ({"kick_period": -1.0}, "kick_period", "outside"),
        ({"kicks": [1e-9, 0.0, 0.0, 0.0], "kick_period": 2e-9}, "kick_period", "between two samples"),
        ({"sway_band": [2.0, 1.0]}, "sway_band", "no band"),
        ({"sway_band": [0.0, 1.0]}, "sway_band", "outside"),
        ({"sway_band": [1e-9, 1e-9]}, "sway_band", "outside"),
        ({"vibration_band": [0.0, 1.0]}, "vibration_band", "outside"),
        ({"sway_acceleration": [1.0, -1.0, 0.0]}, "sway_acceleration", "outside"),
        ({"vibration_acceleration": [1.0, -1.0, 0.0]}, "vibration_acceleration", "outside"),
        ({"translation": "thrown up"}, "translation", "unknown"),
    ],
)
def test_what_cannot_be_is_refused(given: dict[str, object], name: str, told: str) -> None:
    with pytest.raises(ParameterError, match=told) as error:
        Scenario.from_parameters(given)
    assert error.value.name == name


def test_what_has_no_effect_is_told() -> None:
    sentences = Scenario(kick_period=3.0, sway_acceleration=[1.0, 0.0, 0.0], initial_velocity=[0.0, 1.0, 0.0])
    assert [sentence.split()[0] for sentence in sentences.without_effect] == [
        "kick_period",
        "sway_acceleration",
        "initial_velocity",
    ]
