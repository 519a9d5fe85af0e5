"""A run written into a bag: its segments one after the other, and estimates and scores beside them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body import __version__
from lie_rigid_body.evaluation import Score
from lie_rigid_body.evaluation.arguments import numbers, unit
from lie_rigid_body.evaluation.consistency import factor_of
from lie_rigid_body.evaluation.estimate import BIAS_SUFFIX, Estimate
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.messages.batch import SENSOR_TOPICS, BatchEncoder, Messages, ReadingEncoder
from lie_rigid_body.messages.definitions import POSE_STAMPED, POSE_WITH_COVARIANCE_STAMPED, VECTOR3_STAMPED, places
from lie_rigid_body.messages.layout import Layout, Payloads, header
from lie_rigid_body.recording.bag_reader import Recording
from lie_rigid_body.recording.bag_writer import POSE_TOPIC, SCENARIO_TOPIC, TWIST_TOPIC, BagWriter
from lie_rigid_body.recording.records import CUT_OFF, REWRITTEN
from lie_rigid_body.recording.segments import declared_segments
from lie_rigid_body.runs.readings import SensorArrays
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import SENSORS, Sensor
from lie_rigid_body.simulation import SOFTWARE, Samples, Segment, SensorSamples, SimulationStep

OWN_TOPICS: Final = frozenset(
    {POSE_TOPIC, TWIST_TOPIC, SCENARIO_TOPIC, *(f"/{topic.replace('~', SOFTWARE)}" for topic in SENSOR_TOPICS)}
) | {f"/{SOFTWARE}{POSE_TOPIC}", f"/{SOFTWARE}{TWIST_TOPIC}"}
"""Topics of a bag with the run's own messages, truth, scenario and sensors, and those that readers take for such."""
TypedMessages: TypeAlias = tuple[Messages, str]
"""Messages of a topic, and their type."""
_TOPIC: Final = re.compile(r"(?=.{1,255}\Z)(/[A-Za-z_]\w*)+")
"""Pattern of a full topic name of ROS, of at most 255 characters."""


def write_bag(
    path: str | Path,
    segments: tuple[Segment, ...],
    recording: Recording | None,
    within: Callable[[Segment, int, int], SimulationStep],
    beside: Sequence[TypedMessages],
    *,
    overwrite: bool,
) -> None:
    """Write the segments of a recording, or of a simulation, and messages of other topics; see `Run.to_bag`.

    Parameters
    ----------
    path : str or Path
    segments : tuple of Segment
    recording : Recording or None
        Where they are from, if from a bag.
    within : callable
        ``within(segment, begin_ns, end_ns)`` gives what a segment has from one time on and before another one, ns.
    beside : sequence of (Messages, str)
        Other messages, with their types, of full topic names.
    overwrite : bool
        Replace an existing file.
    """
    declared, origin = _declared(segments, recording)
    bounds = [*pairwise([0, *(segment.start_ns for segment in [*declared.values()][1:]), 2**63 - 1])]
    pieces = [within(segment, *each) for segment, each in zip(declared.values(), bounds, strict=True)]
    origin["others"] = {messages.topic: kind for messages, kind in beside}
    with BagWriter(path, stamped_twist=segments[0].scenario.stamped_twist, overwrite=overwrite, **origin) as bag:
        for (text, segment), taken, (begin, end) in zip(declared.items(), pieces, bounds, strict=True):
            bag.begin_segment(segment, None if recording is None else text)
            batch = BatchEncoder(segment.scenario).encode(taken)
            others = (messages.between(begin, end) for messages, _ in beside)
            bag.write(replace(batch, topics=(*batch.topics, *others)))


def write_log(
    path: str | Path,
    scenario: Scenario,
    truth: Samples | None,
    sensors: Mapping[str, SensorArrays],
    beside: Sequence[TypedMessages],
    *,
    overwrite: bool,
) -> None:
    """Write the readings of a log, its truth where there is one, and messages of other topics; see `Run.to_bag`.

    Parameters
    ----------
    path : str or Path
    scenario : Scenario
        Names the frames.
    truth : Samples or None
    sensors : mapping of str to SensorArrays
    beside : sequence of (Messages, str)
        Other messages, with their types, of full topic names.
    overwrite : bool
        Replace an existing file.
    """
    none = Samples(np.empty(0, dtype=np.int64), State(np.empty((0, 4)), np.empty((0, 3))))
    batch = BatchEncoder(scenario).encode(SimulationStep(truth or none))
    readings = [
        Messages(sensor.topics[0].name, np.maximum(arrays.arrival_ns, 0), payloads)
        for sensor, arrays, payloads in encoded_readings(sensors, scenario)
    ]
    others = {messages.topic: kind for messages, kind in beside}
    topics = (*batch.topics, *readings, *(messages for messages, _ in beside))
    with BagWriter(path, stamped_twist=True, overwrite=overwrite, end=None, others=others) as bag:
        bag.write(replace(batch, topics=topics))


def encoded_readings(
    sensors: Mapping[str, SensorArrays], scenario: Scenario, later_ns: int = 0
) -> Iterator[tuple[Sensor, SensorArrays, Payloads]]:
    """Sensors that are on, with their readings as arrays and as messages, whose stamps are later by a time, ns."""
    for name, model in scenario.sensors.on.items():
        if arrays := sensors.get(SENSORS[name].key):
            encoder = ReadingEncoder(SENSORS[name].topics[0], model, scenario)
            told: dict[str, Array] = {field.array: getattr(arrays, field.array) for field in encoder.fields}
            if any(values is None for values in told.values()):
                raise InputError(
                    "the run has no accelerometer, which a message of an IMU holds: give a log that has one"
                )
            held = np.zeros(len(arrays.t_ns), dtype=np.bool_)
            samples = SensorSamples(arrays.arrival_ns + later_ns, arrays.t_ns + later_ns, held, told)
            yield SENSORS[name], arrays, encoder.encode(samples)


