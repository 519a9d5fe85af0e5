"""Writing messages into an MCAP file that rosbag2 plays."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Final

import numpy as np
from mcap.records import Channel, Header, Metadata, Schema

from lie_rigid_body import __version__
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.messages import definitions, encode_strings
from lie_rigid_body.messages.batch import (
    FAULTS_TOPIC,
    POSE,
    SENSOR_TOPICS,
    TWIST,
    Batch,
    BatchEncoder,
    Gathering,
    Messages,
    sensor_topics,
)
from lie_rigid_body.recording.mcap_contents import TopicNames
from lie_rigid_body.recording.mcap_writer import ChunkBuilder, McapFile, RawChunk, compressed, laid_out
from lie_rigid_body.recording.records import METADATA, RESCUE
from lie_rigid_body.simulation import SOFTWARE, Segment, Simulation
from lie_rigid_body.system.output_file import DiskQueue, OutputFile, reason, remedy

POSE_TOPIC: Final = "/pose"
TWIST_TOPIC: Final = "/twist"
SCENARIO_TOPIC: Final = "/lie_rigid_body/scenario"

LIBRARY: Final = f"{SOFTWARE} {__version__}"
"""Name by which a bag calls its writer."""

CHUNK_BYTES: Final = 512 * 1024
"""Default size of a chunk."""
_SCENARIO: Final = "~/scenario"
_LATCHED: Final = {_SCENARIO: 1, FAULTS_TOPIC: 1000}
"""Depth of the history of the topics that late subscribers hear as well."""
_SAMPLE_DEPTH: Final = 10
"""Depth of the history in the quality of service of the topics of samples."""
_TOGETHER: Final = 256
"""Messages of small batches that are laid out at once, in half a millisecond: one alone takes nearly as long."""
_SYNC_AT_LEAST: Final = 0.5
"""Time, s, after the end of a sync from which on the next flush has one, even if others wait for a slow disk."""
_MAX_BATCH: Final = 8192
"""Largest number of samples computed and written at once."""
_STEPS_PER_BATCH: Final = 10_000
"""Number of steps of the moving chart that a batch may take, if it holds more than one sample."""


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
    compression : str, optional
        Of the chunks: ``zstd``, ``lz4`` or nothing.
    chunk_size : int, optional
        Bytes after which a chunk ends.
    wait_for_disk : bool, optional
        Whether writing waits for a disk that does not keep up. Otherwise it never waits, and the bag is given up once
        32 MiB are in the queue.
    topics : mapping of str to str, optional
        Full names of topics by their relative names; ``/`` goes before them by default, and ``/lie_rigid_body`` takes
        the place of ``~``. A sensor's topic is in the bag from its first message on.
    others : mapping of str to str, optional
        Message types of further topics by their full names, as of estimates.
    library : str, optional
        Who wrote it, as its header is to say.
    end : str or None, optional
        Name of the metadata record that ends it, if one does: `records.METADATA` or `records.CUT_OFF`.
    rescued : bool, optional
        Whether the part that was written is kept where the rest cannot be.

    Attributes
    ----------
    path : Path
        The path of the bag, where an older file may stand until it is finished.

    Raises
    ------
    BagError
        If the file cannot be created, or later not written.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        stamped_twist: bool,
        overwrite: bool = False,
        compression: str = "zstd",
        chunk_size: int = CHUNK_BYTES,
        wait_for_disk: bool = True,
        topics: TopicNames | None = None,
        others: TopicNames | None = None,
        library: str = LIBRARY,
        end: str | None = METADATA,
        rescued: bool = True,
    ) -> None:
        self._stamped_twist = stamped_twist
        self._end = end
        self._compression = compression
        self._rescued = rescued
        twist = definitions.TWIST_STAMPED if stamped_twist else definitions.BARE_TWIST
        truth = {POSE: definitions.POSE_STAMPED, TWIST: twist, _SCENARIO: definitions.STRING}
        self._types = {**truth, **SENSOR_TOPICS, **(others or {})}
        usual = {topic: f"/{topic.replace('~', SOFTWARE).lstrip('/')}" for topic in self._types}
        self._names = {topic: (topics or {}).get(topic, name) for topic, name in usual.items()}
        self._counts = dict.fromkeys(self._names, 0)
        self._channels: dict[str, int] = {}
        self._gathered = Gathering()
        self._flushes = 0
        self._synced = -_SYNC_AT_LEAST
        self._open = True
        self._file = OutputFile(path, overwrite=overwrite)
        self.path = self._file.path
        self._queue = DiskQueue(waits=wait_for_disk)
        self._chunk = ChunkBuilder(chunk_size, self._put)
        with self._writing():
            self._mcap = McapFile(self._file.stream, Header("ros2", library))
            for topic in (POSE, TWIST, _SCENARIO):
                self._add_channel(topic)

    @property
    def sample_count(self) -> int:
        """Number of samples of the truth that were written."""
        return self._counts[POSE] + self._gathered.sample_count

    @property
    def topics(self) -> dict[str, str]:
        """Full names of the topics in the bag, by their relative names."""
        return {topic: self._names[topic] for topic in self._channels}

    def _add_channel(self, topic: str) -> None:
        number = len(self._channels) + 1
        kind = self._types[topic]
        schema = Schema(number, definitions.definition(kind).encode(), "ros2msg", kind)
        qos = definitions.offered_qos_profiles(latched=topic in _LATCHED, depth=_LATCHED.get(topic, _SAMPLE_DEPTH))
        channel = Channel(number, self._names[topic], "cdr", {"offered_qos_profiles": qos}, number)
        self._mcap.summary.schemas[number], self._mcap.summary.channels[number] = schema, channel
        self._channels[topic] = number
        self._chunk.add(schema)
        self._chunk.add(channel)

    def begin_segment(self, segment: Segment, text: str | None = None) -> None:
        """Write the scenario message of a new segment, at the time of the segment's start; perhaps as one had it.

        Raises
        ------
        BagError
            If its twists are of another type than the bag's.
        """
        if segment.scenario.stamped_twist != self._stamped_twist:
            raise BagError(f"{self.path}: stamped_twist cannot change within a bag: begin a new one")
        told = (POSE, TWIST, *sensor_topics(segment.scenario.sensors))
        names = {topic: self._names[topic] for topic in told}
        text = segment.to_json(names) if text is None else renamed_topics(text, names)
        with self._writing():
            self._lay_out()
            self._add([Messages(_SCENARIO, np.array([segment.start_ns]), encode_strings([text], len(text)))])

    def write(self, batch: Batch) -> None:
        """Write messages in the order of their times, each logged at its own.

        Parameters
        ----------
        batch : Batch
            As `BatchEncoder` makes it.
        """
        topics = [messages for messages in batch.topics if len(messages.payloads)]
        with self._writing():
            if not self._gathered.fits(topics):
                self._lay_out()
            self._gathered.add(topics)
            if self._gathered.message_count >= _TOGETHER:
                self._lay_out()

    def _lay_out(self) -> None:
        """Put into chunks what was gathered: each sample of a live node alone would take ten times as long."""
        self._add(self._gathered.take())

    def _add(self, topics: list[Messages]) -> None:
        if not topics:
            return
        new = sorted(
            (messages for messages in topics if messages.topic not in self._channels),
            key=lambda messages: int(messages.times_ns.min()),
        )
        numbers = self._channels | {messages.topic: len(self._channels) + 1 + i for i, messages in enumerate(new)}
        data, bounds, first = laid_out(topics, numbers, self._counts)
        done = 0
        for topic in (messages.topic for messages in new):
            self._chunk.add_messages(data, bounds[done : first[topic] + 1])
            self._add_channel(topic)
            done = first[topic]
        self._chunk.add_messages(data, bounds[done:])
        for messages in topics:
            self._counts[messages.topic] += len(messages.payloads)

    def _put(self, raw: RawChunk) -> None:
        """Have a chunk compressed and written by the disk's own thread, while the next one is laid out."""
        self._queue.put(lambda: self._mcap.add_chunk(compressed(raw.table, self._compression), raw.table), len(raw))

    def flush(self) -> None:
        """Finish the present chunk, and let it be written to the disk. It survives a loss of power as soon as it is."""
        with self._writing():
            self._lay_out()
            self._chunk.finish()
            self._flushes += 1
            self._queue.put(partial(self._sync, self._flushes))

    def _sync(self, number: int) -> None:
        if number < self._flushes and time.monotonic() - self._synced < _SYNC_AT_LEAST:
            return  # a later flush waits already: one sync, which may take longer than half a second, is for both
        self._file.sync()
        if number == 1:
            self._file.sync_folder()
        self._synced = time.monotonic()

    def wait(self) -> None:
        """Wait until what was flushed is on the disk."""
        with self._writing():
            self._queue.wait()

    def finish(self) -> None:
        """Write the indexes and close the file. Calling it again does nothing."""
        if not self._open:
            return
        with self._writing():
            self._lay_out()
            self._chunk.finish()
            self._queue.put(self._finish)
            self._queue.finish()
        self._open = False

    def _finish(self) -> None:
        if self._end is not None:
            self._mcap.add(Metadata(self._end, {"samples": str(self.sample_count)}))
        self._mcap.finish()
        self._file.commit()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        if not self._open:
            raise BagError(f"{self.path} is already finished: begin a new bag")
        try:
            yield
        except (BagError, OSError) as error:
            self._abandon()
            if isinstance(error, BagError):
                raise
            rest = f"{remedy(error)}, and rescue it with {RESCUE}"
            if self._file.replaces or not self._rescued:
                kept = "the older file of that name is kept: " * self._file.replaces
                rest = f"{kept}{remedy(error)} and record again"
            raise BagError(f"{self.path} cannot be written: {reason(error)}; {rest}") from None

    def _abandon(self) -> None:
        self._open = False
        self._queue.end(partial(self._file.discard, rescued=self._rescued))

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        holds_something = kind is None or (issubclass(kind, KeyboardInterrupt | SystemExit) and self.sample_count)
        if holds_something or not self._file.replaces:
            self.finish()
        elif self._open:
            self._abandon()  # a run that failed, or that had not begun, does not replace a bag that is whole


def renamed_topics(text: str, topics: TopicNames) -> str:
    """The text of a scenario message with other names of its topics, where it names them."""
    content = json.loads(text)
    return text if "topics" not in content else json.dumps({**content, "topics": topics})


def write_run(
    bag: BagWriter,
    simulation: Simulation,
    last_ns: int,
    computing: Callable[[], AbstractContextManager[None]] = nullcontext,
) -> Iterator[int]:
    """Write the scenario of a simulation and all that it has up to a stamp.

    Parameters
    ----------
    bag : BagWriter
    simulation : Simulation
        Of which nothing was taken yet.
    last_ns : int
        The last stamp, ns.
    computing : callable, optional
        Makes the context in which a batch is computed.

    Yields
    ------
    int
        How many samples a batch had that was written.
    """
    scenario = simulation.segment.scenario
    encoder = BatchEncoder(scenario)
    # few samples when each takes many steps, so that an interruption loses little
    size = scenario.batch_size(_MAX_BATCH, _STEPS_PER_BATCH)
    bag.begin_segment(simulation.segment)
    while simulation.next_stamp_ns <= last_ns:
        with computing():
            taken = simulation.take_until(last_ns, size)
        bag.write(encoder.encode(taken))
        yield len(taken.samples)
