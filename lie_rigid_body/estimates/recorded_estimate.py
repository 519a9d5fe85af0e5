"""An attitude estimate in a bag, the truth that it is held against, and both with their errors in another bag."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from lie_rigid_body.estimates.buffers import DISORDERED, UNUSABLE, BiasBuffer, notes_on_left_out, scorable
from lie_rigid_body.evaluation import Limits, Score, Truth
from lie_rigid_body.evaluation.arguments import unit
from lie_rigid_body.evaluation.consistency import covariance_fault, unknown_covariances
from lie_rigid_body.evaluation.estimate import BIAS_SUFFIX, Estimate
from lie_rigid_body.evaluation.score import BiasEstimate
from lie_rigid_body.evaluation.scoring import ScoreOptions, score_estimate
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed, suggestion
from lie_rigid_body.messages.batch import POSE, SENSOR_TOPICS, TWIST
from lie_rigid_body.messages.definitions import IMU, MAGNETIC_FIELD, STRING, TF_MESSAGE, TWIST_STAMPED, VECTOR3_STAMPED
from lie_rigid_body.recording.bag_files import BagFiles
from lie_rigid_body.recording.bag_reader import NO_TOPICS, read_scenarios
from lie_rigid_body.recording.mcap_contents import McapContents, Progress, RawTopic, TopicNames, unheard
from lie_rigid_body.recording.poses import is_bag, stamped_poses
from lie_rigid_body.recording.segments import declared_segments
from lie_rigid_body.recording.topic_discovery import SCENARIO, given_track, told_topics
from lie_rigid_body.recording.topic_messages import (
    ATTITUDE_TYPES,
    AttitudeTrack,
    read_attitudes,
    require_cdr,
    topic_messages,
)
from lie_rigid_body.runs.bag_of_run import OWN_TOPICS
from lie_rigid_body.runs.bound import sensor_limits
from lie_rigid_body.runs.run import Run
from lie_rigid_body.runs.true_motion import TrueMotion
from lie_rigid_body.simulation import Segment

TRUE_TOPICS: Final = (POSE, SCENARIO)
"""Relative names of the topics that tell the truth."""
TRUTH: Final = "truth"
"""Name of a topic that tells the truth, of either type."""
TRAJECTORY: Final = "trajectory"
"""Type of the attitudes of a text file."""
_STAMPED: Final = {IMU, MAGNETIC_FIELD, TWIST_STAMPED}
_OF_NODE: Final = tuple(f"/{name}" for name in (TWIST, *SENSOR_TOPICS))
_TYPES: Final[dict[str, Sequence[str]]] = {POSE: ATTITUDE_TYPES, SCENARIO: (STRING,)}


@short_dataclass
class RecordedEstimate:
    """The attitudes of a topic, and their truth.

    Attributes
    ----------
    track : AttitudeTrack
    motion : TrueMotion
        What tells the truth.
    truth : Truth
        The truth that it tells.
    notes : tuple of str
        What a reader of the score should know, one sentence each.
    left_out : int
        Further estimates that there were: out of order.
    gyro_bias : BiasEstimate or None
        Estimated biases of the gyro, where there is a topic of them.
    """

    track: AttitudeTrack
    motion: TrueMotion
    truth: Truth
    notes: tuple[str, ...] = ()
    left_out: int = 0
    gyro_bias: BiasEstimate | None = None

    @property
    def covariance(self) -> Array | None:
        """The estimator's own, shape (N, 3, 3), rad², if it gives one at every sample that can be used."""
        P = self.track.covariance
        return None if P is None or unknown_covariances(P).any() or self.fault else P

    @property
    def fault(self) -> str:
        """Reason in one line why a covariance that it gives is none; empty where there is no fault."""
        P = self.track.covariance
        told = "" if P is None else covariance_fault(P)
        return told and f"{self.track.topic}: {told}"

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
            Whether the Cramér–Rao bound is computed as well.
        """
        track = self.track
        last_ns = int(track.stamps_ns.max()) if bounded else None
        return score_estimate(
            Estimate(track.attitude_xyzw, track.stamps_ns, self.covariance, covariance_axes),
            self.truth,
            ScoreOptions(limits),
            sensor_limits(self.motion.segments, self.truth, last_ns),
            gyro_bias=self.gyro_bias,
            left_out=self.left_out,
            due_ns=self.truth.last_ns if due_ns is None else due_ns,
        )


def recorded_estimate(
    bag: str | Path,
    topic: str,
    truth_bag: str | Path | None = None,
    topics: TopicNames = NO_TOPICS,
    progress: Progress = unheard,
) -> RecordedEstimate:
    """Read an estimate and the truth.

    Estimates that are out of the order of time are left out, with a note.

    Parameters
    ----------
    bag : str or Path
        An MCAP file, or a rosbag2 folder of them; or a trajectory in a text file, which is the truth then.
    topic : str
        Of the estimate, of one of `ATTITUDE_TYPES`; or a file with a trajectory.
    truth_bag : str or Path, optional
        The bag or the trajectory with the truth, if it is another one.
    topics : mapping of str to str, optional
        What `TRUE_TOPICS` are called, by these names, or the topic of either type, as `TRUTH`. Others are found by
        their last names.
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
    if Path(topic).is_file() or not is_bag(bag):
        return _of_files(Path(bag), topic, truth_bag, topics, progress)
    # other writers than ROS leave the slash out
    path = Path(bag)
    names = (topic, f"/{topic.lstrip('/')}")
    contents = BagFiles(path, progress).contents(partial(_is_kept, (*names, *topics.values())))
    topic = names[topic not in {track.topic for track in contents.tracks.values()}]
    own = path, contents, topic
    if truth_bag is None:
        motion = _true_motion(*own, topics, near=topic)
        last_ns = _last_of_node(path, contents)
    else:
        motion, last_ns = _motion_of(Path(truth_bag), topics, progress, near=topic)
    read = _beside(motion, last_ns, read_attitudes(path, contents, topic, motion.frames))
    biases = min(
        (track for track in contents.tracks.values() if track.topic == f"{topic}{BIAS_SUFFIX}" and track.count),
        key=lambda track: track.message_type != VECTOR3_STAMPED,
        default=None,
    )
    return read if biases is None else _with_bias(read, path, contents, biases, truth_bag or path)


