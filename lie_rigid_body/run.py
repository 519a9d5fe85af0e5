"""A run that a bag holds, for use from Python: its samples as arrays, its scenario, and its certificate on demand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lie_rigid_body.arrays import Integers
from lie_rigid_body.certificate import Certificate, certify
from lie_rigid_body.certificate.segments import recorded_segments
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording import bag_reader
from lie_rigid_body.recording.bag_reader import Recording
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment
from lie_rigid_body.wording import call_repr


@dataclass(frozen=True)
class RecordedRun:
    """The samples of a bag, and what they are samples of. `read_bag` makes it.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (N,)
        Stamps of the samples that have both pose and twist, rising.
    truth : State
        Their states, of shapes (N, 4) and (N, 3), as recorded.
    segments : tuple of Segment
        The stretches between resets that have samples, each with its scenario.
    """

    t_ns: Integers
    truth: State
    segments: tuple[Segment, ...]
    _recording: Recording

    def __repr__(self) -> str:
        return call_repr(self, {"t_ns": self.t_ns, "truth": self.truth, "segments": len(self.segments)})

    @property
    def scenario(self) -> Scenario:
        """The scenario of the first segment."""
        return self.segments[0].scenario

    def certificate(self, inertia: Sequence[float] | None = None) -> Certificate:
        """Hold every law against every segment, as ``check`` does.

        Parameters
        ----------
        inertia : sequence of float, optional
            To be used in place of the declared one, kg m².

        Returns
        -------
        Certificate
            Its ``passed``, ``messages`` and ``attitude_accuracy`` (rad) tell the verdict.

        Raises
        ------
        BagError
            If the bag does not explain itself.
        """
        return certify(self._recording, inertia)


def read_bag(path: str | Path) -> RecordedRun:
    """Read a bag of this package, or one that ``ros2 bag record`` made of the running node.

    Parameters
    ----------
    path : str or Path
        An MCAP file, or a rosbag2 folder of them.

    Returns
    -------
    RecordedRun

    Raises
    ------
    BagError
        If it is no bag, cut off or damaged, or has no sample with both pose and twist.
    ParameterError
        If it declares a scenario that cannot be.
    """
    recording = bag_reader.read_bag(path)
    pieces = recorded_segments(recording)
    truth = State.trusted(
        np.concatenate([piece.states.attitude_xyzw for piece in pieces]),
        np.concatenate([piece.states.body_rate for piece in pieces]),
    )
    stamps = np.concatenate([piece.stamps_ns for piece in pieces])
    return RecordedRun(stamps, truth, tuple(piece.segment for piece in pieces), recording)
