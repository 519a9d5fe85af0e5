"""The moving chart itself: steps taken in a chart that is re-centred after each, on whatever group the chart is of."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final, Generic, NoReturn, Protocol, TypeVar

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups.stepper import Point, RungeKuttaStepper
from lie_rigid_body.motion.munthe_kaas.integrator import GOOD_TURN

Centre = TypeVar("Centre")

STEPS_BETWEEN_RESTORATIONS: Final = 100
"""Products of elements leave the group by round-off alone, slowly; the nearest element may cost many products."""


class Chart(Protocol[Centre]):
    """A chart A₀ exp(βᵃTᵃ) of a group about a centre A₀, with the momentum carried along.

    A point is a list of the coordinates β, followed by the body momentum p.
    """

    @property
    def dimension(self) -> int:
        """How many coordinates there are."""
        ...

    def field(self, point: Point) -> Point:
        """The rates of coordinates and momentum at a point."""
        ...

    def recentred(self, centre: Centre, coordinates: Point) -> Centre:
        """The group element at these coordinates, as the next centre."""
        ...

    def restored(self, centre: Centre) -> Centre:
        """The group element nearest to a centre that round-off has carried away."""
        ...


class ChartIntegrator(Generic[Centre]):
    """A motion that has come to some time.

    Parameters
    ----------
    stepper : RungeKuttaStepper
    chart : Chart
    centre : group element
        Where the motion starts.
    momentum : list of float
        Body momentum at the start.
    max_step : float
        Largest step, s. Between two requested times the steps are equal and no longer than this.
    reach : float, optional
        Largest norm of the coordinates that a step may come to; a longer step is refused.
    """

    def __init__(
        self,
        stepper: RungeKuttaStepper,
        chart: Chart[Centre],
        centre: Centre,
        momentum: Point,
        max_step: float,
        reach: float = math.inf,
    ) -> None:
        self._stepper = stepper
        self._reach = reach
        self._chart = chart
        self._max_step = float(max_step)
        self._time_ns = 0
        self._origin = [0.0] * chart.dimension
        self._centre = centre
        self._momentum = momentum
        self._steps = 0

    def through(self, times_ns: Sequence[int]) -> Iterator[tuple[Centre, Point]]:
        """The group element and the body momentum at each of the times, which may not decrease.

        Raises
        ------
        InputError
            If a time lies before one already reached; nothing is integrated then. Also where a step is too long.
        """
        self._require_forward(times_ns)
        for t in times_ns:
            self._advance_to(t)
            yield self._centre, self._momentum

    def _require_forward(self, times_ns: Sequence[int]) -> None:
        previous = self._time_ns
        for t in times_ns:
            if t < previous:
                raise InputError(
                    f"t_ns {t} lies before {previous}, which is already reached: give times that do not decrease, "
                    "or start a new motion"
                )
            previous = t

    def _advance_to(self, t_ns: int) -> None:
        span = 1e-9 * (t_ns - self._time_ns)
        steps = max(math.ceil(span / self._max_step - 1e-9), int(span > 0.0))
        for _ in range(steps):
            self._step(span / steps)
        self._time_ns = t_ns

    def _end(self, h: float) -> Point:
        """The end of a step, infinite where a stage overflows on the way."""
        try:
            return self._stepper.step(self._chart.field, [*self._origin, *self._momentum], h)
        except InputError:
            raise
        except (ArithmeticError, ValueError):
            return [math.inf] * (2 * self._chart.dimension)

    def _refuse(self, h: float) -> NoReturn:
        # at the centre of the chart its coordinates have the rate of the motion itself
        way = h * math.hypot(*self._chart.field([*self._origin, *self._momentum])[: self._chart.dimension])
        limit = f"limit {self._reach:.3g} rad" if math.isfinite(self._reach) else "limit: where its end is finite"
        raise InputError(
            f"a step of {h:g} s goes {way:.3g} rad at the rate of its start, or more ({limit}): lower max_step, to "
            f"about {self._advised(h, way):.1g} s"
        )

    @staticmethod
    def _advised(h: float, way: float) -> float:
        return min(h / 10.0, GOOD_TURN * h / way) if way else h / 10.0

    def _step(self, h: float) -> None:
        d, end = self._chart.dimension, self._end(h)
        if not (math.isfinite(sum(end)) and math.hypot(*end[:d]) <= self._reach):
            self._refuse(h)
        # the chart moves on: its centre is the element just reached
        self._centre, self._momentum = self._chart.recentred(self._centre, end[:d]), end[d:]
        self._steps += 1
        if self._steps % STEPS_BETWEEN_RESTORATIONS == 0:
            self._centre = self._chart.restored(self._centre)
