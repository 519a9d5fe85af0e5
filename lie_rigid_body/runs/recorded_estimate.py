"""An attitude estimate in a bag, and the truth that it is held against."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.evaluation import Limits, SampledTruth, Score, Truth, evaluate
from lie_rigid_body.evaluation.arguments import unit
from lie_rigid_body.evaluation.consistency import covariance_fault
from lie_rigid_body.evaluation.score import BiasEstimate
from lie_rigid_body.messages.batch import POSE
from lie_rigid_body.messages.definitions import IMU, POSE_STAMPED, STRING, VECTOR3_STAMPED
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.bag_reader import read_scenarios
from lie_rigid_body.recording.bodies import SCENARIO, given_track, telling_of_bodies
from lie_rigid_body.recording.mcap_contents import McapContents, RawTrack, Wanted
from lie_rigid_body.recording.segments import declared_segments
from lie_rigid_body.recording.topic_messages import (
    ATTITUDE_TYPES,
    AttitudeTrack,
    read_attitudes,
    require_cdr,
    topic_messages,
)
from lie_rigid_body.runs.estimate import BIAS
from lie_rigid_body.runs.kept_attitudes import DISORDERED, STRAY, UNUSABLE, KeptAttitudes
from lie_rigid_body.runs.run import Run
from lie_rigid_body.runs.truth import ScenarioTruth
from lie_rigid_body.runs.unavoidable import bound_of, left_by_errors_of
from lie_rigid_body.simulation import Segment
from lie_rigid_body.wording import listed, short_repr, shown

TRUE_TOPICS: Final = (POSE, SCENARIO)
"""Relative names of the topics that tell the truth."""


@dataclass(frozen=True)
class RecordedEstimate:
    """The attitudes of a topic, and their truth.

    Attributes
    ----------
    track : AttitudeTrack
    truth : Truth
    source : str
        What the truth is made of: ``poses and scenario``, ``scenario`` or ``poses``.
    segments : tuple of Segment
        The scenarios that the truth's bag declares; empty if it declares none.
    covariance : ndarray, shape (N, 3, 3), or None
        The estimator's own, if it gives one at every sample that can be used.
    notes : tuple of str
        What a reader of the score should know, one sentence each.
    left_out : int
        Further estimates that there were: out of order.
    pose_topic : str or None
        Topic of the true poses.
    gyro_bias : BiasEstimate or None
        Estimated biases of the gyro, where there is a topic of them.
    """

    track: AttitudeTrack
    truth: Truth
    source: str
    segments: tuple[Segment, ...]
    covariance: Array | None
    notes: tuple[str, ...]
    left_out: int = 0
    pose_topic: str | None = None
    gyro_bias: BiasEstimate | None = None

    __repr__ = short_repr

    def score(self, limits: Limits, covariance_axes: str, due_ns: int | None = None, *, bounded: bool = True) -> Score:
        """Hold the estimate against the truth; see `evaluate`.

        Parameters
        ----------
        limits : Limits
        covariance_axes : str
            ``"world"`` or ``"body"``.
        due_ns : int, optional
            Stamp until which there should be estimates, ns; by default the end of the truth.
        bounded : bool, optional
            Whether the best that the sensors' noise allows is told as well.
        """
        score = evaluate(
            self.track.stamps_ns,
            self.track.attitude_xyzw,
            self.truth,
            limits=limits,
            covariance=self.covariance,
            covariance_axes=covariance_axes,
            bound=bound_of(self.segments, self.truth, self.track.stamps_ns) if bounded else None,
            sensors=left_by_errors_of(self.segments),
            left_out=self.left_out,
            due_ns=self.truth.last_ns if due_ns is None else due_ns,
        )
        return replace(score, gyro_bias=self.gyro_bias)


def recorded_estimate(
    bag: str | Path,
    topic: str,
    truth_bag: str | Path | None = None,
    topics: Mapping[str, str] = MappingProxyType({}),
    progress: Callable[[int], object] = lambda count: None,
) -> RecordedEstimate:
    """Read an estimate and the truth.

    Estimates that are stamped before an earlier one are left out, with a note, and so are those whose stamps leap ahead
    where later ones do not.

    Parameters
    ----------
    bag : str or Path
        An MCAP file, or a rosbag2 folder of them.
    topic : str
        Of the estimate: PoseStamped, PoseWithCovarianceStamped, QuaternionStamped, Imu, Odometry or TFMessage.
    truth_bag : str or Path, optional
        The bag with the truth, if it is another one.
    topics : mapping of str to str, optional
        What `TRUE_TOPICS` are called, by these names. Others are found by their last names.
    progress : callable, optional
        Called with the number of bytes that were read since it was called last.

    Returns
    -------
    RecordedEstimate

    Raises
    ------
    BagError
        If a bag cannot be read, the topic holds no estimate of one body, or there is no truth of one body.
    ParameterError
        If a declared scenario is impossible.
    InputError
        If an attitude is not finite, or zero.
    """
    path, topic = Path(bag), f"/{topic.lstrip('/')}"
    contents = BagFiles(path, progress).contents(_estimate_or_truth(topic, *topics.values()))
    if truth_bag is None:
        true = _true_motion(path, contents, topic, topics, near=topic)
    else:
        truth = BagFiles(truth_bag, progress).contents(_estimate_or_truth(*topics.values()))
        true = _true_motion(Path(truth_bag), truth, "", topics, near=topic)
    track, kept = read_attitudes(path, contents, topic, true.frames), KeptAttitudes(sys.maxsize)
    kept.add(track)
    kept.end()
    if kept.number_of(UNUSABLE):
        unit("estimate", track.attitude_xyzw)  # refuses them
    ordered = kept.track()
    read = held_against(ordered, true, true.until(int(ordered.stamps_ns[-1])))
    notes = (*read.notes, *(f"{told}." for told in kept.notes("estimates").values()))
    read = replace(read, notes=notes, left_out=kept.number_of(STRAY, DISORDERED))
    biases = contents.tracks.get((f"{topic}{BIAS}", VECTOR3_STAMPED))
    return read if biases is None or not biases.count else _with_bias(read, path, biases, truth_bag or path)


def _with_bias(read: RecordedEstimate, path: Path, biases: RawTrack, truth_bag: str | Path) -> RecordedEstimate:
    """An estimate with biases of the gyro beside the true ones, or with a note why these are not known."""
    found = topic_messages(path, biases.key, biases.take())
    try:
        run = Run.from_bag(truth_bag, topics={} if read.pose_topic is None else {POSE: read.pose_topic})
        truth = run.gyro_bias_at(found.stamps_ns)
    except (BagError, InputError) as error:
        return replace(read, notes=(*read.notes, f"The biases on {biases.topic} have no score: {error}."))
    return replace(read, gyro_bias=BiasEstimate(found.stamps_ns, found.values, truth))


def _estimate_or_truth(*topics: str) -> Wanted:
    """Want the messages of an estimate's topic and its biases, and of those that are said to or may tell the truth."""

    def wanted(name: str, kind: str) -> bool:
        told = kind in ATTITUDE_TYPES and (name in topics or name.rpartition("/")[2] == POSE)
        return told or (kind == VECTOR3_STAMPED and name.endswith(BIAS) and name.removesuffix(BIAS) in topics)

    return wanted


