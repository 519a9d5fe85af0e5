"""Writing messages into an MCAP file that rosbag2 plays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Final

import zstandard  # noqa: F401  # mcap would miss it only once the file is there
from mcap.writer import CompressionType, Writer

from lie_rigid_body import __version__
from lie_rigid_body.errors import BagError
from lie_rigid_body.messages import definitions, encode_string
from lie_rigid_body.messages.batch import POSE, SENSOR_TOPICS, TWIST, Batch
from lie_rigid_body.recording.output_file import OutputFile, reason, rescue
from lie_rigid_body.simulation import SOFTWARE, Segment

POSE_TOPIC: Final = "/pose"
TWIST_TOPIC: Final = "/twist"
SCENARIO_TOPIC: Final = "/lie_rigid_body/scenario"

METADATA: Final = "lie_rigid_body"
"""Name of the metadata record that ends a finished bag, with the number of its samples."""

_CHUNK_BYTES: Final = 256 * 1024
_SAMPLE_DEPTH: Final = 10
"""Depth of the history in the quality of service of the topics of samples."""
_SEQUENCE_NUMBERS: Final = 2**32
"""MCAP counts messages in 32 bits."""


class BagWriter:
    """An MCAP file of one live or headless run.

    Use it as a context manager: leaving it finishes the file, also on KeyboardInterrupt. An exception that a signal
    handler raises *inside* a method may tear the message being written; let such handlers note the signal, and act on
    it between calls.

    Parameters
    ----------
    path : str or Path
    stamped_twist : bool
        The type of the twist topic. It holds for the whole bag, because rosbag2 knows one type per topic.
    overwrite : bool, optional
        Replace a regular file of that name, at `finish` and not before.
    max_chunk_seconds : float, optional
        Finish a chunk when its stamps span as much, s. Without it, chunks end at 256 KiB or at `flush`.
    pose_topic, twist_topic, scenario_topic : str, optional
        Full names of the topics.
    sensor_topics : mapping of str to str, optional
        Full names of the sensors' topics by their relative names; ``/`` goes before them by default. A sensor's topic
        is in the bag from its first message on.

    Raises
    ------
    BagError
        If the file cannot be created, later not written, or is taken away by another program.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        stamped_twist: bool,
        overwrite: bool = False,
        max_chunk_seconds: float | None = None,
        pose_topic: str = POSE_TOPIC,
        twist_topic: str = TWIST_TOPIC,
        scenario_topic: str = SCENARIO_TOPIC,
        sensor_topics: Mapping[str, str] | None = None,
    ) -> None:
        self._stamped_twist = stamped_twist
        self._max_chunk_ns = None if max_chunk_seconds is None else round(max_chunk_seconds * 1e9)
        self._chunk_start_ns: int | None = None
        self._sensor_topics = {topic: f"/{topic}" for topic in SENSOR_TOPICS} | dict(sensor_topics or {})
        self._counts = dict.fromkeys((POSE, TWIST, *SENSOR_TOPICS), 0)
        self._segments = 0
        self._open = True
        self._file = OutputFile(path, overwrite=overwrite)
        with self._writing():
            self._writer = Writer(
                self._file.stream, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD, enable_data_crcs=True
            )
            self._writer.start(profile="ros2", library=f"{SOFTWARE} {__version__}")
            twist = definitions.TWIST_STAMPED if stamped_twist else definitions.TWIST
            self._channels = {
                POSE: self._channel(pose_topic, definitions.POSE_STAMPED),
                TWIST: self._channel(twist_topic, twist),
            }
            self._scenario = self._channel(scenario_topic, definitions.STRING, latched=True)

    @property
    def path(self) -> Path:
        """The path of the bag, where an older file may stand until it is finished."""
        return self._file.path

    @property
    def sample_count(self) -> int:
        """How many samples of the truth were written."""
        return self._counts[POSE]

    def _channel(self, topic: str, message_type: str, *, latched: bool = False) -> int:
        schema = self._writer.register_schema(message_type, "ros2msg", definitions.definition(message_type).encode())
        qos = definitions.offered_qos_profiles(latched=latched, depth=1 if latched else _SAMPLE_DEPTH)
        return self._writer.register_channel(topic, "cdr", schema, {"offered_qos_profiles": qos})

    def begin_segment(self, segment: Segment) -> None:
        """Write the scenario message of a new segment, at the time of the segment's start.

        Raises
        ------
        BagError
            If its twists are of another type than the bag's.
        """
        if segment.scenario.stamped_twist != self._stamped_twist:
            raise BagError(f"{self.path}: stamped_twist cannot change within a bag: begin a new one")
        with self._writing():
            self._add(self._scenario, segment.start_ns, encode_string(segment.to_json()), self._segments)
            self._segments += 1

    def write(self, batch: Batch) -> None:
        """Write messages in the order of their stamps, each logged at its own.

        Parameters
        ----------
        batch : Batch
            As `BatchEncoder` makes it.
        """
        with self._writing():
            for stamp, topic, payload in batch.in_order():
                if topic not in self._channels:
                    self._channels[topic] = self._channel(self._sensor_topics[topic], SENSOR_TOPICS[topic])
                number = self._counts[topic]
                self._add(self._channels[topic], stamp, payload, number % _SEQUENCE_NUMBERS)
                self._counts[topic] = number + 1
                if topic == TWIST:
                    self._bound_chunk(stamp)

    def _add(self, channel: int, stamp: int, data: bytes, number: int) -> None:
        self._writer.add_message(channel, log_time=stamp, data=data, publish_time=stamp, sequence=number)

    def _bound_chunk(self, stamp: int) -> None:
        if self._max_chunk_ns is None:
            return
        if self._chunk_start_ns is None:
            self._chunk_start_ns = stamp
        elif stamp - self._chunk_start_ns >= self._max_chunk_ns:
            self.flush()

    def flush(self) -> None:
        """Finish the present chunk and hand it to the operating system: it survives the end of this process."""
        with self._writing():
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._file.require_intact()
            self._chunk_start_ns = None

    def require_intact(self) -> None:
        """Check that no other program has taken away what was written so far."""
        with self._writing():
            self._file.require_intact()

    def finish(self) -> None:
        """Write the indexes and close the file. Calling it again does nothing."""
        if not self._open:
            return
        self.flush()
        with self._writing():
            self._writer.add_metadata(METADATA, {"samples": str(self.sample_count)})
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.commit()
        self._open = False

    @contextmanager
    def _writing(self) -> Iterator[None]:
        if not self._open:
            raise BagError(f"{self.path} is already finished: begin a new bag")
        try:
            yield
        except BagError:
            self._abandon()
            raise
        except OSError as error:
            self._abandon()
            raise BagError(f"{self.path} cannot be written: {reason(error)}; {self._what_remains()}") from None

    def _abandon(self) -> None:
        self._open = False
        self._file.abandon()

    def _what_remains(self) -> str:
        if self._file.replaces:
            return "the older file of that name is kept: make room and record again"
        return f"make room and record again, or rescue what is whole with {rescue()}"

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is None or not self._file.replaces or issubclass(kind, KeyboardInterrupt | SystemExit):
            self.finish()
        elif self._open:
            self._abandon()  # a run that failed does not replace a bag that is whole
