"""Many motions of any kinds: their constants, and their states block by block."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.arithmetic.decimals import working_precision
from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.arrays import Array
from lie_rigid_body.motion.closed_form.evaluation import Evaluation, Formulas, formulas_and_row
from lie_rigid_body.motion.closed_form.exact import is_steady
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.ordinary_motions import Starts, ordinary_motions
from lie_rigid_body.motion.closed_form.polhode import frame_and_polhode
from lie_rigid_body.motion.closed_form.principal_axes import PrincipalAxes, digits_for, principal_axes
from lie_rigid_body.motion.closed_form.steady_motion import SteadyMotion


@dataclass(frozen=True)
class Ensemble:
    """The motions of B bodies, those of a kind together."""

    evaluations: tuple[Evaluation, ...]

    @classmethod
    def of(cls, starts: Starts) -> Ensemble:
        """The motions of bodies from their starts."""
        alike: dict[Formulas, list[tuple[Array, NDArray[np.intp]]]] = {}
        for motion, members in _motions(starts):
            formulas, row = formulas_and_row(motion)
            alike.setdefault(formulas, []).append((_table(row, len(members)), members))
        return cls(tuple(_together(formulas, parts) for formulas, parts in alike.items()))

    def fill(self, attitude_xyzw: Array, body_rate: Array, t_ns: NDArray[np.int64], block: int) -> None:
        """Write the states at N times into arrays of shapes (B, N, 4) and (B, N, 3), this many samples at once."""
        for evaluation in self.evaluations:
            evaluation.fill(attitude_xyzw, body_rate, t_ns, block)


def _table(row: list[Number], count: int) -> Array:
    """The constants of so many motions, shape (constants, count)."""
    if count == 1:
        return np.array(row, dtype=np.float64).reshape(-1, 1)
    return np.stack([np.broadcast_to(entry, count) for entry in row])


def _together(formulas: Formulas, parts: list[tuple[Array, NDArray[np.intp]]]) -> Evaluation:
    if len(parts) == 1:
        return Evaluation(formulas, *parts[0])
    tables, members = zip(*parts, strict=True)
    return Evaluation(formulas, np.concatenate(tables, axis=1), np.concatenate(members))


def _motions(starts: Starts) -> Iterator[tuple[SteadyMotion | GeneralMotion, NDArray[np.intp]]]:
    """Every motion, those that are computed together as one, and which of the ensemble they are."""
    rest = np.ones(len(starts.inertia), dtype=np.bool_)
    for ordinary, members in ordinary_motions(starts):
        rest[members] = False
        yield ordinary, members
    others = np.flatnonzero(rest)
    for body in _alike(starts.inertia[others]):
        members = others[body]
        tensor = starts.inertia[members[0]].tolist()
        with working_precision(digits_for([entry for row in tensor for entry in row])):
            principal = principal_axes(tensor)
            for i in members:
                yield (
                    _motion(principal, tensor, starts.attitude_xyzw[i].tolist(), starts.body_rate[i].tolist()),
                    np.array([i]),
                )


def _motion(
    principal: PrincipalAxes, inertia: list[list[float]], attitude: list[float], rate: list[float]
) -> SteadyMotion | GeneralMotion:
    if is_steady(inertia, rate):
        return SteadyMotion.of(rate, attitude)
    return GeneralMotion.of(*frame_and_polhode(principal, inertia, rate), attitude)


def _alike(values: Array) -> list[list[int]]:
    """The places along the first axis, those of the same bits together."""
    places: dict[bytes, list[int]] = {}
    for i, value in enumerate(values):
        places.setdefault(value.tobytes(), []).append(i)
    return list(places.values())
