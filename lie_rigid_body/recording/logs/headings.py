"""The sensor, the axis and the unit that the header of a column names, whichever program wrote it."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from typing import Final

from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.logs.bags import ACCELEROMETER, GYRO, MAGNETOMETER

TIME: Final = "time"
GRAVITY: Final = "gravity"
"""The vertical that a phone computes, which is what its linear acceleration lacks."""
STANDARD_GRAVITY: Final = 9.80665
"""The unit g, m/s²."""
_DEGREE: Final = math.pi / 180.0
_ACCELERATIONS: Final = {"m/s2 ms-2 m/s/s mps2 ms2": 1.0, "g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY}
_NAMES_OF_UNITS: Final = {
    GYRO: {
        "rad/s rads-1 rads rad": 1.0,
        "deg/s degs-1 °/s °s-1 dps degs deg": _DEGREE,
        "mdps": 1e-3 * _DEGREE,
    },
    ACCELEROMETER: _ACCELERATIONS,
    GRAVITY: _ACCELERATIONS,
    MAGNETOMETER: {
        "t tesla": 1.0,
        "mt": 1e-3,
        "ut μt microtesla": 1e-6,
        "nt": 1e-9,
        "g ga gauss": 1e-4,
        "mg mga mgauss milligauss": 1e-7,
    },
    TIME: {
        "s sec secs second seconds": 1e9,
        "ms msec millis milliseconds": 1e6,
        "us μs usec micros microseconds": 1e3,
        "ns nsec nanos nanoseconds": 1.0,
    },
}
UNITS: Final = {
    quantity: {key: factor for names, factor in units.items() for key in names.split()}
    for quantity, units in _NAMES_OF_UNITS.items()
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
_INDEX: Final = re.compile(r"[\[(]([012])[\])]")
"""Index of an axis, as in ``gyro_rad[0]``."""
_BRACKETS: Final = re.compile(r"[\[(]([^\])]*)[\])]")
_WORDS: Final = re.compile(r"[A-Z]?[a-z]+|[A-Z]+|\d+|[^\W\d_]+")
_SENSOR: Final = re.compile(
    rf".*\b(?:(?P<{GYRO}>gyr\w*|angular|angvel|omega|rates?)"
    rf"|(?P<{ACCELEROMETER}>acc|accel|accl|acceler\w*)"
    rf"|(?P<{MAGNETOMETER}>mag|magn|magnet\w*))\b"
)
"""The last word that names a sensor."""
_SHORT: Final = re.compile(
    rf"(?P<{GRAVITY}>.*\bgravity\b.*)"
    rf"|(?:.* )?(?:(?P<{GYRO}>g|w|w rs s)|(?P<{ACCELEROMETER}>a|a rs s|g f)|(?P<{MAGNETOMETER}>m|b))"
)
"""The vertical, names of one letter, those of EuRoC (``w_RS_S_x``) and the g-force of Physics Toolbox (``gFx``)."""
_OTHERS: Final = re.compile(
    r"quat|orient|euler|attitude|bias|cov|integral|relative|setpoint|offset|std|sigma|angularacc|heading|vector|delta"
)
"""Words of columns that are no readings."""
_TIME_WORDS: Final = re.compile(
    r"(?!.*(?:relative|zone|sync|offset|exposure|delta))"
    r"(?:.*(?:time|stamp|epoch|elapsed|millis|micros|seconds)|(?:t|ts|secs?)$)"
)
LAYOUTS: Final[Mapping[tuple[str, ...], tuple[str, Mapping[str, str]]]] = {
    ("seconds", "elapsed"): ("Sensor Logger", {MAGNETOMETER: "µT"}),
    ("g", "f"): ("Physics Toolbox", {ACCELEROMETER: "g", MAGNETOMETER: "µT"}),
    ("gyro", "adc"): ("Betaflight", {GYRO: "deg/s"}),
    ("attribute",): ("VMU931", {GYRO: "deg/s", ACCELEROMETER: "g", MAGNETOMETER: "µT"}),
}
"""Programs that are known by the words of a column, and their units that no header tells."""


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
    def is_time(self) -> bool:
        """Whether it is that of a time."""
        return self.axis is None and bool(_TIME_WORDS.match("".join(self.words)))


def unit_key(text: str) -> str:
    """A unit as `UNITS` has it: in small letters, without blanks and signs of powers and products."""
    plain = unicodedata.normalize("NFKC", text).lower().replace("_", "/")
    return re.sub(r"[\s^*·.]", "", plain)


def heading(text: str) -> Heading:
    """Read the header of a column."""
    plain = text.lstrip("#% ").strip()
    indexed = _INDEX.sub(r"_\1", plain)
    *_, unit = ["", *_BRACKETS.findall(indexed)]
    name = unicodedata.normalize("NFKC", _BRACKETS.sub(" ", indexed)).strip()
    if not unit and (tail := _TAIL.search(name)):
        unit = tail["long"] or tail["short"]
        name = f"{name[: tail.start()]}{tail['axis'] or ''}"
    words = [word.lower() for word in _WORDS.findall(name) if word.lower() != "axis"]
    if words[:1] in (["x"], ["y"], ["z"]):
        words.append(words.pop(0))
    stem = re.sub("[xyz012]$", "", " ".join(words)).split()
    if stem == words or (stem and sensor_of(stem) is None):
        return Heading(plain, tuple(words), None, unit)
    return Heading(plain, tuple(stem), "xyz012".find(words[-1][-1]) % 3, unit)


def sensor_of(words: Sequence[str]) -> str | None:
    """The sensor that words name: the last of them which names one, or a short name."""
    if _OTHERS.search("".join(words)):
        return None
    text = " ".join(words)
    found = _SENSOR.match(text) or _SHORT.fullmatch(text)
    return found and found.lastgroup
