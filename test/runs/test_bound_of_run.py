"""The bound of a run: from the scenario alone, thinned for a score, beside the estimate wherever a score is shown."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from lie_rigid_body import InputError
from lie_rigid_body.evaluation.cramer_rao_bound import BiasNoise, NoisySensors, VectorReadings, cramer_rao_bound
from lie_rigid_body.evaluation.score import BoundComparison
from lie_rigid_body.lie import quaternion
from lie_rigid_body.report import scores, write_plot, write_report
from lie_rigid_body.runs.bound import cramer_rao_bound_of, sensor_limits
from untyped import simulate

GIVEN: dict[str, Any] = {
    "imu_rate": 50.0,
    "magnetometer_rate": 25.0,
    "accelerometer_mode": "pivot_gravity",
    "motion": "closed_form",
}


@pytest.fixture(scope="module")
def run() -> Any:
    return simulate("tumbling_cubesat", duration=10.0, sensor_grade="mems", **GIVEN)


def estimate(run: Any, size_deg: float) -> np.ndarray:
    turn = np.radians(size_deg) * np.random.default_rng(1).normal(size=(len(run.imu.t_ns), 3))
    return quaternion.multiply(run.attitude().at(run.imu.t_ns), quaternion.exp(turn))


def test_the_bound_is_that_of_the_declared_noise(run):
    value = run.scenario.parameters()
    number = {name: float(entry) for name, entry in value.items() if isinstance(entry, int | float)}
    root = np.sqrt(50.0)

    def walk(sensor: str) -> BiasNoise:
        return BiasNoise(number[f"{sensor}_turn_on_bias"], number[f"{sensor}_bias_random_walk"] / root)

    t_ns = run.imu.t_ns
    up, field = np.array([0.0, 0.0, number["gravity"]]), np.array(value["magnetic_field"])
    iron = float(np.abs(value["magnetometer_hard_iron"]).max())
    vectors = [
        VectorReadings(t_ns, up, number["accelerometer_noise_density"] * root, walk("accelerometer")),
        VectorReadings(t_ns[::2], field, number["magnetometer_noise_density"] * 5.0, BiasNoise(iron)),
    ]
    sensors = NoisySensors(number["gyro_noise_density"] * root, walk("gyro"), vectors)
    wanted = cramer_rao_bound(t_ns, run.attitude().at(t_ns), sensors)
    unknown = run.cramer_rao_bound()
    found = unknown.calibrated
    np.testing.assert_array_equal(found.stamps_ns, t_ns)
    assert (np.trace(unknown.smoothed - found.smoothed, axis1=1, axis2=2) > 0.0).all()
    np.testing.assert_allclose(found.filtered, wanted.filtered, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(found.smoothed, wanted.smoothed, rtol=1e-6, atol=1e-12)


TRACKER: dict[str, Any] = {
    "magnetometer_rate": 0.0,
    "attitude_sensor_rate": 1.0,
    "attitude_sensor_cross_boresight_noise": 1e-4,
    "attitude_sensor_roll_noise": 1e-3,
}


@pytest.mark.parametrize("given", [{}, {"sun_sensor_rate": 0.5, "sun_sensor_noise": 1e-3}, TRACKER])
def test_thinned_it_is_within_two_percent(given):
    """At 3 rad/s: most of a filter's error is in its first second, and with a slow sensor between readings."""
    sensors: dict[str, Any] = {**GIVEN, "imu_rate": 20.0, "magnetometer_rate": 10.0, "sensor_grade": "mems", **given}
    run = simulate(duration=0.2, initial_body_rate=[0.01, 3.0, 0.01], **sensors)
    last = int(run.t_ns[0]) + 150 * 10**9
    whole, thinned = (cramer_rao_bound_of(run.segments, last, most) for most in (10_000, 1000))  # type: Any, Any
    assert len(thinned.stamps_ns) < 0.5 * len(whole.stamps_ns)
    at_all, at_some = (BoundComparison.of(bound, whole.stamps_ns, 1.0) for bound in (whole, thinned))
    pairs: Any = ((at_all.filtered, at_some.filtered), (at_all.smoothed, at_some.smoothed))
    for wanted, found in pairs:
        names = ("rms", "median", "p95", "final")
        assert [getattr(found, name) / getattr(wanted, name) for name in names] == pytest.approx([1.0] * 4, abs=0.02)


