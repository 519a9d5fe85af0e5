"""One way of getting the attitudes of a task, at one setting."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Contender:
    """A method at one setting, ready to run.

    Attributes
    ----------
    family : str
        Software and method: one curve of a picture.
    setting : str
        For the eye.
    size : float
        What the setting is: a step, s, a tolerance or a spacing, s. The smaller it is, the smaller the error should be.
    run : callable
        Returns the attitudes, xyzw, shape (N, 4), at all times of the task it was made for. What happens in it is
        the cost: everything from the initial state on, but not what a simulator does to load its world.
    ours : bool
    unit : bool
        Whether its cost is the unit that all others are given in.
    """

    family: str
    setting: str
    size: float
    run: Callable[[], NDArray[np.float64]]
    ours: bool = False
    unit: bool = False


def step_text(step: float) -> str:
    """A step for the eye: ``2 ms``, or ``2⁻¹⁰ s`` of a binary one."""
    mantissa, exponent = np.frexp(step)
    if mantissa == 0.5:
        return f"2{str(exponent - 1).translate(_RAISED)} s"
    return f"{1e3 * step:g} ms" if step >= 1e-3 else f"{1e6 * step:g} µs"


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
