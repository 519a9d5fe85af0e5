"""Topics of others found in the graph, and their messages taken as bytes: those of an estimate, and of its truth."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import partial
from typing import Final, TypeAlias

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from lie_rigid_body.estimates.live_estimate import LiveEstimate
from lie_rigid_body.estimates.recorded_estimate import nearest, pose_beside
from lie_rigid_body.evaluation.estimate import BIAS_SUFFIX
from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.foundation.wording import counted, listed
from lie_rigid_body.messages.definitions import IMU, POSE_STAMPED, STRING, VECTOR3_STAMPED
from lie_rigid_body.recording.topic_messages import ATTITUDE_TYPES, wrong_type
from lie_rigid_body.ros.installation import how_to_install
from lie_rigid_body.ros.session import message_class, translated_errors

ESTIMATE: Final = "estimate"
"""Relative name of the estimate's topic, to be remapped."""
TRUE_BIAS: Final = "imu/bias"
"""Relative name of the topic of the true biases, which stand where an Imu has its readings."""
TRUTH: Final = "truth"
"""Relative name of the truth's topic, to be remapped. Without that the truth is looked for beside the estimate."""
MESSAGES_KEPT: Final = 5000
"""Messages of a topic kept between two looks at it: a simulation may send as fast as it can."""

Topics: TypeAlias = dict[str, list[str]]
"""Topics by their names, with their types."""
Hear: TypeAlias = Callable[[list[bytes]], object]
"""A function that takes messages of one topic."""


