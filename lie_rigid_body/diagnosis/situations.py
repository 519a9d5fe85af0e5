"""Situations: where a filter is right with perfect sensors and where it is not, when no repair explains its error."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Final

import numpy as np
import scipy  # whose parts are loaded where they are first called

from lie_rigid_body.diagnosis.course import Course
from lie_rigid_body.diagnosis.repairs import scaled
from lie_rigid_body.diagnosis.search import Search
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.foundation.short_dataclass import short_dataclass

LEVEL: Final = (0.4, -0.3, 0.0)
"""Roll, pitch and yaw of a body that is nearly level, degrees."""
TILTED: Final = (35.0, 25.0, 0.0)
"""Roll, pitch and yaw of a tilted body, degrees."""
HEADED: Final = (35.0, 25.0, 70.0)
"""Roll, pitch and yaw of a tilted body that does not look along the world's x axis, degrees."""
RATE: Final = 1.0
"""Rate about an axis of the body, rad/s."""
TILT: Final = ": look at the tilt compensation or at the order of the Euler angles"
"""Hint for a filter that is right only where it is level."""
RIGHT: Final = 0.1
"""Share of the largest error in any situation up to which a filter is right in one."""
WRONG: Final = 0.5
"""Share of it above which it is wrong there."""


@short_dataclass
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


def _at(course: Course, angles_deg: Sequence[float], rate: Sequence[float] = (0.0, 0.0, 0.0)) -> Course:
    """A course that begins with roll, pitch and yaw, degrees, and a body rate, rad/s."""
    attitude = scipy.spatial.transform.Rotation.from_euler("xyz", angles_deg, degrees=True)
    return course.of_scenario(initial_attitude_xyzw=attitude.as_quat().tolist(), initial_body_rate=rate)


REST: Final = {
    "level at rest": LEVEL,
    "tilted at rest": TILTED,
    "tilted and headed at rest": HEADED,
}
"""Situations at rest, and the angles of the body, degrees."""
TURNS: Final = {f"rotating about {axis}": rate for axis, rate in zip("xyz", (RATE * np.eye(3)).tolist(), strict=True)}
"""Rotations about each axis of the body, and the body rates, rad/s."""
TUMBLES: Final = {
    "tumbling": (),
    "tumbling without magnetometer": ("magnetometer",),
    "tumbling without accelerometer": ("accelerometer",),
}
"""Free tumbles, and the sensors whose readings are zeros there."""


def situations(search: Search) -> Iterator[Situation]:
    """Run the filter, as it is, in each situation; the tumble is that of the course with the larger error."""
    unrepaired = search.unrepaired
    worst = max(zip(unrepaired.unrepaired, search.courses, strict=True), key=lambda each: each[0].error())
    course = worst[1].of_scenario(gyro_rate=unrepaired.kind)
    every = [
        *((name, _at(course, angles), ()) for name, angles in REST.items()),
        *((name, _at(course, LEVEL, rate), ()) for name, rate in TURNS.items()),
        *((name, course, silent) for name, silent in TUMBLES.items()),
    ]
    for name, each, silent in every:
        answer = search.answer(search.settled(each), *(scaled(sensor, 0.0) for sensor in silent))
        if answer is None or answer.broken.size:
            yield Situation(name, None, is_level=False)
        else:
            level = rms(answer.track.fraction().error().inclination)
            yield Situation(name, math.degrees(answer.error()), is_level=level <= search.floor)


RULES: Final = (
    ("tumbling without magnetometer", "tumbling", "without the magnetometer", "with it"),
    ("tumbling without accelerometer", "tumbling", "without the accelerometer", "with it"),
    ("level at rest", "tilted at rest", "at rest and level", "at rest and tilted"),
    ("tilted at rest", "tilted and headed at rest", "where the body looks along x", "at another heading"),
)
"""Situations of which the first is right and the second wrong, and how these are told; the first such pair is told."""
GROUPS: Final = (
    ({*REST}, "at rest"),
    ({*TURNS, "tumbling"}, "in motion"),
    ({*TURNS}, "about each axis"),
    *(
        ({f"rotating about {axis}" for axis in axes}, f"about {' and '.join(axes)}")
        for count in (2, 1)
        for axes in combinations("xyz", count)
    ),
    ({"tumbling"}, "in a tumble"),
)
"""Situations that have a name in common, the largest groups first."""


def common(found: list[Situation], floor_deg: float) -> str:
    """Sentence of what the right situations have in common, and the wrong ones; empty where none failed."""
    known = [each for each in found if each.rms_deg is not None]
    limit = max([floor_deg, *(RIGHT * each.rms_deg for each in known if each.rms_deg and "without" not in each.name)])
    right = [each.name for each in known if (each.rms_deg or 0.0) <= limit]
    wrong = [each.name for each in known if (each.rms_deg or 0.0) > WRONG / RIGHT * limit]
    alone = ", in its heading alone" * all(each.is_level for each in known if each.name in wrong)
    for good, bad, good_words, bad_words in RULES:
        if good in right and bad in wrong:
            hint = TILT if good == "level at rest" else ""
            return f"It is right {good_words}, and wrong {bad_words}{alone}{hint}."
    if not right:
        return f"It is wrong in every situation{alone}."
    return f"It is right {_together(right)}, and wrong {_together(wrong)}{alone}." if wrong else ""


def _together(names: Sequence[str]) -> str:
    """Names of situations in a few words: `about x and y`."""
    said = list[str]()
    names = [name for name in names if "without" not in name] or names
    for group, words in GROUPS:
        if group.issubset(names):
            said.append(words)
            names = [name for name in names if name not in group]
    return " and ".join((*said, *names))
