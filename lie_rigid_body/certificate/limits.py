"""The limit of a certificate: one number L for each way in which a motion is computed.

An attitude may be L rad off the exact motion, a body rate 4 L of the largest rate. A position is that of the scenario
to round-off. See `readings` for sensors.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.motion import METHODS
from lie_rigid_body.scenario import Scenario

U: Final = 2.0**-53
"""Unit round-off of a double."""
CLOSED_FORM_ERROR: Final = 2e-15
"""Largest error of the closed form up to 1e15 rad, rad, as its tests find by enclosures."""
MAX_NORM_ERROR: Final = 8 * U
"""Limit of | |q| − 1 |, dimensionless."""
RATE_FACTOR: Final = 4.0
"""Limit of the body rate's error as a share of the largest rate, in units of L."""

TRANSLATION_ERROR: Final = 8 * U
"""Limit of the position's error as a share of the largest distance from the origin. A velocity along the body's axes
may err by L of the largest speed beside it, as the axes do."""
PATH_ERROR: Final = 1e-9
"""Limit of what follows a path, rad, m and m/s beside those above: the spline's solver differs by machine."""

_CLOSED_FORM: Final = 48 * U
_EXACT_STEPS: Final = 1e-12
_STEPS: Final = 1e-7


class LargestSoFar(dict[str, float]):
    """The largest of the sizes of several quantities, so that one pass through a bag is enough."""

    def with_more(self, name: str, sizes: Array) -> Array:
        """The largest size of a quantity up to each of its next samples."""
        largest = np.maximum(np.maximum.accumulate(sizes), self.get(name, 0.0))
        self[name] = float(largest[-1])
        return largest


def closed_form_error(speeds: Array, elapsed_ns: Integers) -> Array:
    """Bound of the closed form's error beyond `CLOSED_FORM_ERROR`, rad: 0 up to 5e15 rad.

    Its phases err by 2⁻¹⁰¹ of the angle gone through (docs/closed_form.md).

    Parameters
    ----------
    speeds : ndarray, shape (N,)
        Largest body rate so far, rad/s.
    elapsed_ns : ndarray of int64, shape (N,)
    """
    turned = speeds * (1e-9 * elapsed_ns)
    return np.minimum(np.maximum(2.0**-101 * turned - CLOSED_FORM_ERROR, 0.0), np.pi)


def max_attitude_error(scenario: Scenario) -> float:
    """Limit L of the attitude's error, rad, for the motion that a scenario declares.

    The closed form is given twice its own error and a dozen roundings. ``dmv20`` is exact in each step, and its
    roundings add up at random: 3 million steps of 0.2 rad made 2.6e-13 rad. A ground truth of any other stepper may err
    by 1e-7 rad. A path is known to `PATH_ERROR`.
    """
    if scenario.motion == "path":
        return PATH_ERROR
    if scenario.motion == "closed_form":
        return _CLOSED_FORM
    return _EXACT_STEPS if scenario.method == "dmv20" else _STEPS


def remedy(scenario: Scenario, error: float, limit: float) -> str:
    """Advice, in words, how a declared stepper keeps a limit; empty for other motions.

    Parameters
    ----------
    scenario : Scenario
    error, limit : float
        Measured error and its limit, in one unit.
    """
    if scenario.motion != "moving_chart":
        return ""
    better = "record with motion closed_form"
    if scenario.method == "dmv20":
        return f": if {scenario.method} made it, {better}"
    better += " or method dmv20"
    if not 1.0 < error / limit < 1e6:  # the error is no small one, which falls with the steps as the order says
        return f": if {scenario.method} made it, {better}"
    step = 1.0 / (scenario.rate * scenario.steps_per_sample())
    enough = 0.8 * step * (limit / error) ** (1.0 / METHODS[scenario.method].order)
    return f": if {scenario.method} made it, give a max_step of {enough:.1g} s, or {better}"
