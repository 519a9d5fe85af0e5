"""A certificate, and what is proved beside it, as a table for people and as JSON for programs."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Iterator
from typing import Final

from lie_rigid_body.certificate import Certificate, LawResult, SegmentCertificate
from lie_rigid_body.certificate.proved import Proof
from lie_rigid_body.wording import counted, printable

HEADINGS: Final = ("law", "worst", "limit", "", "sample", "time, s", "")
"""Headings of the columns of `law_cells`."""
_COLUMNS: Final = " {:<34} {:>7} {:>7} {:<3} {:>7} {:>9} {}"
_UNIT: Final = 3
"""Width of the column of units, characters; a longer unit stands behind the name."""
_TIME: Final = 9
"""Width of the column of times, characters."""
_COUNTS: Final = (99.0, 1e7)
"""Between these a whole number is a count, and shown with all digits; from the second on it does not fit."""
_WIDTH: Final = 80
"""Width of the table, and of the sentences, characters."""


def as_table(bag: str, certificate: Certificate, proof: Proof | None = None) -> str:
    """Lines of a certificate for a terminal.

    Parameters
    ----------
    bag : str
        Name of the bag, as the user gave it.
    certificate : Certificate
    proof : Proof, optional

    Returns
    -------
    str
        Without a final newline.
    """
    lines = [printable(bag)]
    for i, segment in enumerate(certificate.segments, 1):
        first, *others = segment_facts(i, len(certificate.segments), segment)
        lines += ["", first, *(f"  {fact}" for fact in others), "", _COLUMNS.format(*HEADINGS).rstrip()]
        lines += [law_row(law, segment.time_s(law)) for law in segment.laws]
        lines += [wrapped(note, " note: ") for note in segment.notes]
    lines += [law_row(law, None) for law in certificate.whole]
    lines += ["", verdict(certificate)]
    if certificate.not_certified:
        lines.append(wrapped("; ".join(certificate.not_certified) + ".", "Not certified: "))
    return "\n".join([*lines, *([] if proof is None else [proved(proof)])])


def verdict(certificate: Certificate) -> str:
    """Sentences that say to what accuracy a bag is certified, or which laws it breaks."""
    if not certificate.passed:
        return "\n".join(["NOT CERTIFIED", *(wrapped(message, "  - ") for message in certificate.messages)])
    lines = [
        f"CERTIFIED: attitude within {certificate.attitude_accuracy:.2g} rad of the exact motion "
        f"(limit {_loosest(certificate):.2g}),",
        f"  kinetic energy to {certificate.accuracy('kinetic energy'):.2g}, "
        f"world momentum to {_momentum(certificate):.2g} (relative).",
        *_worst_sample(certificate),
    ]
    if certificate.to_the_bit is not None:
        lines.append(f"  It is {'' if certificate.to_the_bit else 'not '}equal to the bit to what is computed here.")
    if certificate.sensors:
        lines.append(wrapped(f"Every reading is what its scenario determines: {', '.join(certificate.sensors)}.", "  "))
    return "\n".join(lines)


def _worst_sample(certificate: Certificate) -> Iterator[str]:
    number, segment = certificate.farthest
    law = segment.law("closed form")
    if law.sample is not None and law.worst != 0.0:
        where = f" of segment {number}" if len(certificate.segments) > 1 else ""
        yield f"  Attitude is worst at sample {law.sample}{where}, {segment.time_s(law):.7g} s after the start."


def proved(proof: Proof) -> str:
    """Sentence that says what is proved, in lines for a terminal."""
    worst, count = proof.worst, len(proof.samples)
    if worst is None:
        return "proved: nothing, as there is no sample with a motion to hold it against"
    where = f"sample {worst.sample} of segment {worst.segment}, {worst.time_s:.7g} s after the start"
    broken = sum(not sample.holds for sample in proof.samples)
    said = (
        f"proved: {broken} of {count} samples are beyond their limit; the attitude is at least "
        f"{worst.at_least:.2g} rad off the true one (limit {worst.limit:.2g}) at {where}"
        if broken
        else f"proved: within {worst.at_most:.2g} rad at {counted(count, 'sample')}, worst at {where}"
    )
    return textwrap.fill(said, _WIDTH, subsequent_indent="  ")


def as_json(bag: str, certificate: Certificate, proof: Proof | None = None) -> dict[str, object]:
    """JSON-serialisable data of a certificate; a number that is not finite becomes null."""
    return {
        "bag": bag,
        "passed": certificate.passed,
        "certified": _accuracy_json(certificate) if certificate.passed else None,
        "certified_sensors": list(certificate.sensors) if certificate.passed else [],
        "not_certified": list(certificate.not_certified),
        "messages": list(certificate.messages),
        "segments": [_segment_json(segment) for segment in certificate.segments],
        "laws": [_law_json(law, None) for law in certificate.whole],
    } | ({} if proof is None else {"proved": _proof_json(proof)})


def _accuracy_json(certificate: Certificate) -> dict[str, object]:
    number, segment = certificate.farthest
    law = segment.law("closed form")
    return {
        "attitude_rad": _finite(certificate.attitude_accuracy),
        "attitude_limit_rad": _finite(_loosest(certificate)),
        "kinetic_energy_relative": _finite(certificate.accuracy("kinetic energy")),
        "world_momentum_relative": _finite(_momentum(certificate)),
        "attitude_worst": {
            "segment": number,
            "sample": law.sample,
            "stamp_ns": law.stamp_ns,
            "time_s": segment.time_s(law),
        },
        "to_the_bit": certificate.to_the_bit,
    }


def _segment_json(certificate: SegmentCertificate) -> dict[str, object]:
    return {
        "start_ns": certificate.segment.start_ns,
        "first_sample": certificate.segment.first_sample,
        "samples": certificate.samples,
        "passed": certificate.passed,
        "scenario": certificate.segment.scenario.parameters(),
        "laws": [_law_json(law, certificate.time_s(law)) for law in certificate.laws],
        "notes": list(certificate.notes),
    }


def _law_json(law: LawResult, time_s: float | None) -> dict[str, object]:
    return {
        "name": law.name,
        "unit": law.unit,
        "holds": law.holds,
        "worst": _finite(law.worst),
        "limit": _finite(law.limit),
        "sample": law.sample,
        "stamp_ns": law.stamp_ns,
        "time_s": time_s,
        "broken": law.broken,
        "checked": law.checked,
        "message": law.message,
    }


def _proof_json(proof: Proof) -> dict[str, object]:
    at_most = max((sample.at_most for sample in proof.samples), default=math.nan)
    return {
        "passed": proof.passed,
        "attitude_rad": _finite(at_most),
        "samples": [
            {
                "segment": sample.segment,
                "sample": sample.sample,
                "stamp_ns": sample.stamp_ns,
                "time_s": sample.time_s,
                "attitude_at_least_rad": _finite(sample.at_least),
                "attitude_at_most_rad": _finite(sample.at_most),
                "attitude_limit_rad": sample.limit,
                "body_rate_at_most_rad_s": _finite(sample.rate_at_most),
                "holds": sample.holds,
            }
            for sample in proof.samples
        ],
    }


def _finite(value: float) -> float | None:
    """Number for JSON, which has no infinity."""
    return value if math.isfinite(value) else None


def segment_facts(number: int, count: int, certificate: SegmentCertificate) -> tuple[str, ...]:
    """Facts about a segment: its number of so many, samples, inertia, start and motion."""
    scenario = certificate.segment.scenario
    steps = f"moving_chart {scenario.method}, steps of at most {scenario.max_step:g} s"
    return (
        f"segment {number} of {count}: {counted(certificate.samples, 'sample')} at {scenario.rate:g} Hz "
        f"from {certificate.segment.start_ns} ns",
        f"inertia {_numbers(scenario.inertia)} kg m²",
        f"initial body rate {_numbers(scenario.initial_body_rate)} rad/s",
        steps if scenario.motion == "moving_chart" else scenario.motion,
    )


def law_row(law: LawResult, time_s: float | None) -> str:
    """Line of a law in the table; see `law_cells`."""
    return _COLUMNS.format(*law_cells(law, time_s))


def law_cells(law: LawResult, time_s: float | None) -> tuple[str, ...]:
    """Cells of a law's line in the table, under `HEADINGS`.

    Parameters
    ----------
    law : LawResult
    time_s : float or None
        Time of its worst sample since the segment's start, s.
    """
    sample, time = "", ""
    if law.sample is not None and time_s is not None:
        sample, time = ("all", "") if law.worst == 0.0 else (str(law.sample), _time(time_s))
    is_long = len(law.unit) > _UNIT
    name, unit = (f"{law.name}, {law.unit}", "") if is_long else (law.name, law.unit)
    return name, _quantity(law.worst), f"{law.limit:.2g}", unit, sample, time, "holds" if law.holds else "BROKEN"


def _time(time_s: float) -> str:
    """Seven digits, or as many as there is room for: such as of a small time that does not end."""
    texts = (f"{time_s:.{digits}g}" for digits in range(7, 0, -1))
    return next(text for text in texts if len(text) <= _TIME)


def _quantity(value: float) -> str:
    """Two digits of a measure, and all of a count."""
    is_count = _COUNTS[0] < value < _COUNTS[1] and value.is_integer()
    return f"{value:.0f}" if is_count else f"{value:.2g}"


def of_limit(worst: float, limit: float) -> str:
    """Residual as a share of its limit; the residual itself where the limit is 0."""
    return f"{worst / limit:.2g}" if limit > 0.0 else f"{worst:.2g} of 0" if worst != 0.0 else "0"


def wrapped(sentence: str, mark: str) -> str:
    """Lines of a sentence for a terminal, the first after a mark; paths stay whole."""
    indent = " " * min(len(mark), 7)
    return textwrap.fill(
        sentence,
        _WIDTH,
        initial_indent=mark,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _numbers(values: Iterable[float]) -> str:
    return "[" + ", ".join(f"{v:g}" for v in values) + "]"


def _momentum(certificate: Certificate) -> float:
    return max(certificate.accuracy(f"world momentum {axis}") for axis in "xyz")


def _loosest(certificate: Certificate) -> float:
    return max((s.law("closed form").limit for s in certificate.segments), default=0.0)
