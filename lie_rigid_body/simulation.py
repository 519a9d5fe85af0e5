"""The one simulation loop: a scenario becomes samples at integer-nanosecond stamps."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.errors import InputError, ParameterError
from lie_rigid_body.mechanics import State
from lie_rigid_body.parameters import MAX_EPOCH_NS
from lie_rigid_body.scenario import Scenario

SOFTWARE: Final = "lie_rigid_body"


@dataclass(frozen=True)
class SampleClock:
    """Stamps by sample number: ``epoch_ns + round(k · 1e9 / rate)``, in exact arithmetic.

    Parameters
    ----------
    epoch_ns : int
        Stamp of sample 0, ns.
    rate : float
        Samples per second, taken as its shortest decimal.
    """

    epoch_ns: int
    rate: float

    @cached_property
    def period_ns(self) -> Fraction:
        """Time between samples, ns, exactly: a stamp costs less than reading the rate's decimals again."""
        return 1_000_000_000 / Fraction(repr(self.rate))

    def stamps_ns(self, first: int, count: int) -> NDArray[np.int64]:
        """The stamps of ``count`` samples from number ``first``.

        Returns
        -------
        ndarray of int64, shape (count,)
        """
        n, d, epoch = self.period_ns.numerator, self.period_ns.denominator, self.epoch_ns
        stamps = (
            [epoch + k * n for k in range(first, first + count)]
            if d == 1
            else [epoch + _round_ratio(k * n, d) for k in range(first, first + count)]
        )
        if stamps and stamps[-1] > MAX_EPOCH_NS:
            raise ParameterError(
                "epoch_ns",
                f"sample {first + count - 1} would be stamped {stamps[-1]} ns, beyond {MAX_EPOCH_NS}, the last "
                "second of builtin_interfaces/Time: start earlier or sample for a shorter time",
            )
        return np.array(stamps, dtype=np.int64)

    def count_before(self, duration: Fraction) -> int:
        """How many samples lie before a time after the epoch: every k with k / rate < duration (s)."""
        return -int(-(duration * Fraction(repr(self.rate))) // 1)


def _round_ratio(n: int, d: int) -> int:
    """n/d rounded to the nearest integer, ties to even; d positive."""
    quotient, remainder = divmod(2 * n + d, 2 * d)
    return quotient - 1 if remainder == 0 and quotient % 2 else quotient


@dataclass(frozen=True)
class Segment:
    """A stretch of torque-free motion between two resets, and what a bag says of it.

    Parameters
    ----------
    scenario : Scenario
        With the epoch in force.
    first_sample : int
        Number of the sample that carries the initial state.
    start_ns : int
        Its stamp, ns.
    """

    scenario: Scenario
    first_sample: int
    start_ns: int

    def to_json(self) -> str:
        """The text of the latched scenario message: all parameters, ``first_sample`` and ``start_ns``."""
        from lie_rigid_body import __version__

        content = {
            "software": f"{SOFTWARE} {__version__}",
            **self.scenario.parameters(),
            "first_sample": self.first_sample,
            "start_ns": self.start_ns,
        }
        return json.dumps(content)

    @classmethod
    def from_json(cls, text: str) -> Segment:
        """The segment that a scenario message declares.

        Raises
        ------
        InputError
            If the text is not such a message.
        """
        try:
            content = json.loads(text)
            first, start = content.pop("first_sample"), content.pop("start_ns")
            content.pop("software", None)
        except (ValueError, KeyError, AttributeError, TypeError) as error:
            raise InputError(f"the scenario message is not the JSON that lie_rigid_body writes: {error!r}") from None
        for name, value in (("first_sample", first), ("start_ns", start)):
            if isinstance(value, bool) or not isinstance(value, int) or value < 0:
                raise InputError(f"the scenario message gives {name} {value!r}: it must be an integer of at least 0")
        return cls(Scenario.from_parameters(content), first, start)

    def clock(self) -> SampleClock:
        """The clock of the segment's stamps."""
        return SampleClock(self.scenario.epoch_ns, self.scenario.rate)


@dataclass(frozen=True)
class Samples:
    """States and their stamps.

    Parameters
    ----------
    stamps_ns : ndarray of int64, shape (N,)
    states : State
        Of shapes (N, 4) and (N, 3).
    """

    stamps_ns: NDArray[np.int64]
    states: State

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, index: slice) -> Samples:
        return Samples(self.stamps_ns[index], self.states[index])


LOOK_AHEAD: Final = 64
"""Samples of the closed form computed at once when fewer are wanted: one costs almost as much as all of them."""


class Simulation:
    """Samples one after the other, across torque-free resets, on one rising sequence of stamps.

    Parameters
    ----------
    scenario : Scenario
    epoch_ns : int, optional
        Stamp of sample 0, in place of the scenario's, ns.
    """

    def __init__(self, scenario: Scenario, epoch_ns: int | None = None) -> None:
        epoch = scenario.epoch_ns if epoch_ns is None else epoch_ns
        self._begin(replace(scenario, epoch_ns=epoch), 0)

    def _begin(self, scenario: Scenario, first: int) -> None:
        self._clock = SampleClock(scenario.epoch_ns, scenario.rate)
        self._next = first
        self._motion = scenario.make_motion()
        start = int(self._clock.stamps_ns(first, 1)[0])
        self._segment = Segment(scenario, first, start)
        self._look_ahead = LOOK_AHEAD if scenario.motion == "closed_form" else 0
        self._ready = self._samples(0)

    @property
    def segment(self) -> Segment:
        """The present segment."""
        return self._segment

    @property
    def next_sample(self) -> int:
        """Number of the sample that comes next."""
        return self._next

    @property
    def clock(self) -> SampleClock:
        """The clock of the present segment's stamps."""
        return self._clock

    def take(self, count: int) -> Samples:
        """The next ``count`` samples."""
        if count > len(self._ready):
            self._ready = self._ahead(count)
        taken, self._ready = self._ready[:count], self._ready[count:]
        self._next += count
        return taken

    def _ahead(self, count: int) -> Samples:
        """At least the next ``count`` samples."""
        if count < self._look_ahead:
            try:
                return self._samples(self._look_ahead)
            except ParameterError:
                pass  # the stamps end before that, though perhaps not before the samples that are wanted
        return self._samples(count)

    def _samples(self, count: int) -> Samples:
        stamps = self._clock.stamps_ns(self._next, count)
        return Samples(stamps, self._motion.at(stamps - self._segment.start_ns))

    def reset(self, scenario: Scenario) -> Segment:
        """Begin a new segment with the next sample, which carries the initial state of ``scenario``.

        Stamps go on rising: the epoch stays, unless the rate changes; then the next stamp becomes the new epoch.

        Returns
        -------
        Segment
            The new one.
        """
        present = self._segment.scenario
        if scenario.rate == present.rate:
            self._begin(replace(scenario, epoch_ns=present.epoch_ns), self._next)
        else:
            epoch = int(self._clock.stamps_ns(self._next, 1)[0])
            self._begin(replace(scenario, epoch_ns=epoch), 0)
        return self._segment
