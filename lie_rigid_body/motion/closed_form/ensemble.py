"""Many motions of any kinds: their constants, by the fast tier or in decimals, and their states kind by kind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.motion.closed_form.decimal_constants import decimal_motions
from lie_rigid_body.motion.closed_form.evaluation import Evaluation
from lie_rigid_body.motion.closed_form.fast_constants import fast_motions
from lie_rigid_body.motion.closed_form.motion_parameters import BodyMotion, Members, Starts
from lie_rigid_body.motion.closed_form.states import Kind, kind_and_row


@dataclass(frozen=True)
class Ensemble:
    """The motions of B bodies, those of a kind together."""

    evaluations: tuple[Evaluation, ...]

    @classmethod
    def of(cls, starts: Starts) -> Ensemble:
        """The motions of bodies from their starts."""
        by_kind: dict[Kind, list[tuple[Array, Members]]] = {}
        for motion, members in _motions(starts):
            kind, row = kind_and_row(motion)
            by_kind.setdefault(kind, []).append((_table(row, len(members)), members))
        return cls(tuple(_evaluation(kind, parts) for kind, parts in by_kind.items()))

    def fill(self, attitude_xyzw: Array, body_rate: Array, t_ns: Integers, block: int) -> None:
        """Write the states at N times into arrays of shapes (B, N, 4) and (B, N, 3), ``block`` samples at once."""
        for evaluation in self.evaluations:
            evaluation.fill(attitude_xyzw, body_rate, t_ns, block)


def _motions(starts: Starts) -> Iterator[tuple[BodyMotion, Members]]:
    """Every motion with its place in the ensemble; those that are computed together, as one with its places."""
    rest = np.ones(len(starts.inertia), dtype=np.bool_)
    for motion, members in fast_motions(starts):
        rest[members] = False
        yield motion, members
    yield from decimal_motions(starts, np.flatnonzero(rest))


def _table(row: list[Number], count: int) -> Array:
    """The constants of ``count`` motions, shape (constants, count)."""
    if count == 1:
        return np.array(row, dtype=np.float64).reshape(-1, 1)
    return np.stack([np.broadcast_to(entry, count) for entry in row])


def _evaluation(kind: Kind, parts: list[tuple[Array, Members]]) -> Evaluation:
    if len(parts) == 1:
        return Evaluation(kind, *parts[0])
    tables, members = zip(*parts, strict=True)
    return Evaluation(kind, np.concatenate(tables, axis=1), np.concatenate(members))
