"""Columns of time: the unit by its name, its size or its steps, and the times in ns."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from decimal import Decimal
from math import isfinite
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
    ValueError
        If it is none.
    """
    try:
        time = Decimal(text) * unit
        whole = round(time)
        if abs(whole) < 2**62 and (unit > 1 or whole == time):
            return whole
    except ArithmeticError:
        pass
    raise ValueError(f"no time: {text!r}")


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
    if "_" in text or not isfinite(number):
        raise ValueError(f"no number: {text!r}")
    return number


def first_times(texts: Sequence[str]) -> Array:
    """Numbers among some texts, and times of day, s."""
    found = list[float]()
    for text in texts:
        with suppress(ValueError):
            found.append(clock_ns(text) / NS if ":" in text else as_number(text))
    return np.array(found)


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
        ValueError
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


def clock_of(head: Heading, texts: Sequence[str]) -> Clock | None:
    """Clock of a column, whose unit is that of its header, or told by its first times.

    Parameters
    ----------
    head : Heading
    texts : sequence of str
        Its first times.

    Returns
    -------
    Clock or None
        None if they are no times, or neither name, size nor steps tell the unit.
    """
    numbers = first_times(texts)
    if ":" in "".join(texts):
        return Clock(0, "a time of day")
    keys = [key for key in map(unit_key, (head.unit, *head.words)) if key in UNITS[TIME]]
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


def share_that_differs(texts: Sequence[str]) -> float:
    """Share of times that differ from the others, in tenths, a little less where they are no numbers."""
    of_day = ":" in "".join(texts)
    return round(len(np.unique(first_times(texts))) / len(texts), 1) - 0.01 * of_day
