"""Readings of the sensors of a run as arrays: from a simulation, from a bag, and back into samples."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from lie_rigid_body.evaluation.attitudes import longest_rising
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.showing import data_frame
from lie_rigid_body.foundation.wording import call_repr
from lie_rigid_body.messages.batch import told_fields
from lie_rigid_body.recording.bag_reader import Recording
from lie_rigid_body.recording.segments import SensorClocks
from lie_rigid_body.recording.topic_messages import TopicMessages, in_log_order, value_columns
from lie_rigid_body.sensors import Field, Sensor, Topic
from lie_rigid_body.simulation import Segment, SensorSamples

if TYPE_CHECKING:
    from pandas import DataFrame


def read_only(array: Array | Integers) -> Array | Integers:
    """A view of an array that cannot be written."""
    view = array.view()
    view.setflags(write=False)
    return view


class SensorArrays:
    """Readings of a sensor. All arrays are read only.

    Beside those below it has the arrays that `SENSORS` names as attributes, with a row for each reading. Of an IMU
    these are ``gyro``, rad/s, ``specific_force``, m/s², the true biases in them, ``gyro_bias`` and
    ``accelerometer_bias``, each (M, 3), and ``orientation_xyzw``, (M, 4). Of a magnetometer it is ``field``, T, (M, 3).
    Of an attitude sensor they are ``attitude_xyzw``, (M, 4), and ``covariance``, rad², (M, 3, 3), of a sun sensor
    ``direction``, (M, 3). Vectors are on the sensor's axes, attitudes world-from-body, scalar last, covariances of
    small rotations about the fixed axes of the world.

    A bias is None where a bag does not tell it, and NaN at a reading for which a bag does not. An orientation is None
    unless the parameter ``imu_orientation`` is true; the identity where it is not in the segment of a reading.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (M,)
        Stamps, ns.
    arrival_ns : ndarray of int64, shape (M,)
        When each reading arrives, ns: by its latency after it is measured. Of a bag by another recorder, whose log
        times are of another clock, when it was measured.
    """

    t_ns: Integers
    arrival_ns: Integers
    # those of the sensors that come with the package, for editors: a sensor has its own only
    gyro: Array
    specific_force: Array
    gyro_bias: Any
    accelerometer_bias: Any
    orientation_xyzw: Any
    field: Array
    attitude_xyzw: Array
    covariance: Any
    direction: Array

    def __init__(self, t_ns: Integers, arrival_ns: Integers, arrays: Mapping[str, Array | None]) -> None:
        own = {"t_ns": t_ns, **arrays, "arrival_ns": arrival_ns}
        vars(self).update({name: None if array is None else read_only(array) for name, array in own.items()})

    @property
    def t_s(self) -> Array:
        """Stamps, s, shape (M,): doubles, in which times of day are known to 0.2 µs."""
        return self.t_ns / 1e9

    @property
    def arrays(self) -> dict[str, Array | None]:
        """Readings and the biases in them, by their names; None for what is not known."""
        return {name: array for name, array in vars(self).items() if name not in ("t_ns", "arrival_ns")}

    def to_dataframe(self) -> DataFrame:
        """Table of pandas with a row for each reading, by ``t_ns``, and columns such as ``gyro_x``.

        Raises
        ------
        LieRigidBodyError
            If pandas is not installed.
        """
        return data_frame(self.t_ns, {name: array for name, array in vars(self).items() if name != "t_ns"})

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"the readings of a run are read only: make other ones to change {name}")

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"this sensor reads no {name}: it has {', '.join(vars(self))}")

    def __repr__(self) -> str:
        return call_repr(self, vars(self))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.t_ns, self.arrival_ns, self.arrays)  # copies are read only as well

    @classmethod
    def of_samples(cls, sensor: Sensor, samples: SensorSamples) -> SensorArrays:
        """Make the arrays of the readings of a simulation."""
        arrays = {field.array: None for topic in sensor.topics for field in topic.fields}
        return cls(samples.stamps_ns, samples.times_ns, {**arrays, **samples.arrays})

    @classmethod
    def of_recording(cls, sensor: Sensor, recording: Recording, segments: Sequence[Segment]) -> SensorArrays | None:
        """Make the arrays of the messages of a bag, in the order in which ``ros2 bag play`` sends them.

        Readings that a recorder heard are left out where they are stamped before one that came earlier, as few as
        possible.

        Parameters
        ----------
        sensor : Sensor
        recording : Recording
        segments : sequence of Segment
            All that it declares.

        Returns
        -------
        SensorArrays or None
            None if no scenario has the sensor, nor its first topic is in the bag.
        """
        found = {
            topic.name: messages
            for topic in sensor.topics
            if isinstance(messages := recording.readings.get(topic.name), TopicMessages)
        }
        models = [s.scenario.sensors.on[sensor.name] for s in segments if sensor.name in s.scenario.sensors.on]
        name = sensor.topics[0].name
        message_type = sensor.topics[0].message_type
        if name not in found and not models:
            return None
        is_heard = not recording.is_original
        first = in_log_order(found.get(name, TopicMessages.none_of(message_type)))
        first = found[name] = first[longest_rising(first.stamps_ns)] if is_heard else first
        clocks = SensorClocks(segments, sensor.name)
        arrived_ns = clocks.measured_ns(first.stamps_ns) if is_heard else first.log_times_ns
        declared = {field.array for model in models for topic in sensor.topics for field in told_fields(topic, model)}
        arrays = {
            field.array: _array(topic, field, found.get(topic.name), first.stamps_ns, declared)
            for topic in sensor.topics
            for field in topic.fields
        }
        return cls(first.stamps_ns, arrived_ns, arrays)

    def samples(self, sensor: Sensor, begin_ns: int, end_ns: int) -> SensorSamples:
        """Take the readings that arrive from one time on and before another one, ns, as messages tell them.

        Raises
        ------
        InputError
            If something that is told on a topic of its own, as biases are, is not known.
        """
        arrays = self.arrays
        count = len(self.t_ns)
        for topic in sensor.topics[1:]:
            told = [arrays[field.array] for field in topic.fields]
            known = np.hstack([np.full((count, 1), np.nan) if array is None else array for array in told])
            if missing := count - np.count_nonzero(np.isfinite(known).all(axis=1)):
                raise InputError(
                    f"the run does not tell {topic.name} of {missing} of {count} readings of its "
                    f"{sensor.title}, which a bag holds: record all of {topic.name} as well"
                )
        readings = {name: array for name, array in arrays.items() if array is not None}
        inside = (self.arrival_ns >= begin_ns) & (self.arrival_ns < end_ns)
        return SensorSamples(self.arrival_ns, self.t_ns, np.zeros(count, dtype=np.bool_), readings)[inside]


def _array(
    topic: Topic, field: Field, messages: TopicMessages | None, t_ns: Integers, declared: Collection[str]
) -> Array | None:
    """Array of a field at the stamps of readings: None if it is not told, NaN at readings without a message."""
    columns = value_columns(topic, field)
    shape = field.shape or (len(columns),)
    if messages is None:
        return None if len(t_ns) else np.empty((0, *shape))
    if field.covariance and field.array not in declared:
        return None
    values = messages.values[:, columns].reshape(-1, *shape)
    if np.array_equal(messages.stamps_ns, t_ns):
        return values
    order = np.argsort(messages.stamps_ns, kind="stable")
    place = order[np.minimum(np.searchsorted(messages.stamps_ns[order], t_ns), len(order) - 1)]
    told = (messages.stamps_ns[place] == t_ns)[:, np.newaxis]
    return np.where(told, values[place], np.nan)
