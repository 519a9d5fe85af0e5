"""What the tests of bags share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

from mcap.writer import CompressionType, Writer

from foreign_bags import Message, bag_of, messages_of
from lie_rigid_body import __version__
from lie_rigid_body.messages import definitions, encode_string
from lie_rigid_body.messages.batch import FAULTS_TOPIC, POSE, SENSOR_TOPICS, TWIST, Batch, BatchEncoder, sensor_topics
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Samples, Segment, Simulation, SimulationStep

MakeBag = Callable[..., Path]


def write_samples(bag: BagWriter, scenario: Scenario, samples: Samples) -> None:
    bag.write(BatchEncoder(scenario).encode(SimulationStep(samples)))


def write_bag(path: Path, count: int = 100, batch: int = 1024, **parameters: object) -> Path:
    """Write samples of a closed-form scenario with the given parameters."""
    scenario = Scenario.from_parameters({"motion": "closed_form", **parameters})
    simulation = Simulation(scenario)
    with BagWriter(path, stamped_twist=scenario.stamped_twist) as bag:
        bag.begin_segment(simulation.segment)
        while simulation.next_sample < count:
            write_samples(bag, scenario, simulation.take(min(batch, count - simulation.next_sample)))
    return path


class PlainBag:
    """The bag that the `mcap` library's own writer makes, message by message."""

    def __init__(self, stream: BinaryIO, **options: object) -> None:
        self._writer = Writer(stream, **{"chunk_size": 256 * 1024, "enable_data_crcs": True, **options})  # type: ignore[arg-type]
        self._writer.start("ros2", f"lie_rigid_body {__version__}")
        self._types = {POSE: definitions.POSE_STAMPED, TWIST: definitions.TWIST_STAMPED, **SENSOR_TOPICS}
        self._channels = {topic: self._channel(f"/{topic}", self._types[topic], 10) for topic in (POSE, TWIST)}
        self._scenario = self._channel("/lie_rigid_body/scenario", definitions.STRING, 1, latched=True)
        self._counts: dict[int, int] = {}

    def _channel(self, topic: str, kind: str, depth: int, *, latched: bool = False) -> int:
        schema = self._writer.register_schema(kind, "ros2msg", definitions.definition(kind).encode())
        qos = definitions.offered_qos_profiles(latched=latched, depth=depth)
        return self._writer.register_channel(topic, "cdr", schema, {"offered_qos_profiles": qos})

    def begin_segment(self, segment: Segment) -> None:
        told = (POSE, TWIST, *sensor_topics(segment.scenario.sensors))
        names = {topic: f"/{topic.replace('~', 'lie_rigid_body')}" for topic in told}
        self._add(self._scenario, segment.start_ns, encode_string(segment.to_json(names)))

    def write(self, batch: Batch) -> None:
        for stamp, topic, payload in batch.in_order():
            if topic == FAULTS_TOPIC and topic not in self._channels:
                self._channels[topic] = self._channel("/lie_rigid_body/faults", definitions.STRING, 1000, latched=True)
            elif topic not in self._channels:
                self._channels[topic] = self._channel(f"/{topic}", self._types[topic], 10)
            self._add(self._channels[topic], stamp, payload)

    def _add(self, channel: int, stamp: int, payload: bytes) -> None:
        number = self._counts.get(channel, 0)
        self._counts[channel] = number + 1
        self._writer.add_message(channel, stamp, payload, stamp, number)

    def finish(self, samples: int) -> None:
        self._writer.flush()
        self._writer.add_metadata("lie_rigid_body", {"samples": str(samples)})
        self._writer.finish()


Rename = Callable[[str], str | None]


def rewrite(
    source: Path,
    target: Path,
    rename: Rename = lambda topic: topic,
    *,
    keep: Callable[[int, str], bool] = lambda number, topic: True,
    change: Callable[[int, str, bytes], bytes] = lambda number, topic, data: data,
    **options: Any,
) -> Path:
    """A copy of a bag as another recorder would have written it, which logs later, and beside it a log."""
    written, topics = list[Message](), dict[str, str]()
    for number, message in enumerate(messages_of(source)):
        topic, late = rename(message.topic), message.log_time + 5
        if topic is None:
            continue
        topics[topic] = message.kind
        if keep(number, topic):
            data = change(number, topic, message.data)
            written.append(message._replace(topic=topic, log_time=late, data=data))
            written.append(Message("/rosout", "rcl_interfaces/msg/Log", b"", late, 0, b"anything"))
    silent = topics.items() if not written or topics.keys() - {m.topic for m in written} else ()
    target.write_bytes(bag_of(written, topics=silent, **options))
    return target


COMPRESSIONS = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "": CompressionType.NONE}