def messages_beside(
    estimates: Mapping[str, Estimate | tuple[ArrayLike, ArrayLike]],
    scores: Mapping[str, Score],
    scenario: Scenario,
    stamped: Callable[[Estimate], Estimate],
) -> list[TypedMessages]:
    """Messages of estimates, which are given their stamps, and of scores, with their types; see `Run.to_bag`."""
    for name, each in (("estimates", estimates), ("scores", scores)):
        if not isinstance(each, Mapping):
            raise InputError(f"{name}: {shown(each)} has no topics: give it by its topic, as {{'/estimate': ...}}")
    for topic in estimates:
        if not _TOPIC.fullmatch(str(topic)) or topic in OWN_TOPICS:
            raise InputError(f"estimates: {shown(topic)} is no name of a topic of its own: give such as '/estimate'")
    own = {topic: stamped(Estimate.of(given)) for topic, given in estimates.items()}
    for topic, score in scores.items():
        if topic not in own or not isinstance(score, Score) or not np.isin(score.stamps_ns, own[topic].t_ns).all():
            raise InputError(f"scores: {shown(topic)}: give the Score of an estimate by the topic of that estimate")
    of_estimates = (each for topic, estimate in own.items() for each in _of_estimate(topic, estimate, scenario))
    of_scores = (each for topic, score in scores.items() for each in _of_score(topic, score, scenario.world_frame))
    found = [*of_estimates, *of_scores]
    if len({messages.topic for messages, _ in found}) < len(found):
        raise InputError(f"estimates: {listed(list(estimates))}: two topics have one name: rename one")
    return found


def _of_estimate(topic: str, estimate: Estimate, scenario: Scenario) -> Iterator[TypedMessages]:
    """Attitudes as messages of a bag, and biases of the gyro below their topic where there are some."""
    yield _attitudes(topic, estimate, scenario.world_frame)
    if estimate.gyro_bias is not None:
        bias = numbers("gyro_bias", estimate.gyro_bias, 3)
        yield _messages(f"{topic}{BIAS_SUFFIX}", VECTOR3_STAMPED, scenario.body_frame, estimate.t_ns, {"vector": bias})


def _attitudes(topic: str, estimate: Estimate, frame: str) -> TypedMessages:
    """Attitudes as messages of a bag, with a covariance where there is one, and their type."""
    attitude = unit("estimate", estimate.attitude_xyzw)
    if estimate.covariance is None:
        return _messages(topic, POSE_STAMPED, frame, estimate.t_ns, {"pose.orientation": estimate.attitude_xyzw})
    factor_of(P := estimate.rotation_covariance())
    if estimate.covariance_axes == "body":
        R = quaternion.to_matrix(attitude)
        P = R @ P @ np.swapaxes(R, -1, -2)
    of_pose = np.pad(P, ((0, 0), (3, 0), (3, 0))).reshape(-1, 36)  # the position is not estimated
    fields = {"pose.pose.orientation": estimate.attitude_xyzw, "pose.covariance": of_pose}
    return _messages(topic, POSE_WITH_COVARIANCE_STAMPED, frame, estimate.t_ns, fields)


def _messages(topic: str, kind: str, frame: str, stamps_ns: Integers, fields: Mapping[str, Array]) -> TypedMessages:
    """Messages of a type with a header, of which some fields are set and all other numbers are 0, and their type.

    They are logged at their stamps, and at 0 where these are before it, as no time of MCAP is.
    """
    where = places(kind)
    layout = Layout(header(frame), [0.0] * len(where[""]), [where[name] for name in fields])
    return Messages(topic, np.maximum(stamps_ns, 0), layout.encode(stamps_ns, *fields.values())), kind


def _of_score(topic: str, score: Score, frame: str) -> Iterator[TypedMessages]:
    """Errors below a topic, with their type: total, heading, inclination, deg; NEES and bounds; gyro bias, rad/s."""
    error_deg = np.degrees(np.stack(score.error, axis=-1))
    yield _messages(f"{topic}/error_deg", VECTOR3_STAMPED, frame, score.stamps_ns, {"vector": error_deg})
    if score.consistency is not None:
        nees = score.consistency.nees
        bounds = score.consistency.bounds
        rows = np.column_stack([nees, np.broadcast_to(bounds, (len(nees), 2))])
        yield _messages(f"{topic}/nees", VECTOR3_STAMPED, frame, score.stamps_ns, {"vector": rows})
    if bias := score.gyro_bias:
        error = {"vector": bias.estimate - bias.truth}
        yield _messages(f"{topic}{BIAS_SUFFIX}_error", VECTOR3_STAMPED, frame, bias.stamps_ns, error)


def _declared(segments: tuple[Segment, ...], recording: Recording | None) -> tuple[dict[str, Segment], dict[str, Any]]:
    """The segments by the texts that declare them, and what a bag of them is to say of its writer and its end."""
    if recording is None:
        return {segment.to_json(): segment for segment in segments}, {}
    declared = declared_segments((text for _, text in recording.scenario_texts), recording.name)
    if recording.is_original:
        return declared, {"end": CUT_OFF} if recording.was_cut_off and recording.expected_samples is None else {}
    recorder = recording.library.partition(REWRITTEN)[0]
    return declared, {"end": None, "library": f"{recorder}{REWRITTEN}{__version__}"}
