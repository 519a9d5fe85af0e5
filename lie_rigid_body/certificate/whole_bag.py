"""The laws of a bag as a whole, beside those of its segments."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from lie_rigid_body.certificate.law_result import LawResult
from lie_rigid_body.certificate.survey import Survey
from lie_rigid_body.errors import ParameterError
from lie_rigid_body.recording.bag_reader import Bag, Recording


def laws(bag: Bag | Recording, surveyed: Survey) -> tuple[LawResult, ...]:
    """The laws of a bag: declared frames, zero translation, scenarios that agree, log times and the count of samples.

    Parameters
    ----------
    bag : Bag or Recording
    surveyed : Survey
        Of the same bag.
    """
    laws = [_frames(surveyed), _at_rest(surveyed), _declaration(bag, surveyed)]
    if surveyed.as_written:
        laws.append(_log_times(bag, surveyed))
    if bag.expected_samples is not None:
        found = max(surveyed.poses, surveyed.twists)
        missing = abs(bag.expected_samples - found)
        message = f"the bag's end counts {bag.expected_samples} samples, the bag holds {found}"
        laws.append(_flag("sample count", missing, message))
    return tuple(laws)


def _frames(surveyed: Survey) -> LawResult:
    worlds = {found.segment.scenario.world_frame for found in surveyed.segments}
    bodies = {found.segment.scenario.body_frame for found in surveyed.segments}
    others = sorted((surveyed.world_frames - worlds) | (surveyed.body_frames - bodies))
    message = f"frames {', '.join(map(repr, others))} are not those declared: {', '.join(sorted(worlds | bodies))}"
    return _flag("frames", len(others), message)


def _declaration(bag: Bag | Recording, surveyed: Survey) -> LawResult:
    """The scenarios agree with each other and with the type of the twists."""
    faults = [*_clock_faults(surveyed), *_twist_faults(bag, surveyed)]
    return _flag("declaration", len(faults), "; ".join(faults))


def _clock_faults(surveyed: Survey) -> Iterator[str]:
    """Every reset happens at a sample of the clock before it, which goes on or, at another rate, begins anew."""
    segments = surveyed.declared
    if surveyed.as_written and segments[0].first_sample > 0:
        yield f"the first scenario begins with sample {segments[0].first_sample}: those before it are not in the bag"
    for before, after in itertools.pairwise(segments):
        number = before.clock().count_until(after.start_ns) - 1
        goes_on = (before.scenario.epoch_ns, number) if before.scenario.rate == after.scenario.rate else None
        if before.clock().stamp_ns(number) != after.start_ns or (after.scenario.epoch_ns, after.first_sample) not in (
            goes_on,
            (after.start_ns, 0),
        ):
            yield f"the scenario that starts at {after.start_ns} ns does not follow the clock of the one before it"


def _twist_faults(bag: Bag | Recording, surveyed: Survey) -> Iterator[str]:
    stamped = bag.stamped
    if any(segment.scenario.stamped_twist != stamped for segment in surveyed.declared):
        yield f"a scenario declares stamped_twist {str(not stamped).lower()}, the twists are otherwise"


def _log_times(bag: Bag | Recording, surveyed: Survey) -> LawResult:
    """Every message is logged and published at its stamp, as this package writes them: by that they are replayed."""
    off = bag.published_otherwise + surveyed.logged_otherwise
    return _flag("log times", off, f"{off} messages are not logged, or not published, at their stamps")


def _at_rest(surveyed: Survey) -> LawResult:
    moving = surveyed.moved
    return _flag(
        "position and linear velocity", moving, f"{moving} components of position or linear velocity are not 0"
    )


def _flag(name: str, faults: int, message: str) -> LawResult:
    """The result of a law of the bag as a whole, which holds where there are no faults."""
    return LawResult(name, "", float(faults), 0.0, None, None, faults, 1, message if faults else "")


def impossible(error: ParameterError) -> LawResult:
    """The broken law of a bag that declares what cannot be: a body that cannot be has no motion to hold it against."""
    return _flag("declaration", 1, f"the bag declares an impossible scenario: {error}")
