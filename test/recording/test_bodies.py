"""The bodies of a bag, by the names of its topics and by those that a user gives."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from bags import MakeBag, rewrite
from refused_bags import FAULTS, refused

from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import BagError, ChoiceError
from lie_rigid_body.messages import encode_string
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.messages.definitions import BARE_TWIST, IMU, POSE_STAMPED, STRING, TWIST_STAMPED
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.recording.mcap_contents import (
    ChunkMessages,
    McapContents,
    Progress,
    RawMessages,
    RawTopic,
    TopicKey,
)
from lie_rigid_body.recording.topic_discovery import BODY_TOPICS, Body, bodies, the_body
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system import console
from said import Error

HERE = Path("x.mcap")
POSE, RATE, TEXT = POSE_STAMPED, TWIST_STAMPED, STRING
BODY = {"/pose": POSE, "/twist": RATE, "/lie_rigid_body/scenario": TEXT}


def contents(
    topics: dict[str, str], ours: tuple[str, ...] = ("",), counts: Mapping[str, int] = MappingProxyType({})
) -> McapContents:
    tracks = [RawTopic(topic, kind, "cdr", count=counts.get(topic, 3)) for topic, kind in topics.items()]
    return McapContents(tracks={(track.topic, track.message_type): track for track in tracks}, again=[texts(ours)])


def texts(ours: tuple[str, ...]) -> Callable[[Collection[TopicKey], Progress], Iterator[ChunkMessages]]:
    """Messages of topics of texts, those of some topics scenarios."""

    def read(keys: Collection[TopicKey], progress: Progress) -> Iterator[ChunkMessages]:
        for key in tuple(keys):  # whoever asks may want fewer from part to part
            data = encode_string('{"inertia": [1, 2, 3]}' if key[0].startswith(ours) else "9 lanes")
            yield {key: RawMessages(memoryview(data), np.array([len(data)]), np.array([0]))}

    return read


def inside(namespace: str) -> dict[str, str]:
    return {f"{namespace}{topic}": kind for topic, kind in BODY.items()}


def found(topics: dict[str, str], **renamed: str) -> list[Body]:
    return bodies(HERE, contents(topics), {name.replace("__", "/"): topic for name, topic in renamed.items()})


def names(body: Body) -> tuple[str, ...]:
    return tuple(body.tracks[name].topic for name in BODY_TOPICS)


OWN = "/lie_rigid_body/scenario"
TWO = {**inside("/a"), **inside("/b")}
ELSEWHERE = {"/truth/pose": POSE, "/rates": RATE, "/sim/scenario": TEXT}
TRUTH = {**BODY, "/truth/attitude": POSE, "/truth/twist": RATE}


@pytest.mark.parametrize(
    ("topics", "renamed", "wanted"),
    [
        ({**inside("/b"), **inside(""), **inside("/fleet/a")}, {}, [BODY, inside("/b"), inside("/fleet/a")]),
        ({**BODY, "/estimate/pose": POSE, "/cmd/twist": BARE_TWIST, "/chatter": TEXT}, {}, [BODY]),
        (ELSEWHERE, {}, [ELSEWHERE]),
        (TWO, {"pose": "/b/pose"}, [inside("/b")]),
        (TWO, {"scenario": f"/a{OWN}"}, [inside("/a")]),
        (TRUTH, {"pose": "/truth/attitude", "twist": "/truth/twist"}, [("/truth/attitude", "/truth/twist", OWN)]),
        ({**TRUTH, "/cmd/twist": RATE}, {"pose": "/truth/attitude"}, [("/truth/attitude", "/truth/twist", OWN)]),
        ({**BODY, "/traffic/scenario": TEXT}, {"scenario": OWN}, [BODY]),
    ],
)
def test_each_scenario_with_pose_and_twist_beside_it_or_as_named_is_a_body(topics, renamed, wanted) -> None:
    assert [names(body) for body in found(topics, **renamed)] == [tuple(body) for body in wanted]


def sensors(body: Body) -> dict[str, str]:
    return {name: track.topic for name, track in body.tracks.items() if name not in BODY_TOPICS}


def test_sensors_belong_to_the_body_of_their_namespace() -> None:
    two = found({**TWO, "/a/imu/data_raw": IMU, "/imu/bias": IMU})
    assert [sensors(body) for body in two] == [{"imu/data_raw": "/a/imu/data_raw"}, {}]
    faults = {**inside(""), **inside("/b"), "/lie_rigid_body/faults": TEXT}
    assert [sensors(body) for body in found(faults, pose="/b/pose")] == [{}]
    assert [sensors(body) for body in found(faults, pose="/pose")] == [{"~/faults": "/lie_rigid_body/faults"}]
    named = found({**BODY, "/front/imu/data_raw": IMU, "/imu2": IMU}, imu__data_raw="/imu2")
    assert sensors(named[0]) == {"imu/data_raw": "/imu2"}


@pytest.mark.parametrize(
    ("topics", "renamed", "error"),
    [
        (BODY, {"pose": "/pos"}, refused("no topic, but one like it", name="/pos", like="/pose")),
        (
            BODY,
            {"pose": "/twist"},
            refused("topic of another type", name="/twist", kind="TwistStamped", wanted="PoseStamped", those="/pose"),
        ),
        (BODY, {"imu__mag": "/x"}, refused("no topic of the type", name="/x", kind="MagneticField")),
        (
            {**BODY, "/a/pose": POSE, "/a/scenario": TEXT},
            {"pose": "/a/pose"},
            refused("no topic of the body", name="/a/twist"),
        ),
        ({**BODY, "/other/scenario": TEXT}, {}, refused("several topics", choice=f'"scenario": "{OWN}"')),
        (
            {"/truth/pose": POSE, "/ekf/pose": POSE, "/twist": RATE, "/s": TEXT},
            {},
            refused("several topics", choice='"pose": "/truth/pose"'),
        ),
    ],
)
def test_what_cannot_be_told_is_one_line(topics: dict[str, str], renamed: dict[str, str], error: Error) -> None:
    with error as caught:
        found(topics, **renamed)
    assert len(str(caught.value).splitlines()) == 1


def test_what_one_of_several_bodies_lacks_is_its_own_fault() -> None:
    without_twist = {topic: kind for topic, kind in TWO.items() if topic != "/b/twist"} | {"/b/imu/data_raw": IMU}
    mute, doubled = contents(TWO, counts={"/b/pose": 0}), contents({**TWO, "/b/lie2/scenario": TEXT})
    for held, fault, named in (
        (contents(without_twist), "no topic", {"scenario": "/b/lie_rigid_body/scenario", "topic": "/b/twist"}),
        (mute, "no message", {"topic": "/b/pose"}),
        (doubled, "several topics", {"kind": ".../scenario"}),
    ):
        whole, faulty = bodies(HERE, held, {})
        assert (whole.name, whole.fault, faulty.name) == ("/a", None, "/b")
        assert str(faulty.fault).startswith(FAULTS[fault].format_map(named))
        assert [body.name for body in bodies(HERE, held, {"pose": "/a/pose"})] == ["/a"]
    without_pose = contents({topic: kind for topic, kind in TWO.items() if topic != "/a/pose"})
    with refused("bodies", pose="/b/pose"):
        the_body(HERE, without_pose, {})
    assert sensors(bodies(HERE, contents(without_twist), {})[1]) == {"imu/data_raw": "/b/imu/data_raw"}


def test_texts_of_another_node_that_are_called_scenario_are_none() -> None:
    """Where it would matter; of a damaged scenario alone it is still told that it is damaged."""
    ours = ("/lie", "/a/lie", "/b/lie")
    for other in ("/x/scenario", "/scenario", "/m/n/scenario"):
        for topics in ({other: TEXT, **BODY}, {**BODY, other: TEXT}):
            assert [names(body) for body in bodies(HERE, contents(topics, ours), {})] == [tuple(BODY)]
    apart = {"/truth/pose": POSE, "/rates": RATE, "/lie_rigid_body/scenario": TEXT, "/x/scenario": TEXT}
    assert names(bodies(HERE, contents(apart, ours), {})[0]) == tuple(apart)[:3]
    beside = {**inside("/a"), "/c/pose": POSE, "/c/scenario": TEXT}
    assert [body.name for body in bodies(HERE, contents(beside, ours), {})] == ["/a"]
    with refused("several topics", choice=""):
        bodies(HERE, contents({**BODY, "/lie2/scenario": TEXT}, ours), {})
    alone = {"/pose": POSE, "/twist": RATE, "/scenario": TEXT}
    assert [names(body) for body in bodies(HERE, contents(alone, ours), {})] == [tuple(alone)]


def test_a_scenario_names_the_topics_of_its_body(make_bag: MakeBag, tmp_path: Path) -> None:
    """Wherever they are; where they were renamed since, its namespace tells."""
    topics = {"pose": "/truth/attitude", "twist": "/rates", "imu/data_raw": "/strapdown"}
    simulation = Simulation(Scenario.from_parameters({"imu_rate": 50.0}))
    path = tmp_path / "named.mcap"
    with BagWriter(
        path,
        stamped_twist=True,
        topics={**topics, "~/scenario": "/sim/scenario"},
        others={"/other/pose": POSE, "/other/imu": IMU},
    ) as bag:
        bag.begin_segment(simulation.segment)
        batch = BatchEncoder(simulation.segment.scenario).encode(simulation.take_until(490_000_000, 50))
        bag.write(batch)
        bag.write(replace(batch, topics=tuple(replace(m, topic="/other/pose") for m in batch.topics[:1])))
    found = Bag(path)
    assert (found.pose_topic, found.twist_topic, found.sensors["imu/data_raw"].topic) == tuple(topics.values())
    assert certify(path).passed
    moved = {"/truth/attitude": "/a/pose", "/rates": "/a/twist", "/sim/scenario": "/a/sim/scenario"}
    renamed = rewrite(path, tmp_path / "renamed.mcap", lambda topic: moved.get(topic, topic))
    assert Bag(renamed).pose_topic == "/a/pose"


def test_each_caller_is_told_its_own_way_to_choose(make_bag: MakeBag, tmp_path: Path) -> None:
    """In Python there is ``topics``; the verbs have an option."""
    own, path = make_bag(count=3), tmp_path / "folder"
    path.mkdir()
    for i, name in enumerate("ab"):
        rewrite(own, path / f"folder_{i}.mcap", lambda topic, name=name: f"/{name}{topic}")  # type: ignore[misc]
    with pytest.raises(ChoiceError) as caught:
        certify(path)
    assert str(caught.value).endswith('topics={"pose": "/a/pose"}')
    assert console.explanation(caught.value).endswith("--topic pose:=/a/pose")
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    assert Bag(path, topics={"pose": "/a/pose"}).pose_count == 3
    assert certify(path, topics={"pose": "/a/pose"}).passed


@pytest.mark.parametrize("kind", ["", "geometry_msgs/PoseStamped"])
def test_the_type_that_is_missing_is_named_and_not_the_topic(kind: str) -> None:
    with pytest.raises(BagError, match=r"topic /pose is .*geometry_msgs/msg/PoseStamped") as caught:
        found({"/pose": kind, "/twist": RATE, "/lie_rigid_body/scenario": TEXT})
    assert kind in str(caught.value)
