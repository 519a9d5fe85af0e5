"""A run as arrays: the truth and what the sensors read, from a simulation or a bag, and into a bag."""

from __future__ import annotations

import functools
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.evaluation import CramerRaoBound, Limits, SampledTruth, Score, Truth
from lie_rigid_body.evaluation.arguments import integer_stamps, numbers, quantity
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.score import BiasEstimate
from lie_rigid_body.evaluation.scoring import ScoreOptions, ScoresEstimates, SensorLimits, score_estimate
from lie_rigid_body.foundation.arrays import Array, Integers, linear
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.showing import Shown, data_frame
from lie_rigid_body.foundation.wording import call_repr, shown
from lie_rigid_body.mechanics import State
from lie_rigid_body.messages.batch import FAULTS_TOPIC
from lie_rigid_body.motion.harmonics import Harmonics
from lie_rigid_body.motion.kicks import Kicks
from lie_rigid_body.motion.mass_centre import MassCentre
from lie_rigid_body.recording.bag_reader import NO_TOPICS, Bag, Recording, read_bag
from lie_rigid_body.recording.logs import Log, read_log
from lie_rigid_body.recording.samples import Block
from lie_rigid_body.recording.topic_discovery import require_topics
from lie_rigid_body.runs.bag_of_run import messages_beside, write_bag, write_log
from lie_rigid_body.runs.blind_scenario import BlindScenario
from lie_rigid_body.runs.bound import MAX_BOUNDED, THINNED, bound_of_readings, cramer_rao_bound_of, sensor_limits
from lie_rigid_body.runs.own_readings import GivenTruth, declared_sensors, log_of_arrays, sensors_of, truth_of
from lie_rigid_body.runs.readings import SensorArrays, read_only
from lie_rigid_body.runs.truth import ScenarioTruth
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import SENSORS, Fault
from lie_rigid_body.simulation import Samples, Segment, Simulation, SimulationStep

if TYPE_CHECKING:
    from pandas import DataFrame

    from lie_rigid_body.certificate import Certificate

IMU: Final = "imu"
"""Name of the IMU among the sensors of a run."""
_NO_STATE: Final[Any] = None


class _NamedSensors:
    """Sensors that come with the package, for editors: a run finds these and others by their names."""

    imu: SensorArrays
    magnetometer: SensorArrays | None
    attitude_sensor: SensorArrays | None
    sun: SensorArrays | None