@dataclass(frozen=True)
class TrueMotion:
    """True motion as it is told: by scenarios, poses, or both.

    Parameters
    ----------
    segments : tuple of Segment
        In the order of their starts; empty if no scenario is known.
    poses : AttitudeTrack or None
    """

    segments: tuple[Segment, ...]
    poses: AttitudeTrack | None

    __repr__ = short_repr

    @property
    def frames(self) -> tuple[str, str] | None:
        """Names of the world's and the body's frame, if a scenario tells them."""
        scenario = self.segments[0].scenario if self.segments else None
        return None if scenario is None else (scenario.world_frame, scenario.body_frame)

    @property
    def source(self) -> str:
        """Names of what it is made of."""
        return " and ".join([*(["poses"] if self.poses is not None else []), *(["scenario"] if self.segments else [])])

    def until(self, last_ns: int) -> Truth:
        """The truth as a function of time; without poses it is asked until the given stamp at most."""
        if self.poses is None:
            start = self.segments[0].start_ns
            return ScenarioTruth(self.segments, start, max(last_ns, start))
        stamps, first = np.unique(self.poses.stamps_ns, return_index=True)
        attitude = self.poses.attitude_xyzw[first]
        if not self.segments:
            return SampledTruth(stamps, attitude)
        return ScenarioTruth.of_samples(self.segments, stamps, attitude)


