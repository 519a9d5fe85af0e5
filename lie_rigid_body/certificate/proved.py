"""Recorded attitudes held against enclosures of the true motion, which owe nothing to the closed form."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from lie_rigid_body.certificate.certification import Certificate
from lie_rigid_body.certificate.limits import max_attitude_error
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.bag_reader import AnyBag
from lie_rigid_body.recording.samples import Block, numbered_blocks
from lie_rigid_body.simulation import Segment

MAX_PROVED: Final = 10_000
"""Largest number of samples that are proved, which takes half a minute."""


@short_dataclass
class ProvedSample:
    """Proved bounds of the errors of one sample.

    Parameters
    ----------
    segment : int
        Number of its segment, from 1.
    sample : int
    stamp_ns : int
    time_s : float
        Since the segment's start, s.
    attitude_at_least_rad, attitude_at_most_rad : float
        Bounds of the angle between the recorded attitude and the true one.
    attitude_limit_rad : float
        Limit of the attitude error at this sample in the certificate.
    body_rate_at_most_rad_s : float
        Bound of the distance of the recorded body rate from the true one.
    """

    segment: int
    sample: int
    stamp_ns: int
    time_s: float
    attitude_at_least_rad: float
    attitude_at_most_rad: float
    attitude_limit_rad: float
    body_rate_at_most_rad_s: float

    @property
    def holds(self) -> bool:
        """Whether the true error may be within the limit."""
        return self.attitude_at_least_rad <= self.attitude_limit_rad


@short_dataclass
class Proof:
    """Proved errors of the enclosed samples of a bag."""

    samples: tuple[ProvedSample, ...]

    @property
    def passed(self) -> bool:
        """Whether no sample is proved to be beyond its limit."""
        return all(sample.holds for sample in self.samples)

    @property
    def worst(self) -> ProvedSample | None:
        """The sample farthest beyond its limit, or if there is none the one with the largest bound."""
        broken = [sample for sample in self.samples if not sample.holds]
        if broken:
            return max(broken, key=lambda sample: sample.attitude_at_least_rad / sample.attitude_limit_rad)
        return max(self.samples, key=lambda sample: sample.attitude_at_most_rad, default=None)


def require_count(count: int) -> None:
    """Refuse a number of samples that cannot be asked for, and any where python-flint is missing.

    Raises
    ------
    InputError
        If the number is out of range.
    LieRigidBodyError
        If python-flint is not installed.
    """
    if not 1 <= count <= MAX_PROVED:
        raise InputError(f"--prove {count}: not a number of samples: give 1 to {MAX_PROVED}")
    import lie_rigid_body.proof  # noqa: F401


def prove(
    bag: AnyBag,
    certificate: Certificate,
    count: int,
    max_attitude: float | None = None,
) -> Iterator[ProvedSample]:
    """Enclose samples spread evenly over a bag, its ends among them, and the worst sample of each segment.

    Parameters
    ----------
    bag : Bag or Recording
    certificate : Certificate
        Of the bag.
    count : int
        How many samples to spread, of all segments together.
    max_attitude : float, optional
        As for `certify`.

    Yields
    ------
    ProvedSample
        In the order of the recording.
    """
    if any(found.segment.scenario.motion == "path" for found in certificate.segments):
        raise InputError("the motion is prescribed by a path, of which there is nothing to prove: leave --prove out")
    if not certificate.segments:
        return
    segments = [found.segment for found in certificate.segments]
    total = sum(found.samples for found in certificate.segments)
    spread = np.unique(np.rint(np.linspace(0, total - 1, count)).astype(np.int64))
    first = 0
    for i, block in numbered_blocks(bag, segments):
        own = spread[(spread >= first) & (spread < first + len(block.samples))] - first
        worst = np.flatnonzero(block.samples == certificate.segments[i].law("attitude").sample)
        yield from _prove_samples(i + 1, segments[i], block[np.union1d(own, worst)], max_attitude)
        first += len(block.samples)


def _prove_samples(number: int, segment: Segment, chosen: Block, max_attitude: float | None) -> Iterator[ProvedSample]:
    from lie_rigid_body.proof.kicked import EnclosedMotion

    scenario = segment.scenario
    limit = max_attitude_error(scenario) if max_attitude is None else max_attitude
    last_ns = int(chosen.stamps_ns.max(initial=segment.start_ns)) - segment.start_ns
    times_ns, rates = scenario.kick_schedule().until(last_ns)
    motion = EnclosedMotion(
        scenario.inertia, scenario.initial_attitude_xyzw, [0, *times_ns.tolist()], [scenario.initial_body_rate, *rates]
    )
    for i, stamp_ns in enumerate(chosen.stamps_ns.tolist()):
        truth = motion.at(stamp_ns - segment.start_ns)
        yield ProvedSample(
            number,
            int(chosen.samples[i]),
            stamp_ns,
            (stamp_ns - segment.start_ns) * 1e-9,
            *truth.attitude_error(chosen.states.attitude_xyzw[i]),
            limit,
            truth.rate_error(chosen.states.body_rate[i])[1],
        )
