"""Poses and twists of a bag as arrays, and a whole bag in memory."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeAlias, TypeVar

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.recording.mcap_contents import RawTrack
from lie_rigid_body.recording.sensor_reader import FaultMessages, SensorMessages
from lie_rigid_body.wording import short_repr

UNNAMED: Final = "the bag"
"""Name in errors of a bag that has none."""


@dataclass(frozen=True)
class PoseTrack:
    """Messages of the pose topic, in file order.

    Parameters
    ----------
    topic : str
    log_times_ns : ndarray of int64, shape (N,)
    stamps_ns : ndarray of int64, shape (N,)
    attitudes_xyzw : ndarray, shape (N, 4)
        As recorded: not normalised, perhaps not finite.
    positions : ndarray, shape (N, 3)
    frame_ids : tuple of str
        The distinct frame names, in order of appearance.
    """

    topic: str
    log_times_ns: Integers
    stamps_ns: Integers
    attitudes_xyzw: Array
    positions: Array
    frame_ids: tuple[str, ...]

    __repr__ = short_repr


@dataclass(frozen=True)
class TwistTrack:
    """Messages of the twist topic, in file order.

    Parameters
    ----------
    topic : str
    log_times_ns : ndarray of int64, shape (N,)
    stamps_ns : ndarray of int64, shape (N,), or None
        None for a bare Twist.
    body_rates : ndarray, shape (N, 3)
        The angular part, rad/s.
    linear : ndarray, shape (N, 3)
        m/s
    frame_ids : tuple of str
        The distinct frame names, in order of appearance; empty for a bare Twist.
    """

    topic: str
    log_times_ns: Integers
    stamps_ns: Integers | None
    body_rates: Array
    linear: Array
    frame_ids: tuple[str, ...]

    __repr__ = short_repr


Track = TypeVar("Track", PoseTrack, TwistTrack)
OfSensor: TypeAlias = SensorMessages | FaultMessages
TakeReadings: TypeAlias = Callable[[Mapping[str, OfSensor]], object]
"""Function that takes messages of sensors, and about their faults, by relative topic names."""


@dataclass(kw_only=True)
class BagFacts:
    """Facts of a bag beside its poses, twists and readings.

    Parameters
    ----------
    library : str
        The software that wrote the file.
    scenario_texts : list of (int, str)
        Log time, ns, and JSON of every scenario message, in file order.
    expected_samples : int or None
        Number of samples that the writer says it wrote, where it does.
    published_otherwise : int
        Messages of the three topics whose time of publishing is not their log time.
    others : tuple of str
        What the bag holds besides, in words: topics and attachments.
    undefined : tuple of str
        Topics among the three whose message definition is left out, or in a language that is not compared.
    without_checksum : int
        Chunks, or files without chunks, whose bytes stand under no checksum.
    was_cut_off : bool
        Whether `recover` says that it made the bag of a file that was cut off.
    sensors : dict of str to RawTrack
        Topics of the body's sensors, with their messages counted, by their relative names.
    name : str
        Name in errors: its path, if it has one.
    """

    library: str
    scenario_texts: list[tuple[int, str]]
    expected_samples: int | None = None
    published_otherwise: int = 0
    others: tuple[str, ...] = ()
    undefined: tuple[str, ...] = ()
    without_checksum: int = 0
    was_cut_off: bool = False
    sensors: Mapping[str, RawTrack] = field(default_factory=dict)
    name: str = UNNAMED

    __repr__ = short_repr


@dataclass(kw_only=True, repr=False)
class Recording(BagFacts):
    """Messages of a run that a bag holds, in memory. See `BagFacts` for the other parameters.

    Parameters
    ----------
    poses : PoseTrack
    twists : TwistTrack
    readings : dict of str to SensorMessages or FaultMessages
        Messages of the sensors by their relative names.
    """

    poses: PoseTrack
    twists: TwistTrack
    readings: Mapping[str, OfSensor] = field(default_factory=dict)

    @property
    def pose_topic(self) -> str:
        """Name of the topic of the poses."""
        return self.poses.topic

    @property
    def twist_topic(self) -> str:
        """Name of the topic of the twists."""
        return self.twists.topic

    @property
    def pose_count(self) -> int:
        """Number of poses."""
        return len(self.poses.log_times_ns)

    @property
    def twist_count(self) -> int:
        """Number of twists."""
        return len(self.twists.log_times_ns)

    @property
    def stamped(self) -> bool:
        """Whether twists have stamps of their own."""
        return self.twists.stamps_ns is not None

    def batches(
        self, sensors: Collection[str] = (), take: TakeReadings = lambda readings: None
    ) -> Iterator[tuple[PoseTrack, TwistTrack]]:
        """All poses and twists, as `Bag.batches` reads them."""
        take({name: self.readings[name] for name in sensors})
        yield self.poses, self.twists


def joined(tracks: Sequence[Track]) -> Track:
    """Tracks that continue each other as one."""
    if len(tracks) == 1:
        return tracks[0]
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(track, name) for track in tracks])
        for name, value in vars(tracks[0]).items()
        if isinstance(value, np.ndarray)
    }
    frames = dict.fromkeys(frame for track in tracks for frame in track.frame_ids)
    return replace(tracks[0], frame_ids=tuple(frames), **joined)