def _true_motion(
    path: Path, contents: McapContents, estimate_topic: str, topics: Mapping[str, str], near: str
) -> TrueMotion:
    """The truth in a bag, in which the topic of the estimate is not the truth, whatever its name.

    Of several bodies it is that in the namespace of a topic that is given, or else of the topic `near`.
    """
    if estimate_topic in topics.values():
        raise InputError(f"--topic {estimate_topic}: that is the estimate: name the topic of the truth")
    given = {name: given_track(path, contents, name, topic) for name, topic in topics.items()}
    near = next(iter(topics.values()), near)
    others = [track for track in contents.tracks.values() if track.count and track.topic != estimate_topic]
    # a text may be that of another node, which calls something else a scenario
    telling = telling_of_bodies(path, contents, [track for track in others if track.message_type == STRING])
    candidates = [track for track in others if track.message_type != STRING or track.key in telling]
    scenario = given.get(SCENARIO) or _only(path, candidates, SCENARIO, STRING, near)
    segments: tuple[Segment, ...] = ()
    if scenario is not None:
        require_cdr(path, scenario)
        told = read_scenarios(path, contents, scenario)
        segments = tuple(declared_segments((text for _, text in told), f"{path}").values())
        candidates = [track for track in candidates if track.topic == pose_beside(scenario.topic)]
    pose = given.get(POSE) or _only(path, candidates, POSE, POSE_STAMPED, near)
    if scenario is None and pose is None:
        raise BagError(
            f"{path} has no truth, neither a topic .../scenario nor .../pose: give the bag that has it by --truth, or "
            "its topic by --topic pose:=/NAME"
        )
    return TrueMotion(segments, None if pose is None else read_attitudes(path, contents, pose.topic))


def held_against(track: AttitudeTrack, true: TrueMotion, truth: Truth) -> RecordedEstimate:
    """An estimate and its truth, with what a reader of the score should know of them."""
    covariance = track.covariance
    usable = covariance is not None and covariance_fault(covariance) == ""
    notes = tuple(_notes(track, true))
    return RecordedEstimate(
        track,
        truth,
        true.source,
        true.segments,
        covariance if usable else None,
        notes,
        pose_topic=None if true.poses is None else true.poses.topic,
    )


def _notes(track: AttitudeTrack, true: TrueMotion) -> Iterator[str]:
    if true.poses is None:
        start, first = true.segments[0].start_ns, int(track.stamps_ns[0])
        yield (
            f"The truth is that of the scenario alone, from {start / 1e9:.13g} s on; the estimate begins "
            f"{(first - start) / 1e9:.9g} s after that."
        )
    # an Imu is stamped with the frame of the sensor (REP-145)
    world = true.frames[0] if true.frames else true.poses.frame if true.poses is not None else ""
    ours = {world}
    if track.message_type == IMU and true.segments:
        parameters = true.segments[0].scenario.parameters()
        ours |= {true.segments[0].scenario.body_frame, str(parameters.get("imu_frame", "imu_link"))}
    if track.frame not in ours and not (track.message_type == IMU and not true.segments):
        yield (
            f"The frame of the estimate is {shown(track.frame)}, that of the truth {shown(world)}: they are taken for "
            "the same. Is it the right topic?"
        )
    if true.frames and track.child_frame and track.child_frame != true.frames[1]:
        yield (
            f"The body of the estimate is {shown(track.child_frame)}, that of the truth {shown(true.frames[1])}: they "
            "are taken for the same. Is it the right body?"
        )
    fault = "" if track.covariance is None else covariance_fault(track.covariance)
    if fault:
        yield f"There is no NEES: {fault}."


def _only(path: Path, tracks: list[RawTrack], ending: str, kind: str, estimate_topic: str) -> RawTrack | None:
    """The track of a type that `nearest` finds."""
    found = {t.topic: t for t in tracks if t.message_type == kind}
    try:
        topic = nearest(found, ending, estimate_topic)
    except InputError as error:
        raise BagError(
            f"{path} has {error}: choose one, as by --topic pose:=/a/pose, or record the estimate in its namespace"
        ) from None
    return None if topic is None else found[topic]


def nearest(topics: Iterable[str], ending: str, estimate_topic: str) -> str | None:
    """The one topic with the given last name; of several that in the namespace of the estimate.

    Raises
    ------
    InputError
        If there are several, and none, or more than one, in its namespace.
    """
    found = [topic for topic in topics if topic.rpartition("/")[2] == ending]
    if len(found) > 1:
        # that of the scenario is a private topic of the node, that of the poses is not
        spaces = {topic: namespace(topic) if ending == "scenario" else topic.rpartition("/")[0] for topic in found}
        near = [topic for topic, space in spaces.items() if space and estimate_topic.startswith(f"{space}/")]
        found = near if len(near) == 1 else found
    if len(found) > 1:
        raise InputError(f"several topics .../{ending}: {listed(sorted(found))}")
    return found[0] if found else None


def namespace(private_topic: str) -> str:
    """The namespace of the node that publishes a private topic, such as that of the scenario."""
    return private_topic.rsplit("/", 2)[0]


def pose_beside(scenario_topic: str) -> str:
    """The topic of the poses of the node that publishes a scenario."""
    return f"{namespace(scenario_topic)}/pose"
