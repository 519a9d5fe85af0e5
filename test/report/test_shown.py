"""What notebooks and pandas get of results, and pictures of scores: scales, limits and biases."""

from __future__ import annotations

import json
from copy import deepcopy
from functools import cache
from html.parser import HTMLParser
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import PROGRAM, Browser

from lie_rigid_body import Estimate, InputError, Limits
from lie_rigid_body.diagnosis import FilterDiagnosis, Mistake, Probe
from lie_rigid_body.diagnosis.filter_diagnosis import ErrorOverTime
from lie_rigid_body.evaluation import Score
from lie_rigid_body.report import write_plot, write_report
from lie_rigid_body.runs.ensemble import BlindRun
from sampled import sampled
from untyped import simulate


@pytest.fixture(scope="module")
def run() -> Any:
    rates = {"imu_rate": 50.0, "magnetometer_rate": 25.0, "attitude_sensor_rate": 5.0}
    noises = {"attitude_sensor_cross_boresight_noise": 1e-3, "attitude_sensor_roll_noise": 1e-3}
    how = {"accelerometer_mode": "pivot_gravity", "sensor_grade": "tactical", "motion": "closed_form"}
    return simulate("tumbling_cubesat", duration=10.0, **rates, **noises, **how)


@cache
def off_by(run: Any, degrees: float, limits: Limits | None = None, *, variance: float = 0.0) -> Score:
    """The score of an estimate that is off by an angle about a level axis, growing by a fifth."""
    half = np.radians(degrees) / 2.0 * np.linspace(1.0, 1.2, len(run.imu.t_ns))[:, np.newaxis]
    x, y, z, w = run.attitude().at(run.imu.t_ns).T[..., np.newaxis]
    turned = np.concatenate([w, -z, y, -x], axis=1) * np.sin(half) + np.concatenate([x, y, z, w], axis=1) * np.cos(half)
    covariance = np.eye(3) * variance if variance else None
    estimate = Estimate(turned, covariance=covariance, gyro_bias=run.gyro_bias_at(run.imu.t_ns) + 1e-3 * np.eye(3)[0])
    score: Score = run.score(estimate, limits=limits)
    return score


