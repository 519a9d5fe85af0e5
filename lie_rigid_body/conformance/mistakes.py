"""Exact motions of the usual mistakes of engines, to which a wrong engine converges as its step goes to 0."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import permutations, product
from typing import Final

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


def suspects(case: EngineCase, t_s: Array) -> Iterator[tuple[tuple[str, str], MotionArrays]]:
    """Codes and messages of every mistake that some body could have in a case, with its motion; the usual ones first.

    The attitudes and returned rates are those at given times, s.
    """
    for (at_start, start), (at_return, returned) in product(STARTS.items(), RETURNS.items()):
        for code, what, inertia in _bodies(case):
            with suppress(ParameterError):  # no body has this inertia
                rate = start(case.attitude_xyzw, case.body_rate)
                attitude, rate = exact_motion(0.5 * (inertia + inertia.T), case.attitude_xyzw, rate, t_s)
                message = "; ".join(filter(None, (what, at_start, at_return)))
                yield (code, message), (attitude, returned(attitude, rate))


def _bodies(case: EngineCase) -> Iterator[tuple[str, str, Array]]:
    """Codes and messages of bodies that an engine could take for that of a case, with their inertia.

    The first is that of the case. Without the gyroscopic term a body keeps its rate, as a sphere does. Moments
    Iᵢ (tr I − 2 Iᵢ) turn the sign of each (Iⱼ − Iₖ)/Iᵢ in Euler's equations.
    """
    inertia = case.inertia
    R = quaternion.to_matrix(case.attitude_xyzw)
    P = quaternion.to_matrix(np.roll(case.inertial_frame_wxyz, -1))
    diagonal = np.diag(np.diag(inertia))
    yield "rate_axes", "", inertia
    yield "gyroscopic_term_missing", "the rate stays as at the start, as of a sphere", np.eye(3)
    opposite = inertia @ (np.trace(inertia) * np.eye(3) - 2.0 * inertia)
    yield "gyroscopic_term_sign", "the gyroscopic term has the opposite sign", opposite
    for moments in permutations(case.principal_moments.tolist()):
        yield "inertia_axes", "the principal moments are taken along the body's axes", np.diag(moments)
    found = {
        "the frame of the inertia is inverted": P.T @ np.diag(case.principal_moments) @ P,
        "products of inertia are left out": diagonal,
        "products of inertia have the opposite sign, as CAD writes them": 2.0 * diagonal - inertia,
        "the inertia is taken to be in the world's axes at the start": R.T @ inertia @ R,
        "the inertia is turned by the attitude at the start": R @ inertia @ R.T,
    }
    for message, wrong in found.items():
        yield "inertia_axes", message, wrong
