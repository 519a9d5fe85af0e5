"""Runs as arrays: the same bits from a simulation and from its bag, and the truth between samples."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import asdict
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_check_many import merged
from test_rewritten_bags import bag_of, recorded

from lie_rigid_body import BagError, ClosedForm, InputError, Run, Scenario
from lie_rigid_body.evaluation import attitude_error
from lie_rigid_body.lie import quaternion
from lie_rigid_body.runs.truth import ScenarioTruth
from lie_rigid_body.simulation import Segment
from said import numbers
from untyped import evaluate, simulate

SENSORS: dict[str, Any] = {
    "imu_rate": 200.0,
    "magnetometer_rate": 50.0,
    "accelerometer_mode": "pivot_gravity",
    "gyro_noise_density": 1e-3,
    "gyro_turn_on_bias": 1e-2,
    "gyro_bias_random_walk": 1e-4,
    "magnetometer_noise_density": 1e-8,
}
SCENARIO = "tumbling_cubesat"
DURATION = 2.0


@pytest.fixture(scope="module")
def run() -> Any:
    return simulate(SCENARIO, duration=DURATION, **SENSORS)


def arrays(run: Any) -> list[np.ndarray]:
    imu = run.imu
    return [
        *(run.t_ns, run.truth.attitude_xyzw, run.truth.body_rate),
        *(imu.t_ns, imu.gyro, imu.specific_force, imu.gyro_bias, imu.accelerometer_bias),
        *(run.magnetometer.t_ns, run.magnetometer.field),
    ]


def bits(run: Run) -> list[bytes]:
    return [array.tobytes() for array in arrays(run)]


def test_shapes_and_stamps(run):
    assert [array.shape for array in arrays(run)] == [
        *[(40,), (40, 4), (40, 3)],
        *[(400,), (400, 3), (400, 3), (400, 3), (400, 3)],
        *[(100,), (100, 3)],
    ]
    assert run.t_ns.dtype == run.imu.t_ns.dtype == np.int64
    assert run.imu.t_ns[-1] == 1_995_000_000
    assert run.scenario.rate == 20.0


@pytest.mark.parametrize("motion", ["closed_form", "moving_chart"])
def test_bits_and_bytes_are_those_of_record(tmp_path, motion):
    own, recorded = tmp_path / "own.mcap", tmp_path / "recorded.mcap"
    run = simulate(SCENARIO, duration=DURATION, motion=motion, **SENSORS)
    run.to_bag(own)
    given = [f"-p{name}:={value}" for name, value in {**SENSORS, "motion": motion}.items()]
    command = [sys.executable, "-m", "lie_rigid_body", "record", str(recorded), "--quiet", f"--duration={DURATION}"]
    subprocess.run([*command, "--scenario", SCENARIO, *given], check=True)
    assert own.read_bytes() == recorded.read_bytes()
    read = Run.from_bag(recorded)
    assert bits(read) == bits(run)
    assert read.scenario == run.scenario


def test_a_run_has_the_certificate_of_its_bag(run, tmp_path):
    run.to_bag(tmp_path / "a.mcap")
    found, of_bag = run.certificate(), Run.from_bag(tmp_path / "a.mcap").certificate()
    assert found.passed
    assert found.attitude_accuracy == of_bag.attitude_accuracy < 1e-14
    assert found.messages == of_bag.messages
    assert not run.certificate([1.5, 2.25, 3.0]).passed


def test_an_existing_bag_is_kept_unless_told(run, tmp_path):
    bag = tmp_path / "a.mcap"
    run.to_bag(bag)
    before = bag.read_bytes()
    with pytest.raises(BagError, match="exists"):
        run.to_bag(bag)
    run.to_bag(bag, overwrite=True)
    assert bag.read_bytes() == before


@pytest.mark.parametrize("motion", ["closed_form", "moving_chart"])
def test_seeds_have_the_bits_of_single_runs_and_share_the_truth(motion):
    given: dict[str, Any] = {"duration": 0.5, "motion": motion, "gyro_rate": "integrated", **SENSORS}
    runs = simulate(SCENARIO, seeds=[7, 3, 7], **given)
    assert [bits(r) for r in runs] == [bits(simulate(SCENARIO, sensor_seed=s, **given)) for s in (7, 3, 7)]
    assert runs[0].imu.gyro.tobytes() != runs[1].imu.gyro.tobytes()
    assert np.shares_memory(runs[0].truth.attitude_xyzw, runs[1].truth.attitude_xyzw)
    assert [r.scenario.parameters()["sensor_seed"] for r in runs] == [7, 3, 7]


@pytest.mark.parametrize("motion", ["closed_form", "moving_chart"])
def test_seeds_by_which_other_numbers_of_readings_arrive_have_the_bits_of_single_runs(motion):
    """With steps that err so much that others would give other bits."""
    given: dict[str, Any] = {"imu_latency_jitter": 0.1, "magnetometer_latency_jitter": 0.3, "rate": 100.0}
    given |= {"duration": 2.0, "motion": motion, "method": "rkmk2", "max_step": 0.004, "gyro_rate": "integrated"}
    given |= {"imu_rate": 100.0, "magnetometer_rate": 100.0, "gyro_noise_density": 1e-3}
    runs = simulate(seeds=range(6), **given)
    assert [bits(run) for run in runs] == [bits(simulate(sensor_seed=seed, **given)) for seed in range(6)]
    lengths = [len(run.imu.t_ns) for run in runs]
    assert min(np.diff(lengths)) < 0 < max(np.diff(lengths))


def test_a_scenario_through_a_pipe_serves_all_seeds():
    """As of ``<(...)`` in a shell, which can be read once."""
    readable, writable = os.pipe()
    with os.fdopen(readable), os.fdopen(writable, "w") as pipe:
        pipe.write("/**: {ros__parameters: {motion: closed_form, rate: 20.0}}")
        pipe.close()
        runs = simulate(Path(f"/dev/fd/{readable}"), duration=0.1, seeds=range(2), imu_rate=20.0)
    assert [run.scenario.rate for run in runs] == [20.0, 20.0]


def test_the_truth_is_computed_once_for_all_seeds(monkeypatch):
    asked: list[int] = []
    at = ClosedForm.at

    def counting(self, t_ns):
        asked.append(np.size(t_ns))
        return at(self, t_ns)

    monkeypatch.setattr(ClosedForm, "at", counting)
    simulate(SCENARIO, duration=1.0, motion="closed_form", seeds=range(1), imu_rate=100.0)
    alone = asked.copy()
    simulate(SCENARIO, duration=1.0, motion="closed_form", seeds=range(9), imu_rate=100.0)
    assert asked == alone + alone


def test_a_run_without_sensors_and_a_scenario_of_ones_own(tmp_path):
    scenario = Scenario.from_parameters({"rate": 10.0, "epoch_ns": 5})
    run = simulate(scenario, duration=1, inertia=np.array([3.0, 4.0, 5.0]))
    with pytest.raises(AttributeError, match="imu_rate"):
        assert run.imu
    assert run.magnetometer is None
    assert run.scenario.inertia == (3.0, 4.0, 5.0)
    assert run.t_ns[:2].tolist() == [5, 100_000_005]
    run.to_bag(tmp_path / "a.mcap")
    assert not hasattr(Run.from_bag(tmp_path / "a.mcap"), "imu")
    file = tmp_path / "p.yaml"
    file.write_text("/**:\n  ros__parameters: {rate: 25.0}\n")
    assert len(simulate(file, duration=1.0).t_ns) == 25
    assert len(simulate(duration=0.1).t_ns) == 10


def test_rates_that_a_reset_has_changed_leave_no_gap_and_hide_none():
    """The usual period is that of a segment: of one for the whole run the slower segment would be full of gaps."""
    truth = ScenarioTruth([Segment(Scenario(), 0, start_ns) for start_ns in (0, 10**10)], 0, 2 * 10**10)
    stamps = np.r_[0 : 10**10 : 10**8, 10**10 : 2 * 10**10 : 2 * 10**6]
    assert evaluate(stamps, truth.at(stamps), truth).findings == ()
    for lost, wide_s, period_s in (([50, 51], 0.3, 0.1), ([2000], 0.004, 0.002)):
        kept = np.delete(stamps, lost)
        [finding] = evaluate(kept, truth.at(kept), truth).findings
        assert finding.code == "gaps"
        assert numbers(finding.message)[::3] == [1, period_s]
        assert numbers(finding.message)[1] == wide_s


def test_a_bag_with_a_reset(tmp_path):
    given = {
        "motion": "closed_form",
        "rate": 10.0,
        "imu_rate": 40.0,
        "gyro_noise_density": 1e-3,
        "gyro_turn_on_bias": 0.1,
    }
    other = {"initial_body_rate": [0.0, 0.2, 2.0], "sensor_seed": 1}
    bag_of(tmp_path / "a.mcap", given, {**given, **other}, each_ns=10**9)
    run: Any = Run.from_bag(tmp_path / "a.mcap")
    assert [segment.start_ns for segment in run.segments] == [0, 10**9]
    assert run.magnetometer is None
    assert len(run.t_ns) == 20
    run.to_bag(tmp_path / "b.mcap")
    again: Any = Run.from_bag(tmp_path / "b.mcap")
    assert again.imu.gyro.tobytes() == run.imu.gyro.tobytes()
    assert again.segments == run.segments
    # the truth between samples is that of the segment, on either side of the jump
    truth = run.attitude()
    for stamp in (10**9 - 1, 10**9 + 33_333_333):
        segment = run.segments[stamp >= 10**9]
        motion = ClosedForm(segment.scenario.body(), segment.scenario.start())
        expected = motion.at(np.array([stamp - segment.start_ns])).attitude_xyzw
        assert attitude_error(truth.at(np.array([stamp])), expected).total < 1e-14
    _, rates = truth.states(10**9 + np.array([-1, 0, 1]))
    assert np.linalg.norm(rates, axis=1).max() < 2.1
    assert truth.last_ns == 2 * 10**9 - 1
    before, after = run.gyro_bias_at([10**9 - 1, 10**9])
    np.testing.assert_array_equal([before, after], run.imu.gyro_bias[[0, -1]])
    assert np.linalg.norm(after - before) > 0.01


@pytest.mark.parametrize("oriented", [False, True])
@pytest.mark.parametrize("fault", [{"dropout_probability": 1.0}, {"latency": 9.0}])
def test_a_sensor_of_which_no_reading_arrives_has_none_from_its_bag_either(fault, oriented, tmp_path):
    sensors = ("imu", "magnetometer", "attitude_sensor", "sun_sensor")
    given = {f"{sensor}_{name}": value for sensor in sensors for name, value in {"rate": 10.0, **fault}.items()}
    run = simulate(duration=1.0, imu_orientation=oriented, **given)
    run.to_bag(tmp_path / "a.mcap")
    read: Any = Run.from_bag(tmp_path / "a.mcap")

    def kinds(run: Run) -> list[dict[str, Any]]:
        arrays = [vars(part) for part in (run.imu, run.magnetometer, run.attitude_sensor, run.sun)]
        return [{name: a is not None and (a.shape, a.dtype) for name, a in part.items()} for part in arrays]

    assert kinds(read) == kinds(run)
    assert len(read.imu.t_ns) == 0
    assert read.faults == run.faults != ()
    read.to_bag(tmp_path / "b.mcap")
    assert (tmp_path / "b.mcap").read_bytes() == (tmp_path / "a.mcap").read_bytes()


def test_one_body_of_several_is_chosen_by_its_topics(run, tmp_path):
    run.to_bag(tmp_path / "a.mcap")
    simulate(duration=1.0).to_bag(tmp_path / "b.mcap")
    two = merged(tmp_path / "two.mcap", a=tmp_path / "a.mcap", b=tmp_path / "b.mcap")
    with pytest.raises(BagError, match=r"/a, /b"):
        Run.from_bag(two)
    first, second = (Run.from_bag(two, topics={"pose": f"/{name}/pose"}) for name in "ab")
    assert [each.tobytes() for each in arrays(first)] == [each.tobytes() for each in arrays(run)]
    assert not hasattr(second, "imu")  # those of the other body are not its own
    assert second.certificate().passed
    with pytest.raises(BagError, match=r"/pose"):
        Run.from_bag(two, topics={"pose": "/pose"})


def test_what_a_bag_lacks_is_none_or_nan(run, tmp_path):
    run.to_bag(tmp_path / "a.mcap")

    def without(topic: str, name: str, keep_every: int = 10**6) -> Path:
        number = count(1)
        heard = lambda time, each: None if each == topic and next(number) % keep_every else time  # noqa: E731
        return recorded(tmp_path / "a.mcap", tmp_path / name, heard)

    read: Any = Run.from_bag(without("/imu/bias", "b.mcap"))
    imu = read.imu
    assert imu.gyro.tobytes() == run.imu.gyro.tobytes()
    assert imu.gyro_bias is None
    assert imu.accelerometer_bias is None
    with pytest.raises(InputError, match=r"400 of 400 .* imu/bias"):
        read.to_bag(tmp_path / "c.mcap")
    assert not (tmp_path / "c.mcap").exists()
    few: Any = Run.from_bag(without("/imu/bias", "d.mcap", keep_every=4))
    some = few.imu.gyro_bias
    told = np.arange(400) % 4 == 3
    assert np.isnan(some[~told]).all()
    np.testing.assert_array_equal(some[told], np.asarray(run.imu.gyro_bias)[told])
    with pytest.raises(InputError, match=r"300 of 400 .* imu/bias"):
        few.to_bag(tmp_path / "f.mcap")
    assert not (tmp_path / "f.mcap").exists()
    np.testing.assert_allclose(few.gyro_bias_at(imu.t_ns), run.gyro_bias_at(imu.t_ns), rtol=0, atol=1e-4)
    attitude = few.attitude().at(imu.t_ns)
    assert few.score(attitude, gyro_bias=few.gyro_bias_at(imu.t_ns), diagnosed=False).gyro_bias_rad_s is not None
    with pytest.raises(BagError, match=r"/scenario"):
        Run.from_bag(without("/lie_rigid_body/scenario", "e.mcap"))


@pytest.mark.parametrize("method", ["dmv20", "rkmk1"])
def test_the_truth_between_samples_is_the_motion_that_the_sensors_read(method):
    given = {"duration": 5.0, "method": method, "initial_body_rate": [1.0, 2.0, -0.5], "max_step": 0.01}
    run = simulate(**given, rate=20.0)
    fine = simulate(**given, rate=100.0, motion="moving_chart")
    truth = run.attitude()
    at_samples = attitude_error(truth.at(run.t_ns), run.truth.attitude_xyzw).total
    assert at_samples.max() < 1e-14
    between = attitude_error(truth.at(fine.t_ns[:490]), fine.truth.attitude_xyzw[:490]).total
    exact = ClosedForm(run.scenario.body(), run.scenario.start()).at(fine.t_ns[:490]).attitude_xyzw
    off = attitude_error(exact, fine.truth.attitude_xyzw[:490]).total
    assert between.max() < (1e-14 if method == "dmv20" else 0.01 * off.max())
    assert truth.uncertainty_at(fine.t_ns) < (1e-14 if method == "dmv20" else 1e-2 * off.max())


@pytest.mark.parametrize("method", ["rkmk2", "dmv2"])
def test_the_truth_far_from_samples_is_no_worse_than_the_exact_solution(method):
    """As live, before the first pose that is heard: two samples tell nothing of a far time."""
    run = simulate(duration=30.0, rate=20.0, method=method, max_step=0.02, initial_body_rate=[0.5, 2.0, 0.3])
    heard = slice(400, 500)
    truth = ScenarioTruth(run.segments, 0, int(run.t_ns[-1]), run.t_ns[heard], run.truth.attitude_xyzw[heard])
    exact = ScenarioTruth(run.segments, 0, int(run.t_ns[-1]))
    error, off = (attitude_error(one.at(run.t_ns), run.truth.attitude_xyzw).total for one in (truth, exact))
    assert error[0] < 1e-15
    assert error[heard].max() < 1e-14
    for far in (slice(400), slice(500, None)):
        assert np.sqrt(np.mean(error[far] ** 2)) < np.sqrt(np.mean(off[far] ** 2))
    assert truth.uncertainty_at(run.t_ns[:400]) == pytest.approx(off[400], rel=1e-9)


def test_scores_of_a_run(run):
    truth = run.attitude()
    late = run.score(truth.at(np.maximum(run.imu.t_ns - 4_000_000, 0)))
    assert late.samples == 400
    assert [finding.code for finding in late.findings] == ["lagging"]
    assert abs(late.lag_s - 0.004) < 1e-6
    assert run.score(run.truth.attitude_xyzw, diagnosed=False).total_deg.max < 1e-12
    assert run.score(run.truth.attitude_xyzw[::2], run.t_ns[::2]).samples == 20


def test_errors_of_the_vertical_in_a_run_without_gravity_are_told_first():
    """Where the accelerometer reads none: of a default scenario, or where the estimate is right, nothing is said."""
    for given, told in (({}, 0), ({"accelerometer_mode": "free_fall"}, 1)):
        run = simulate(duration=4.0, imu_rate=50.0, **given)
        assert bool(np.abs(run.imu.specific_force).max() > 9.0) is not bool(told)
        right = run.attitude().at(run.imu.t_ns)
        tilted = quaternion.multiply(quaternion.exp(np.array([0.5, 0.0, 0.0])), right)
        assert run.score(right, diagnosed=False).remarks == ()
        score = run.score(tilted, diagnosed=False)
        assert len(score.remarks) == told
        assert str(score).startswith("\n".join(score.remarks))


def test_the_error_of_an_estimated_bias(run):
    bias = np.asarray(run.imu.gyro_bias) + np.array([3e-3, 0.0, -4e-3])
    score = run.score(run.attitude().at(run.imu.t_ns), gyro_bias=bias, diagnosed=False)
    assert score.gyro_bias_rad_s.rms == pytest.approx(5e-3, rel=1e-12)
    assert score.to_dict()["gyro_bias_rad_s"] == asdict(score.gyro_bias_rad_s)
    middle = run.gyro_bias_at(run.imu.t_ns[:-1] + 2_500_000)
    np.testing.assert_allclose(middle, 0.5 * (bias[1:] + bias[:-1]) - np.array([3e-3, 0.0, -4e-3]), rtol=0, atol=1e-15)
    assert run.gyro_bias_at([]).shape == (0, 3)
    with pytest.raises(InputError, match=r"^gyro_bias: 400 of 400"):
        run.score(run.attitude().at(run.imu.t_ns), gyro_bias=np.full((400, 3), np.nan), diagnosed=False)
    silent = simulate(SCENARIO, duration=1.0, imu_rate=10.0, imu_dropout_probability=1.0)
    for untold in (simulate(SCENARIO, duration=1.0), silent):
        with pytest.raises(InputError, match="bias"):
            untold.gyro_bias_at([0])


@pytest.mark.parametrize("seeds", [None, [1, 2]])
def test_noise_of_a_sensor_that_is_off_is_a_warning(seeds):
    with pytest.warns(UserWarning, match=r"^gyro_noise_density ") as found:
        simulate(SCENARIO, duration=0.1, seeds=seeds, gyro_noise_density=1e-3)
    assert [warning.filename for warning in found] == [__file__]
