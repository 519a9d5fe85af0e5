"""A proof as a sentence for people and as JSON for programs."""

from __future__ import annotations

import textwrap

from lie_rigid_body.certificate.proved import Proof, ProvedSample
from lie_rigid_body.cli.certificate_text import finite


def as_sentence(proof: Proof) -> str:
    """What is proved, in lines for a terminal."""
    worst = proof.worst
    if worst is None:
        return "proved: nothing, as there is no sample with a motion to hold it against"
    where = f"sample {worst.sample} of segment {worst.segment}, {worst.time_s:.7g} s after the start"
    if worst.holds:
        count = len(proof.samples)
        said = f"proved: within {worst.at_most:.2g} rad at {count} sample{'s' if count > 1 else ''}, worst at {where}"
    else:
        broken = sum(not sample.holds for sample in proof.samples)
        said = (
            f"proved: {broken} of {len(proof.samples)} samples are beyond their limit; the attitude is at least "
            f"{worst.at_least:.2g} rad off the true one (limit {worst.limit:.2g}) at {where}"
        )
    return textwrap.fill(said, 80, subsequent_indent="  ")


def as_json(proof: Proof) -> dict[str, object]:
    """The proof as JSON-serialisable data; a bound that is infinite becomes null."""
    return {
        "passed": proof.passed,
        "attitude_rad": None if proof.worst is None else finite(max(s.at_most for s in proof.samples)),
        "samples": [_sample_json(sample) for sample in proof.samples],
    }


def _sample_json(sample: ProvedSample) -> dict[str, object]:
    return {
        "segment": sample.segment,
        "sample": sample.sample,
        "stamp_ns": sample.stamp_ns,
        "time_s": sample.time_s,
        "attitude_at_least_rad": finite(sample.at_least),
        "attitude_at_most_rad": finite(sample.at_most),
        "attitude_limit_rad": sample.limit,
        "body_rate_at_most_rad_s": finite(sample.rate_at_most),
        "holds": sample.holds,
    }