def _of_files(
    path: Path,
    estimate: str,
    truth_bag: str | Path | None,
    topics: TopicNames,
    progress: Progress,
) -> RecordedEstimate:
    """An estimate in a trajectory, beside the truth of another one, or of a bag."""
    if not Path(estimate).is_file():
        raise InputError(f"{estimate} is no file, and {path} no bag with topics: give a trajectory by --estimate FILE")
    motion, last_ns = _motion_of(Path(truth_bag or path), topics, progress)
    return _beside(motion, last_ns, _trajectory(Path(estimate)))


def _motion_of(path: Path, topics: TopicNames, progress: Progress, near: str = "") -> tuple[TrueMotion, int | None]:
    """The truth of a bag or a trajectory alone, and the last stamp of a node's messages in it, ns."""
    if not is_bag(path):
        return TrueMotion((), _trajectory(path)), None
    contents = BagFiles(path, progress).contents(partial(_is_kept, (*topics.values(),)))
    return _true_motion(path, contents, "", topics, near), _last_of_node(path, contents)


def _trajectory(path: Path) -> AttitudeTrack:
    """The attitudes of a file of poses, as those of a topic that is called like the file."""
    stamps, poses = stamped_poses(path)
    return AttitudeTrack(f"{path}", TRAJECTORY, stamps, np.zeros_like(stamps), poses[:, 3:], None, "")


def _beside(motion: TrueMotion, last_ns: int | None, track: AttitudeTrack) -> RecordedEstimate:
    """An estimate beside the truth, and notes; see `TrueMotion.require_same_clock` about the last stamp."""
    ordered, left_out = scorable(track)
    if len(left_out[UNUSABLE]):
        unit("estimate", track.attitude_xyzw)  # refuses them
    told = notes_on_left_out(left_out, len(ordered), "estimates")
    if motion.poses is None:
        motion.require_same_clock(int(ordered.stamps_ns[0]), last_ns)
    notes = (*motion.notes_on(ordered), *(f"{note}." for note in told))
    truth = motion.until(int(ordered.stamps_ns[-1]))
    return RecordedEstimate(ordered, motion, truth, notes, len(left_out[DISORDERED]))