class Following:
    """The topics of an estimate and its truth, found as they appear.

    Parameters
    ----------
    node : Node
    spin : callable
        Calls back for the messages of the node that have come; see `session.listening`.
    begin : callable
        ``begin(topic, message_type)`` is called once the topic of the estimate is there.

    Attributes
    ----------
    live : LiveEstimate or None
        What was heard; None until the topic of the estimate is there.
    """

    def __init__(self, node: Node, spin: Callable[[float], None], begin: Callable[[str, str], LiveEstimate]) -> None:
        self._node = node
        self._spin = spin
        self._begin = begin
        with translated_errors("the topics estimate and truth"):
            self.estimate, self._truth = (node.resolve_topic_name(name) for name in (ESTIMATE, TRUTH))
        self.live: LiveEstimate | None = None
        self._subscriptions: dict[str, tuple[Subscription, list[bytes], Hear]] = {}
        self._true_kinds: dict[str, str] = {}
        self._crowd: dict[str, int] = {}
        self._unreadable: dict[str, tuple[int, str]] = {}

    def look(self) -> None:
        """Subscribe to what has appeared; begin anew where that is the truth, and another was taken for it.

        Raises
        ------
        InputError
            If a topic is of no type that can be used, or it is not clear which is meant when the comparison begins.
        """
        there = self.published()
        try:
            kinds = self._true_topics(there)
        except InputError:
            if self.live is None or not self.live.tally.count:
                raise
            kinds = self._true_kinds  # it was clear; who comes later does not end the comparison
        if not self._true_kinds.keys() <= kinds.keys():
            self._forget(kinds)
        if self.live is None:
            if self.estimate not in there:
                return
            kind = self._type(self.estimate, there[self.estimate], ATTITUDE_TYPES)
            self.live = self._begin(self.estimate, kind)
            self._hear(self.estimate, kind, self.live.hear_estimates)
        self._true_kinds = kinds
        truth = self.live.truth
        for topic, kind in kinds.items():
            self._hear(topic, kind, truth.hear_scenarios if kind == STRING else partial(truth.hear_poses, topic, kind))
            self._crowd[topic] = max(self._crowd.get(topic, 0), self._node.count_publishers(topic))
        biases = f"{self.estimate}{BIAS_SUFFIX}"
        if VECTOR3_STAMPED in there.get(biases, []):
            self._hear(biases, VECTOR3_STAMPED, partial(self.live.gyro_bias.hear, biases, VECTOR3_STAMPED))
            for pose in {pose_beside(topic) if kind == STRING else topic for topic, kind in kinds.items()}:
                true = f"{pose.rpartition('/')[0]}/{TRUE_BIAS}"
                if IMU in there.get(true, []):
                    self._hear(true, IMU, partial(truth.gyro_bias.hear, true, IMU))

    def _hear(self, topic: str, kind: str, hear: Hear) -> None:
        """Subscribe to a topic, once."""
        if topic not in self._subscriptions:
            payloads = list[bytes]()
            self._subscriptions[topic] = subscribe(self._node, topic, kind, payloads.append), payloads, hear

    def _forget(self, nearer: Collection[str]) -> None:
        """Forget what was heard, as a truth has appeared that is nearer to the estimate."""
        told = f"the truth is on {listed(sorted(nearer))}, not on {listed(sorted(self._true_kinds))}"
        self._node.get_logger().warning(f"{told}: the comparison of {self.estimate} begins anew")
        for subscription, _, _ in self._subscriptions.values():
            self._node.destroy_subscription(subscription)
        self.live = None
        self._subscriptions = {}
        self._crowd = {}

    def notes(self) -> Iterator[str]:
        """Sentences about the topics that a reader of the score should know."""
        for topic, (count, reason) in self._unreadable.items():
            yield f"{counted(count, 'message')} of {topic} could not be read, and count for nothing: {reason}."
        for topic, count in self._crowd.items():
            if count > 1:
                yield f"{count} nodes published the truth on {topic} at a time: a score needs one, or one's namespace."

    def take(self) -> None:
        """Hand on the messages that have come: those of the truth last, which is then ahead of the estimate."""
        before = -1
        while before < (count := sum(len(payloads) for _, payloads, _ in self._subscriptions.values())) < MESSAGES_KEPT:
            before = count
            self._spin(0.0)
        for topic, (_, payloads, hear) in self._subscriptions.items():
            come = payloads.copy()
            payloads.clear()
            if come:
                self._hand_on(topic, come, hear)

    def _hand_on(self, topic: str, payloads: list[bytes], hear: Hear) -> None:
        """Hand on messages; one that cannot be read costs itself, and the first of a topic is logged."""
        try:
            hear(payloads)
        except LieRigidBodyError as error:
            if len(payloads) > 1:
                for payload in payloads:
                    self._hand_on(topic, [payload], hear)
                return
            count, reason = self._unreadable.get(topic, (0, str(error)))
            self._unreadable[topic] = count + 1, reason
            if not count:
                self._node.get_logger().warning(f"a message of {topic} is left out: {reason}")

    def published(self) -> Topics:
        """The topics that have a publisher, with their types."""
        found = dict(self._node.get_topic_names_and_types())
        return {topic: kinds for topic, kinds in found.items() if self._node.count_publishers(topic)}

    def silence(self) -> str:
        """A sentence about what is missing, and what there is instead."""
        there = self.published()
        domain = self._node.context.get_domain_id()
        known = [t for t, kinds in there.items() if set(kinds) & set(ATTITUDE_TYPES)]
        attitudes = f"topics of types with attitudes are {listed(sorted(known)) or 'none'} in domain {domain}"
        if self.live is not None and self.live.messages:
            if self.live.truth.is_known:
                return self.live.why_not_compared()
            if silent := listed([*self._true_kinds]):
                return f"no truth of {self.estimate}: nothing came on {silent}: is its simulation paused?"
            return f"no truth of {self.estimate}: there is no topic .../scenario or .../pose: remap it, -r truth:=TOPIC"
        if self.live is not None:
            return f"nothing came on {self.estimate}, which is there: does its node get what it needs? {attitudes}"
        return f"there is no topic {self.estimate}: {attitudes}; remap it, --ros-args -r estimate:=TOPIC"

    def stop(self) -> str:
        """A sentence about why no more estimates are compared, once some were."""
        there = self.published()
        gone = [topic for topic in (self.estimate, *self._true_kinds) if topic not in there]
        if gone:
            return f"nobody publishes {listed(gone)} any more"
        return f"nothing more of {self.estimate} can be compared: is its node busy, or the simulation paused?"

    def _true_topics(self, there: Topics) -> dict[str, str]:
        """Types of the topics of the truth by their names, as far as they are there or have been."""
        there = {topic: [kind] for topic, kind in self._true_kinds.items()} | there
        if self._truth in there:
            kind = self._type(self._truth, there[self._truth], (STRING, *ATTITUDE_TYPES))
            beside = pose_beside(self._truth)
            poses = kind == STRING and POSE_STAMPED in there.get(beside, [])
            return {self._truth: kind, **({beside: POSE_STAMPED} if poses else {})}
        if not self._truth.endswith(f"/{TRUTH}") or self.estimate not in there:
            return {**self._true_kinds}  # it was remapped, and is not there yet
        others = {topic: kinds for topic, kinds in there.items() if topic != self.estimate}
        scenario = self._nearest(others, "scenario", STRING)
        if scenario is not None:
            others = {topic: kinds for topic, kinds in others.items() if topic == pose_beside(scenario)}
        pose = self._nearest(others, "pose", POSE_STAMPED)
        found = {scenario: STRING, pose: POSE_STAMPED}
        return {topic: kind for topic, kind in found.items() if topic is not None}

    def _nearest(self, there: Topics, ending: str, kind: str) -> str | None:
        try:
            return nearest([t for t, kinds in there.items() if kind in kinds], ending, self.estimate)
        except InputError as error:
            raise InputError(f"there are {error}: say which is the truth, --ros-args -r truth:=TOPIC") from None

    def _type(self, topic: str, kinds: list[str], wanted: Collection[str]) -> str:
        usable = [kind for kind in kinds if kind in wanted]
        if not usable:
            raise InputError(f"topic {topic} {wrong_type(kinds[0])}")
        if len(kinds) > 1:
            raise InputError(f"topic {topic} is of the types {listed(kinds)}: let one node publish it")
        return usable[0]


def subscribe(node: Node, topic: str, kind: str, hear: Callable[[bytes], None]) -> Subscription:
    """Subscribe to a topic, whose messages are taken as bytes.

    Parameters
    ----------
    node : Node
    topic, kind : str
        Name and message type of the topic.
    hear : callable
        Takes the bytes of a message.

    Raises
    ------
    InputError
        If the package of the message is not installed.
    """
    try:
        message = message_class(kind)
    except ImportError:
        package, _, name = kind.split("/")
        raise InputError(
            f"topic {topic} is of {package}/{name}: {package} is not installed: {how_to_install(package)}"
        ) from None
    with translated_errors(f"to listen to {topic}"):
        return node.create_subscription(message, topic, hear, _quality(node, topic), raw=True)


def _quality(node: Node, topic: str) -> QoSProfile:
    """The quality of service that every publisher of a topic offers: a wish for more would not be served."""
    offered = [info.qos_profile for info in node.get_publishers_info_by_topic(topic)]
    reliable = all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in offered)
    latched = all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
    return QoSProfile(
        depth=MESSAGES_KEPT,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
