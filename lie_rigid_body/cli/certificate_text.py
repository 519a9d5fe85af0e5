"""A certificate as a table for people and as JSON for programs."""

from __future__ import annotations

import math
import textwrap
from typing import Final

from lie_rigid_body.certificate import Certificate, LawResult, SegmentCertificate
from lie_rigid_body.parameters import Value
from lie_rigid_body.wording import counted, printable

HEADINGS: Final = ("law", "worst", "limit", "", "sample", "time, s", "")
"""Of the columns of `law_cells`."""
_COLUMNS: Final = " {:<34} {:>7} {:>7} {:<3} {:>7} {:>9} {}"
_UNIT: Final = 3
"""Characters of the column of units; a longer one stands behind the name."""
_TWO_DIGITS: Final = 99.0
_TIME: Final = 9
"""Characters of the column of times."""
_LONGEST_COUNT: Final = 1e7
"""Counts from here on do not fit into their column."""
_WIDTH: Final = 80
"""Characters of a line of the table, and of the sentences."""


def as_table(bag: str, certificate: Certificate) -> str:
    """The certificate in lines for a terminal.

    Parameters
    ----------
    bag : str
        Name of the bag, as the user gave it.
    certificate : Certificate

    Returns
    -------
    str
        Without a final newline.
    """
    lines = [printable(bag)]
    for i, segment in enumerate(certificate.segments, 1):
        lines += ["", *_segment_lines(i, len(certificate.segments), segment)]
    for law in certificate.whole:
        lines.append(_row(law, None))
    return "\n".join([*lines, "", verdict(certificate), *_not_certified(certificate)])


def verdict(certificate: Certificate) -> str:
    """The verdict in sentences: to what accuracy the bag is certified, or which laws it breaks."""
    if not certificate.passed:
        return "\n".join(["NOT CERTIFIED", *(_wrapped(message, "  - ") for message in certificate.messages)])
    lines = [
        f"CERTIFIED: attitude within {certificate.attitude_accuracy:.2g} rad of the exact motion "
        f"(limit {_loosest(certificate):.2g}),",
        f"kinetic energy to {certificate.accuracy('kinetic energy'):.2g}, "
        f"world momentum to {_momentum(certificate):.2g} (relative).",
        *_worst_sample(certificate),
    ]
    if certificate.to_the_bit is not None:
        lines.append(f"It is {'' if certificate.to_the_bit else 'not '}equal to the bit to what is computed here.")
    return "\n".join(["\n  ".join(lines), *_sensors(certificate)])


def _sensors(certificate: Certificate) -> list[str]:
    if not certificate.sensors:
        return []
    return [_wrapped(f"Every reading is what its scenario determines: {', '.join(certificate.sensors)}.", "  ")]


def _worst_sample(certificate: Certificate) -> list[str]:
    number, segment = certificate.farthest
    law = segment.law("closed form")
    if law.sample is None or law.worst == 0.0:
        return []
    where = f" of segment {number}" if len(certificate.segments) > 1 else ""
    return [f"Attitude is worst at sample {law.sample}{where}, {segment.time_s(law):.7g} s after the start."]


def _not_certified(certificate: Certificate) -> list[str]:
    if not certificate.not_certified:
        return []
    return [_wrapped("; ".join(certificate.not_certified) + ".", "Not certified: ")]


def as_json(bag: str, certificate: Certificate) -> dict[str, object]:
    """The certificate as JSON-serialisable data; a number that is not finite becomes null."""
    return {
        "bag": bag,
        "passed": certificate.passed,
        "certified": {
            "attitude_rad": finite(certificate.attitude_accuracy),
            "attitude_limit_rad": finite(_loosest(certificate)),
            "kinetic_energy_relative": finite(certificate.accuracy("kinetic energy")),
            "world_momentum_relative": finite(_momentum(certificate)),
        }
        | {"attitude_worst": _worst_json(certificate), "to_the_bit": certificate.to_the_bit}
        if certificate.passed
        else None,
        "certified_sensors": list(certificate.sensors) if certificate.passed else [],
        "not_certified": list(certificate.not_certified),
        "messages": list(certificate.messages),
        "segments": [_segment_json(segment) for segment in certificate.segments],
        "laws": [_law_json(law, None) for law in certificate.whole],
    }


def _worst_json(certificate: Certificate) -> dict[str, object]:
    number, segment = certificate.farthest
    law = segment.law("closed form")
    return {"segment": number, "sample": law.sample, "stamp_ns": law.stamp_ns, "time_s": segment.time_s(law)}


