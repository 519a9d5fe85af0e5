"""What `diagnose` says of textbook filters with and without mistakes."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import textbook
from scipy.spatial.transform import Rotation

import lie_rigid_body
from lie_rigid_body import ClosedForm, InputError, RigidBody, State
from lie_rigid_body.cli.diagnose import main
from lie_rigid_body.cli.league import main as league
from lie_rigid_body.diagnosis import FilterDiagnosis, diagnose
from lie_rigid_body.diagnosis.course import courses_of
from lie_rigid_body.diagnosis.probes import NOTES, PROBES
from lie_rigid_body.diagnosis.probing import told
from lie_rigid_body.diagnosis.repairs import Repair, exact_repairs
from lie_rigid_body.diagnosis.search import QUICK, Search
from lie_rigid_body.diagnosis.situations import REST, TUMBLES, TURNS, Situation, common
from lie_rigid_body.diagnosis.trials import Trial
from lie_rigid_body.estimates.estimators import each_alone
from lie_rigid_body.lie import quaternion
from said import numbers
from sampled import sampled

HERE = Path(__file__).parent
SLOWLY: dict[str, Any] = {"imu_rate": 25.0, "magnetometer_rate": 25.0}
CODES = "follows half_turn exact_starts other_fields headings irregular_steps converges gyro_bias slow"
CODES += " linear_acceleration accelerometer_bias hard_iron noise dropouts long_run repeatable norm finite needs_rest"
SWAPPED = [1, 0, 2]


def failed(found: FilterDiagnosis) -> list[str]:
    """Codes of failed probes, but for that which every filter without memory fails."""
    return [probe.code for probe in found.failed if probe.code != "linear_acceleration"]


def test_right_filter_has_no_mistake_and_passes_every_probe() -> None:
    found = lie_rigid_body.diagnose(lambda run: textbook.triad(run))
    assert found.mistakes == ()
    assert " ".join(probe.code for probe in found.probes) == CODES
    assert failed(found) == []
    assert [probe.code for probe in found.failed] == ["linear_acceleration"]  # it trusts each single set of readings
    assert found.rms_deg < 1e-10
    assert [note.code for note in found.notes] == ["deaf"]  # the gyro


@pytest.mark.slow
@pytest.mark.parametrize(("first", "each"), sampled([(1, 3), (0, 7), (0, 20)], every=2))
def test_right_filter_may_answer_some_readings(first: int, each: int) -> None:
    """What noise may leave is asked of these readings alone."""

    def some(run: Any) -> tuple[Any, Any]:
        return run.imu.t_ns[first::each], textbook.triad(run)[first::each]

    found = diagnose(some)
    assert [mistake.code for mistake in found.mistakes] == failed(found) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "codes"),
    [
        (lambda q: q * [-1.0, -1.0, -1.0, 1.0], ["inverted"]),
        (lambda q: np.roll(q, 1, axis=1), ["scalar_first"]),
        (lambda q: quaternion.multiply([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0], q), ["ned_world"]),
    ],
)
def test_convention_of_the_output_is_named_without_a_search(change: Callable[[Any], Any], codes: list[str]) -> None:
    found = diagnose(lambda run: change(textbook.triad(run)))
    assert [mistake.code for mistake in found.mistakes] == codes
    assert found.mistakes[0].rms_deg_after < 1e-10
    assert found.mistakes[0].rms_deg_before > 60.0
    assert found.filter_runs < 150
    assert len(found.remarks) == 1
    assert not found.passed


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimate", "mistakes"),
    [
        (textbook.upside_down, {("accelerometer_axes", "-x -y -z")}),
        (textbook.two_mistakes, {("accelerometer_axes", "y x z"), ("magnetometer_axes", "x y -z")}),
    ],
)
def test_mistakes_of_the_input_are_named_one_after_the_other_with_their_repairs(
    estimate: Callable[[Any], Any], mistakes: set[tuple[str, str]]
) -> None:
    found = diagnose(estimate)
    assert {(m.code, m.repair) for m in found.mistakes} == mistakes
    for first, second in pairwise(found.mistakes):
        assert second.rms_deg_before == pytest.approx(first.rms_deg_after)
    assert found.mistakes[-1].rms_deg_after < 1e-10
    assert len(found.errors) == 1 + len(mistakes)
    assert failed(found) == []


def swapped_field() -> Repair:
    (repair,) = [each for each in exact_repairs() if (each.code, each.text) == ("magnetometer_axes", "y x z")]
    return repair


def test_a_repair_has_an_effect_where_the_estimate_changes_and_not_its_error() -> None:
    search = Search(partial(each_alone, textbook.begins_upside_down), courses_of({}), 2000)
    (given,), (repaired,) = search.tried([((), search.short), ((swapped_field(),), search.short)])
    assert given.error == pytest.approx(repaired.error, abs=1e-6)
    assert repaired.changes(given)
    assert not given.changes(given)


def test_a_constant_is_fitted_beside_a_repair_of_the_output() -> None:
    search = Search(partial(each_alone, textbook.late_and_inverted), courses_of({}), 2000)
    assert search._fitted("magnetometer_late", (), QUICK).text == "5 samples earlier"


def test_run_of_a_diagnosis_tells_no_truth() -> None:
    seen: list[Any] = []

    def estimate(run: Any) -> Any:
        seen.append(run)
        raise ZeroDivisionError

    with pytest.raises(InputError):
        diagnose(estimate)
    run, *_ = seen
    assert run.truth is None
    names = ("attitude", "to_bag", "certificate", "cramer_rao_bound")
    for ask in [*(getattr(run, name) for name in names), lambda: run.score([[0, 0, 0, 1]]), run.scenario.exact_motion]:
        with pytest.raises(InputError):
            ask()
    for name in ("initial_attitude_xyzw", "initial_body_rate", "sensor_seed"):
        assert name not in run.scenario.parameters()
        assert not hasattr(run.scenario, name)
    assert run.imu.gyro_bias is None
    assert run.scenario.parameters()["imu_rate"] == 100.0


def test_nan_fails_the_probe_with_the_first_sample() -> None:
    found = diagnose(lambda run: textbook.not_a_number(run), max_runs=1)
    finite = next(probe for probe in found.probes if probe.code == "finite")
    assert (finite.passed, finite.value) == (False, 1293.0)
    assert numbers(finite.message)[-1] == 7


@pytest.mark.parametrize(
    ("estimate", "said"),
    [
        (textbook.triad_with_covariance, "No inconsistency"),
        (textbook.triad_with_deviations, "variances"),
        pytest.param(textbook.triad_for_the_body, "covariance_axes", marks=pytest.mark.slow),
    ],
)
def test_covariance_is_judged_and_what_is_wrong_with_it_is_told(estimate: Callable[[Any], Any], said: str) -> None:
    found = diagnose(lambda run: estimate(run), parameters={"sensor_grade": "tactical"}, **SLOWLY)
    (probe,) = (probe for probe in found.probes if probe.code == "covariance")
    assert probe.passed == (said == "No inconsistency")
    assert failed(found) == ([] if probe.passed else ["covariance"])
    assert said in probe.message
    assert probe.value is not None
    assert (abs(probe.value - 3.0) < 0.5) == probe.passed


@pytest.mark.slow
def test_covariance_is_not_judged_without_the_noise_that_the_filter_assumes() -> None:
    found = diagnose(lambda run: textbook.triad_with_deviations(run))
    (probe,) = (probe for probe in found.probes if probe.code == "covariance")
    assert probe.passed is None
    assert failed(found) == []


@pytest.mark.slow
def test_covariance_that_is_none_fails_in_one_line() -> None:
    found = diagnose(lambda run: lie_rigid_body.Estimate(textbook.triad(run), covariance=-np.eye(3)))
    assert failed(found) == ["covariance"]
    assert not found.probes[-1].message.startswith("covariance")


@pytest.mark.slow
def test_stuck_estimate_is_told_and_is_judged_by_no_probe_beside_its_error() -> None:
    found = diagnose(textbook.stuck, max_runs=1, imu_rate=50.0, magnetometer_rate=50.0)
    (probe,) = (probe for probe in found.probes if probe.code == "gyro_bias")
    assert probe.passed is None
    assert found.mistakes == ()
    assert "stuck: " in found.probes[0].message
    assert {note.code: note.value for note in found.notes}["deaf"] == "gyro, accelerometer, magnetometer"


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gyro_noise_density", -1e-3),
        ("sensor_grade", "golden"),
        ("initial_body_rate", [0.0, 0.0, 0.0]),
        *(("workers", value) for value in (0, 10_000, 10**400, True)),
        ("max_runs", 2.5),
        *(("timeout", value) for value in (0.0, float("inf"))),
        *((rate, 1e9) for rate in ("imu_rate", "magnetometer_rate")),  # a body all but stands between readings
    ],
)
def test_argument_that_cannot_be_is_refused(name: str, value: object) -> None:
    given: dict[str, Any] = {name: value}
    with pytest.raises(InputError, match=name):
        diagnose(textbook.triad, **given)


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE)


@pytest.mark.usefixtures("here", "asked_here")
def test_verb_names_a_mistake_with_status_1(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    page = tmp_path / "out.html"
    assert main(["textbook:scalar_first", "--json", "--workers", "1", "--report", str(page)]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [mistake["code"] for mistake in found["mistakes"]] == ["scalar_first"]
    assert set(found) == {"mistakes", "probes", "notes", "situations", "filter_runs", "passed"}
    assert set(found["mistakes"][0]) == {"code", "message", "repair", "rms_deg_before", "rms_deg_after", "or_else"}
    assert set(found["probes"][0]) == {"code", "passed", "message", "value"}
    assert "<svg" in page.read_text(encoding="utf-8")


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    "name", sampled(["textbook:none_such", "textbook", "no_such_module:estimate", "textbook:HERE"], every=4)
)
def test_name_without_a_function_is_one_line_and_status_2(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([name, "--workers", "1"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("verb", [main, league])
@pytest.mark.parametrize("workers", ["0", "10000", "1e3", str(10**400)])
def test_what_is_no_number_of_processes_is_one_line_and_status_2(
    verb: Callable[[list[str]], int], workers: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert verb(["textbook:triad", "--workers", workers]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.slow
@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("name", "workers", "timeout", "word"),
    [
        ("hangs", "1", "1", "--timeout"),
        pytest.param("forks", "2", "1", "--timeout", marks=pytest.mark.slow),
        pytest.param("dies", "1", "60", "status 3", marks=pytest.mark.slow),
    ],
)
def test_filter_that_hangs_or_dies_is_ended(
    name: str, workers: str, timeout: str, word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([f"textbook:{name}", "--workers", workers, "--timeout", timeout]) == 2
    assert word in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimate", "changes", "code"),
    [
        (textbook.mahony, {"gyro": np.radians}, "gyro_units"),
        (textbook.mahony, {"gyro": lambda v: v[:, SWAPPED]}, "gyro_axes"),
        (textbook.mahony, {"gyro": lambda v: 1.05 * v}, "time_step"),
        (textbook.mahony, {"field": textbook.late(3)}, "magnetometer_late"),
        (textbook.from_afar, {"field": lambda v: v[:, SWAPPED]}, "magnetometer_axes"),
    ],
)
def test_mistake_in_mahonys_filter_is_named(estimate: Callable[[Any], Any], changes: dict[str, Any], code: str) -> None:
    found = diagnose(lambda run: estimate(textbook.changed(run, **changes)))
    assert [mistake.code for mistake in found.mistakes] == [code]
    assert found.mistakes[0].rms_deg_after < (0.01 if estimate is textbook.mahony else 0.1)


@pytest.mark.slow
def test_right_filter_that_expects_integrated_rates_is_told_so() -> None:
    found = diagnose(textbook.mahony, workers=2)
    assert found.passed
    assert {note.code: note.value for note in found.notes} == {"gyro_kind": "integrated"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimate", "given", "fails", "told"),
    [
        (textbook.averages_the_gyro, {"max_runs": 1}, ["needs_rest"], ""),
        (textbook.corrects_the_wrong_way, {"workers": 2}, ["headings"], "unstable"),
        (textbook.from_afar, {"workers": 2}, ["converges"], ""),
    ],
)
def test_filter_without_a_mistake_that_fails_a_probe_is_told_why(
    estimate: Callable[[Any], Any], given: dict[str, Any], fails: list[str], told: str
) -> None:
    found = diagnose(estimate, **given)
    assert found.mistakes == ()
    assert {*fails} <= {*failed(found)}
    assert told in found.sentences[0]
    assert found.filter_runs < 200 or "max_runs" in given


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 1.0])
def test_jumps_and_answers_by_chance_are_no_chatter_that_explains_an_error(share: float) -> None:
    """Any rotation at a share of the samples, by digits of the gyro that errors of the sensors change."""

    def jumping(run: Any) -> Any:
        angle = np.pi * (np.modf(1e6 * np.abs(run.imu.gyro[:, :1]))[0] < share) * np.modf(1e7 * run.imu.gyro)[0]
        return quaternion.multiply(textbook.triad(run), quaternion.exp(2.0 * angle))

    found = diagnose(jumping, max_runs=1)
    assert found.rms_deg > 20.0
    assert found.probes[0].passed is False
    assert "chatters" not in {note.code for note in found.notes}


@pytest.mark.slow
def test_filter_that_begins_with_one_attitude_is_judged_when_it_has_settled() -> None:
    found = diagnose(textbook.from_afar, workers=2)
    [off] = [note.value for note in found.notes if note.code == "first_attitude"]
    assert isinstance(off, float)
    assert off > 90.0
    assert found.rms_deg < found.floor_deg


@pytest.mark.slow
def test_filter_without_a_magnetometer_is_judged_by_its_vertical() -> None:
    found = diagnose(lambda run: textbook.without_a_magnetometer(run), max_runs=1, **SLOWLY)
    assert {note.code: note.value for note in found.notes}["deaf"] == "magnetometer"
    assert found.mistakes == ()
    assert found.probes[0].passed


@pytest.mark.slow
@pytest.mark.parametrize("sensor", ["accelerometer", "magnetometer"])
def test_unstable_filter_is_told_the_sensor_whose_correction_has_the_wrong_sign(sensor: str) -> None:
    signs = (-1.0, 1.0, 1.0) if sensor == "accelerometer" else (1.0, -1.0, 1.0)
    search = Search(partial(each_alone, partial(textbook.mahony, signs=signs)), courses_of({}), 1)
    search.run()
    assert search.growth > search.floor
    assert search.unstable_by == sensor
    assert search.chatter == 0.0


@pytest.mark.slow
def test_bias_that_is_learnt_in_minutes_is_learnt_before_the_headings() -> None:
    """Gains of slow filters of flight controllers: the bias decays with a time constant of 33 s."""
    search = Search(partial(each_alone, partial(textbook.mahony, kp=0.2, ki=0.005)), courses_of({}), 1)
    search.run()
    [headings] = told(search, [row for row in PROBES if row.code == "headings"])
    assert headings.passed
    assert search.longest_rest_s == 0.0  # without a bias it begins settled


NED = quaternion.multiply([np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0], [0.0, 0.0, np.sin(0.4), np.cos(0.4)])


def with_sensors_exchanged(run: Any) -> Any:
    imu = SimpleNamespace(t_ns=run.imu.t_ns, gyro=run.imu.specific_force, specific_force=run.imu.gyro)
    return textbook.from_afar(SimpleNamespace(imu=imu, magnetometer=run.magnetometer, scenario=run.scenario))


def with_the_pitch_negated(run: Any) -> Any:
    yaw, pitch, roll = Rotation.from_quat(textbook.triad(run)).as_euler("ZYX").T
    return Rotation.from_euler("ZYX", np.stack([yaw, -pitch, roll], axis=1)).as_quat()


MORE: dict[str, Callable[[Any], Any]] = {
    "sensors_exchanged": with_sensors_exchanged,
    "output_axes": lambda run: textbook.triad(run)[:, [0, 2, 1, 3]],
    "euler_order": with_the_pitch_negated,
    "ned_world heading_offset": lambda run: quaternion.multiply(NED, textbook.triad(run)),
    "time_step": lambda run: textbook.mahony(textbook.changed(run, gyro=lambda v: 1e5 * v)),
}


@pytest.mark.slow
@pytest.mark.parametrize("codes", MORE)
def test_more_mistakes_are_named(codes: str) -> None:
    found = diagnose(MORE[codes])
    assert [mistake.code for mistake in found.mistakes] == codes.split()
    assert found.mistakes[-1].rms_deg_after < found.floor_deg


@pytest.mark.slow
def test_filter_that_knows_the_dynamics_is_judged_on_free_motions() -> None:
    def of_euler(run: Any) -> Any:
        start = State(textbook.triad(run)[0], run.imu.gyro[0])
        body = RigidBody(run.scenario.parameters()["inertia"])
        return ClosedForm(body, start).at(run.imu.t_ns - run.imu.t_ns[0]).attitude_xyzw

    found = diagnose(of_euler, workers=1)
    assert found.mistakes == ()
    assert found.rms_deg < found.floor_deg
    assert not {"headings", "needs_rest"} & {probe.code for probe in found.probes}


@pytest.mark.slow
def test_gyro_that_counts_a_little_less_is_a_note() -> None:
    found = diagnose(lambda run: textbook.mahony(textbook.changed(run, gyro=lambda v: 0.99 * v)))
    assert found.mistakes == ()
    assert {note.code: note.value for note in found.notes}["gyro_scale"] == pytest.approx(0.99, abs=1e-4)
    assert found.probes[0].passed


@pytest.mark.slow
def test_where_nothing_explains_the_error_situations_do() -> None:
    """A compass that is compensated for its tilt with a wrong sign."""

    def estimate(run: Any) -> Any:
        force, (x, y, z) = run.imu.specific_force, run.magnetometer.field.T
        roll, pitch = np.arctan2(force[:, 1], force[:, 2]), np.arctan2(-force[:, 0], np.hypot(force[:, 1], force[:, 2]))
        level = x * np.cos(pitch) + y * np.sin(roll) * np.sin(pitch) - z * np.cos(roll) * np.sin(pitch)
        field = run.scenario.parameters()["magnetic_field"]
        yaw = np.arctan2(field[1], field[0]) - np.arctan2(y * np.cos(roll) - z * np.sin(roll), level)
        return Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=1)).as_quat()

    found = diagnose(estimate, max_runs=1)
    errors = {each.name: each.rms_deg or 0.0 for each in found.situations}
    assert len(errors) == 9
    assert errors["level at rest"] < 2.0 < 20.0 < errors["tilted at rest"]
    assert {probe.passed for probe in found.probes if probe.code in ("noise", "slow", "long_run")} == {None}


@pytest.mark.slow
def test_the_tumble_among_the_situations_is_the_one_in_which_it_is_wrong() -> None:
    def wrong_of_one_body(run: Any) -> Any:
        w = run.imu.gyro * (run.scenario.parameters()["inertia"][1] == courses_of({})[1].parameter("inertia")[1])
        return quaternion.multiply(textbook.triad(run), quaternion.exp(w * w[:, [1, 2, 0]]))

    found = diagnose(wrong_of_one_body, max_runs=1)
    assert found.mistakes == ()
    assert {each.name: each.rms_deg or 0.0 for each in found.situations}["tumbling"] > found.rms_deg


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.02, 1.0])
def test_a_diagnosis_that_finds_nothing_ends(size: float) -> None:
    """An error that grows with the square of the rate has no name, whether probes are judged beside it or not."""

    def wrong_in_motion(run: Any) -> Any:
        w = run.imu.gyro
        return quaternion.multiply(textbook.triad(run), quaternion.exp(size * w * w[:, [1, 2, 0]]))

    found = diagnose(wrong_in_motion, workers=1)
    assert found.mistakes == ()
    assert found.updates <= 600_000


def test_situations_are_told_together() -> None:
    names = [*REST, *TURNS, *TUMBLES]

    def said(*right: str) -> str:
        return common([Situation(name, 90.0 * (name not in right), is_level=False) for name in names[:7]], 0.1)

    assert said(*REST) == "It is right at rest, and wrong in motion."
    assert said(*REST, names[5]) == "It is right at rest and about z, and wrong about x and y and in a tumble."
    assert said(*REST, *TURNS) == "It is right at rest and about each axis, and wrong in a tumble."


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda b: b, ""),
        (lambda b: -b, "opposite"),
        (np.degrees, "degrees"),
        (lambda b: 0.0 * b, "never"),
        (lambda b: b * np.arange(len(b))[:, np.newaxis], "another size"),
        (lambda b: -5.0 * b * [np.arange(3) < 1] * np.linspace(0.9, 1.0, len(b))[:, np.newaxis], "another direction"),
    ],
)
def test_estimated_bias_is_compared_with_the_one_put_in(change: Callable[[Any], Any], word: str) -> None:
    bias = np.radians(1.0) / np.sqrt(3.0) * np.array([1.0, -1.0, 1.0])

    def estimate(run: Any) -> Any:
        told = change(np.tile(bias * (np.abs(run.imu.gyro[0] - bias).max() < 1e-3), (len(run.imu.t_ns), 1)))
        return lie_rigid_body.Estimate(textbook.triad(run), gyro_bias=told)

    found = diagnose(estimate, max_runs=1)
    (probe,) = (probe for probe in found.probes if probe.code == "bias_estimate")
    assert probe.passed == (not word)
    assert word in probe.message


def repairs_by_units(estimate: Callable[[Any], Any], code: str) -> tuple[Search, list[Trial]]:
    """A search, and the repairs of units that leave less than the floor in a short course."""
    search = Search(partial(each_alone, estimate), courses_of({}), 2000)
    units = [((repair,), search.short) for repair in exact_repairs() if repair.code == code]
    return search, [trial for (trial,) in search.tried(units) if trial.error < search.floor]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimate", "code"),
    [
        pytest.param(textbook.with_wrong_jacobian, "magnetometer_units", marks=pytest.mark.slow),
        (partial(textbook.proportional, signs=(-1.0, 1.0), gain=10.0), "accelerometer_units"),
        pytest.param(partial(textbook.proportional, signs=(1.0, -1.0)), "accelerometer_units", marks=pytest.mark.slow),
    ],
)
def test_repair_that_silences_a_sensor_names_no_mistake_of_an_unstable_filter(
    estimate: Callable[[Any], Any], code: str
) -> None:
    """A sensor taken wrongly leaves 0.00° where it is nearly silent, or where the right one outweighs it."""
    search, trials = repairs_by_units(estimate, code)
    search.trials = list(search.fully([()], courses=search.courses))
    search._compare()
    assert np.degrees(search.chatter + search.growth) > 3.0
    assert trials
    assert not any(search._uses_what_it_scales(trial) for trial in trials)


@pytest.mark.parametrize(
    ("code", "given", "offset"),
    [
        ("magnetometer_units", "field", [5e-6, -3e-6, 2e-6]),
        ("accelerometer_units", "force", [0.5, -0.3, 0.2]),
    ],
)
def test_repair_that_drowns_a_constant_names_no_units_where_the_filter_normalises(
    code: str, given: str, offset: list[float]
) -> None:
    """A wrong hard iron, or a wrong bias, is nothing beside readings that are multiplied by much."""
    search, trials = repairs_by_units(
        lambda run: textbook.triad(textbook.changed(run, **{given: lambda vectors: vectors + offset})), code
    )
    assert trials
    assert not any(search._uses_what_it_scales(trial) for trial in trials)


@pytest.mark.parametrize(
    ("code", "units", "repair"),
    [
        ("magnetometer_units", (1.0, 1e6), "× 1e-06"),
        pytest.param("magnetometer_units", (1.0, 1e4), "× 0.0001", marks=pytest.mark.slow),
        ("accelerometer_units", (1e3 / 9.80665, 1.0), "× 0.00980665"),
    ],
)
@pytest.mark.parametrize("gain", [0.2, 2.0])
def test_unit_that_makes_a_right_filter_unstable_is_heard_again(
    gain: float, code: str, units: tuple[float, float], repair: str
) -> None:
    search, trials = repairs_by_units(partial(textbook.proportional, gain=gain, units=units), code)
    (right,) = (trial for trial in trials if trial.mistakes[0].text == repair)
    assert search.drift_costs(code.partition("_")[0], right.repairs)[0] > 10.0 * search.floor


@pytest.mark.slow
def test_filter_whose_equal_runs_differ_is_told_so_at_once() -> None:
    """No repair can be told from chance, nor whether it is unstable or uses later readings."""
    draw = np.random.default_rng(3)

    def by_chance(run: Any) -> Any:
        turn = Rotation.from_rotvec(np.cumsum(draw.normal(scale=0.1, size=(len(run.imu.t_ns), 3)), axis=0))
        return (Rotation.from_quat(textbook.triad(run)) * turn).as_quat()

    found = diagnose(by_chance)
    assert found.mistakes == ()
    assert {"follows", "repeatable"} <= {*failed(found)}
    assert "unstable" not in str(found)
    assert [note.code for note in found.notes if note.code == "causal"] == []
    assert found.filter_runs < 200


@pytest.mark.slow
@pytest.mark.parametrize(("estimate", "is_causal"), [(textbook.both_ways, False), (textbook.right, True)])
def test_an_estimate_that_uses_later_readings_is_told(estimate: Callable[[Any], Any], is_causal: bool) -> None:
    search = Search(partial(each_alone, estimate), courses_of({}), 2000)
    search.run()
    [note] = told(search, [row for row in NOTES if row.code == "causal"])
    assert (note.passed, max(numbers(note.message)) > 0.1) == (is_causal, not is_causal)


@pytest.mark.parametrize(
    "given",
    [
        {"gyro_rate": "instantaneous"},
        {"accelerometer_mode": "free_fall"},
        {"rate": 100.0},
    ],
)
def test_parameter_without_effect_is_refused_unless_a_scenario_has_it(given: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="initial_body_rate"):
        courses_of(given, said=given)
    assert courses_of(given) == courses_of({})


@pytest.mark.parametrize(
    ("estimate", "said"),
    [
        (textbook.interrupts, ["KeyboardInterrupt: of the filter"]),
        pytest.param(textbook.stops, ["BaseException"], marks=pytest.mark.slow),
        pytest.param(
            textbook.spoils_its_process,
            ["the filter failed, ", "No module named 'numpy': correct"],
            marks=pytest.mark.slow,
        ),
        (textbook.endless, ["the filter failed, MemoryError: correct"]),
    ],
)
def test_filter_that_fails_in_a_process_of_its_own_is_refused_in_one_line(
    estimate: Callable[[Any], Any], said: list[str]
) -> None:
    with pytest.raises(InputError) as caught:
        diagnose(estimate, workers=1)
    assert [word for word in said if word not in str(caught.value)] == []
