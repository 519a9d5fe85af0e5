"""The transforms of a bag: those from the world to the body are its poses, and are held against the exact motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lie_rigid_body.certificate.law_result import LawResult, LawTally, Watch
from lie_rigid_body.certificate.laws import angles_between
from lie_rigid_body.certificate.limits import PATH_ERROR, TRANSLATION_ERROR, max_attitude_error
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import vectors
from lie_rigid_body.recording.bag_reader import Bag, Recording
from lie_rigid_body.recording.segments import segment_parts
from lie_rigid_body.simulation import Segment


@short_dataclass
class TransformFindings:
    """Findings about the transforms of a bag.

    Parameters
    ----------
    laws : tuple of LawResult
        Of attitude and position, where there are transforms of the body.
    not_certified : tuple of str
        What else is in their topic, in words.
    """

    laws: tuple[LawResult, ...]
    not_certified: tuple[str, ...]


def transforms(
    bag: Bag | Recording, segments: Sequence[Segment], max_attitude: float | None, watch: Watch | None
) -> TransformFindings:
    """Hold the transforms of a bag against the exact motion; those before the first segment belong to none."""
    off = "on /tf the body is {worst} %s off the exact motion (limit {limit}) at {where}"
    attitude = LawTally("transform", "rad", off % "rad", "transform", watch)
    place = LawTally("transform position", "m", off % "m", "transform", watch)
    judged = others = 0
    for track in bag.transforms() if isinstance(bag, Bag) else ():
        others += len(track)
        for i, rows in segment_parts(segments, track.stamps_ns):
            scenario = segments[i].scenario
            if (track.frame, track.child_frame) != (scenario.world_frame, scenario.body_frame):
                continue
            part = track[rows]
            numbers = np.arange(judged, judged + len(part))
            judged += len(part)
            elapsed_ns = part.stamps_ns - segments[i].start_ns
            exact = scenario.exact_motion().at(elapsed_ns)
            angle, _ = angles_between(exact.attitude_xyzw, part.attitude_xyzw)
            limit = max_attitude_error(scenario) if max_attitude is None else max_attitude
            attitude.add(angle, limit, numbers, part.stamps_ns)
            assert part.position is not None
            centre = scenario.mass_centre().at(elapsed_ns).position
            far = TRANSLATION_ERROR * vectors.norm(centre).max(initial=0.0) + (PATH_ERROR if scenario.path() else 0.0)
            place.add(vectors.norm(part.position - centre), far, numbers, part.stamps_ns)
    left = [f"transforms of other frames: {others - judged}"] if others > judged else []
    return TransformFindings((attitude.result(), place.result()) if judged else (), tuple(left))
