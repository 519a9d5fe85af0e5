"""Kicks and translation of a scenario in words and as data: all but free rotation about a resting mass centre."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import counted, numerals
from lie_rigid_body.motion import describe
from lie_rigid_body.scenario.definition import Scenario

MAX_ARCS: Final = 10
"""Largest number of arcs that are told."""


def facts(scenario: Scenario) -> dict[str, str]:
    """Phrases by what each is about; none of a body that turns freely about a resting mass centre.

    Parameters
    ----------
    scenario : Scenario

    Returns
    -------
    dict of str to str
        In the order in which they are told.
    """
    kicks = scenario.kick_schedule()
    imu = scenario.sensors.imu
    found = {}
    if len(kicks):
        again = f", again every {scenario.kick_period:g} s" if kicks.period_ns else ""
        found["kicks"] = f"{counted(len(kicks), 'kick')}, {kicks.rests} to rest{again}"
    if scenario.translation != "none":
        found["mass centre"] = _mass_centre(scenario)
    is_carried = scenario.moves and scenario.translation != "thrown"
    if imu is not None and is_carried and imu.accelerometer_mode == "free_fall":
        found["gravity"] = "the accelerometer reads none in free_fall: give pivot_gravity where the world has weight"
    return found


def _mass_centre(scenario: Scenario) -> str:
    position, velocity = map(numerals, (scenario.initial_position, scenario.initial_velocity))
    start = f"{scenario.translation} from [{position}] m at [{velocity}] m/s"
    if scenario.translation == "thrown":
        return f"{start}, with a gravity of {scenario.value('gravity'):g} m/s²"
    low, high = scenario.sway_band
    return f"{start}, with a sway of [{numerals(scenario.sway_acceleration)}] m/s² RMS from {low:g} to {high:g} Hz"


def beyond_rotation(scenario: Scenario) -> dict[str, Any]:
    """Data of the first arcs, of all kicks, and of the sway.

    Parameters
    ----------
    scenario : Scenario

    Returns
    -------
    dict of str to object
        ``arcs``: of each its begin, s, its first body rate, rad/s, and its regime.
        ``kicks``: their number, how many bring the body to rest, and their period, s, if they come again.
        ``sway``: None without one; RMS on each axis of the world, and bounds of speed and displacement.
    """
    kicks = scenario.kick_schedule()
    starts = scenario.arc_starts()
    count = MAX_ARCS if kicks.period_ns else min(MAX_ARCS, len(starts))
    arcs = []
    for number in range(count):
        start = starts[(kicks.places(number)[1])]
        regime = describe(scenario.body(), start).regime
        arcs.append({"begin_s": kicks.begin_ns(number) / NS, "body_rate": start.body_rate.tolist(), "regime": regime})
    of_kicks = {
        "count": len(kicks),
        "rests": kicks.rests,
        "period_s": scenario.kick_period if kicks.period_ns else None,
    }
    return {"arcs": arcs, "kicks": of_kicks, "sway": _sway(scenario)}


def _sway(scenario: Scenario) -> dict[str, object] | None:
    """RMS of the sway on each axis of the world, and bounds of its speed and displacement; None without a sway."""
    sway = scenario.sway()
    if sway is None:
        return None
    speed = sway.amplitude / (math.tau * sway.frequency_hz)
    displacement = speed / (math.tau * sway.frequency_hz)
    sizes = {"speed_m_s": speed, "displacement_m": displacement}
    return {
        **{f"{name}_rms": np.sqrt(0.5 * (size * size).sum(axis=1)).tolist() for name, size in sizes.items()},
        **{f"{name}_at_most": float(np.linalg.norm(size.sum(axis=1))) for name, size in sizes.items()},
    }
