"""Runs by simulation, of one seed or of many, and runs without the truth, for a filter to be tested."""

from __future__ import annotations

import warnings
from collections import defaultdict
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, Final, TypeAlias, overload

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers, plain
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import exact_duration
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.recording.poses import with_path
from lie_rigid_body.runs.blind_scenario import BlindScenario, refuse
from lie_rigid_body.runs.readings import SensorArrays
from lie_rigid_body.runs.run import Run
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather
from lie_rigid_body.simulation import SampleClock, Segment, Simulation, motions_of
from lie_rigid_body.simulation.loop import LastCall

GivenScenario: TypeAlias = "str | Path | Scenario | RigidBody | None"
"""A name of a scenario, a file, the scenario itself, or a body; None: the defaults."""
DEFAULT_MEMORY_LIMIT: Final = 4 * 1024**3
"""Memory that one call may take by default, bytes (4 GiB)."""
_TRUTH_BYTES: Final = 300
"""Largest memory for a sample of the truth while it is computed, bytes."""
_READING_BYTES: Final = 700
"""Largest memory for a reading of a sensor, of 16 numbers, while it is computed, bytes."""
_KEPT_BYTES: Final = 160
"""Memory for each reading that a run keeps, bytes."""
_RUN_BYTES: Final = 2**16
"""Memory that a run takes beside its arrays, bytes."""
_TELLING: Final = ("attitude", "score", "to_bag", "certificate", "cramer_rao_bound", "gyro_bias_at")
"""Methods of a run that need the truth, which a run without it refuses."""
_NO_TRUTH: Final[Any] = None
_NO_BIASES: Final = {"gyro_bias": None, "accelerometer_bias": None}


@overload
def simulate(
    scenario: GivenScenario = None,
    start: State | None = None,
    *,
    duration: float,
    seeds: None = None,
    memory_limit: int = DEFAULT_MEMORY_LIMIT,
    **parameters: object,
) -> Run: ...


@overload
def simulate(
    scenario: GivenScenario = None,
    start: State | None = None,
    *,
    duration: float,
    seeds: Iterable[int],
    memory_limit: int = DEFAULT_MEMORY_LIMIT,
    **parameters: object,
) -> tuple[Run, ...]: ...


