"""Columns of time: the unit by its name, its size or its steps, and the times in ns."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from datetime import date
from decimal import Decimal
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.recording.logs.headings import TIME, UNITS, Heading, unit_key
from lie_rigid_body.system.bounded_input import real

_CLOCK: Final = re.compile(
    r"(?:(\d{4})[-/.](\d\d)[-/.](\d\d)[T, ]+)?(\d{1,2}):(\d\d):(\d\d)(?:[.,:](\d{1,9}))?(?:Z|[-+]\d\d:?\d\d)?"
)
"""A time of day, perhaps behind a date."""
_DAY_S: Final = 86_400
_NAMES: Final = {NS: "s", 10**6: "ms", 10**5: "0.1 ms", 10**3: "µs", 1: "ns"}
_SIZES: Final = {NS: (5e8, 5e9), 10**6: (5e11, 5e12), 10**3: (5e14, 5e15), 1: (5e17, 5e18)}
"""Numbers of each unit, by its ns, that are taken for times since 1970: 1985 to 2128."""
_STEPS: Final = {NS: (6e-4, 0.6), 10**6: (0.6, 600.0), 10**3: (600.0, 6e5), 1: (6e5, 6e8)}
"""Steps of each unit: logs have 0.6 ms to 0.6 s from one reading to the next."""
_FINE: Final = {10**5: (0.0, 1200.0), 10**3: (1200.0, 1e6)}
"""Steps of Xsens' SampleTimeFine, of older devices and of others."""
_WRAPS: Final = 2**32
_NEAR: Final = 0.1
"""Part of its range in which a counter stands right before and after it begins anew."""


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


def clock_ns(text: str, _: int = 0) -> int:
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


def first_times(texts: Sequence[str]) -> tuple[Array, bool]:
    """Times among some texts, as numbers, in s where they are times of day, and whether they are."""
    texts = [text.replace(",", ".") for text in texts if text]
    of_day = [clock_ns(text) / NS for text in texts if is_clock(text)]
    return np.array(of_day or [float(text) for text in texts if is_number(text)]), bool(of_day)


def is_clock(text: str) -> bool:
    """Whether a text is a time of day."""
    return _is_read_by(clock_ns, text)


def is_number(text: str) -> bool:
    """Whether a text is a number."""
    return _is_read_by(real, text)


def _is_read_by(read: Callable[[str], object], text: str) -> bool:
    try:
        read(text)
    except ValueError:
        return False
    return True


class Clock:
    """A column of time, whose unit is that of its header, of the program, or told by its first times.

    Parameters
    ----------
    head : Heading
    texts : sequence of str
        Its first times.
    unit : str
        The one that the program is known to write.
    name : str
        Path of the file, for errors.

    Raises
    ------
    InputError
        If they are no times, or neither name, size nor steps tell the unit.
    """

    MISSING: Final = -(2**63)
    """The time of an empty cell."""

    def __init__(self, head: Heading, texts: Sequence[str], unit: str, name: str) -> None:
        self.head = head
        self._read: Callable[[str, int], int] = nanoseconds
        numbers, of_day = first_times(texts)
        if of_day:
            self._read = clock_ns
            self._unit, self._told, self._period = 0, "a time of day", _DAY_S * NS
            return
        found = _unit(head, numbers, unit)
        if found is None:
            remedy = f"name another column, or its unit, such as t={head.text}:ms"
            raise InputError(f"{name}: size and steps of {shown(head.text)} are those of no time: {remedy}")
        self._unit, self._told = found
        self._period = _WRAPS * self._unit

    def at(self, texts: Sequence[str], refuse: Callable[[int, str], InputError]) -> Integers:
        """Times of texts, ns."""
        found = list[int]()
        try:
            for text in texts:
                found.append(self._read(text.replace(",", "."), self._unit) if text else self.MISSING)
        except (ValueError, ArithmeticError):
            raise refuse(len(found), f"{shown(texts[len(found)])} is no time") from None
        return np.array(found, dtype=np.int64)

    def unwrapped(self, t_ns: Integers) -> tuple[Integers, str]:
        """Times, ns, that go on where a counter of 32 bits, or the clock at midnight, begins anew, and words."""
        near = _NEAR * self._period
        anew = (t_ns[1:] >= 0) & (t_ns[1:] < near) & (t_ns[:-1] < self._period) & (t_ns[:-1] > self._period - near)
        if self._unit == 1 or not anew.any():
            return t_ns, self._told
        more = self._period * np.concatenate([[0], np.cumsum(anew)])
        return t_ns + more.astype(np.int64), f"{self._told}, which begins anew at {t_ns[1:][anew][0] / NS:.9g} s"


def _unit(head: Heading, numbers: Array, of_program: str) -> tuple[int, str] | None:
    """Nanoseconds of the unit of a column, and the words that say how it is known."""
    told = [*map(unit_key, (head.unit, of_program, *(word for word in head.words if len(word) > 1)))]
    named = next((int(UNITS[TIME][key]) for key in told if key in UNITS[TIME]), None)
    if named is not None:
        return named, f"in {_NAMES[named]}"
    steps = np.diff(numbers)
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    is_fine = head.words == ("sample", "time", "fine")
    for limits, number, what in (
        ({} if is_fine else _SIZES, float(np.median(numbers)) if len(numbers) else 0.0, "size"),
        (_FINE if is_fine else _STEPS, step, f"steps of {step:g}"),
    ):
        for unit, (low, high) in limits.items():
            if low <= number < high and number:
                return unit, f"in {_NAMES[unit]} by its {what}"
    return None


def share_that_rises(texts: Sequence[str]) -> float:
    """Share of times that rise, in tenths, a little less where they are no numbers."""
    numbers, of_day = first_times(texts)
    return round(float(np.mean(np.diff(numbers) > 0)), 1) - 0.01 * of_day if len(numbers) > 1 else -1.0
