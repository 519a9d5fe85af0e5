"""Cases by which engines are judged: bodies with their free motions, frozen in a file with truth of 40 digits."""

from __future__ import annotations

import json
import math
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.foundation.arrays import Array, real_array
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion import ClosedForm
from lie_rigid_body.scenario.parameter_file import CONFIG

FILE: Final = CONFIG / "conformance" / "1.json"
"""Inputs of each case, with truth at 16 instants that is proved to 1e-40; benchmarks/make_conformance.py made it."""
_EXPONENT: Final = 32
"""Power of two below which a stretched time stays, s: in nanoseconds it is then an int64."""
MotionArrays: TypeAlias = "tuple[Array, Array]"
"""Attitudes, shape (N, 4), and rates, shape (N, 3)."""


@short_dataclass(eq=False)
class EngineCase:
    """A body and its start, in SI and in the conventions of engines. Numbers are exactly the given doubles.

    Attributes
    ----------
    name : str
    about : str
        The body and its motion, in words.
    inertia : ndarray, shape (3, 3)
        Tensor about the mass centre in the body's axes, kg m².
    attitude_xyzw, attitude_wxyz : ndarray, shape (4,)
        Attitude at the start, world from body, scalar last and scalar first.
    body_rate, world_rate : ndarray, shape (3,)
        Angular velocity at the start in the body's axes and in the world's, rad/s; the second is rounded.
    principal_moments : ndarray, shape (3,)
        Ascending, kg m².
    inertial_frame_wxyz : ndarray, shape (4,)
        Body from principal axes, scalar first: engines that take moments and a frame are given these two. Rounded.
    period : float
        Time of one turn at the largest body rate, s.
    duration : float
        Length of the motion, s.
    """

    name: str
    about: str
    inertia: Array
    attitude_xyzw: Array
    body_rate: Array
    principal_moments: Array
    inertial_frame_wxyz: Array
    attitude_wxyz: Array
    world_rate: Array
    period: float
    duration: float

    def truth(self, t_s: ArrayLike) -> State:
        """The true state at times, by the closed form.

        Parameters
        ----------
        t_s : float or array_like, shape (N,)
            Since the start, s.

        Returns
        -------
        State
            Shapes (4,) and (3,) for one time, (N, 4) and (N, 3) for an array.
        """
        times = real_array("t_s", t_s, (...,), empty=True)
        return State(*exact_motion(self.inertia, self.attitude_xyzw, self.body_rate, times))


def exact_motion(inertia: Array, attitude_xyzw: Array, body_rate: Array, t_s: Array) -> MotionArrays:
    """Exact attitudes and rates of a body at times in s, of which no digit is lost.

    Motions of one body differ by the scale of time alone. The closed form takes whole nanoseconds. So time is stretched
    by a power of two, so far that int64 holds it, and rates are reduced by it, exactly.
    """
    exponent = _EXPONENT - math.frexp(float(np.abs(t_s).max(initial=0.0)))[1]
    ratios = map(float.as_integer_ratio, np.ldexp(t_s, exponent).ravel().tolist())
    t_ns = np.array([m * 10**9 // n for m, n in ratios], dtype=np.int64)
    motion = ClosedForm(RigidBody(inertia), State(attitude_xyzw, np.ldexp(body_rate, -exponent)))
    found = motion.at(t_ns.reshape(t_s.shape))
    return found.attitude_xyzw, np.ldexp(found.body_rate, exponent)


def _case(row: dict[str, Any]) -> EngineCase:
    # broadcast arrays cannot be written: an engine that integrates in place would change the cases
    numbers: list[Any] = [
        np.broadcast_to(value, np.shape(value)) if isinstance(value, list) else value for value in row.values()
    ]
    return EngineCase(*numbers[:-1])


CASES: Final = tuple(map(_case, json.loads(FILE.read_text(encoding="utf-8"))["cases"]))
"""The cases, in the order of the file, which has their numbers in the order of the attributes, and then the truth."""