def estimate_of_run(name: str, estimate: Estimate, run: Run) -> RecordedEstimate:
    """An estimate of a run, as that of a topic that is called like its estimator.

    Parameters
    ----------
    name : str
    estimate : Estimate
        With stamps.
    run : Run
        With a truth.
    """
    covariance = None if estimate.covariance is None else estimate.rotation_covariance()
    stamps = np.asarray(estimate.t_ns)
    track = AttitudeTrack(name, "", stamps, np.zeros_like(stamps), estimate.attitude_xyzw, covariance, "")
    known = AttitudeTrack("", "", run.t_ns, np.zeros_like(run.t_ns), run.truth.attitude_xyzw, None, "")
    return RecordedEstimate(track, TrueMotion(run.segments, known), run.attitude())


def _with_bias(
    read: RecordedEstimate, path: Path, contents: McapContents, biases: RawTopic, truth_bag: str | Path
) -> RecordedEstimate:
    """An estimate with biases of the gyro beside the true ones, or with a note why they have no score."""
    if biases.message_type != VECTOR3_STAMPED:
        told = f"The biases on {biases.topic} have no score: they are of {biases.message_type}: give {VECTOR3_STAMPED}."
        return replace(read, notes=(*read.notes, told))
    found = topic_messages(path, biases.key, [contents.messages(biases.key)])
    kept = BiasBuffer()
    kept.take(biases.topic, found.stamps_ns, found.values)
    stamps_ns, values = kept.finite()
    read = replace(read, notes=(*read.notes, *kept.notes))
    if not len(values):
        return read
    try:
        truth = _run_of(read, truth_bag).gyro_bias_at(stamps_ns)
    except (BagError, InputError) as error:
        return replace(read, notes=(*read.notes, f"The biases on {biases.topic} have no score: {error}."))
    return replace(read, gyro_bias=BiasEstimate(stamps_ns, values, truth))


def _is_kept(topics: Collection[str], name: str, kind: str) -> bool:
    """Whether messages are those of an estimate, of its biases, or of a topic that is said to or may tell the truth."""
    told = kind in ATTITUDE_TYPES and (name in topics or name.rpartition("/")[2] == POSE)
    return told or (kind == VECTOR3_STAMPED and name.endswith(BIAS_SUFFIX) and name.removesuffix(BIAS_SUFFIX) in topics)


def _true_motion(path: Path, contents: McapContents, estimate_topic: str, topics: TopicNames, near: str) -> TrueMotion:
    """The truth in a bag, in which the topic of the estimate is not the truth, whatever its name.

    Of several bodies it is that in the namespace of a topic that is given, or else of the topic `near`.
    """
    if TRUTH in topics:
        topics = {**topics, _named(path, contents, topics[TRUTH]): topics[TRUTH]}
        del topics[TRUTH]
    if estimate_topic in topics.values():
        raise InputError(f"{estimate_topic} is the estimate: name the topic of the truth by --truth")
    given = {name: given_track(path, contents, name, topic, _TYPES[name]) for name, topic in topics.items()}
    near = next(iter(topics.values()), near)
    others = [track for track in contents.tracks.values() if track.count and track.topic != estimate_topic]
    # a text may be that of another node, which calls something else a scenario
    telling = told_topics(path, contents, [track for track in others if track.message_type == STRING])
    candidates = [track for track in others if track.message_type != STRING or track.key in telling]
    scenario = given.get(SCENARIO) or _only(path, candidates, SCENARIO, near)
    segments: tuple[Segment, ...] = ()
    if scenario is not None:
        require_cdr(path, scenario)
        told = read_scenarios(path, contents, scenario)
        segments = tuple(declared_segments((text for _, text in told), f"{path}").values())
        candidates = [track for track in candidates if track.topic == pose_beside(scenario.topic)]
    pose = given.get(POSE) or _only(path, candidates, POSE, near)
    if scenario is None and pose is None:
        raise BagError(
            f"{path} has no truth, neither a topic .../scenario nor .../pose: give the topic of the truth, or the bag "
            "that has it, by --truth"
        )
    motion = TrueMotion(segments, None)
    return motion if pose is None else TrueMotion(segments, read_attitudes(path, contents, pose.topic, motion.frames))