class Texts(HTMLParser):
    """The texts of some HTML, with every element closed that was opened."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.texts: list[str] = []
        self.feed(source)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_a_notebook_shows_a_sentence_and_tables(run: Any) -> None:
    score = off_by(run, 5.0, Limits(1.0))
    texts = Texts(score._repr_html_()).texts
    assert texts[0].startswith("BROKEN: ")
    assert f"{score.total_deg.rms:.4g}" in texts
    assert score.findings
    assert all(f"{finding.code}: {finding.message}" in texts for finding in score.findings)
    certificate = Texts(run.certificate()._repr_html_()).texts
    assert certificate[0].startswith("CERTIFIED: ")
    assert {"kinetic energy", "gyro", "rad/s"} <= {*certificate}
    shown = Texts(run._repr_html_()).texts
    assert {"truth", "imu", "magnetometer", "attitude_sensor", str(len(run.t_ns)), str(len(run.imu.t_ns))} <= {*shown}
    assert "truth" not in Texts(BlindRun.without_truth(run)._repr_html_()).texts
    mistake = Mistake("inverted", "It is <inverted>.", "inverse", 90.0, 0.1)
    found = FilterDiagnosis((mistake,), (Probe("noise", False, "it errs"),), (), 1, 90.0, 0.1)
    told = Texts(found._repr_html_()).texts
    assert told[0] == "It is <inverted>."
    assert {"inverted", "inverse", "noise", "FAILED"} <= {*told}


def test_results_are_compared_and_hashed_as_what_they_are(run: Any) -> None:
    """Their arrays have no truth of their own."""
    score = off_by(run, 5.0, variance=1e-3)
    diagnosis = FilterDiagnosis((), (), (), 1, 0.0, 0.1, errors=(ErrorOverTime("", np.ones(3), np.ones(3), 1.0),))
    for result in (score, score.error, score.consistency, score.best, diagnosis, run, run.certificate()):
        assert result == result
        assert isinstance(result != deepcopy(result), bool)
        assert result in {result}


def test_tables_of_pandas_have_the_arrays(run: Any) -> None:
    pandas = pytest.importorskip("pandas")
    score = off_by(run, 5.0, variance=1e-3)
    table = score.to_dataframe()
    assert table.index.name == "t_ns"
    np.testing.assert_array_equal(table.index, score.stamps_ns)
    np.testing.assert_array_equal(table["total_deg"], np.degrees(score.error.total))
    assert {"heading_deg", "inclination_deg", "nees"} <= {*table.columns}
    imu = run.imu.to_dataframe()
    np.testing.assert_array_equal(imu[["gyro_x", "gyro_y", "gyro_z"]], run.imu.gyro)
    whole = run.to_dataframe()
    assert isinstance(whole, pandas.DataFrame)
    assert whole.index.is_monotonic_increasing
    assert {*whole.index} == {*run.t_ns, *run.imu.t_ns, *run.magnetometer.t_ns, *run.attitude_sensor.t_ns}
    columns = [f"attitude_{axis}" for axis in "xyzw"]
    np.testing.assert_array_equal(whole.loc[run.t_ns, columns], run.truth.attitude_xyzw)
    np.testing.assert_array_equal(whole.loc[run.imu.t_ns, "imu_gyro_y"], run.imu.gyro[:, 1])
    assert whole["magnetometer_field_x"].count() == len(run.magnetometer.t_ns)
    tilt = run.attitude_sensor.covariance[:, 0, 1]
    np.testing.assert_array_equal(whole.loc[run.attitude_sensor.t_ns, "attitude_sensor_covariance_xy"], tilt)
    assert not [name for name in BlindRun.without_truth(run).to_dataframe() if name.startswith(("attitude_x", "body"))]


def test_a_score_makes_its_json_picture_and_page(run: Any, tmp_path: Path) -> None:
    score: Any = off_by(run, 5.0)
    json.dumps(score.to_dict(series=True), allow_nan=False)
    assert score.plot()._repr_png_()[:4] == b"\x89PNG"
    write_plot(score, tmp_path / "e.png")
    write_report(score, tmp_path / "e.html")
    page = (tmp_path / "e.html").read_text("utf-8")
    parts = ("<h1>", f" {score.total_deg.rms:.3g}° ", "<svg", "<table", score.findings[0].code)
    order = [page.index(text) for text in parts]
    assert order == sorted(order)


@pytest.mark.parametrize("write", [write_plot, write_report])
def test_what_is_no_score_is_told_what_makes_its_page(write: Any, run: Any, tmp_path: Path) -> None:
    found = FilterDiagnosis((), (), (), 1, 90.0, 0.1)
    remedies = {"run.score": run, "check": run.certificate(), "diagnose": found, "evaluate": None}
    for remedy, given in remedies.items():
        with pytest.raises(InputError, match=remedy):
            write(given, tmp_path / "e.png")
    with pytest.raises(InputError, match="title"):
        write(off_by(run, 5.0), tmp_path / "e.png", title=None)
    assert not [*tmp_path.iterdir()]


@pytest.mark.skipif(PROGRAM is None, reason="no Chromium is installed")
def test_a_page_fits_a_screen_and_the_dark(run: Any, tmp_path: Path) -> None:
    page, colours = tmp_path / "e.html", {}
    write_report(off_by(run, 5.0, Limits(1.0)), page)
    with Browser(tmp_path) as browser:
        for width, scheme in product((1400, 400), ("light", "dark")):
            browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            browser.open(page, width, 900)
            assert browser.evaluate("document.documentElement.scrollWidth") <= width
            style = "getComputedStyle(document.body)"
            of_page = browser.evaluate(f"[{style}.color, {style}.backgroundColor]")
            colours[width, scheme] = [int(colour.split("(")[1].split(",")[0]) for colour in of_page]
        assert browser.complaints == []
    for width in (1400, 400):
        assert colours[width, "light"][0] < 64 < 192 < colours[width, "light"][1]
        assert colours[width, "dark"][1] < 64 < 192 < colours[width, "dark"][0]


@pytest.mark.parametrize(
    ("degrees", "limits"),
    sampled(product([1e-4, 3.0, 100.0], [None, Limits(2.0), Limits(170.0, ((1.0, 1e-3),))]), every=4),
)
def test_errors_bound_and_limits_are_all_in_the_picture(run: Any, degrees: float, limits: Limits | None) -> None:
    score: Any = off_by(run, degrees, limits)
    total, parts, *_ = score.plot().axes
    assert (total.get_yscale(), parts.get_yscale()) == ("log", "linear")
    low, high = total.get_ylim()
    best = score.best.filtered_deg
    assert low < min(best.min(), np.degrees(score.error.total).min())
    assert high > max(best.max(), np.degrees(score.error.total).max())
    names = [text.get_text() for text in total.get_legend().get_texts()]
    told: Any = [] if limits is None else [limits.max_rms_deg, *(limit for _, limit in limits.max_after)]
    for limit in told:
        assert low < limit < high
        assert any(f" {limit:g}°" in name for name in names)


def test_the_biases_of_a_gyro_are_drawn_beside_the_true_ones(run: Any) -> None:
    score: Any = off_by(run, 5.0)
    axes = score.plot().axes[-1]
    lines = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
    assert len(lines) == 6
    np.testing.assert_allclose(lines["estimated x"] - lines["true x"], 1e-3, rtol=1e-9)
    np.testing.assert_array_equal(lines["true z"], run.gyro_bias_at(run.imu.t_ns)[:, 2])
    assert len(run.score(run.attitude().at(run.imu.t_ns), diagnosed=False).plot().axes) == 2


def test_a_perfect_estimate_is_drawn(run: Any) -> None:
    still: Any = simulate(duration=1.0, initial_body_rate=[0, 0, 0], motion="closed_form")
    drawn: Any = still.score(still.truth.attitude_xyzw, limits=Limits(1.0)).plot()
    assert drawn._repr_png_()
    assert run.score(run.truth.attitude_xyzw).plot("$\x00").axes
