"""Tests of attitude filters: a plugin of pytest with runs to filter, and an assertion that says what is wrong.

The plugin is loaded by its entry point, and loads nothing heavy before a test wants a run. A test that takes the
fixture `attitude_run` is called with a `lie_rigid_body.Run` of every shipped scenario and sensor grade, or of those
that its marker chooses. Where it chooses none, scenarios of a thrown body are left out::

    @pytest.mark.attitude_run(scenarios=["tumbling_cubesat"], grades=["perfect", "mems"], duration=60.0)
    def test_my_filter(attitude_run):
        estimate = my_filter(attitude_run.imu.t_ns, attitude_run.imu.gyro, attitude_run.imu.specific_force)
        assert_attitude(estimate, attitude_run, max_rms_deg=1.0, after_s=10.0)

Strategies of hypothesis are in `lie_rigid_body.testing.strategies`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Set
from functools import cache
from typing import TYPE_CHECKING, Any, Final, NoReturn

import pytest

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import ArrayLike

    from lie_rigid_body.estimates.programs import CommandEstimator, NodeEstimator
    from lie_rigid_body.evaluation import Score
    from lie_rigid_body.runs import Run
    from lie_rigid_body.scenario import Scenario

__all__ = ["assert_attitude", "attitude_run", "command_estimator", "node_estimator"]

FIXTURE: Final = "attitude_run"
"""Name of the fixture, and of its marker."""
RUN_DEFAULTS: Final[dict[str, object]] = {
    "duration": 30.0,
    "motion": "closed_form",
    "imu_rate": 100.0,
    "magnetometer_rate": 100.0,
    "gyro_rate": "integrated",
    "accelerometer_mode": "pivot_gravity",
}
"""Arguments of `lie_rigid_body.simulate` that a marker may override."""
_OF_SIMULATE: Final = ("duration", "seeds", "memory_limit", "record_path")
"""Arguments of `lie_rigid_body.simulate` that are no parameters of a scenario."""

_runs: dict[tuple[Scenario, str], Run | tuple[Run, ...]] = {}
"""Runs that tests of this process have asked for, by their keys."""


def command_estimator(command: str, timeout: float = 60.0) -> CommandEstimator:
    """Make an estimator of a program.

    Parameters
    ----------
    command : str
        Program and arguments. It reads CSV, ``t_ns,gyro_x,...``, rad/s, m/s² and T, on its standard input, and prints
        ``t_ns,x,y,z,w`` for each reading of the IMU.
    timeout : float
        Longest time of a run, s.

    Returns
    -------
    CommandEstimator
        A function of a `Run`, for `lie_rigid_body.diagnose`, for tests, and for campaigns.
    """
    from lie_rigid_body.estimates.programs import CommandEstimator

    return CommandEstimator(command, timeout)


def node_estimator(command: str, timeout: float = 60.0, topic: str = "imu/data") -> NodeEstimator:
    """Make an estimator of a ROS 2 node.

    For each run the node is started anew, in a ROS domain of its own, and given the readings in lock-step.

    Parameters
    ----------
    command : str
        Program and arguments, such as ``ros2 run my_package my_filter --ros-args -p gain:=0.5``. The node hears
        ``imu/data_raw`` and, if it wants, ``imu/mag``, and publishes an attitude for each reading, with its stamp.
    timeout : float
        Longest time of a run, s.
    topic : str
        Topic of the attitudes: of any type that ``evaluate`` takes.

    Returns
    -------
    NodeEstimator
        A function of a `Run`, for `lie_rigid_body.diagnose`, for tests, and for campaigns.
    """
    from lie_rigid_body.estimates.programs import NodeEstimator

    return NodeEstimator(command, timeout, topic)


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker."""
    config.addinivalue_line(
        "markers",
        f"{FIXTURE}(scenarios=None, grades=None, **parameters): runs of the fixture of that name, by scenario and "
        "sensor grade, all by default; further arguments are those of lie_rigid_body.simulate",
    )


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Call a test with every run that its marker chooses, unless it chooses them by ``parametrize``."""
    if FIXTURE not in metafunc.fixturenames or _has_its_own(metafunc):
        return

    from lie_rigid_body.foundation.errors import InputError
    from lie_rigid_body.foundation.wording import shown
    from lie_rigid_body.sensors import GRADES

    marker = metafunc.definition.get_closest_marker(FIXTURE)
    if marker is not None and marker.args:
        _fail(f"{shown(marker.args[0])} has no name: give scenarios=, grades= or arguments of simulate by name")
    chosen = dict(marker.kwargs) if marker else {}
    if wrong := [name for name in ("scenario", "grade") if name in chosen]:
        _fail(f"{wrong[0]}={shown(chosen[wrong[0]])} is no argument: did you mean {wrong[0]}s=?")
    if once := [name for name, value in chosen.items() if isinstance(value, Iterator)]:
        _fail(f"{once[0]}= can be read once: give a list, as several tests read it")
    if {"grades", "sensor_grade"} <= chosen.keys():
        _fail("sensor_grade= is given beside grades=: give one of them")
    scenarios = _names(chosen, "scenarios", _with_a_vertical())
    grades = _names(chosen, "grades", GRADES)
    pairs = [(scenario, grade) for scenario in scenarios for grade in grades]
    if marker is not None:
        for scenario, grade in {(scenarios[0], grade) for grade in grades} | {(name, grades[0]) for name in scenarios}:
            try:
                _key(scenario, {**RUN_DEFAULTS, "sensor_grade": grade, **chosen})
            except InputError as error:
                _fail(str(error))
    metafunc.parametrize(FIXTURE, pairs, indirect=True, ids=["-".join(map(str, pair)) for pair in pairs])


@cache
def _with_a_vertical() -> tuple[str, ...]:
    """Names of the shipped scenarios but those of a thrown body, in which no filter finds the vertical."""
    from lie_rigid_body.scenario.parameter_file import gather, scenario_files

    return tuple(name for name in scenario_files() if gather(name, [], []).get("translation") != "thrown")


def _names(chosen: dict[str, Any], name: str, every: Iterable[str]) -> list[str]:
    """Take the names that a marker chooses, all where it does not choose; a text is one name."""
    from lie_rigid_body.foundation.wording import shown

    given = chosen.pop(name, None)
    if given is None:
        return list(every)
    try:
        in_order = sorted(given, key=str) if isinstance(given, Set) else given  # of a set each process has its own
        hash(names := (given,) if isinstance(given, str) else tuple(in_order))
    except TypeError:
        _fail(f"{name}={shown(given)} is no list of names: give such as [{next(iter(every))!r}]")
    if not any(names):
        _fail(f"{name}={shown(given)} makes no run: leave it out for all")
    return list(names)


def _fail(message: str) -> NoReturn:
    """End the collection with one line and no traceback, as ``parametrize`` does when it refuses its arguments."""
    raise pytest.fail.Exception(f"{FIXTURE}: {message}", pytrace=False) from None


def _has_its_own(metafunc: pytest.Metafunc) -> bool:
    """Whether a test chooses its runs by ``parametrize``, or its project has a fixture of this name itself."""
    names = [mark.args[0] for mark in metafunc.definition.iter_markers("parametrize") if mark.args]
    fixtures = getattr(metafunc, "_arg2fixturedefs", {}).get(FIXTURE, ())
    return any(FIXTURE in (name.split(",") if isinstance(name, str) else name) for name in names) or any(
        fixture.func.__module__ != __name__ for fixture in fixtures
    )


@pytest.fixture
def attitude_run(request: pytest.FixtureRequest) -> Run | tuple[Run, ...]:
    """A simulated run of a scenario and a sensor grade, the same in every run of the tests.

    Tests that ask for the same run share it, so its arrays are read-only: copy what is to be changed. Without a marker
    it lasts 30 s, with IMU and magnetometer at 100 Hz, the gyro integrated, and gravity in the accelerometer. The
    marker ``attitude_run`` chooses scenarios and grades, and gives further arguments of `simulate`. With ``indirect``,
    ``parametrize`` does as well: pairs of a scenario and a grade, or scenarios of which the sensors are perfect.
    """
    from lie_rigid_body.foundation.errors import InputError
    from lie_rigid_body.foundation.wording import shown
    from lie_rigid_body.runs import simulate

    pair = getattr(request, "param", ())  # none in a unittest, or of what asks for it by getfixturevalue
    pair = tuple(pair) if isinstance(pair, tuple | list) else (pair, "perfect")
    if len(pair) != 2:
        _fail(f"{shown(pair)} is no scenario and grade: ask for the fixture as a test's argument, or give such pairs")
    scenario, grade = pair
    marker = request.node.get_closest_marker(FIXTURE)
    chosen = {k: v for k, v in (marker.kwargs if marker else {}).items() if k not in ("scenarios", "grades")}
    given = {**RUN_DEFAULTS, "sensor_grade": grade, **chosen}
    try:
        key = _key(scenario, given)
        if key not in _runs:
            _runs[key] = simulate(scenario, **given)
    except InputError as error:
        _fail(str(error))
    return _runs[key]


def _key(scenario: str | Path | Scenario, settings: dict[str, Any]) -> tuple[Scenario, str]:
    """Key of a run: its scenario with all parameters, and the other arguments of `simulate`."""
    from lie_rigid_body.foundation.arrays import plain
    from lie_rigid_body.runs.ensemble import scenario_of

    others = {name: plain(value) for name, value in settings.items() if name in _OF_SIMULATE}
    parameters = {name: value for name, value in settings.items() if name not in _OF_SIMULATE}
    return scenario_of(scenario, parameters), json.dumps(others, sort_keys=True, default=repr)


def assert_attitude(
    estimate: ArrayLike,
    run: Run,
    *,
    max_rms_deg: float | None = None,
    max_after: str | tuple[str, ...] = (),
    after_s: float = 0.0,
    t_ns: ArrayLike | None = None,
    plot: str | Path | None = None,
    **options: Any,
) -> Score:
    """Assert that an attitude estimate keeps its limits; if not, the message tells the error and its causes.

    Parameters
    ----------
    estimate : array_like, shape (K, 4)
        World-from-body, scalar last.
    run : Run
    max_rms_deg : float, optional
        Largest RMS of the total error, degrees.
    max_after : str or tuple of str
        Largest total error after a time since the first estimate that counts, such as ``"10s:2deg"``.
    after_s : float
        Estimates of so many seconds from the first on do not count: a filter converges.
    t_ns : array_like of int, shape (K,), optional
        Stamps, ns. By default those of the IMU, if it has as many readings, or of the truth.
    plot : str or Path, optional
        A PNG that is drawn when a limit is broken, such as ``tmp_path / "errors.png"``; an older one is replaced. The
        message says where it is, or why there is none.
    **options
        Further arguments of `Run.score`, such as ``covariance`` and ``gyro_bias``.

    Returns
    -------
    Score
        For further assertions.

    Raises
    ------
    AssertionError
        If a limit is broken.
    InputError
        If there is no limit, or the estimate is unusable: not finite, empty, out of order.
    """
    __tracebackhide__ = True
    from lie_rigid_body.evaluation import Limits
    from lie_rigid_body.foundation.errors import InputError
    from lie_rigid_body.runs.run import require_run

    try:
        require_run(run)
        limits = Limits(max_rms_deg, Limits.parse(None, max_after).max_after)
        if limits == Limits():
            raise InputError("assert_attitude needs a limit: give max_rms_deg=1.0 or max_after='10s:2deg'")
        score = run.score(estimate, t_ns, after_s=after_s, limits=limits, **options)
    except InputError as error:
        raise error.with_traceback(None) from None  # which pytest would show down to the package's own lines
    if score.passed:
        return score
    lines = [
        "; ".join(score.broken),
        "",
        str(score),
        *([] if plot is None else [_drawn(score, plot)]),
        "What is wrong in the filter itself, lie_rigid_body.diagnose(filter) finds: it runs it again and again.",
    ]
    raise AssertionError("\n".join(lines))


def _drawn(score: Score, plot: str | Path) -> str:
    """Draw the errors, and say where they are, or why they are not."""
    from lie_rigid_body.foundation.errors import describe

    try:
        from lie_rigid_body.report import write_plot

        write_plot(score, plot, overwrite=True)
    except Exception as error:  # whatever it is, the broken limit is what the test is to tell
        return f"The errors over time are not drawn: {describe(error)}"
    return f"The errors over time: {plot}"