def test_the_bound_of_a_score_is_that_of_all_readings_over_minutes_of_fast_turns():
    given: dict[str, Any] = {**GIVEN, "rate": 10.0, "imu_rate": 10.0, "magnetometer_rate": 10.0, "sensor_grade": "mems"}
    run = simulate(duration=180.0, initial_body_rate=[0.01, 3.0, 0.01], **given)
    best, whole = run.score(run.truth.attitude_xyzw, run.t_ns).best, run.cramer_rao_bound()
    assert best.filtered.rms == pytest.approx(np.degrees(whole.rms(whole.filtered)), rel=0.02)


def test_a_reset_begins_anew(run):
    segment = run.segments[0]
    later = type(segment)(segment.scenario, 100, segment.clock().stamp_ns(100))
    found: Any = cramer_rao_bound_of((segment, later), int(run.t_ns[-1]), 50)
    first = int(np.searchsorted(found.stamps_ns, later.start_ns))
    trace = np.trace(found.filtered, axis1=1, axis2=2)
    assert trace[first] > 5.0 * trace[first - 1]


@pytest.mark.parametrize(
    "given",
    [
        {"imu_rate": 0.0},
        {"sensor_grade": "perfect"},
        {"accelerometer_noise_density": 0.0},
        {"imu_orientation": True, "imu_heading_noise": 0.1},
        {"attitude_sensor_rate": 1.0},
        {"gyro_noise_density": 1e-60},
        {"gravity": 1e-300},
        {"accelerometer_noise_density": 1e-18},
        {"attitude_sensor_rate": 1.0, "attitude_sensor_cross_boresight_noise": 1e-15},
        {"magnetic_field": [1e-162, 0.0, 0.0]},
    ],
)
def test_without_noise_there_is_none(given):
    run = simulate("tumbling_cubesat", duration=0.2, **{"sensor_grade": "mems", **GIVEN, **given})
    assert sensor_limits(run.segments, run.attitude(), int(run.t_ns[-1])).bound is None


@pytest.mark.filterwarnings("error")
def test_a_vector_that_is_all_but_0_or_readings_without_end_leave_a_score_without_a_bound(run):
    dark = simulate("tumbling_cubesat", duration=1.0, sensor_grade="mems", **GIVEN, magnetic_field=[1e-300, 0.0, 0.0])
    with pytest.raises(InputError, match=r"3\.35e\+293"):
        dark.cramer_rao_bound()
    assert dark.score(estimate(dark, 1.0)).best is None
    segment = run.segments[0]
    fast = type(segment)(segment.scenario.resampled(rate=50.0), 0, 0)
    with pytest.raises(InputError, match=r"2\.16e\+07"):
        cramer_rao_bound_of([fast], 80 * 3600 * 10**9, 50)


def test_every_sensor_helps(run):
    bounds = []
    more = {**TRACKER, "magnetometer_rate": 25.0, "sun_sensor_noise": 1e-3}
    for sun, attitude in ((0.0, 0.0), (10.0, 0.0), (10.0, 2.0)):
        given = {**GIVEN, **more, "sun_sensor_rate": sun, "attitude_sensor_rate": attitude}
        same = simulate("tumbling_cubesat", duration=2.0, sensor_grade="mems", **given)
        found: Any = cramer_rao_bound_of(same.segments, int(same.t_ns[-1]), 50)
        bounds.append(found.rms(found.smoothed))
    assert bounds[0] > bounds[1] > bounds[2] > 0.0


