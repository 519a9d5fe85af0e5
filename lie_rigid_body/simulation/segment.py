"""A segment: the torque-free motion between two resets, and its JSON."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

from lie_rigid_body.errors import InputError
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.wording import short_repr

SOFTWARE: Final = "lie_rigid_body"
"""Name of this software in the scenario message."""
LONGEST_TEXT: Final = 64 * 1024
"""Largest length of a scenario message that is read, characters; this package writes about 2000."""


@dataclass(frozen=True)
class Segment:
    """The torque-free motion between two resets, as a bag declares it.

    Parameters
    ----------
    scenario : Scenario
        The scenario, with the epoch in force.
    first_sample : int
        Number of the sample that carries the initial state.
    start_ns : int
        Stamp of that sample, ns.
    """

    scenario: Scenario
    first_sample: int
    start_ns: int

    __repr__ = short_repr

    def to_json(self) -> str:
        """The text of the latched scenario message: all parameters, ``first_sample`` and ``start_ns``."""
        from lie_rigid_body import __version__

        content = {
            "software": f"{SOFTWARE} {__version__}",
            **self.scenario.parameters(),
            "first_sample": self.first_sample,
            "start_ns": self.start_ns,
        }
        return json.dumps(content)

    @classmethod
    def from_json(cls, text: str) -> Segment:
        """The segment that a scenario message declares.

        Raises
        ------
        InputError
            If the text is not such a message, or its ``start_ns`` is not the stamp of its ``first_sample``.
        """
        if len(text) > LONGEST_TEXT:
            raise InputError(f"the scenario message has {len(text)} characters: at most {LONGEST_TEXT} are read")
        try:
            content = _parsed(text)
        except ValueError as error:
            raise InputError(f"the scenario message is not the JSON that lie_rigid_body writes: {error}") from None
        first, start = content.pop("first_sample"), content.pop("start_ns")
        content.pop("software", None)
        for name, value in (("first_sample", first), ("start_ns", start)):
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MAX_EPOCH_NS:
                raise InputError(
                    f"the scenario message gives {name} {value!r:.40}: it must be an integer from 0 to {MAX_EPOCH_NS}"
                )
        segment = cls(_scenario(json.dumps(content)), first, start)
        if segment.clock().stamp_ns(first) != start:
            raise InputError(
                f"the scenario message starts at {start} ns with sample {first}, which its epoch_ns and rate stamp "
                f"{segment.clock().stamp_ns(first)} ns: restore the bag"
            )
        return segment

    def clock(self) -> SampleClock:
        """The clock of the segment's stamps."""
        return SampleClock(self.scenario.epoch_ns, self.scenario.rate)


@lru_cache(maxsize=1)
def _scenario(parameters: str) -> Scenario:
    """Read a scenario from a JSON object. The last one is kept: most resets repeat it, and to read it takes long."""
    return Scenario.from_parameters(json.loads(parameters))


def _parsed(text: str) -> dict[str, Any]:
    """Parse a scenario message."""
    try:
        content = json.loads(text, object_pairs_hook=_without_repeats)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    if not isinstance(content, dict):
        raise ValueError("it is no object")
    if missing := [name for name in ("first_sample", "start_ns") if name not in content]:
        raise ValueError(f"it has no {missing[0]}")
    return content


def _without_repeats(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Make an object of names and values, and refuse a name given twice: some readers would take its first value."""
    content: dict[str, object] = {}
    for name, value in pairs:
        if name in content:
            raise ValueError(f"it gives {name!r:.40} twice")
        content[name] = value
    return content
