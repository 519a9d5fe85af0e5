"""Runs of which a filter is told the readings and nothing of the truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from functools import lru_cache
from typing import Any, Final, NoReturn

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.parameters import Value
from lie_rigid_body.runs.readings import SensorArrays
from lie_rigid_body.runs.run import Run
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment

WITHHELD: Final = ("initial_attitude_xyzw", "initial_body_rate", "sensor_seed")
"""Parameters that would tell the truth, or the noise."""
_MADE_OF_THEM: Final = ("_start", "_exact_motion", "_motion_at_start", "_rate_bound")
"""Attributes that a scenario computes from them."""
_TELLING: Final = ("attitude", "score", "to_bag", "certificate", "unavoidable_error", "gyro_bias_at")
"""Methods of a run that would tell the truth, were it in a bag."""
_NO_TRUTH: Final[Any] = None


class WithheldError(InputError, AttributeError):
    """Something was asked of a run or a scenario that would tell the truth."""


def _refuse(name: str) -> NoReturn:
    raise WithheldError(
        f"{name} would tell the truth, which this run withholds: estimate from what run.imu and run.magnetometer read"
    )


class BlindScenario(Scenario):
    """A scenario without its start and its seed."""

    @classmethod
    @lru_cache(maxsize=32)  # a filter is run many times on few scenarios
    def of(cls, scenario: Scenario) -> BlindScenario:
        """What a filter may know of a scenario."""
        told = {name: value for name, value in scenario.parameters().items() if name not in WITHHELD}
        known, blind = Scenario.from_parameters(told), object.__new__(cls)
        vars(blind).update({f.name: getattr(known, f.name) for f in fields(known) if f.name not in WITHHELD})
        vars(blind)["sensor_parameters"] = tuple(pair for pair in known.sensor_parameters if pair[0] not in WITHHELD)
        return blind

    def parameters(self) -> dict[str, Value]:
        """Names and values of the parameters but those that are withheld."""
        names = [f.name for f in fields(self) if f.name not in (*WITHHELD, "sensors", "sensor_parameters")]
        return {**{name: getattr(self, name) for name in names}, **dict(self.sensor_parameters)}

    def __getattr__(self, name: str) -> Any:
        if name in (*WITHHELD, *_MADE_OF_THEM):
            _refuse(f"scenario.{name}")
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __getstate__(self) -> dict[str, object]:
        """The attributes that there are."""
        return dict(vars(self))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, BlindScenario) and self.parameters() == other.parameters()

    def __hash__(self) -> int:
        return hash(self.sensor_parameters)


class BlindRun(Run):
    """The readings of a run whose ``truth`` is None. Its methods that would tell the truth raise `InputError`."""

    @classmethod
    def without_truth(cls, run: Run) -> BlindRun:
        """The readings of a run, without its truth, its faults and the true biases."""
        told = {"gyro_bias": None, "accelerometer_bias": None}
        sensors = {
            key: SensorArrays(arrays.t_ns, arrays.arrival_ns, {**arrays.arrays, **(told if key == "imu" else {})})
            for key, arrays in run.sensors.items()
        }
        return cls(run.t_ns, _NO_TRUTH, sensors, _blind(run.scenario))

    @classmethod
    def of_readings(
        cls, scenario: Scenario, t_ns: Integers, vectors: Mapping[str, Array], field_t_ns: Integers | None
    ) -> BlindRun:
        """The run of readings that arrive at their stamps.

        Parameters
        ----------
        scenario : Scenario
        t_ns : ndarray of int64, shape (M,)
            Stamps of the IMU, ns.
        vectors : mapping of str to ndarray
            ``gyro``, rad/s, and ``specific_force``, m/s², of shape (M, 3), and ``field``, T, of shape (L, 3).
        field_t_ns : ndarray of int64, shape (L,), or None
            Stamps of the magnetometer, ns; None without one.
        """
        biases = {"gyro_bias": None, "accelerometer_bias": None, "orientation_xyzw": None}
        of_imu = {name: array for name, array in vectors.items() if name != "field"}
        sensors = {"imu": SensorArrays(t_ns, t_ns, {**of_imu, **biases})}
        if field_t_ns is not None:
            sensors["magnetometer"] = SensorArrays(field_t_ns, field_t_ns, {"field": vectors["field"]})
        return cls(t_ns, _NO_TRUTH, sensors, _blind(scenario))

    def __getattribute__(self, name: str) -> Any:
        if name in _TELLING:
            return lambda *arguments, **options: _refuse(f"run.{name}()")
        return super().__getattribute__(name)


def _blind(scenario: Scenario) -> tuple[Segment, ...]:
    """The one segment of a run without its truth."""
    return (Segment(BlindScenario.of(scenario), 0, scenario.epoch_ns),)