def _last_of_node(path: Path, contents: McapContents) -> int | None:
    """The last stamp of readings and rates that the body's node published, ns; None without any."""
    tracks = [track for track in contents.tracks.values() if track.message_type in _STAMPED and track.count]
    known = [track for track in tracks if f"/{track.topic}".endswith(_OF_NODE)]
    ends = (topic_messages(path, track.key, [contents.messages(track.key)]).stamps_ns.max() for track in known)
    return max(map(int, ends), default=None)


def _named(path: Path, contents: McapContents, topic: str) -> str:
    """Relative name of a topic that is given as the truth: the pose, or the scenario where its messages are texts."""
    kinds = {track.message_type for track in contents.tracks.values() if track.topic == topic}
    if not kinds:
        known = [track.topic for track in contents.tracks.values() if track.message_type in ATTITUDE_TYPES]
        there = suggestion(topic, known, "topics with attitudes") if known else "no topic has attitudes"
        raise InputError(f"--truth {topic} is neither a file nor a topic of {path}: {there}")
    return SCENARIO if STRING in kinds else POSE


def _only(path: Path, tracks: list[RawTopic], ending: str, estimate_topic: str) -> RawTopic | None:
    """The track of a relative name that `nearest` finds."""
    found = {t.topic: t for t in tracks if t.message_type in _TYPES[ending]}
    try:
        return found.get(nearest(found, ending, estimate_topic) or "")
    except InputError as error:
        raise BagError(
            f"{path} has {error}: choose one, as by --topic pose:=/a/pose, or record the estimate in its namespace"
        ) from None


def nearest(topics: Iterable[str], ending: str, estimate_topic: str) -> str | None:
    """The one topic with the given last name; of several that in the namespace of the estimate.

    Raises
    ------
    InputError
        If there are several, and none, or more than one, in its namespace.
    """
    found = [topic for topic in topics if topic.rpartition("/")[2] == ending]
    if len(found) > 1:
        spaces = {topic: (pose_beside(topic) if ending == SCENARIO else topic).rpartition("/")[0] for topic in found}
        near = [topic for topic, space in spaces.items() if space and estimate_topic.startswith(f"{space}/")]
        found = near if len(near) == 1 else found
    if len(found) > 1:
        raise InputError(f"several topics .../{ending}: {listed(sorted(found))}")
    return found[0] if found else None


def pose_beside(scenario_topic: str) -> str:
    """The topic of the poses of the node that publishes a scenario, on a private topic."""
    return f"{scenario_topic.rsplit('/', 2)[0]}/{POSE}"


def _run_of(read: RecordedEstimate, truth_bag: str | Path) -> Run:
    """The run that an estimate is held against, of the bag of the truth."""
    return Run.from_bag(truth_bag, topics={} if read.motion.poses is None else {POSE: read.motion.poses.topic})


def write_scored(
    path: str | Path,
    truth: str | Path,
    scored: Sequence[tuple[RecordedEstimate, Score]],
    covariance_axes: str,
    *,
    overwrite: bool,
) -> None:
    """Write the run of a bag, estimates of it, and their errors, as `Run.to_bag` does.

    Each estimate keeps its topic, but as a pose; where the run has a topic of that name, and for transforms, it is
    ``TOPIC/estimate``.

    Parameters
    ----------
    path : str or Path
    truth : str or Path
        The bag of the truth.
    scored : sequence of (RecordedEstimate, Score)
        At least one, all of the same truth.
    covariance_axes : str
        Those that covariances were read on; the new bag has them on the world's.
    overwrite : bool
        Replace an existing file.

    Raises
    ------
    BagError, InputError
        If the truth's bag has no pose, twist and scenario, or the file cannot be written.
    """
    run = _run_of(scored[0][0], truth)
    estimates = {}
    scores = {}
    for read, score in scored:
        track = read.track
        topic = read.track.topic
        name = f"{topic}/estimate" if topic in OWN_TOPICS or track.message_type == TF_MESSAGE else topic
        told = read.gyro_bias
        bias = None
        if told is not None:  # the last before each attitude
            last = np.searchsorted(told.stamps_ns, track.stamps_ns, side="right") - 1
            bias = told.estimate[np.maximum(last, 0)]
        estimates[name] = Estimate(track.attitude_xyzw, track.stamps_ns, read.covariance, covariance_axes, bias)
        scores[name] = score
    run.to_bag(path, estimates=estimates, scores=scores, overwrite=overwrite)
