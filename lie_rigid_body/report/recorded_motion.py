"""A recorded motion as it is drawn: its samples, its largest residuals, and what pictures share of times and curves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from lie_rigid_body.certificate.certification import Certificate
from lie_rigid_body.certificate.law_result import Watch
from lie_rigid_body.certificate.survey import survey
from lie_rigid_body.foundation.arrays import Array, Booleans, Integers
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import counted, numerals
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.bag_reader import AnyBag
from lie_rigid_body.recording.samples import Block, numbered_blocks
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment

POLHODE_POINTS: Final = 20_000
"""Largest number of points of a polhode."""
_STEP: Final = 0.05
"""Turn from one point of a path to the next, rad, where the samples are as near."""
_FAR: Final = 1e3
"""Largest body rate that is drawn, as a multiple of the fastest of the motion: a larger one was damaged."""
MAX_PIECES: Final = 100
"""Largest number of pieces of a block of samples of which the largest residuals are kept."""


@short_dataclass
class RecordedSegment(Block):
    """Samples of one segment, as recorded. See `Block` for the other parameters.

    Parameters
    ----------
    segment : Segment
        As the bag declares it.
    """

    segment: Segment


Pieces = Sequence[RecordedSegment]
"""Segments of one recording, in the order of time."""


def recorded_segments(bag: AnyBag, certificate: Certificate | None = None) -> list[RecordedSegment]:
    """Segments of a bag with their samples, 80 bytes each.

    Parameters
    ----------
    bag : Bag or Recording
    certificate : Certificate, optional
        Of the bag, with at least one segment; without it the bag is read once more to find its segments.

    Raises
    ------
    BagError, ParameterError
        See `survey`.
    """
    found = survey(bag).segments if certificate is None else certificate.segments
    segments = [each.segment for each in found]
    blocks: list[list[Block]] = [[] for _ in segments]
    for i, block in numbered_blocks(bag, segments):
        blocks[i].append(block)
    return [
        RecordedSegment(**vars(Block.joined(own)), segment=segment)
        for own, segment in zip(blocks, segments, strict=True)
    ]


def first_arc(piece: RecordedSegment) -> tuple[RecordedSegment, State]:
    """Samples of the first arc in which the body moves, and the state at its begin; of one that rests the last arc."""
    scenario = piece.segment.scenario
    kicks = scenario.kick_schedule()
    begin = scenario.start()
    samples = piece
    for number, places in kicks.parts(piece.stamps_ns - piece.segment.start_ns):
        samples = piece[places]
        begin = scenario.exact_motion().at(kicks.begin_ns(number)) if number else begin
        if begin.body_rate.any():
            break
    return RecordedSegment(**{**vars(piece), **vars(samples)}), begin


class ResidualsOverTime(Watch):
    """The largest residuals and limits of each law in pieces of the blocks in which samples come: a `Watch`."""

    def __init__(self) -> None:
        self.pieces: dict[str, list[tuple[Integers, Array]]] = {}

    def __call__(self, name: str, unit: str, residuals: Array, limits: Array | float, stamps_ns: Integers) -> None:
        """Take the residuals of a law for the samples that come next, not negative, NaN for broken."""
        if len(stamps_ns):
            first = np.unique(np.linspace(0, len(stamps_ns), MAX_PIECES, endpoint=False).astype(np.int64))
            sizes = np.where(np.isnan(residuals), np.inf, residuals)
            of_each = np.stack(np.broadcast_arrays(sizes, limits, ~(residuals <= limits)))
            largest = np.maximum.reduceat(of_each, first, axis=1)
            self.pieces.setdefault(name, []).append((stamps_ns[first], largest))

    def series(self, name: str, origin_ns: int) -> tuple[Array, Array, Array, Booleans]:
        """Times at which the pieces of a law begin, s since a stamp, residuals, limits, and which are broken."""
        stamps_ns, largest = (np.concatenate(each, axis=-1) for each in zip(*self.pieces[name], strict=True))
        order = np.argsort(stamps_ns, kind="stable")
        residuals, limits, broken = largest[:, order]
        return (stamps_ns[order] - origin_ns) * 1e-9, residuals, limits, broken > 0.0


def in_words(scenario: Scenario) -> str:
    """Inertia, initial body rate and method of a motion, or the knots of its path."""
    if path := scenario.path():
        return f"a path through {counted(len(path), 'knot')}"
    steps = f"moving_chart {scenario.method}, steps of at most {scenario.longest_step:.3g} s"
    return (
        f"inertia [{numerals(scenario.inertia)}] kg m², initial body rate [{numerals(scenario.initial_body_rate)}] "
        f"rad/s, {steps if scenario.motion == 'moving_chart' else scenario.motion}"
    )


def times(stamps_ns: Integers, pieces: Pieces) -> Array:
    """Times since the first sample of a recording, s."""
    return np.asarray((stamps_ns - pieces[0].stamps_ns[0]) * 1e-9, dtype=np.float64)


@np.errstate(invalid="ignore", over="ignore")  # recorded numbers may be anything
def usable(piece: RecordedSegment, places: Integers | slice) -> tuple[State, Booleans]:
    """States at some places of a segment, of unit quaternions, and which places have one that can be drawn.

    Left out are attitudes that are zero or not finite, and rates far beyond those of the motion.
    """
    attitude = piece.states.attitude_xyzw[places]
    rate = piece.states.body_rate[places]
    norms = np.linalg.norm(attitude, axis=1)
    largest = np.abs(rate).max(axis=1)
    sane = np.isfinite(norms) & (norms > 0.0) & (largest <= _FAR * piece.segment.scenario.rate_bound())
    return State.trusted(attitude[sane] / norms[sane, np.newaxis], rate[sane]), sane


def path(piece: RecordedSegment, most: int) -> State:
    """States of the first part of a segment that a path is drawn through, at most so many, as dense as it needs."""
    scenario = piece.segment.scenario
    turn = scenario.rate_bound() / scenario.rate
    step = max(1, int(_STEP / turn)) if turn > 0.0 else 1
    states, _ = usable(piece, slice(0, step * most, step))
    return states


VIEW: Final = (24.0, 35.0)
"""Direction from which a polhode is seen, off the axes: elevation and azimuth, degrees."""
EYE: Final = np.array([0.748, 0.524, 0.407])
"""Unit vector in this direction."""


@short_dataclass
class Ellipsoid:
    """Ellipsoid ½ Σ Iᵢωᵢ² = H of the kinetic energy, on which the body rate runs in the principal frame.

    Parameters
    ----------
    radii : ndarray, shape (3,)
        Semi-axes √(2H/Iᵢ), rad/s.
    polhode : ndarray, shape (N, 3)
        Recorded body rates on the principal axes, rad/s.
    """

    radii: Array
    polhode: Array

    @classmethod
    def of(cls, piece: RecordedSegment, most: int) -> Ellipsoid | None:
        """Ellipsoid and polhode of the first moving arc, of so many points at most; none at rest or on a path."""
        body = piece.segment.scenario.body()
        arc, begin = first_arc(piece)
        energy = body.kinetic_energy(begin)
        rates = path(arc, most).body_rate
        if energy == 0.0 or not len(rates) or piece.segment.scenario.path():
            return None
        return cls(np.sqrt(2.0 * energy / body.principal_moments), rates @ body.principal_axes)

    def surface(self) -> Array:
        """Points of the surface on a grid of parallels and meridians, shape (3, 31, 61)."""
        u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 61), np.linspace(0, np.pi, 31))
        sphere = np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
        return np.asarray(self.radii[:, np.newaxis, np.newaxis] * sphere)
