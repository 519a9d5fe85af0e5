"""How much goes out before anyone else is heard."""

from __future__ import annotations

import math
from typing import Final

from lie_rigid_body.scenario import Scenario

LARGEST_BURST: Final = 250
"""Samples of a kind that go out before anyone else is heard. Subscribers keep as many and more, see `publisher`."""
STEPS_PER_BURST: Final = 2000
"""Steps of the moving chart, about 20 ms of computing, before anyone else is heard."""


def fastest_rate(scenario: Scenario) -> float:
    """Samples per second of what has the most."""
    sensors = (scenario.sensors.imu, scenario.sensors.magnetometer)
    return max(scenario.rate, *(sensor.rate for sensor in sensors if sensor is not None), 0.0)


def largest_burst(scenario: Scenario) -> int:
    """How many samples to take at once: few when each costs many steps, so that others are heard in between."""
    if scenario.motion == "closed_form":
        return LARGEST_BURST
    return max(1, min(LARGEST_BURST, STEPS_PER_BURST // steps_per_sample(scenario)))


def steps_per_sample(scenario: Scenario) -> int:
    """Steps from one sample to the next; of the closed form 1."""
    return 1 if scenario.motion == "closed_form" else math.ceil(1.0 / (scenario.rate * scenario.max_step))
