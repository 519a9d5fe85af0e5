"""Columns of time: the unit by its name, its size or its steps, and the times in ns."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from datetime import date
from decimal import Decimal
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.logs.headings import TIME, UNITS, Heading, unit_key

_CLOCK: Final = re.compile(
    r"(?:(\d{4})[-/.](\d\d)[-/.](\d\d)[T, ]+)?(\d{1,2}):(\d\d):(\d\d)(?:[.,:](\d{1,9}))?(?:Z|[-+]\d\d:?\d\d)?"
)
"""A time of day, perhaps behind a date."""
_DAY_S: Final = 86_400
_NAMES: Final = {NS: "s", 10**6: "ms", 10**5: "0.1 ms", 10**3: "µs", 1: "ns"}
_UNITS: Final = (NS, 10**6, 10**3, 1)
"""Units of times, ns."""
_FINE: Final = (10**3, 10**5)
"""Units of Xsens' SampleTimeFine, of newer and of older devices, ns."""
_SINCE_1970_NS: Final = (5e17, 5e18)
"""Times that are taken for those since 1970: 1985 to 2128."""
_STEPS_NS: Final = (6e5, 6e8)
"""Steps of logs from one reading to the next."""
_WRAPS: Final = 2**32
_MIN_DROP: Final = 0.8
"""Least part of its range by which a counter falls where it begins anew."""
MISSING: Final = -(2**63)
"""The time of an empty cell."""


def nanoseconds(text: str, unit: int) -> int:
    """A time in units of so many ns, as its decimal tells it, in ns; of a time in ns a whole one.

    Raises
    ------
    ValueError
        If it is none.
    """
    if not abs(float(text)) * unit < 2**62:
        raise ValueError(f"no time: {text!r}")
    if text.isdecimal():
        return int(text) * unit
    time = Decimal(text) * unit
    if unit == 1 and time % 1:
        raise ValueError(f"no whole ns: {text!r}")
    return round(time)


def clock_ns(text: str) -> int:
    """A time of day, and perhaps its date, in ns.

    Raises
    ------
    ValueError
        If it is none.
    """
    found = _CLOCK.fullmatch(text)
    if found is None:
        raise ValueError(f"no time: {text!r}")
    *day, hours, minutes, seconds, fraction = found.groups()
    days = date(*map(int, day)).toordinal() - date(1970, 1, 1).toordinal() if day[0] else 0
    whole = days * _DAY_S + int(hours) * 3600 + int(minutes) * 60 + int(seconds)
    return whole * NS + int((fraction or "").ljust(9, "0"))


def as_number(text: str) -> float:
    """A number, perhaps with a decimal comma; NaN for an empty cell.

    Raises
    ------
    ValueError
        If it is none, or is not finite.
    """
    if not text:
        return np.nan
    number = float(text.replace(",", "."))
    if not abs(number) < np.inf or "_" in text:
        raise ValueError(f"no number: {text!r}")
    return number


def value_of(text: str) -> float:
    """A number, or a time of day, s; NaN for what is neither."""
    for read, unit in ((as_number, 1.0), (clock_ns, float(NS))):
        with suppress(ValueError):
            return read(text) / unit
    return np.nan


def is_row(texts: Sequence[str]) -> bool:
    """Whether cells are those of a row: most that are filled are numbers or times of day."""
    filled = [text for text in texts if text]
    return 2 * int(np.isfinite([value_of(text) for text in filled]).sum()) > len(filled)


def first_times(texts: Sequence[str]) -> Array:
    """Times among some texts, as numbers, in s where they are times of day."""
    found = np.array([value_of(text) for text in texts])
    return found[np.isfinite(found)]


@short_dataclass
class Clock:
    """A column of time.

    Attributes
    ----------
    unit : int
        Its unit, ns; 0 for times of day.
    told : str
        Words about the unit.
    """

    unit: int
    told: str

    def read(self, text: str) -> int:
        """A time, ns; `MISSING` for an empty cell.

        Raises
        ------
        ValueError, ArithmeticError
            If it is none.
        """
        if not text:
            return MISSING
        return nanoseconds(text.replace(",", "."), self.unit) if self.unit else clock_ns(text)

    def unwrapped(self, t_ns: Integers) -> tuple[Integers, str]:
        """Times, ns, that go on where a counter of 32 bits, or the clock at midnight, begins anew, and words."""
        period = _WRAPS * self.unit or _DAY_S * NS
        drops = t_ns[:-1] - t_ns[1:]
        anew = (drops > _MIN_DROP * period) & (drops <= period) & (self.unit != 1)
        told = f"{self.told}, which begins anew at {t_ns[1:][anew][0] / NS:.9g} s" if anew.any() else self.told
        return t_ns + period * np.append(0, np.cumsum(anew)), told


def clock_of(head: Heading, texts: Sequence[str], unit: str) -> Clock | None:
    """Clock of a column, whose unit is that of its header, of the program, or told by its first times.

    Parameters
    ----------
    head : Heading
    texts : sequence of str
        Its first times.
    unit : str
        The one that the program is known to write.

    Returns
    -------
    Clock or None
        None if they are no times, or neither name, size nor steps tell the unit.
    """
    numbers = first_times(texts)
    if len(numbers) and ":" in "".join(texts):
        return Clock(0, "a time of day")
    words = [word for word in head.words if len(word) > 1]
    keys = [key for key in map(unit_key, (head.unit, unit, *words)) if key in UNITS[TIME]]
    if keys:
        named = int(UNITS[TIME][keys[0]])
        return Clock(named, f"in {_NAMES[named]}")
    steps = np.diff(numbers)
    steps = steps[steps > 0]
    step = float(steps[steps <= np.quantile(steps, 0.99)].mean()) if len(steps) else 0.0  # in bursts most are short
    size = float(np.median(numbers)) if len(numbers) else 0.0
    is_fine = head.words == ("sample", "time", "fine")
    by_size = [(each, "size") for each in _UNITS if _SINCE_1970_NS[0] <= size * each < _SINCE_1970_NS[1]]
    by_step = [
        (each, f"steps of {step:g}")
        for each in (_FINE if is_fine else _UNITS)
        if _STEPS_NS[0] <= step * each < _STEPS_NS[1]
    ]
    for each, what in (by_step if is_fine else by_size + by_step)[:1]:
        return Clock(each, f"in {_NAMES[each]} by its {what}")
    return None


def share_that_rises(texts: Sequence[str]) -> float:
    """Share of times that rise, in tenths, a little less where they are no numbers."""
    numbers = first_times(texts)
    of_day = ":" in "".join(texts)
    return round(float(np.mean(np.diff(numbers) > 0)), 1) - 0.01 * of_day if len(numbers) > 1 else -1.0
