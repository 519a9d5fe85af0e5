"""The transforms of a bag: those from the world to the body are its poses, and are judged as these are."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from lie_rigid_body.certificate.law_result import Laws, LawTally, Watch
from lie_rigid_body.certificate.laws import SegmentLaws
from lie_rigid_body.recording.bag_reader import AnyBag, Bag
from lie_rigid_body.recording.segments import segment_parts
from lie_rigid_body.simulation import Segment


def transforms(
    bag: AnyBag, segments: Sequence[Segment], max_attitude: float | None, watch: Watch | None
) -> tuple[Laws, list[str]]:
    """The laws of the transforms of the body, if there are some, and what else is in their topic, in words.

    Transforms before the first segment belong to none.
    """
    off = "on /tf the body is {worst} %s off the exact motion (limit {limit}) at {where}"
    attitude = LawTally("transform", "rad", off % "rad", "transform", watch)
    place = LawTally("transform position", "m", off % "m", "transform", watch)
    laws_of = cache(lambda i: SegmentLaws(segments[i], max_attitude))
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
            assert part.position is not None
            errors = laws_of(i).poses(part.stamps_ns, part.attitude_xyzw, part.position)
            for tally, (residuals, limits) in zip((attitude, place), errors, strict=True):
                tally.add(residuals, limits, numbers, part.stamps_ns)
    left = [f"transforms of other frames: {others - judged}"] if others > judged else []
    return (attitude.result(), place.result()) if judged else (), left
