"""A bag of estimates, their errors and the truth beside each other, for programs that plot and play bags."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.evaluation import Score
from lie_rigid_body.messages.definitions import TF_MESSAGE
from lie_rigid_body.runs.estimate import Estimate
from lie_rigid_body.runs.recorded_estimate import RecordedEstimate
from lie_rigid_body.runs.run import OWN_TOPICS, Run


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
    of_truth = scored[0][0].pose_topic
    run = Run.from_bag(truth, topics={} if of_truth is None else {"pose": of_truth})
    estimates, scores = {}, {}
    for read, score in scored:
        track, topic = read.track, read.track.topic
        name = f"{topic}/estimate" if topic in OWN_TOPICS or track.message_type == TF_MESSAGE else topic
        estimates[name] = Estimate(
            track.attitude_xyzw, track.stamps_ns, read.covariance, covariance_axes, _bias_at(read, track.stamps_ns)
        )
        scores[name] = score
    run.to_bag(path, estimates=estimates, scores=scores, overwrite=overwrite)


def _bias_at(read: RecordedEstimate, stamps_ns: Integers) -> Array | None:
    """Estimated biases at stamps, shape (N, 3), rad/s: the last before each; None where there are none."""
    if read.gyro_bias is None:
        return None
    last = np.searchsorted(read.gyro_bias.stamps_ns, stamps_ns, side="right") - 1
    return read.gyro_bias.estimate[np.maximum(last, 0)]
