"""The sensor, the axis and the unit that the header of a column names, whichever program wrote it."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterable, Mapping
from typing import Final

from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.logs.bags import ACCELEROMETER, GYRO, MAGNETOMETER

TIME: Final = "time"
GRAVITY: Final = "gravity"
"""The vertical that a phone computes, which is what its linear acceleration lacks."""
STANDARD_GRAVITY: Final = 9.80665
"""The unit g, m/s²."""


def _units(names: str, factor: float) -> dict[str, float]:
    return dict.fromkeys(names.split(), factor)


_DEGREE: Final = math.pi / 180.0
_ACCELERATIONS: Final = {
    **_units("m/s2 ms-2 m/s/s mps2 ms2", 1.0),
    "g": STANDARD_GRAVITY,
    "mg": 1e-3 * STANDARD_GRAVITY,
}
UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    GYRO: {
        **_units("rad/s rads-1 rads rad", 1.0),
        **_units("deg/s degs-1 °/s °s-1 dps degs deg", _DEGREE),
        "mdps": 1e-3 * _DEGREE,
    },
    ACCELEROMETER: _ACCELERATIONS,
    GRAVITY: _ACCELERATIONS,
    MAGNETOMETER: {
        **_units("t tesla", 1.0),
        "mt": 1e-3,
        **_units("ut μt microtesla", 1e-6),
        "nt": 1e-9,
        **_units("g ga gauss", 1e-4),
        **_units("mg mga mgauss milligauss", 1e-7),
    },
    TIME: {
        **_units("s sec secs second seconds", 1e9),
        **_units("ms msec millis milliseconds", 1e6),
        **_units("us μs usec micros microseconds", 1e3),
        **_units("ns nsec nanos nanoseconds", 1.0),
    },
}
"""Units by quantity, as `unit_key` writes them, in rad/s, m/s², T and ns."""
_KEYS: Final = sorted({key for units in UNITS.values() for key in units}, key=len, reverse=True)
_TAIL: Final = re.compile(
    r"[_ ](?:(?P<long>{})(?P<axis>[_ ]?[xyz012])?|(?P<short>[gst]))$".format(
        "|".join(re.escape(key).replace("/", "[_/]") for key in _KEYS if len(key) > 1)
    ),
    re.IGNORECASE,
)
"""Unit at the end of a name, perhaps before the axis: ``acc_x_g``, ``gyro_rad_0``, ``Time since start in ms``."""
_BRACKETS: Final = re.compile(r"[\[(]([^\])]*)[\])]")
_WORDS: Final = re.compile(r"[A-Z]?[a-z]+|[A-Z]+|\d+|[^\W\d_]+")
_SENSOR_WORDS: Final = (
    (GYRO, re.compile(r"gyr\w*|angular|angvel|omega|rates?")),
    (ACCELEROMETER, re.compile(r"acc|accel|accl|acceler\w*")),
    (MAGNETOMETER, re.compile(r"mag|magn|magnet\w*")),
)
_SHORT: Final = {
    "g": GYRO,
    "w": GYRO,
    "wrss": GYRO,
    "a": ACCELEROMETER,
    "arss": ACCELEROMETER,
    "gf": ACCELEROMETER,
    "m": MAGNETOMETER,
    "b": MAGNETOMETER,
}
"""Names of one letter, those of EuRoC (``w_RS_S_x``) and the g-force of Physics Toolbox (``gFx``)."""
_OTHERS: Final = re.compile(
    r"quat|orient|euler|attitude|bias|cov|integral|relative|setpoint|offset|std|sigma|angularacc|heading|vector|delta"
)
"""Words of columns that are no readings."""
_TIME_WORDS: Final = re.compile(r"time|stamp|epoch|elapsed|millis|micros|seconds|^(t|ts|secs?)$")
_NO_TIMES: Final = re.compile(r"relative|zone|sync|offset|exposure|delta")
LAYOUTS: Final[Mapping[str, tuple[str, Mapping[str, str]]]] = {
    "secondselapsed": ("Sensor Logger", {MAGNETOMETER: "µT"}),
    "gfx": ("Physics Toolbox", {ACCELEROMETER: "g", MAGNETOMETER: "µT"}),
    "gyroadcx": ("Betaflight", {GYRO: "deg/s"}),
    "attribute": ("VMU931", {GYRO: "deg/s", ACCELEROMETER: "g", MAGNETOMETER: "µT", TIME: "ms"}),
}
"""Programs that are known by the name of a column, and their units that no header tells."""


@short_dataclass
class Heading:
    """The header of a column.

    Attributes
    ----------
    text : str
        As it stands.
    words : tuple of str
        Words of its name, without axis and unit.
    axis : int or None
        0, 1, 2 for x, y, z.
    unit : str
        As it stands; empty where there is none.
    """

    text: str
    words: tuple[str, ...]
    axis: int | None
    unit: str

    @property
    def joined(self) -> str:
        """The words as one, with the axis."""
        return "".join(self.words) + ("" if self.axis is None else "xyz"[self.axis])

    @property
    def is_time(self) -> bool:
        """Whether it is that of a time."""
        joined = "".join(self.words)
        return self.axis is None and bool(_TIME_WORDS.search(joined)) and not _NO_TIMES.search(joined)


def unit_key(text: str) -> str:
    """A unit as `UNITS` has it: in small letters, without blanks and signs of powers and products."""
    plain = unicodedata.normalize("NFKC", text).lower().replace("_", "/")
    return re.sub(r"[\s^*·.]", "", plain)


def heading(text: str) -> Heading:
    """Read the header of a column."""
    name = unicodedata.normalize("NFKC", text).strip().lstrip("#%").strip()
    brackets = [each for each in _BRACKETS.findall(text) if each not in ("0", "1", "2")]
    name = _BRACKETS.sub(lambda found: f"_{found[1]}" if found[1] in ("0", "1", "2") else " ", name).strip()
    unit = brackets[-1] if brackets else ""
    if not unit and (tail := _TAIL.search(name)):
        unit = tail["long"] or tail["short"]
        name = f"{name[: tail.start()]}{tail['axis'] or ''}"
    words = [word.lower() for word in _WORDS.findall(name) if word.lower() != "axis"]
    if words and words[0] in ("x", "y", "z"):
        words.append(words.pop(0))
    stem = [word for word in (*words[:-1], *(word[:-1] for word in words[-1:])) if word]
    axis = "xyz012".find("".join(words)[-1:])
    has_axis = bool(words) and axis >= 0 and (not stem or sensor_of(stem) is not None)
    plain = text.strip().lstrip("#%").strip()
    return Heading(plain, tuple(stem if has_axis else words), axis % 3 if has_axis else None, unit)


def sensor_of(words: Iterable[str]) -> str | None:
    """The sensor that words name: the last of them which names one, or a short name."""
    words = [*words]
    joined = "".join(words)
    if _OTHERS.search(joined):
        return None
    for word in reversed(words):
        for sensor, pattern in _SENSOR_WORDS:
            if pattern.fullmatch(word):
                return sensor
    if "gravity" in words:
        return GRAVITY
    return _SHORT.get(joined) or (_SHORT.get(words[-1]) if words else None)
