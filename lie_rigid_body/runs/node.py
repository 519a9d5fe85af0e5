"""A ROS 2 node as an estimator: a process plays the readings of a run to it, in lock-step and a domain of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.messages.encoding import ReadingEncoder
from lie_rigid_body.messages.framed import Frames
from lie_rigid_body.recording.topic_messages import NO_ORIENTATION, AttitudeTrack, attitudes_of
from lie_rigid_body.runs.estimate import Estimate
from lie_rigid_body.runs.estimators import CommandEstimator
from lie_rigid_body.runs.run import Run
from lie_rigid_body.runs.workers import Interpreter
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.simulation import SensorSamples
from lie_rigid_body.wording import listed, shown

PLAYER: Final = "lie_rigid_body.ros.play"
"""Module that plays readings to a node: nothing else here needs ROS."""
TOPIC: Final = "imu/data"
"""Topic of the attitudes of a filter, as filters of imu_tools call it."""
IMU: Final = "imu"
"""Sensor whose readings are answered, and the last of those that arrive at once."""
_BEGIN_NS: Final = 10**9
"""Time that is added to the stamps of a run, ns: 0 means that there is no time yet."""
_GRACE_S: Final = 1.0
"""Time that a player has beyond that of its run, s."""


class Reading(NamedTuple):
    """A message of a sensor."""

    arrival_ns: int
    sensor: str
    stamp_ns: int
    payload: bytes


class Play(NamedTuple):
    """What a player is to do: start a command, play it the readings, and return what it publishes on a topic."""

    node: NodeEstimator
    readings: tuple[Reading, ...]


class Answered(NamedTuple):
    """What a node has published: the full name and the type of its topic, and the messages."""

    topic: str
    message_type: str
    payloads: list[bytes]


@dataclass(frozen=True, repr=False)
class NodeEstimator(CommandEstimator):
    """An estimator that starts a node for each run.

    Attributes
    ----------
    command : str
        Program and arguments, such as ``ros2 run my_package my_filter``; no shell is started.
    timeout_s : float
        Longest time of a run, s.
    topic : str
        Topic of its attitudes.
    """

    topic: str = TOPIC

    def __call__(self, run: Run) -> Estimate:  # type: ignore[override]  # a node may tell a covariance as well
        """Attitudes that the node publishes, with their covariances where all have one.

        Raises
        ------
        InputError
            If it cannot be started, ends, hears no IMU, publishes no attitude of the body, or leaves a reading without
            an answer.
        """
        answered = self._played(Play(self, readings_of(run)))
        try:
            found = attitudes_of(*answered)
        except BagError as error:
            raise InputError(f"{self._name}: {error}") from None
        track = self._of_body(answered.topic, found, (run.scenario.world_frame, run.scenario.body_frame))
        stamps, first = np.unique(track.stamps_ns, return_index=True)  # of two answers to a reading the first
        P = track.covariance
        told = None if P is None or not P[first].any(axis=(1, 2)).all() else P[first]
        return Estimate(track.attitude_xyzw[first], stamps - _BEGIN_NS, told)

    @property
    def _name(self) -> str:
        return f"node {shown(self.command)}"

    def _played(self, play: Play) -> Answered:
        player = Interpreter("-m", PLAYER)
        try:
            reply: Answered | str = player.ask(play, self.timeout_s + _GRACE_S)
        except (EOFError, TimeoutError):
            raise InputError(
                f"{self._name} did not end within {self.timeout_s:g} s: give it more, or play it less"
            ) from None
        finally:
            player.end()
        if isinstance(reply, str):
            raise InputError(f"{self._name} {reply}")
        return reply

    def _of_body(self, topic: str, found: Mapping[Frames, AttitudeTrack], frames: Frames) -> AttitudeTrack:
        """The attitudes of the body's frames; without frames of two of the only ones that there are."""
        (first, *others) = found or [frames]
        if first not in found or not len(found[first]):
            raise InputError(f"{self._name}: {topic} {NO_ORIENTATION}")
        if frames in found:
            return found[frames]
        if others or first[1]:
            told = listed([" to ".join(filter(None, pair)) for pair in found])
            raise InputError(
                f"{self._name}: {topic} is of {told}, and not of {' to '.join(frames)}: name the frames so"
            )
        return found[first]


def readings_of(run: Run) -> tuple[Reading, ...]:
    """The readings of a run as messages in the order in which they arrive, those of the IMU after others.

    Raises
    ------
    InputError
        If there is no IMU.
    """
    if run.imu is None:
        raise InputError("a run without an IMU cannot be played to a node: give imu_rate")
    return tuple(sorted(_readings(run), key=lambda reading: (reading.arrival_ns, reading.sensor == IMU)))


def _readings(run: Run) -> Iterator[Reading]:
    for name, model in run.scenario.sensors.on.items():
        if arrays := run.sensors.get(SENSORS[name].key):
            encoder = ReadingEncoder(SENSORS[name].topics[0], model, run.scenario)  # the others tell the truth
            stamps, arrival = arrays.t_ns + _BEGIN_NS, arrays.arrival_ns + _BEGIN_NS
            told: dict[str, Array] = {field.array: getattr(arrays, field.array) for field in encoder.fields}
            payloads = encoder.encode(SensorSamples(arrival, stamps, np.zeros(len(stamps), dtype=np.bool_), told))
            yield from map(Reading, arrival.tolist(), [name] * len(stamps), stamps.tolist(), payloads)
