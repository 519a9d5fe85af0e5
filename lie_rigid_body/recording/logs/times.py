"""Columns of time: the unit by its name, its size or its steps, and the times in ns."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from decimal import Decimal
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.recording.logs.headings import TIME, UNITS, Heading, unit_key

_CLOCK: Final = re.compile(
    r"(?:(\d{4}[-/.]\d\d[-/.]\d\d)[T, ]+)?(\d{1,2}:\d\d:\d\d)(?:[.,:](\d{1,9}))?(?:Z|[-+]\d\d:?\d\d)?"
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


def nanoseconds(text: str, unit: int) -> int:
    """A time in units of so many ns, as its decimal tells it, in ns; of a time in ns a whole one.

    Raises
    ------
    ValueError, ArithmeticError
        If it is none.
    """
    time = Decimal(text) * unit
    if abs(time) >= 2**62 or (unit == 1 and time % 1):
        raise ValueError(f"no time: {text!r}")
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
    day, time, fraction = found.groups("")
    day = re.sub(r"\D", "-", day) or "1970-01-01"
    return int(np.datetime64(f"{day}T{time:0>8}.{fraction:0<9}", "ns").astype(np.int64))


def as_number(text: str) -> float:
    """A number, perhaps with a decimal comma.

    Raises
    ------
    ValueError
        If it is none, or is not finite.
    """
    number = float(text.replace(",", "."))
    if not abs(number) < np.inf or "_" in text:
        raise ValueError(f"no number: {text!r}")
    return number


def value_of(text: str) -> float:
    """A number, or a time of day, s; NaN for what is neither."""
    with suppress(ValueError):
        return clock_ns(text) / NS if ":" in text else as_number(text)
    return np.nan


def is_row(texts: Sequence[str]) -> bool:
    """Whether cells are those of a row: most that are filled are numbers or times of day."""
    filled = [text for text in texts if text]
    return 2 * len(first_times(filled)) > len(filled)


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
        """A time, ns.

        Raises
        ------
        ValueError, ArithmeticError
            If it is none.
        """
        return nanoseconds(text.replace(",", "."), self.unit) if self.unit else clock_ns(text)

    def unwrapped(self, t_ns: Integers) -> tuple[Integers, str]:
        """Times, ns, that go on where a counter of 32 bits, or the clock at midnight, begins anew, and words."""
        period = _WRAPS * self.unit or _DAY_S * NS
        drops = -np.diff(t_ns)
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
    keys = [key for key in map(unit_key, (head.unit, unit, *head.words)) if key in UNITS[TIME]]
    if keys:
        named = int(UNITS[TIME][keys[0]])
        return Clock(named, f"in {_NAMES[named]}")
    steps = np.diff(numbers)
    steps = steps[steps > 0]
    if not len(steps):
        return None
    step = steps[steps <= np.quantile(steps, 0.99)].mean()  # in bursts most are short
    tests = ((np.median(numbers), _SINCE_1970_NS, "size"), (step, _STEPS_NS, f"steps of {step:g}"))
    for value, (low, high), told in tests:
        for each in _FINE if head.words == ("sample", "time", "fine") else _UNITS:
            if low <= value * each < high:
                return Clock(each, f"in {_NAMES[each]} by its {told}")
    return None


def share_that_rises(texts: Sequence[str]) -> float:
    """Share of times that rise, in tenths, a little less where they are no numbers."""
    numbers = first_times(texts)
    of_day = ":" in "".join(texts)
    return round(float(np.mean(np.diff(numbers) > 0)), 1) - 0.01 * of_day if len(numbers) > 1 else -1.0
