"""What a scenario has beside a free rotation about a resting mass centre, in words: kicks, translation, vibration."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from lie_rigid_body.foundation.parameters import NS, Vector
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
    rests = int((~kicks.body_rate.any(axis=1)).sum())
    again = f", again every {scenario.kick_period:g} s" if kicks.period_ns else ""
    imu = scenario.sensors.imu
    vibration = ""
    gravity = ""
    if imu is not None and any(imu.vibration_acceleration):
        vibration = f"{_harmonics(imu.vibration_acceleration, imu.vibration_band)}, of the accelerometer's mount"
    if imu is not None and scenario.translation == "carried" and imu.accelerometer_mode == "free_fall":
        gravity = (
            "the accelerometer reads none, as its mode is free_fall: give pivot_gravity where the world has weight"
        )
    found = {
        "kicks": f"{counted(len(kicks), 'kick')}, {rests} to rest{again}" if len(kicks) else "",
        "mass centre": _mass_centre(scenario),
        "vibration": vibration,
        "gravity": gravity,
    }
    return {name: phrase for name, phrase in found.items() if phrase}


def _mass_centre(scenario: Scenario) -> str:
    place = f"[{numerals(scenario.initial_position)}] m"
    if scenario.translation == "none":
        return f"at rest at {place}" if any(scenario.initial_position) else ""
    start = f"{scenario.translation} from {place} at [{numerals(scenario.initial_velocity)}] m/s"
    if scenario.translation == "thrown":
        return f"{start}, with a gravity of {scenario.value('gravity'):g} m/s²"
    if scenario.sway() is None:
        return start
    return f"{start}, with a sway of {_harmonics(scenario.sway_acceleration, scenario.sway_band)}"


def _harmonics(rms: Vector, band: Vector) -> str:
    low, high = band
    return f"[{numerals(rms)}] m/s² RMS from {low:g} to {high:g} Hz"


def beyond_rotation(scenario: Scenario) -> dict[str, Any]:
    """Data of the first arcs, of all kicks, and of the sway.

    Parameters
    ----------
    scenario : Scenario

    Returns
    -------
    dict of str to object
        ``arcs``: of each its begin, s, its first body rate, rad/s, its regime, and its period, s, if it has one.
        ``kicks``: their number, how many bring the body to rest, and their period, s, if they come again.
        ``sway``: None without one; RMS on each axis of the world, and bounds of speed and displacement.
    """
    kicks = scenario.kick_schedule()
    starts = scenario.arc_starts()
    count = MAX_ARCS if kicks.period_ns else min(MAX_ARCS, len(starts))
    arcs = []
    for number in range(count):
        start = starts[(number - 1) % len(kicks) + 1 if number else 0]
        description = describe(scenario.body(), start)
        arcs.append(
            {
                "begin_s": kicks.begin_ns(number) / NS,
                "body_rate": start.body_rate.tolist(),
                "regime": description.regime,
                "period_s": description.circulation.period_s if description.circulation else None,
            }
        )
    rests = int((~kicks.body_rate.any(axis=1)).sum())
    of_kicks = {"count": len(kicks), "rests": rests, "period_s": scenario.kick_period if kicks.period_ns else None}
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
        "band_hz": scenario.sway_band,
        "acceleration_m_s2_rms": scenario.sway_acceleration,
        **{f"{name}_rms": np.sqrt(0.5 * (size * size).sum(axis=1)).tolist() for name, size in sizes.items()},
        **{f"{name}_at_most": float(np.linalg.norm(size.sum(axis=1))) for name, size in sizes.items()},
    }
