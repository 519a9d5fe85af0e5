"""What an estimator returns: read once, scored, and put into a bag beside the truth."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from lie_rigid_body import Estimate, InputError, Run, certify
from lie_rigid_body.cli.evaluate import main
from lie_rigid_body.estimates.recorded_estimate import recorded_estimate
from lie_rigid_body.lie import quaternion
from lie_rigid_body.report import scores
from lie_rigid_body.report.answer import as_page
from untyped import simulate

SIZE = np.radians(0.5)


@pytest.fixture(scope="module")
def run():
    return simulate("tumbling_cubesat", duration=2.0, imu_rate=50.0, gyro_noise_density=1e-4)


@pytest.fixture(scope="module")
def attitude(run):
    noise = np.random.default_rng(3).normal(size=(len(run.t_ns), 3)) * SIZE
    return quaternion.multiply(quaternion.exp(noise), run.truth.attitude_xyzw)


def test_an_estimate_is_scored_as_its_parts_are(run, attitude):
    P, bias = np.eye(3) * SIZE**2, run.gyro_bias_at(run.t_ns) + 0.01
    estimate = Estimate(attitude, run.t_ns, P, gyro_bias=bias)
    score = run.score(estimate, diagnosed=False)
    parts = run.score(attitude, run.t_ns, covariance=P, gyro_bias=bias, diagnosed=False)
    assert score.to_dict(series=True) == parts.to_dict(series=True)
    assert score.gyro_bias_rad_s.rms == pytest.approx(0.01 * np.sqrt(3.0))
    assert score.to_dict()["gyro_bias_rad_s"]["rms"] == score.gyro_bias_rad_s.rms
    of_samples = score.to_dict(series=True)["series"]["gyro_bias_error_rad_s"]
    assert of_samples == pytest.approx(score.samples * [0.01 * np.sqrt(3.0)])
    assert "0.01732 rad/s" in str(score)
    assert "0.01732 rad/s" in as_page("title", scores.parts(None, score)).decode()
    later = run.score(estimate, after_s=1.0, diagnosed=False)
    assert later.samples == np.count_nonzero(run.t_ns - run.t_ns[0] >= 10**9)


@pytest.mark.parametrize("axes", ["world", "body"])
def test_estimates_and_scores_lie_beside_the_truth_in_a_bag(axes, run, attitude, tmp_path):
    P = np.diag([1.0, 4.0, 9.0]) * SIZE**2
    estimate = Estimate(attitude, run.t_ns, P, axes)
    score = run.score(estimate, diagnosed=False)
    path = tmp_path / "run.mcap"
    run.to_bag(path, estimates={"/mine": estimate, "/plain": (run.t_ns, attitude)}, scores={"/mine": score})
    assert certify(path).passed
    assert np.array_equal(Run.from_bag(path).truth.attitude_xyzw, run.truth.attitude_xyzw)
    read: Any = recorded_estimate(path, "/mine")
    np.testing.assert_array_equal(read.track.attitude_xyzw, attitude)
    R = quaternion.to_matrix(quaternion.normalize(attitude)) if axes == "body" else np.eye(3)
    np.testing.assert_allclose(read.covariance, R @ np.broadcast_to(P, (len(attitude), 3, 3)) @ np.swapaxes(R, -1, -2))
    assert recorded_estimate(path, "/plain").covariance is None
    with path.open("rb") as stream:
        topics = {channel.topic for _, channel, _ in make_reader(stream).iter_messages()}
    assert {"/mine/error_deg", "/mine/nees"} <= topics


def test_without_estimates_the_bytes_are_those_of_record(run, tmp_path):
    run.to_bag(tmp_path / "a.mcap")
    run.to_bag(tmp_path / "b.mcap", estimates={}, scores={})
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_stamps_before_0_stay_though_no_time_of_a_bag_is(run, attitude, tmp_path):
    """As of a filter that knows a little more than the clock."""
    stamps = run.t_ns - 1_000_001
    run.to_bag(tmp_path / "x.mcap", estimates={"/estimate": (stamps, attitude)})
    assert certify(tmp_path / "x.mcap").passed
    assert recorded_estimate(tmp_path / "x.mcap", "/estimate").track.stamps_ns.tolist() == stamps.tolist()


def test_only_an_estimate_has_its_stamps_filled_in(run, attitude):
    np.testing.assert_array_equal(run.stamped(Estimate(attitude)).t_ns, run.t_ns)
    for given in (attitude, (run.t_ns, attitude), None):
        with pytest.raises(InputError):
            run.stamped(given)


def test_two_topics_of_one_name_are_refused(run, attitude, tmp_path):
    score = run.score(attitude, run.t_ns, diagnosed=False)
    estimates = dict.fromkeys(("/a", "/a/error_deg"), (run.t_ns, attitude))
    with pytest.raises(InputError, match="one name"):
        run.to_bag(tmp_path / "x.mcap", estimates=estimates, scores={"/a": score})
    with pytest.raises(InputError, match=r"/imu/data_raw"):
        run.to_bag(tmp_path / "x.mcap", estimates={"/imu/data_raw": (run.t_ns, attitude)})
    assert not (tmp_path / "x.mcap").exists()


def test_a_score_is_that_of_the_estimate_beside_it(run, attitude, tmp_path):
    score = run.score(attitude, run.t_ns, diagnosed=False)
    for topic, some in (("/a", slice(None, None, 2)), ("/b", slice(None))):
        with pytest.raises(InputError, match=r"^scores: "):
            run.to_bag(tmp_path / "x.mcap", estimates={topic: (run.t_ns[some], attitude[some])}, scores={"/a": score})
    assert not (tmp_path / "x.mcap").exists()


def test_estimated_biases_have_their_score_from_a_bag_too(run, attitude, tmp_path, capsys):
    bias = run.gyro_bias_at(run.t_ns) + np.array([0.0, 0.02, 0.0])
    estimate, path, out = Estimate(attitude, run.t_ns, gyro_bias=bias), tmp_path / "run.mcap", tmp_path / "scored.mcap"
    run.to_bag(path, estimates={"/mine": estimate, "/plain": (run.t_ns, attitude)})
    assert main([str(path), "--estimate", "/mine", "--json", "--out", str(out)]) == 0
    told = json.loads(capsys.readouterr().out)["gyro_bias_rad_s"]
    assert told == run.score(estimate, diagnosed=False).to_dict()["gyro_bias_rad_s"]
    assert told["rms"] == pytest.approx(0.02)
    assert main([str(path), "--estimate", "/plain", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["gyro_bias_rad_s"] is None
    again: Any = recorded_estimate(out, "/mine").gyro_bias
    assert np.array_equal(again.estimate, bias)
    with out.open("rb") as stream:
        messages = make_reader(stream).iter_messages(topics=["/mine/gyro_bias_error"])
        errors = [np.frombuffer(message.data[-24:]) for _, _, message in messages]
    np.testing.assert_allclose(errors, np.broadcast_to([0.0, 0.02, 0.0], bias.shape), rtol=0, atol=1e-15)
    assert certify(out).passed


def test_biases_whose_truth_is_not_known_are_told_in_a_note(run, attitude, tmp_path):
    bag = tmp_path / "run.mcap"
    still = simulate("tumbling_cubesat", duration=2.0)
    still.to_bag(bag, estimates={"/mine": Estimate(attitude, run.t_ns, gyro_bias=attitude[:, :3])})
    read = recorded_estimate(bag, "/mine")
    assert read.gyro_bias is None
    assert "/mine" in read.notes[-1]


@pytest.mark.parametrize(("rate", "share"), [(5.0, 0.0), (12.0, 1.0)])
def test_a_gyro_at_the_limit_of_its_range_is_told_beside_the_score(rate, share):
    """Tactical grade reads up to 400 °/s, 6.98 rad/s."""
    spin = [0.0, 0.0, rate]
    run = simulate("spherical_top", duration=1.0, sensor_grade="tactical", imu_rate=100.0, initial_body_rate=spin)
    score = run.score(run.truth.attitude_xyzw, run.t_ns)
    assert score.gyro_at_limit == share
    assert ("at the limit of its range in 100 % of the readings" in str(score)) is bool(share)
