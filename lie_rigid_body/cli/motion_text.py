"""The course of a motion in sentences and rows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from lie_rigid_body.cli.wording import axis_name, degrees, number, period, vector
from lie_rigid_body.mechanics.symmetric_top import SymmetricTop
from lie_rigid_body.motion.description import Circulation, Description, Flips, SteadyRotation

Row = tuple[str, str]

_SEPARATRIX: Final = (
    "Exactly on the separatrix, between circling axis 1 and circling axis 3: the body rate tends to axis 2 "
    "(intermediate) and never returns. The least disturbance makes it a periodic motion."
)
_STEADY: Final = {
    "stable": "It is stable: a small disturbance stays small.",
    "unstable": "It is unstable: the least disturbance grows until the body turns over, again and again.",
    "neutral": "It is neutral: a small disturbance makes another motion, which drifts away steadily if at all.",
}


def regime_sentences(description: Description) -> str:
    """What the body rate does."""
    if description.steady is not None:
        return _steady_sentences(description, description.steady)
    if description.regime == "rest":
        return "The body is at rest, and stays so in any attitude."
    if description.regime == "separatrix":
        return _SEPARATRIX
    axis = axis_name(description.kind, _circled(description))
    course = "on a circle, at a constant rate" if "symmetry" in axis else "on a closed curve"
    return f"In the body, the body rate and the momentum circle {axis}, {course}."


def _circled(description: Description) -> int:
    return 0 if description.regime == "about_smallest" else 2


def _steady_sentences(description: Description, steady: SteadyRotation) -> str:
    first, *others = steady.principal
    axis = f"{vector(steady.axis)} in the body" if others else axis_name(description.kind, first)
    return f"A steady rotation about {axis}. {_STEADY[description.axes[first].spin.verdict]}"


def motion_rows(description: Description) -> Iterator[Row]:
    """The motion's numbers, each with its name."""
    yield "kinetic energy", f"{number(description.kinetic_energy_j)} J"
    yield "angular momentum", f"{number(description.angular_momentum_kg_m2_s)} kg m²/s"
    yield "  in the world frame", f"{vector(description.world_momentum_kg_m2_s)} kg m²/s"
    if description.steady is not None:
        yield "one turn", f"{number(description.steady.turn_s)} s"
    circulation = description.circulation
    if circulation is None:
        return
    yield "distance from the separatrix", f"1 - m = {number(circulation.separatrix_distance)}"
    if description.regime == "separatrix":
        yield from _separatrix_rows(circulation)
    else:
        yield from _periodic_rows(circulation, f"axis {_circled(description) + 1}", description.symmetric_top)


def _separatrix_rows(circulation: Circulation) -> Iterator[Row]:
    yield "period of the body rate", "infinite"
    yield "turn about the momentum", f"tends to {number(circulation.precession_rate_rad_s)} rad/s"
    first = math.inf if circulation.flips is None else circulation.flips.first_s
    yield "Dzhanibekov flips", f"one, {number(first)} s after the start" if math.isfinite(first) else "none any more"


def _periodic_rows(circulation: Circulation, axis: str, top: SymmetricTop | None) -> Iterator[Row]:
    rate, angle = circulation.precession_rate_rad_s, circulation.advance_per_period_rad
    yield "period of the body rate", f"{number(circulation.period_s)} s"
    if top is not None:
        yield f"  circling {axis}", f"at {number(top.body_precession_rate_rad_s)} rad/s"
    yield "mean precession", f"{number(rate)} rad/s: {axis} circles the momentum once in {period(rate)}"
    yield f"  tilt of {axis}", _tilt(circulation)
    yield "  advance per period", f"{number(angle)} rad, {number(angle / (2.0 * math.pi))} turns about the momentum"
    if top is not None:
        axial, momentum = degrees(top.rate_to_axis_rad), degrees(top.rate_to_momentum_rad)
        yield "  tilt of the body rate", f"{axial} from {axis}, {momentum} from the momentum, always"
    if circulation.flips is not None:
        yield from _flip_rows(circulation.flips)


def _tilt(circulation: Circulation) -> str:
    lowest, highest = degrees(circulation.tilt_min_rad), degrees(circulation.tilt_max_rad)
    swing = f"{lowest}, always: no nutation" if lowest == highest else f"swings between {lowest} and {highest}"
    return f"{swing} (angle to the momentum)"


def _flip_rows(flips: Flips) -> Iterator[Row]:
    near = degrees(flips.nearest_angle_rad)
    yield (
        "Dzhanibekov flips" if flips.sudden else "axis 2 turns over",
        f"every {number(flips.interval_s)} s, the first {number(flips.first_s)} s after the start",
    )
    if flips.sudden:
        yield "  between flips", f"the momentum comes within {near} of axis 2"
    else:
        yield "  not suddenly", f"the momentum comes within {near} of axis 2, and does not linger there"