@dataclass(frozen=True, eq=False)
class Run(_NamedSensors, ScoresEstimates, Shown):
    """The truth and the readings of one run, whose arrays are read only: copy one to change it.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (N,)
        Stamps of the truth, ns.
    truth : State
        Attitudes world-from-body, scalar last, shape (N, 4), and body rates, rad/s, shape (N, 3).
    imu : SensorArrays
        What the IMU read; an AttributeError where there is none.
    magnetometer, attitude_sensor, sun : SensorArrays or None
        What each other sensor of `SENSORS` read; None where there is no such sensor.
    sensors : mapping of str to SensorArrays
        The sensors that are on, by the same names.
    segments : tuple of Segment
        The scenario in force from the start, and after each reset.
    faults : tuple of Fault
        What went wrong with the sensors, in the order in which it began.
    position, velocity, acceleration : ndarray, shape (N, 3), or None
        Of the mass centre in the world frame at the stamps of the truth, m, m/s and m/s²; None where the truth is
        withheld.
    kicks : Kicks
        Stamps, ns, and body rates right after the kicks, rad/s, up to the last sample.
    sway, vibration : Harmonics or None
        The harmonics of the acceleration of the mass centre, and of the accelerometer's mount; None without.
    log : Log or None
        The readings of a run of a log or of arrays, each sensor with its own stamps; ``log.taken`` says what was taken
        for what. Such a run has no segments. Its stamps are those of its truth, or without one those of the IMU.
    """

    t_ns: Integers
    truth: State
    sensors: Mapping[str, SensorArrays]
    segments: tuple[Segment, ...]
    faults: tuple[Fault, ...] = ()
    _recording: Recording | None = None
    log: Log | None = None
    _known: SampledTruth | None = None
    _declared: Scenario | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "t_ns", read_only(self.t_ns))  # an estimate is scored by the stamps that it got

    @property
    def t_s(self) -> Array:
        """Stamps of the truth, s, shape (N,): doubles, in which times of day are known to 0.2 µs."""
        return self.t_ns / 1e9

    @property
    def left_out(self) -> dict[str, int]:
        """Numbers of readings of a bag that were stamped before one that came earlier, by their sensors."""
        recorded = {} if self._recording is None else self._recording.readings
        found = {sensor.key: recorded.get(sensor.topics[0].name, ()) for sensor in SENSORS.values()}
        left_out = {key: len(found[key]) - len(arrays.t_ns) for key, arrays in self.sensors.items()}
        return {key: count for key, count in left_out.items() if count > 0}

    def __repr__(self) -> str:
        left_out = {"left_out": self.left_out} if self.left_out else {}
        return call_repr(self, {"t_ns": self.t_ns, **self.sensors, "segments": len(self.segments), **left_out})

    def __getattr__(self, name: str) -> SensorArrays | None:
        if name == IMU and name not in self.sensors:
            raise AttributeError("the run has no IMU: give simulate imu_rate, such as imu_rate=100.0")
        if any(name == sensor.key for sensor in SENSORS.values()):
            return self.sensors.get(name)
        raise AttributeError(f"a run has no {name}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(sensor.key for sensor in SENSORS.values())]

    @cached_property
    def _centre(self) -> MassCentre | None:
        """The mass centre at the stamps of the truth; None where that is withheld or nobody knows it."""
        if self.log is not None:
            return None
        parts = [
            segment.scenario.mass_centre().at(self.t_ns[rows] - segment.start_ns) for segment, rows in self._parts()
        ]
        return functools.reduce(MassCentre.joined, parts)

    def _parts(self) -> Iterator[tuple[Segment, slice]]:
        """The segments, and the samples of the truth that are theirs."""
        bounds = np.searchsorted(self.t_ns, [segment.start_ns for segment in self.segments[1:]])
        for segment, begin, end in zip(self.segments, [0, *bounds], [*bounds, len(self.t_ns)], strict=True):
            yield segment, slice(begin, end)

    @property
    def position(self) -> Array | None:
        """Position of the mass centre in the world frame, m, shape (N, 3)."""
        return getattr(self._centre, "position", None)

    @property
    def velocity(self) -> Array | None:
        """Velocity of the mass centre in the world frame, m/s, shape (N, 3)."""
        return getattr(self._centre, "velocity", None)

    @property
    def acceleration(self) -> Array | None:
        """Acceleration of the mass centre in the world frame, m/s², shape (N, 3)."""
        return getattr(self._centre, "acceleration", None)

    @cached_property
    def kicks(self) -> Kicks:
        """The kicks up to the last sample of the truth, by their stamps, ns."""
        self._require_simulated("no kicks that are known")
        parts = []
        for segment, rows in self._parts():
            last_ns = int(self.t_ns[rows][-1]) if rows.stop > rows.start else segment.start_ns
            times_ns, rates = segment.scenario.kick_schedule().until(last_ns - segment.start_ns)
            parts.append((times_ns + segment.start_ns, rates))
        return Kicks(np.concatenate([t for t, _ in parts]), np.concatenate([rates for _, rates in parts]))

    @property
    def sway(self) -> Harmonics | None:
        """The harmonics of the acceleration of the mass centre; of a run with resets those of its first scenario."""
        return self.scenario.sway()

    @property
    def vibration(self) -> Harmonics | None:
        """The harmonics of the oscillation of the accelerometer's mount; None without."""
        imu = self.scenario.sensors.imu
        return None if imu is None else imu.vibration

    @classmethod
    def of(cls, simulation: Simulation, end_ns: int) -> Run:
        """Take a run of one segment, up to a time, ns, from a simulation that has not begun."""
        taken = simulation.take_until(end_ns, sys.maxsize)
        return cls(
            taken.samples.stamps_ns,
            taken.samples.states,
            {SENSORS[name].key: SensorArrays.of_samples(SENSORS[name], some) for name, some in taken.sensors.items()},
            (simulation.segment,),
            taken.faults,
        )

    @classmethod
    def from_bag(cls, path: str | Path, *, topics: Mapping[str, str] | None = None) -> Run:
        """Read a bag: one of this package, or one that ``ros2 bag record`` made of the running node.

        Numbers are as recorded, to the bit. Of the truth it has the samples whose pose and twist are both in the bag.
        Readings are in the order of their log times, in which ``ros2 bag play`` sends them, and of their stamps where
        these are equal. Of those that a recorder heard, `left_out` counts the ones that are stamped before one that
        came earlier, and are left out. A
        sensor is None if no scenario of the bag declares it, nor its topic is in the bag. One that is declared and
        whose readings are all lost has arrays of none. Of readings the biases are None if ``imu/bias`` is not in the
        bag; a reading whose stamp is not on that topic has the bias NaN.

        Parameters
        ----------
        path : str or Path
            An MCAP file, or a folder of them.
        topics : mapping of str to str, optional
            Topics that are called otherwise, or choose one body of several, as ``{"pose": "/a/pose"}``.

        Raises
        ------
        BagError
            If it is no bag, cut off or damaged, lacks the scenario, the poses or the twists, or has several bodies.
        ParameterError
            If it declares a scenario that cannot be.
        """
        from lie_rigid_body.certificate.survey import Surveyor

        topics = NO_TOPICS if topics is None else topics
        require_topics(topics)
        recording = Bag(path, topics=topics, in_memory=True).load()
        surveyor = Surveyor(recording)
        samples = Block.joined(surveyor.samples())
        declared = surveyor.segments
        segments = tuple(found.segment for found in surveyor.result().segments)
        found = {sensor.key: SensorArrays.of_recording(sensor, recording, declared) for sensor in SENSORS.values()}
        told = recording.readings.get(FAULTS_TOPIC)
        has_faults = any(each.scenario.sensors.has_faults for each in declared)  # else they are of others
        texts = dict.fromkeys(text for _, text in told) if has_faults and isinstance(told, list) else ()
        try:
            faults = tuple(map(Fault.from_json, texts))
        except InputError as error:
            raise BagError(f"{recording.name}: {error}") from None
        return cls(
            samples.stamps_ns,
            samples.states,
            {key: arrays for key, arrays in found.items() if arrays is not None},
            segments,
            faults,
            recording,
        )

    @classmethod
    def from_log(
        cls,
        path: str | Path,
        *,
        truth: GivenTruth = None,
        imu: str | None = None,
        magnetometer: str | None = None,
        columns: Mapping[str, str | int] | None = None,
    ) -> Run:
        """Read a log of anybody's sensors, in SI units and in the order of the file; ``log.taken`` tells what is what.

        Where the accelerometer has stamps of its own, it is linear at those of the gyro. ``run.log`` has its readings.

        Parameters
        ----------
        path : str or Path
            A bag in MCAP or SQLite with Imu, a CSV, or a folder or a zip with one CSV a sensor.
        truth : SampledTruth, tuple, str or Path, optional
            Stamps and attitudes world-from-body, a trajectory, a bag of poses, or a topic of the log.
        imu, magnetometer : str, optional
            Topics, where there are several.
        columns : mapping of str to str or int, optional
            Headers or numbers of columns, such as ``{"gyro_x": "wx:deg/s"}``; see `read_log`.

        Raises
        ------
        InputError, BagError
            With the row or the message that is at fault.
        """
        return cls._of_log(read_log(path, imu=imu, magnetometer=magnetometer, columns=columns), truth)

    @classmethod
    def from_arrays(
        cls,
        t_ns: ArrayLike,
        gyro: ArrayLike,
        specific_force: ArrayLike,
        magnetic_field: ArrayLike | tuple[ArrayLike, ArrayLike] | None = None,
        truth: SampledTruth | tuple[ArrayLike, ArrayLike] | None = None,
    ) -> Run:
        """Make a run of arrays of anybody's sensors.

        Parameters
        ----------
        t_ns : array_like of int, shape (N,)
            Stamps of the IMU, ns.
        gyro, specific_force : array_like, shape (N, 3)
            Rad/s and m/s².
        magnetic_field : array_like, shape (N, 3), or tuple, optional
            T; with a clock of its own its stamps and fields, shapes (L,) and (L, 3).
        truth : SampledTruth or tuple, optional
            Stamps and attitudes world-from-body, scalar last; NaN where they are unknown.

        Raises
        ------
        InputError
            If shapes or types are not those, or a reading is not finite.
        """
        return cls._of_log(log_of_arrays(t_ns, gyro, specific_force, magnetic_field), truth)

    @classmethod
    def _of_log(cls, log: Log, given: GivenTruth) -> Run:
        sensors = sensors_of(log)
        run = cls(sensors[IMU].t_ns, _NO_STATE, sensors, (), log=log)
        known = truth_of(log, given)
        return run if known is None else run.with_truth(known)

    @property
    def given_truth(self) -> SampledTruth | None:
        """Truth that was given beside a log; None without, and of a simulated run."""
        return self._known

    def with_truth(self, known: SampledTruth) -> Run:
        """The run of a log beside another truth, whose stamps are then those of the run."""
        t_ns = known.stamps_ns
        return replace(self, t_ns=t_ns, truth=State(*known.states(t_ns)), _known=known)

    def with_sensors(self, file: str | Path | Mapping[str, object]) -> Run:
        """A run of a log whose sensors are declared, so that it has a bound.

        Parameters
        ----------
        file : str, Path or mapping
            A parameter file, or parameters, with noise densities and the world's field; rates are those of the log.

        Raises
        ------
        InputError
            If a parameter is invalid, or the run is simulated, and declares its sensors itself.
        """
        if self.log is None:
            raise InputError("a simulated run declares its sensors itself: give simulate other parameters")
        return replace(self, _declared=declared_sensors(file, self.sensors))

    def declared(self) -> Run:
        """The run, whose sensors are taken for perfect ones where it is that of a log without declared noise."""
        return self if self.log is None or self._declared is not None else self.with_sensors({})

    @property
    def scenario(self) -> Scenario:
        """The scenario of the run; of a run with resets the first, of a log its declared sensors without a motion."""
        if self._declared is not None:
            return BlindScenario.of(self._declared)
        if not self.segments:
            raise _lacks("no scenario, which simulated runs have: run.with_sensors(file) declares its sensors")
        return self.segments[0].scenario

    def to_bag(
        self,
        path: str | Path,
        *,
        estimates: Mapping[str, Estimate | tuple[ArrayLike, ArrayLike]] | None = None,
        scores: Mapping[str, Score] | None = None,
        overwrite: bool = False,
    ) -> None:
        """Write the run into an MCAP bag: of a simulated run the same bytes as those of ``record``.

        What a recorder heard of a running node stays its recording. The new bag names the recorder as well, claims no
        samples before its first and after its last. It is certified by the same laws as the old one. Messages are
        logged at their stamps there, and the scenarios are in the words of the old bag, with the software's version.
        Biases of readings that the old one lacks are left out. Of a log the bag has no scenario, but the readings, and
        the poses of its truth.

        Parameters
        ----------
        path : str or Path
        estimates : mapping of str to Estimate, or to stamps and attitudes, optional
            Estimates by their topics, such as ``/estimate``, that are put beside the truth. Their biases of the gyro,
            rad/s, are on ``TOPIC/gyro_bias``.
        scores : mapping of str to Score, optional
            Scores by the topics of their estimates. On ``TOPIC/error_deg`` are total, heading and inclination error,
            degrees, as x, y, z; on ``TOPIC/nees`` the NEES and its 95 % bounds.
        overwrite : bool
            Replace an existing file, when the new one is whole.

        Raises
        ------
        BagError
            If the file exists and is not to be replaced, or cannot be written.
        InputError
            If the path is none, a topic is no name or the run's own, or an estimate is unusable. Also if the run has
            readings of an IMU without their biases, as some bags have one, or of a sensor that its scenario has
            not.
        """
        given = {} if estimates is None else estimates
        scored = {} if scores is None else scores
        scenario = self.declared()._declared or self.scenario
        beside = messages_beside(given, scored, scenario, self.stamped)
        if self.log is not None:
            truth = None if self._known is None else Samples(self.t_ns, self.truth)
            write_log(path, scenario, truth, self.sensors, beside, overwrite=overwrite)
            return
        write_bag(path, self.segments, self._recording, self._within, beside, overwrite=overwrite)

    def to_dataframe(self) -> DataFrame:
        """Table of pandas with a row for each stamp: the truth, and what each sensor read, NaN where it read nothing.

        Columns are named after arrays and axes: ``attitude_w``, ``body_rate_x``, ``imu_gyro_x``. The table of one
        sensor alone is that of `SensorArrays.to_dataframe`.

        Raises
        ------
        LieRigidBodyError
            If pandas is not installed.
        """
        arrays = {name: getattr(self.truth, name, None) for name in ("attitude_xyzw", "body_rate")}
        table = data_frame(self.t_ns, arrays)
        for name, readings in self.sensors.items():
            table = table.join(readings.to_dataframe().drop(columns="arrival_ns").add_prefix(f"{name}_"), how="outer")
        return table

    def certificate(self, inertia: Sequence[float] | None = None) -> Certificate:
        """Certify the run as ``check`` does: the bag that it was read from, or the bag that it would write.

        Parameters
        ----------
        inertia : sequence of float, optional
            To be used in place of the declared one, kg m².

        Returns
        -------
        Certificate
            Its ``passed``, ``messages`` and ``attitude_accuracy`` (rad) tell the verdict.
        """
        from lie_rigid_body.certificate import certify

        self._require_simulated("no scenario, by which it would be certified")
        if self._recording is not None:
            return certify(self._recording, inertia)
        with TemporaryDirectory() as folder:
            self.to_bag(Path(folder, "run.mcap"))
            return certify(read_bag(Path(folder, "run.mcap")), inertia)

    def attitude(self) -> Truth:
        """The true attitude at any time from the first sample until just before the one after the last."""
        if self._known is not None:
            return self._known
        if self.log is not None:
            raise _lacks("no truth: give one, as in Run.from_log(path, truth=file)")
        return self._attitude

    @cached_property
    def _attitude(self) -> ScenarioTruth:
        return ScenarioTruth.of_samples(self.segments, self.t_ns, self.truth.attitude_xyzw)

    def score(
        self,
        estimate_xyzw: ArrayLike | Estimate,
        t_ns: ArrayLike | None = None,
        *,
        after_s: float = 0.0,
        gyro_bias: ArrayLike | None = None,
        limits: Limits | None = None,
        covariance: ArrayLike | None = None,
        covariance_axes: str | None = None,
        converged_deg: float | None = None,
        longest_lag_s: float | None = None,
        diagnosed: bool = True,
    ) -> Score:
        """Score an attitude estimate of this run.

        Parameters
        ----------
        estimate_xyzw : array_like, shape (K, 4), or Estimate
            World-from-body, scalar last. What is given beside an `Estimate` takes the place of its own.
        t_ns : array_like of int, shape (K,), optional
            Its stamps, ns. By default those of the IMU, if it has as many readings, or of the truth.
        after_s : float
            Time after the first estimate, s, in which estimates do not count: a filter converges.
        gyro_bias : array_like, shape (K, 3), optional
            Estimated biases of the gyro at the same stamps, rad/s.
        limits, covariance_axes, converged_deg, longest_lag_s, diagnosed : optional
            As of `lie_rigid_body.evaluation.evaluate`.
        covariance : array_like, shape (K, 3, 3), (K, 6, 6), (3, 3) or (6, 6), optional
            The estimator's own, of small rotations, rad². A single one is that of every sample.

        Returns
        -------
        Score
            Its ``str`` is the table that ``evaluate`` prints; `lie_rigid_body.report` draws it.

        Raises
        ------
        InputError
            If there are no stamps of that number, the estimate is unusable, or the run does not tell the true bias.
        """
        after_s = quantity("after_s", after_s, "seconds", "after_s=10.0", or_zero=True)
        options = ScoreOptions(Limits() if limits is None else limits, converged_deg, longest_lag_s, diagnosed)
        estimate = self.stamped(
            Estimate.of(
                estimate_xyzw,
                t_ns=t_ns,
                gyro_bias=gyro_bias,
                covariance=covariance,
                covariance_axes=covariance_axes,
            )
        )
        truth = self.attitude()
        bounded_ns = int(estimate.t_ns[-1]) if diagnosed else None
        if after_s:
            late = np.flatnonzero(estimate.t_ns - estimate.t_ns[:1] >= np.round(after_s * 1e9))
            if not late.size:
                raise InputError(
                    f"after_s {after_s:g} is beyond the last estimate: give a longer run, or a shorter time"
                )
            estimate = estimate[int(late[0]) :]
            truth = truth.between(int(estimate.t_ns[0]), truth.last_ns)
        limits_of_sensors = self._limits(truth, bounded_ns)
        return score_estimate(estimate, truth, options, limits_of_sensors, gyro_bias=self._bias(estimate))

    def _limits(self, truth: Truth, bounded_ns: int | None) -> SensorLimits:
        """Limits that the sensors set to estimates."""
        if self.log is not None:
            return (
                SensorLimits() if bounded_ns is None or self._declared is None else SensorLimits(self._bound(THINNED))
            )
        return sensor_limits(self.segments, truth, bounded_ns, self.imu.gyro if IMU in self.sensors else None)

    def _bias(self, estimate: Estimate) -> BiasEstimate | None:
        """The estimated biases of the gyro beside the true ones."""
        if estimate.gyro_bias is None or self.log is not None:  # which no log tells
            return None
        given = numbers("gyro_bias", estimate.gyro_bias, 3)
        truth_of_bias = self.gyro_bias_at(estimate.t_ns)
        return BiasEstimate(estimate.t_ns, given, truth_of_bias, estimate.gyro_bias_covariance)

    def cramer_rao_bound(self) -> CramerRaoBound | None:
        """Bound that the declared noise of the sensors sets to the error of any estimator that knows no dynamics.

        It is computed at each reading of the IMU; of more than 20 000 at as many, denser toward both ends. Noise and
        biases are as declared. Scale, mounting and soft iron are constants that no estimator knows, as many as a sensor
        declares. Of the hard iron there is a bound, and faults are left out. Readings that are missing or late count as
        well.

        Returns
        -------
        CramerRaoBound or None
            None without an IMU, or where a sensor that tells the attitude has no noise: the bound is 0 then.

        Raises
        ------
        InputError
            If the scenario declares more than 20 million readings, or a vector or a noise is too small or too large.
        """
        if self.log is not None:
            return self._bound(MAX_BOUNDED)
        last = max([self.t_ns[-1], *(self.imu.t_ns if IMU in self.sensors else [])])
        return cramer_rao_bound_of(self.segments, int(last))

    def _bound(self, most: int) -> CramerRaoBound | None:
        if self._declared is None:
            raise _lacks("no declared noise: declare it by run.with_sensors(file)")
        stamps = {name: arrays.t_ns for name, arrays in self.sensors.items()}
        return bound_of_readings(self._declared, self.attitude(), stamps, most)

    def _require_simulated(self, lacking: str) -> None:
        if self.log is not None:
            raise _lacks(lacking)

    def gyro_bias_at(self, t_ns: ArrayLike) -> Array:
        """The true bias of the gyro at stamps, shape (K, 3), rad/s.

        It is linear between the readings of a segment that have one, and constant before the first and after the last.

        Raises
        ------
        InputError
            If the run does not tell it, there is no such reading, or a stamp is no integer.
        """
        self._require_simulated("no true bias of its gyro")
        imu = self.sensors.get(IMU)
        bias = np.empty((0, 3)) if imu is None or imu.gyro_bias is None else imu.gyro_bias
        told = np.flatnonzero(np.isfinite(bias).all(axis=1))
        if imu is None or not told.size:
            raise InputError("the run does not tell the bias of a gyro: give it an IMU, and its bag the topic imu/bias")
        told = told[np.argsort(imu.t_ns[told], kind="stable")]
        stamps = integer_stamps("t_ns", t_ns)
        known_ns = imu.t_ns[told]
        known = bias[told]
        found = linear(stamps, known_ns, known)
        starts = [segment.start_ns for segment in self.segments[1:]]
        of_known, of_stamps = (np.searchsorted(starts, each, side="right") for each in (known_ns, stamps))
        for i in np.unique(of_known):
            own = of_known == i
            at = of_stamps == i
            found[at] = linear(stamps[at], known_ns[own], known[own])
        return found

    def stamped(self, estimate: Estimate) -> Estimate:
        """An estimate with its stamps: by default those of the readings of the IMU, or of the samples of the truth.

        Raises
        ------
        InputError
            If it is none, or has no stamps and is of another length than these.
        """
        if not isinstance(estimate, Estimate):
            raise InputError(f"{shown(estimate)} is no Estimate: give Estimate(attitude_xyzw)")
        if estimate.t_ns is not None:
            return estimate
        of_imu = self.imu.t_ns if IMU in self.sensors else self.t_ns[:0]
        for stamps in (of_imu, self.t_ns):
            if len(stamps) == len(estimate):
                return replace(estimate, t_ns=stamps)
        raise InputError(
            f"an estimate of {len(estimate)} rows goes neither with {len(of_imu)} readings of the IMU nor with "
            f"{len(self.t_ns)} samples of the truth: give its stamps as t_ns"
        )

    def _within(self, segment: Segment, begin_ns: int, end_ns: int) -> SimulationStep:
        """Truth and readings of a segment from one time on and before another one, ns."""
        kept = (self.t_ns >= begin_ns) & (self.t_ns < end_ns)
        sensors = {
            name: self.sensors[sensor.key].samples(sensor, begin_ns, end_ns)
            for name, sensor in SENSORS.items()
            if sensor.key in self.sensors
        }
        for name, samples in sensors.items():
            if len(samples) and name not in segment.scenario.sensors.on:
                raise InputError(
                    f"the run has {len(samples)} readings of a sensor, {name}, that its scenario has not: "
                    "take their topic out of the bag that it is from"
                )
        faults = tuple(fault for fault in self.faults if begin_ns <= fault.begin_ns < end_ns)
        centre = self._centre if segment.scenario.moves else None
        return SimulationStep(Samples(self.t_ns, self.truth, centre)[kept], sensors, faults)


def _lacks(what: str) -> InputError:
    """Error for what nobody knows of a run."""
    return InputError(f"a run of a log or of arrays has {what}")


def require_run(run: object) -> None:
    """Refuse what is no run.

    Raises
    ------
    InputError
    """
    if not isinstance(run, Run):
        raise InputError(f"run: {shown(run)} is no Run: give one of simulate, Run.from_bag or Run.from_log")