def simulate(
    scenario: GivenScenario = None,
    start: State | None = None,
    *,
    duration: float,
    seeds: Iterable[int] | None = None,
    memory_limit: int = DEFAULT_MEMORY_LIMIT,
    **parameters: object,
) -> Run | tuple[Run, ...]:
    """Simulate a body and its sensors, with the same bits as in a bag of ``record``.

    Parameters
    ----------
    scenario : str, Path, Scenario or RigidBody, optional
        A str is the name of a scenario of the package, a Path that of a ROS 2 parameter file. None: the defaults.
    start : State, optional
        Attitude and body rate at the start, over those of the scenario.
    duration : float
        Length, s: the last sample comes less than this time after the first.
    seeds : iterable of int, optional
        Values of the parameter ``sensor_seed``, for as many runs. They share the truth, which is computed once.
    memory_limit : int, optional
        Memory that the runs may take, bytes.
    **parameters
        Parameters by their public names, over those of the scenario.

    Returns
    -------
    Run, or tuple of Run
        A tuple where seeds are given, in their order.

    Warns
    -----
    UserWarning
        If something is asked of a sensor that is off.

    Raises
    ------
    InputError
        If the duration is not a time, a name is unknown, the parameters make no scenario, or the memory limit leaves no
        room for the runs. This is known before anything is computed.
    """
    length = exact_duration(plain(duration), "duration", "duration=60.0")
    if parameters.get("record_path"):
        path = shown(parameters["record_path"])
        raise InputError(f"record_path {path} is for the node: call to_bag({path}) of the run")
    parameters = {**_start(start), **parameters}
    given = _merged(scenario, parameters)
    chosen = list[dict[str, object]]([{}])
    if seeds is not None:
        if "sensor_seed" in parameters:
            raise InputError(f"sensor_seed {parameters['sensor_seed']!r} is given beside seeds: give one of them")
        most = max(1, memory_limit // _RUN_BYTES) if isinstance(memory_limit, int) else 1
        chosen = [{"sensor_seed": seed} for seed in _chosen(seeds, most)]
    scenarios = (Scenario.from_parameters({**given, **seed}) for seed in chosen)
    first = next(scenarios)
    for sentence in first.without_effect:
        warnings.warn(sentence, stacklevel=2)
    _require_memory(first, length, len(chosen), memory_limit)
    motions = partial(motions_of, clocks=defaultdict(LastCall))
    simulations = [Simulation(one, motions=motions) for one in (first, *scenarios)]
    end_ns = simulations[0].clock.last_ns_before(length)
    first.require_until(end_ns - first.epoch_ns)
    runs = [Run.of(simulations.pop(0), end_ns) for _ in chosen]  # nothing of each is kept but its run
    return runs[0] if seeds is None else tuple(runs)


def scenario_of(scenario: str | Path | Scenario | None, parameters: Mapping[str, object]) -> Scenario:
    """The scenario of a name, a file or a scenario, with parameters over its own.

    Raises
    ------
    InputError
    """
    return Scenario.from_parameters(_merged(scenario, parameters))


def _merged(scenario: GivenScenario, parameters: Mapping[str, object]) -> dict[str, object]:
    """Parameters over those of a scenario, whose knots another path takes the place of."""
    own = _parameters(scenario)
    if {"path_file", "path_interval"} & parameters.keys():
        own.pop("path_knots", None)
    return with_path({**own, **parameters})


def _start(start: State | None) -> dict[str, object]:
    """Parameters of a start."""
    if start is None:
        return {}
    if not isinstance(start, State) or start.body_rate.shape != (3,):
        raise InputError(f"start {shown(start)} is no State of one instant: give State(attitude_xyzw, body_rate)")
    return {"initial_attitude_xyzw": start.attitude_xyzw.tolist(), "initial_body_rate": start.body_rate.tolist()}


def _chosen(seeds: Iterable[int], most: int) -> list[int]:
    """Seeds as a list, cut off at one more than the memory has room for."""
    try:
        chosen = list(islice(plain(seeds), most + 1))
    except TypeError:
        raise InputError(f"seeds {shown(seeds)} are no numbers in a row: give for example seeds=range(3)") from None
    if not chosen:
        raise InputError("seeds are none: give at least one, for example seeds=range(3)")
    return chosen


def _require_memory(scenario: Scenario, duration: Fraction, runs: int, memory_limit: int) -> None:
    """Refuse runs that would take more memory than is allowed, before any is computed."""
    truth = SampleClock(0, scenario.rate).count_before(duration)
    readings = [SampleClock(0, model.rate).count_before(duration) for model in scenario.sensors.on.values()]
    kept = (runs + 1) * _KEPT_BYTES * sum(readings) + runs * _RUN_BYTES
    samples = truth + runs * sum(readings)
    least = truth * _TRUTH_BYTES + max(readings, default=0) * _READING_BYTES + kept
    if type(plain(memory_limit)) is not int:
        raise InputError(f"memory_limit {shown(memory_limit)} is not a number of bytes: give an integer")
    if memory_limit < least:
        raise InputError(
            f"memory_limit {memory_limit} bytes is too little for {samples} samples in {runs} runs, which take "
            f"{least}: ask for fewer at once, or give a larger memory_limit"
        )


def _parameters(scenario: GivenScenario) -> dict[str, object]:
    if isinstance(scenario, RigidBody):
        return {"inertia": scenario.inertia[np.triu_indices(3)].tolist()}
    if isinstance(scenario, Scenario):
        return dict(scenario.parameters())
    if isinstance(scenario, Path):
        return gather(None, [scenario], [])
    if isinstance(scenario, str) and (Path(scenario).name != scenario or scenario.endswith((".yaml", ".yml"))):
        raise InputError(f"scenario {shown(scenario)} is no name of one, but a path: give it as pathlib.Path(...)")
    if scenario is None or isinstance(scenario, str):
        return gather(scenario, [], [])
    raise InputError(f"scenario {shown(scenario)} is no name: give that of a scenario, a Path of a file, or a Scenario")


class BlindRun(Run):
    """The readings of a run whose ``truth`` is None. Its methods that would tell the truth raise `InputError`."""

    _centre = None
    vibration = None  # its phases would tell what the accelerometer reads beside the motion

    @classmethod
    def without_truth(cls, run: Run, given: tuple[str, ...] = ()) -> BlindRun:
        """The readings of a run, without its truth, its faults and the true biases, and parameters that are given."""
        sensors = {
            key: SensorArrays(arrays.t_ns, arrays.arrival_ns, {**arrays.arrays, **(_NO_BIASES if key == "imu" else {})})
            for key, arrays in run.sensors.items()
        }
        return cls(run.t_ns, _NO_TRUTH, sensors, _blind(run.scenario, given))

    @classmethod
    def of_readings(
        cls, scenario: Scenario, t_ns: Integers, vectors: Mapping[str, Array], field_t_ns: Integers
    ) -> BlindRun:
        """The run of readings that arrive at their stamps.

        Parameters
        ----------
        scenario : Scenario
        t_ns : ndarray of int64, shape (M,)
            Stamps of the IMU, ns.
        vectors : mapping of str to ndarray
            ``gyro``, rad/s, and ``specific_force``, m/s², of shape (M, 3), and ``field``, T, of shape (L, 3).
        field_t_ns : ndarray of int64, shape (L,)
            Stamps of the magnetometer, ns.
        """
        of_imu = {name: array for name, array in vectors.items() if name != "field"}
        sensors = {
            "imu": SensorArrays(t_ns, t_ns, {**of_imu, **_NO_BIASES, "orientation_xyzw": None}),
            "magnetometer": SensorArrays(field_t_ns, field_t_ns, {"field": vectors["field"]}),
        }
        return cls(t_ns, _NO_TRUTH, sensors, _blind(scenario))

    def __getattribute__(self, name: str) -> Any:
        if name in _TELLING:
            return partial(refuse, f"run.{name}()")
        return super().__getattribute__(name)


def _blind(scenario: Scenario, given: tuple[str, ...] = ()) -> tuple[Segment, ...]:
    """The one segment of a run without its truth."""
    return (Segment(BlindScenario.of(scenario, given), 0, scenario.epoch_ns),)
