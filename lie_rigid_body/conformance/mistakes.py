"""Exact motions of the usual mistakes of engines, to which a wrong engine converges as its step goes to 0."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import permutations, product
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.conformance.cases import EngineCase, MotionArrays, exact_motion
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.lie import quaternion

Turned = Callable[[Array, Array], Array]
"""A rate in other axes, from an attitude and the rate."""


def _to_body(attitude_xyzw: Array, rate: Array) -> Array:
    return quaternion.rotate(quaternion.conjugate(attitude_xyzw), rate)


def _same(attitude_xyzw: Array, rate: Array) -> Array:
    return rate


STARTS: Final[dict[str, Turned]] = {
    "": _same,
    "the engine takes the given body rate as one in the world's axes": _to_body,
    "the engine, which takes body rates, is given one in the world's axes": quaternion.rotate,
}
RETURNS: Final[dict[str, Turned]] = {
    "": _same,
    "returned rates are in the world's axes": quaternion.rotate,
    "returned rates are turned to the body's axes, in which they are already": _to_body,
}


class Suspect(NamedTuple):
    """A mistake, with its motion of a case.

    Attributes
    ----------
    code, message : str
    inertia : ndarray, shape (3, 3)
        Tensor with which the body moves, kg m².
    start, returned : callable
        Rate with which it starts and which is returned, from the attitude and the right one.
    """

    code: str
    message: str
    inertia: Array
    start: Turned = _same
    returned: Turned = _same

    def motion(self, case: EngineCase, t_s: Array) -> MotionArrays:
        """Attitudes and returned rates at times."""
        rate = self.start(case.attitude_xyzw, case.body_rate)
        attitude, rate = exact_motion(self.inertia, case.attitude_xyzw, rate, t_s)
        return attitude, self.returned(attitude, rate)


def suspects(case: EngineCase, t_s: Array) -> Iterator[tuple[Suspect, MotionArrays]]:
    """Every mistake that some body could have in a case, with its motion; the more usual ones first."""
    for suspect in (*_rates_and_gyroscopic_terms(case), *_inertias(case)):
        with suppress(ParameterError):  # no body has this inertia
            yield suspect, suspect.motion(case, t_s)


def _rates_and_gyroscopic_terms(case: EngineCase) -> Iterator[Suspect]:
    """A body without the gyroscopic term keeps its rate, as a sphere does."""
    for (at_start, start), (at_return, returned) in product(STARTS.items(), RETURNS.items()):
        axes = f"{at_start}; {at_return}".strip("; ")
        if axes:
            yield Suspect("rate_axes", axes, case.inertia, start, returned)
        what = f"the rate stays as at the start, as of a sphere; {axes}".strip("; ")
        yield Suspect("gyroscopic_term_missing", what, np.eye(3), start, returned)


def _inertias(case: EngineCase) -> Iterator[Suspect]:
    inertia = case.inertia
    R = quaternion.to_matrix(case.attitude_xyzw)
    P = quaternion.to_matrix(np.roll(case.inertial_frame_wxyz, -1))
    diagonal = np.diag(np.diag(inertia))
    found = {
        "the frame of the inertia is inverted": P.T @ np.diag(case.principal_moments) @ P,
        "products of inertia are left out": diagonal,
        "products of inertia have the opposite sign, as CAD writes them": 2.0 * diagonal - inertia,
        "the inertia is taken to be in the world's axes at the start": R.T @ inertia @ R,
        "the inertia is turned by the attitude at the start": R @ inertia @ R.T,
    }
    for moments in permutations(case.principal_moments.tolist()):
        yield Suspect("inertia_axes", "the principal moments are taken along the body's axes", np.diag(moments))
    for message, wrong in found.items():
        yield Suspect("inertia_axes", message, 0.5 * (wrong + wrong.T))