def test_it_stands_beside_the_estimate(run, tmp_path):
    score = run.score(estimate(run, 1.0))
    assert not score.best.beaten
    lines = str(score).splitlines()
    kinds = ("filter", "smoother", "calibrated filter", "calibrated smoother", "dynamic filter", "dynamic smoother")
    named = [f"bound, {kind}" for kind in kinds]
    assert [line.split("  ")[0] for line in lines[1:10]] == ["total", "heading", "inclination", *named]
    content = score.to_dict(series=True)
    assert content["cramer_rao_bound"]["filtered_deg"]["rms"] == score.best.filtered.rms
    calibrated = content["cramer_rao_bound"]["calibrated"]
    assert 0.0 < calibrated["filtered_deg"]["rms"] < content["cramer_rao_bound"]["filtered_deg"]["rms"]
    assert calibrated["calibrated"] is None
    dynamic = content["cramer_rao_bound"]["dynamic"]
    assert 0.0 < dynamic["smoothed_deg"]["rms"] < calibrated["smoothed_deg"]["rms"]
    assert (dynamic["calibrated"], dynamic["dynamic"], dynamic["beaten"]) == (None, None, False)
    assert len(content["series"]["cramer_rao_bound_deg"]) == score.samples
    write_plot(score, tmp_path / "errors.png")
    write_report(score, tmp_path / "errors.html")
    assert (tmp_path / "errors.png").read_bytes().startswith(b"\x89PNG")
    page = (tmp_path / "errors.html").read_text(encoding="utf-8")
    assert f"{score.best.filtered.rms:.3g}°" in page
    assert "Cramér–Rao bound" in page


def test_no_line_is_drawn_where_there_are_no_estimates(run, monkeypatch):
    drawn = []
    monkeypatch.setattr("matplotlib.axes.Axes.plot", lambda axes, t, y, **_: drawn.append((t, y)))
    monkeypatch.setattr("matplotlib.axes.Axes.legend", lambda axes, **_: None)
    t_ns = run.imu.t_ns
    kept = (t_ns < t_ns[0] + 2_000_000_000) | (t_ns > t_ns[0] + 3_000_000_000)
    score = run.score(run.attitude().at(t_ns[kept]), t_ns[kept])
    scores.draw("a gap", score)
    for t, error in drawn:
        [gap] = np.flatnonzero(np.isnan(t))
        assert t[gap - 1] < 2.0
        assert t[gap + 1] > 3.0
        assert np.array_equal(np.isnan(t), np.isnan(error))


def test_an_estimate_that_has_seen_the_truth_is_remarked_and_no_other(run):
    seen = run.score(estimate(run, 1e-4), diagnosed=True)
    assert seen.best.beaten
    assert "has seen the truth" in str(seen)
    assert seen.findings == ()
    smallest = seen.best.dynamic.smoothed.rms
    for error in (0.3, 0.5 * smallest):  # errors of independent samples: √3 times this
        assert run.score(estimate(run, error)).best.beaten is False


def test_estimates_at_the_dynamic_bound_are_below_a_point_as_often_as_it_says(run):
    """Of Gaussian errors with the covariance of the bound."""
    bound = run.cramer_rao_bound().dynamic
    draws = np.random.default_rng(3)
    values, vectors = np.linalg.eigh(bound.joint)
    errors = draws.normal(size=(20_000, len(values))) * np.sqrt(values.clip(0.0)) @ vectors.T
    squares = np.sort(np.mean(np.sum(errors.reshape(20_000, -1, 3) ** 2, axis=2), axis=1))
    for probability in (0.005, 0.02, 0.2):
        for share, below in ((0.6, True), (1.4, False)):
            square = squares[round(share * probability * 20_000)]
            assert bound.is_below(bound.joint_ns, square, probability) is below
    assert bound.is_below(bound.joint_ns, 1e-6 * squares.mean(), 1e-3)
    assert not bound.calibrated


def test_what_no_sensor_tells_is_said():
    run = simulate("tumbling_cubesat", duration=1.0, sensor_grade="mems", **{**GIVEN, "magnetometer_rate": 0.0})
    score = run.score(estimate(run, 1.0))
    assert re.search(r"^bound +not known", str(score), re.MULTILINE)
    assert score.to_dict()["cramer_rao_bound"]["filtered_deg"] is None
