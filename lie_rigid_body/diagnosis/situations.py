"""Situations: where a filter is right with perfect sensors and where it is not, when no repair explains its error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Final

import numpy as np

from lie_rigid_body.diagnosis.course import Course, Readings
from lie_rigid_body.diagnosis.repairs import SENSOR_READINGS, Repair
from lie_rigid_body.diagnosis.search import Search
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.lie import quaternion

LEVEL: Final = (0.4, -0.3, 0.0)
"""Roll, pitch and yaw of a body that is nearly level, degrees."""
TILTED: Final = (35.0, 25.0, 0.0)
"""Roll, pitch and yaw of a tilted body, degrees."""
HEADED: Final = (35.0, 25.0, 70.0)
"""Roll, pitch and yaw of a tilted body that does not look along the world's x axis, degrees."""
RATE: Final = 1.0
"""Rate about an axis of the body, rad/s."""
RIGHT: Final = 0.1
"""Share of the largest error in any situation up to which a filter is right in one."""


@short_dataclass(frozen=True)
class Situation:
    """RMS of the error of a filter in a situation.

    Attributes
    ----------
    name : str
    rms_deg : float or None
        Of the total error over the last two thirds, degrees; None where the filter failed.
    is_level : bool
        Whether the vertical is right there.
    """

    name: str
    rms_deg: float | None
    is_level: bool


def _at(course: Course, angles_deg: tuple[float, float, float], *rate: float) -> Course:
    roll, pitch, yaw = (
        quaternion.exp(angle * axis) for angle, axis in zip(np.radians(angles_deg), np.eye(3), strict=True)
    )
    attitude = quaternion.multiply(yaw, quaternion.multiply(pitch, roll))
    return course.of_scenario(initial_attitude_xyzw=attitude.tolist(), initial_body_rate=list(rate) or [0.0] * 3)


def _zeros(sensor: str, given: Readings) -> Readings:
    return given.changed(np.zeros_like, SENSOR_READINGS[sensor])


def _silent(sensor: str) -> Repair:
    """Zeros in place of the readings of a sensor."""
    return Repair("", "", 0, partial(_zeros, sensor), "", "")


REST: Final[Mapping[str, tuple[float, float, float]]] = {
    "level at rest": LEVEL,
    "tilted at rest": TILTED,
    "tilted and headed at rest": HEADED,
}
"""Situations at rest, and the angles of the body, degrees."""
TURNS: Final = {f"rotating about {axis}": rate for axis, rate in zip("xyz", (RATE * np.eye(3)).tolist(), strict=True)}
"""Rotations about each axis of the body, and the body rates, rad/s."""
TUMBLES: Final[Mapping[str, tuple[str, ...]]] = {
    "tumbling": (),
    "tumbling without magnetometer": ("magnetometer",),
    "tumbling without accelerometer": ("accelerometer",),
}
"""Free tumbles, and the sensors whose readings are zeros there."""


def situations(search: Search) -> Iterator[Situation]:
    """Run the filter, as it is, in each situation."""
    course = search.course
    every: list[tuple[str, Course, tuple[str, ...]]] = [
        *((name, _at(course, angles), ()) for name, angles in REST.items()),
        *((name, _at(course, LEVEL, *rate), ()) for name, rate in TURNS.items()),
        *((name, course, silent) for name, silent in TUMBLES.items()),
    ]
    for name, each, silent in every:
        answer = search.answer(search.settled(each), *map(_silent, silent))
        if answer is None or answer.broken.size:
            yield Situation(name, None, is_level=False)
        else:
            track = answer.track.fraction()
            level = float(np.sqrt(np.mean(track.error().inclination ** 2)))
            yield Situation(name, float(np.degrees(answer.error())), is_level=level <= search.floor)


def common(found: list[Situation], floor_deg: float) -> str:
    """Sentence of what the right situations have in common, and the wrong ones; empty where all are alike."""
    known = {each.name: each.rms_deg for each in found if each.rms_deg is not None}
    limit = max(floor_deg, RIGHT * max((error for name, error in known.items() if "without" not in name), default=0.0))
    right = {name: error <= limit for name, error in known.items()}
    wrong_level = all(each.is_level for each in found if not right.get(each.name, True))
    alone = ", in its heading alone" * wrong_level
    about = {axis: right[f"rotating about {axis}"] for axis in "xyz" if f"rotating about {axis}" in right}
    if all(right.values()) or not any(right.values()):
        return f"It is wrong in every situation{alone}." if known and not any(right.values()) else ""
    if not right.get("tumbling") and right.get("tumbling without magnetometer"):
        return f"It is right without the magnetometer, and wrong with it{alone}."
    if not right.get("tumbling") and right.get("tumbling without accelerometer"):
        return f"It is right without the accelerometer, and wrong with it{alone}."
    if right.get("level at rest") and not right.get("tilted at rest"):
        return (
            f"It is right at rest and level, and wrong at rest and tilted{alone}: look at the tilt compensation or at "
            "the order of the Euler angles."
        )
    if right.get("tilted at rest") and not right.get("tilted and headed at rest"):
        return f"It is right where the body looks along x, and wrong at another heading{alone}."
    if len(set(about.values())) == 2:
        said = [" and ".join(axis for axis, good in about.items() if good is wanted) for wanted in (True, False)]
        return f"It is right in rotations about {said[0]}, and wrong about {said[1]}{alone}."
    if all(right.get(name) for name in REST) and not any(about.values()):
        return f"It is right at rest, and wrong in motion{alone}."
    if all(about.values()) and not right.get("tumbling"):
        return f"It is right about each axis alone, and wrong in a tumble{alone}."
    good, bad = (", ".join(name for name, is_right in right.items() if is_right is wanted) for wanted in (True, False))
    return f"It is right {good}; it is wrong {bad}{alone}."
