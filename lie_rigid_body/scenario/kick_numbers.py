"""Kicks at random, as a hand or a playing child gives them: numbers for the parameter ``kicks``."""

from __future__ import annotations

from typing import Final

import numpy as np

from lie_rigid_body.arithmetic.elementary import sine_cosine
from lie_rigid_body.foundation.arrays import plain
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import Parameter, exact_duration, read_table
from lie_rigid_body.motion.kicks import MAX_KICKS
from lie_rigid_body.sensors.noise import Draws, NoiseSource
from lie_rigid_body.sensors.parameters import seed as seed_parameter

_ARGUMENTS: Final = (
    Parameter("interval", "double", 2.0, "Mean time from one kick to the next, s.", minimum=1e-6, maximum=1e9),
    Parameter("rate", "double", 1.5, "Largest body rate after a kick, rad/s.", minimum=0.0),
    Parameter("rest_probability", "double", 0.3, "Share of the kicks after which it rests.", minimum=0.0, maximum=1.0),
    seed_parameter("seed", "Seed of all that is drawn."),
)


def random_kicks(
    duration: float, interval: float = 2.0, rate: float = 1.5, rest_probability: float = 0.3, seed: int = 0
) -> list[float]:
    """Draw kicks: numbers for the parameter ``kicks``, the same for the same arguments on every machine.

    Those of a longer duration begin with those of a shorter one.

    Parameters
    ----------
    duration : float
        Time before which all kicks come, s.
    interval : float, optional
        Mean time from one kick to the next, s: each is uniform between 0.5 and 1.5 of it.
    rate : float, optional
        Largest body rate after a kick, rad/s: its size is uniform between 0.3 and 1 of it, its direction in the body
        is uniform on the sphere.
    rest_probability : float, optional
        Share of the kicks after which the body rests.
    seed : int, optional

    Returns
    -------
    list of float
        Four numbers a kick: its time, s, and the body rate right after it, rad/s.

    Raises
    ------
    InputError
        If an argument is out of its range, or there would be more than 1000 kicks.
    """
    length = float(exact_duration(plain(duration), "duration", "duration=60.0"))
    given = {"interval": interval, "rate": rate, "rest_probability": rest_probability, "seed": seed}
    values = read_table(_ARGUMENTS, {name: plain(value) for name, value in given.items()})
    draws = Draws((seed), NoiseSource.KICKS, width=5).following(0, MAX_KICKS + 1)
    times = interval * np.cumsum(0.5 + draws[:, 0])
    count = np.searchsorted(times, length)
    if count > MAX_KICKS:
        raise InputError(
            f"duration {length:g} s has more than {MAX_KICKS} kicks with an interval of {values['interval']:g} s: give "
            "a longer interval, or a shorter duration and kick_period"
        )
    _, chance, height, turns, share = draws[:count].T
    z = 2.0 * height - 1.0  # uniform on the sphere, by Archimedes
    across = np.sqrt(1.0 - z * z)
    sine, cosine = sine_cosine((turns - np.rint(turns), np.zeros(count)))
    rates = rate * (0.3 + 0.7 * share) * np.stack([across * cosine, across * sine, z])
    numbers = np.stack([times[:count], *np.where(chance < rest_probability, 0.0, rates)], axis=-1)
    return [*numbers.ravel().tolist()]