def _segment_lines(number: int, count: int, certificate: SegmentCertificate) -> list[str]:
    first, *others = segment_facts(number, count, certificate)
    lines = [first, *(f"  {fact}" for fact in others), "", _COLUMNS.format(*HEADINGS).rstrip()]
    lines += [_row(law, certificate.time_s(law)) for law in certificate.laws]
    return lines + [_wrapped(note, " note: ") for note in certificate.notes]


def segment_facts(number: int, count: int, certificate: SegmentCertificate) -> tuple[str, ...]:
    """What a segment is: its number of so many, samples, inertia, start and motion."""
    scenario = certificate.segment.scenario
    motion = scenario.motion
    if motion == "moving_chart":
        motion = f"moving_chart {scenario.method}, steps of at most {scenario.max_step:g} s"
    return (
        f"segment {number} of {count}: {counted(certificate.samples, 'sample')} at {scenario.rate:g} Hz "
        f"from {certificate.segment.start_ns} ns",
        f"inertia {_numbers(scenario.inertia)} kg m²",
        f"initial body rate {_numbers(scenario.initial_body_rate)} rad/s",
        motion,
    )


def _row(law: LawResult, time_s: float | None) -> str:
    return _COLUMNS.format(*law_cells(law, time_s))


def law_cells(law: LawResult, time_s: float | None) -> tuple[str, ...]:
    """The columns of a law's line in the table: see `HEADINGS`.

    Parameters
    ----------
    law : LawResult
    time_s : float or None
        Of its worst sample since the segment's start, s.
    """
    sample, time = "", ""
    if law.sample is not None and time_s is not None:
        sample, time = ("all", "") if law.worst == 0.0 else (str(law.sample), _time(time_s))
    verdict = "holds" if law.holds else "BROKEN"
    is_long = len(law.unit) > _UNIT
    name, unit = (f"{law.name}, {law.unit}", "") if is_long else (law.name, law.unit)
    return name, _quantity(law.worst), f"{law.limit:.2g}", unit, sample, time, verdict


def _time(time_s: float) -> str:
    """Seven digits, or as many as there is room for: such as of a small time that does not end."""
    texts = (f"{time_s:.{digits}g}" for digits in range(7, 0, -1))
    return next(text for text in texts if len(text) <= _TIME)


def _quantity(value: float) -> str:
    """Two digits of a measure, and all of a count."""
    is_count = _TWO_DIGITS < value < _LONGEST_COUNT and value.is_integer()
    return f"{value:.0f}" if is_count else f"{value:.2g}"


def of_limit(worst: float, limit: float) -> str:
    """A residual as a share of its limit; of a limit of 0 the residual itself."""
    return f"{worst / limit:.2g}" if limit > 0.0 else f"{worst:.2g} of 0" if worst != 0.0 else "0"


def _wrapped(sentence: str, mark: str) -> str:
    return textwrap.fill(sentence, _WIDTH, initial_indent=mark, subsequent_indent=" " * min(len(mark), 7))


def _numbers(values: tuple[float, ...]) -> str:
    return "[" + ", ".join(f"{v:g}" for v in values) + "]"


def _momentum(certificate: Certificate) -> float:
    return max(certificate.accuracy(f"world momentum {axis}") for axis in "xyz")


def _loosest(certificate: Certificate) -> float:
    return max((s.law("closed form").limit for s in certificate.segments), default=0.0)


def _segment_json(certificate: SegmentCertificate) -> dict[str, object]:
    parameters: dict[str, Value] = certificate.segment.scenario.parameters()
    return {
        "start_ns": certificate.segment.start_ns,
        "first_sample": certificate.segment.first_sample,
        "samples": certificate.samples,
        "passed": certificate.passed,
        "scenario": parameters,
        "laws": [_law_json(law, certificate.time_s(law)) for law in certificate.laws],
        "notes": list(certificate.notes),
    }


def _law_json(law: LawResult, time_s: float | None) -> dict[str, object]:
    return {
        "name": law.name,
        "unit": law.unit,
        "holds": law.holds,
        "worst": finite(law.worst),
        "limit": finite(law.limit),
        "sample": law.sample,
        "stamp_ns": law.stamp_ns,
        "time_s": time_s,
        "broken": law.broken,
        "checked": law.checked,
        "message": law.message,
    }


def finite(value: float) -> float | None:
    """A number for JSON, which has no infinity."""
    return value if math.isfinite(value) else None
