"""Many motions of any kinds: their constants, and their states block by block."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.motion.closed_form import double_double
from lie_rigid_body.motion.closed_form.columns import numbers
from lie_rigid_body.motion.closed_form.double_double import Array
from lie_rigid_body.motion.closed_form.exact import is_steady
from lie_rigid_body.motion.closed_form.general_motion import GeneralMotion
from lie_rigid_body.motion.closed_form.polhode import frame_and_polhode
from lie_rigid_body.motion.closed_form.precision import working_precision
from lie_rigid_body.motion.closed_form.principal_axes import PrincipalAxes, digits_for, principal_axes
from lie_rigid_body.motion.closed_form.stack import BodyMotion, Stack
from lie_rigid_body.motion.closed_form.steady_motion import SteadyMotion


@dataclass
class _Rows:
    """Numbers of motions of one kind, while they are gathered."""

    form: BodyMotion
    members: list[int] = field(default_factory=list)
    rows: list[Array] = field(default_factory=list)


@dataclass(frozen=True)
class Ensemble:
    """The motions of B bodies, stacked by kind."""

    stacks: tuple[Stack, ...]

    @classmethod
    def of(cls, inertia: Array, attitude_xyzw: Array, body_rate: Array) -> Ensemble:
        """The motions of bodies from their starts, shapes (B, 3, 3), (B, 4) and (B, 3)."""
        kinds: dict[tuple[type, ...], _Rows] = {}
        for motion, members in _motions(inertia, body_rate):
            gathered = kinds.setdefault(_kind(motion), _Rows(motion))
            gathered.members += members
            gathered.rows += [np.array([float(number) for number in numbers(motion)])] * len(members)
        return cls(tuple(Stack.of(g.members, g.form, g.rows, attitude_xyzw[g.members]) for g in kinds.values()))

    def fill(self, attitude_xyzw: Array, body_rate: Array, t_ns: NDArray[np.int64], block: int) -> None:
        """Write the states at N times into arrays of shapes (B, N, 4) and (B, N, 3), this many samples at once."""
        breadth = min(len(t_ns), block)
        for stack in self.stacks:
            for some in _slices(len(stack.members), block // breadth if breadth else block):
                motion, members = stack.part(some), stack.members[some]
                for times in _slices(len(t_ns), breadth):
                    states = motion.states(double_double.from_integers(t_ns[times]))
                    attitude_xyzw[members, times] = states.attitude_xyzw
                    body_rate[members, times] = states.body_rate


def _slices(length: int, step: int) -> Iterator[slice]:
    return (slice(begin, min(begin + step, length)) for begin in range(0, length, max(step, 1)))


def _kind(motion: SteadyMotion | GeneralMotion) -> tuple[type, ...]:
    if isinstance(motion, SteadyMotion):
        return (SteadyMotion,)
    return GeneralMotion, type(motion.polhode_clock), type(motion.wave)


def _motions(inertia: Array, body_rate: Array) -> Iterator[tuple[SteadyMotion | GeneralMotion, list[int]]]:
    """Each distinct motion, not yet placed in the world, and which of the ensemble have it."""
    for body in _alike(inertia):
        tensor = inertia[body[0]].tolist()
        with working_precision(digits_for([entry for row in tensor for entry in row])):
            principal = principal_axes(tensor)
            for start in _alike(body_rate[body]):
                rate = body_rate[body[start[0]]].tolist()
                yield _motion(principal, tensor, rate), [body[i] for i in start]


def _motion(principal: PrincipalAxes, inertia: list[list[float]], rate: list[float]) -> SteadyMotion | GeneralMotion:
    if is_steady(inertia, rate):
        return SteadyMotion.of(rate)
    return GeneralMotion.of(*frame_and_polhode(principal, inertia, rate))


def _alike(values: Array) -> list[list[int]]:
    """The places along the first axis, those of the same bits together."""
    places: dict[bytes, list[int]] = {}
    for i, value in enumerate(values):
        places.setdefault(value.tobytes(), []).append(i)
    return list(places.values())
