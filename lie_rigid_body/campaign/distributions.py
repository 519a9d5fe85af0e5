"""Distributions of parameters. What is drawn depends on the campaign's seed, the run and the parameter's name alone.

A generator Philox 4×64 with 10 rounds, under a key made of these three, gives raw words, which are the same in every
version of NumPy. Each becomes one uniform number between 0 and 1, and every distribution is made of such numbers.
"""

from __future__ import annotations

import hashlib
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Final, TypeAlias

import numpy as np

from lie_rigid_body.foundation.arrays import as_double
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import shown, suggestion
from lie_rigid_body.scenario import random_kicks
from lie_rigid_body.sensors.noise import uniform


class Uniforms:
    """A sequence of independent numbers, uniform between 0 and 1, that belongs to one parameter of one run.

    Parameters
    ----------
    seed : int
        The seed of the campaign.
    run : int
        The number of the run.
    name : str
        The name of the parameter.
    duration : float, optional
        The length of the run, s.
    """

    def __init__(self, seed: int, run: int, name: str, duration: float = 0.0) -> None:
        digest = hashlib.sha256(f"{seed} {run} {name}".encode()).digest()
        self._words = np.random.Philox(key=np.frombuffer(digest[:16], dtype="<u8"))
        self.run = run
        self.duration = duration

    def next(self) -> float:
        """The next number, neither 0 nor 1."""
        return float(uniform(self._words.random_raw(1))[0])


Draw: TypeAlias = Callable[[Uniforms], Any]
"""A function that draws a value."""


def distribution(what: str, given: object) -> Draw:
    """The distribution that a campaign file names.

    Parameters
    ----------
    what : str
        Place of the distribution in the file, for messages.
    given : object
        A mapping with the key ``distribution``, and those of that distribution.

    Returns
    -------
    callable
        Function that draws a value: a number, a word, or a list of numbers.

    Raises
    ------
    InputError
        If there is no such distribution, or its numbers make none.
    """
    if not isinstance(given, Mapping) or not isinstance(given.get("distribution"), str):
        raise InputError(f"{what} is not a distribution: give for example {{distribution: uniform, low: 0, high: 1}}")
    name = given["distribution"]
    if name not in DISTRIBUTIONS:
        raise InputError(
            f"{what}: there is no distribution {shown(name)}: {suggestion(name, DISTRIBUTIONS, 'distributions')}"
        )
    draw, *checks = DISTRIBUTIONS[name]
    values = {key: value for key, value in given.items() if key != "distribution"}
    _require_keys(f"{what}: {name}", draw, values)
    read = {key: _READERS[key](f"{what}.{key}", value) for key, value in values.items()}
    for require in checks:
        require(what, **read)
    return partial(draw, **read)


def _require_keys(what: str, draw: Callable[..., Any], values: Mapping[Any, object]) -> None:
    """Refuse keys that a function that draws does not take, or lacks."""
    signature = inspect.signature(draw)
    keys = [*signature.parameters][1:]
    try:
        signature.bind(None, **values)
    except TypeError as error:
        raise InputError(f"{what}: {error}: it takes {', '.join(keys) or 'nothing more'}") from None
    if "mass" in keys and ("mass" in values) == ("density" in values):
        raise InputError(f"{what} has a mass or a density: give one of them")


def _number(what: str, value: object) -> float:
    number = as_double(value)
    if not math.isfinite(number):
        raise InputError(f"{what}: {shown(value)} is not a finite number: give one")
    return number


def _values(what: str, value: object) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise InputError(f"{what} is to be a list of at least one: give for example values: [1.0, 2.0]")
    return value


def _edges(what: str, value: object) -> list[Draw]:
    if not isinstance(value, list) or len(value) != 3:
        raise InputError(f"{what} is to be a list of three lengths or ranges, m: give [[0.1, 0.3], 0.2, 0.4]")
    return [_size(what, edge) for edge in value]


def _scalar(what: str, value: object) -> Draw:
    """A number, a range [low, high] or a distribution."""
    if isinstance(value, Mapping):
        if (name := value.get("distribution")) in _OF_SEVERAL:
            raise InputError(f"{what}: {name} draws several numbers: give a distribution of one")
        return distribution(what, value)
    if isinstance(value, Sequence) and not isinstance(value, str):
        if len(value) != 2:
            raise InputError(f"{what}: {len(value)} numbers are no range: give [low, high]")
        return distribution(what, {"distribution": "uniform", "low": value[0], "high": value[1]})
    number = _number(what, value)
    return partial(_constant, number)


def _constant(number: float, u: Uniforms) -> float:
    return number


def _size(what: str, value: object, *, or_zero: bool = False) -> Draw:
    """A number, a range [low, high] or a distribution, of a quantity above 0."""
    return partial(_sized, what, _scalar(what, value), or_zero)


def _sized(what: str, draw: Draw, or_zero: bool, u: Uniforms) -> float:
    """Draw a number, and refuse one that is not above 0."""
    drawn = draw(u)
    number = as_double(drawn)
    if not (0.0 < number < math.inf or (or_zero and number == 0.0)):
        limit = "of at least 0" if or_zero else "above 0"
        raise InputError(
            f"{what}: {shown(drawn)} was drawn in run {u.run} and is not a finite number {limit}: draw from others only"
        )
    return number


def _require_range(what: str, low: float, high: float) -> None:
    if low > high:
        raise InputError(f"{what}: low {low:g} is above high {high:g}: exchange them")
    if not math.isfinite(high - low):
        raise InputError(f"{what}: from {low:g} to {high:g} is beyond double precision: bring them nearer")


def _require_logarithm(what: str, low: float, high: float) -> None:
    if low <= 0.0:
        raise InputError(f"{what}: low {low:g} has no logarithm: give a number above 0")


def _require_deviation(what: str, mean: float, std: float) -> None:
    if std < 0.0:
        raise InputError(f"{what}: std {std:g} is below 0: give a standard deviation")


def _require_kicks(what: str, **given: Any) -> None:
    try:
        random_kicks(1e-9, **given)  # before which none comes
    except InputError as error:
        raise InputError(f"{what}: {error}") from None


def _uniform(u: Uniforms, low: float, high: float) -> float:
    return low + (high - low) * u.next()


def _loguniform(u: Uniforms, low: float, high: float) -> float:
    share = u.next()
    if math.isfinite(high / low):
        return min(max(low * float((high / low) ** share), low), high)
    return min(max(math.exp(math.log(low) + share * (math.log(high) - math.log(low))), low), high)


def _normal(u: Uniforms, mean: float, std: float) -> float:
    from scipy.special import ndtri

    return float(mean + std * ndtri(u.next()))


def _choice(u: Uniforms, values: Sequence[Any]) -> Any:
    return values[int(u.next() * len(values))]


def _rotation(u: Uniforms) -> list[float]:
    """A uniformly distributed rotation: K. Shoemake, "Uniform random rotations", Graphics Gems III (1992) 124."""
    share = u.next()
    first = 2.0 * math.pi * u.next()
    second = 2.0 * math.pi * u.next()
    a = math.sqrt(1.0 - share)
    b = math.sqrt(share)
    return [a * math.sin(first), a * math.cos(first), b * math.sin(second), b * math.cos(second)]


def _direction(u: Uniforms, norm: Draw) -> list[float]:
    """A vector whose direction is uniform on the sphere: its z is uniform, by Archimedes."""
    z = 2.0 * u.next() - 1.0
    angle = 2.0 * math.pi * u.next()
    radius = math.sqrt(1.0 - z * z)
    length = norm(u)
    return [length * radius * math.cos(angle), length * radius * math.sin(angle), length * z]


def _run(u: Uniforms) -> int:
    return u.run


def _box(u: Uniforms, edges: Sequence[Draw], mass: Draw | None = None, density: Draw | None = None) -> list[float]:
    """Moments m (b² + c²)/12, m (a² + c²)/12, m (a² + b²)/12 of a homogeneous box with edges a, b, c along x, y, z."""
    a, b, c = (edge(u) for edge in edges)
    m = _mass(u, a * b * c, mass, density)
    return [m * (y * y + z * z) / 12.0 for y, z in ((b, c), (a, c), (a, b))]


def _cylinder(
    u: Uniforms, radius: Draw, height: Draw, mass: Draw | None = None, density: Draw | None = None
) -> list[float]:
    """Moments m (3r² + h²)/12 across and m r²/2 about the axis of a homogeneous cylinder, which is the body's z."""
    r = radius(u)
    h = height(u)
    m = _mass(u, math.pi * r * r * h, mass, density)
    across = m * (3.0 * r * r + h * h) / 12.0
    return [across, across, m * r * r / 2.0]


def _random_kicks(u: Uniforms, interval: float = 2.0, rate: float = 1.5, rest_probability: float = 0.3) -> list[float]:
    """Kicks all along the run, of a seed that is drawn."""
    return random_kicks(u.duration, interval, rate, rest_probability, int(u.next() * 2.0**52))


def _mass(u: Uniforms, volume: float, mass: Draw | None, density: Draw | None) -> float:
    """Mass, kg, of a volume, m³: as given, or from a density, kg/m³."""
    return float(mass(u)) if mass else float(density(u)) * volume if density else math.nan


_OF_SEVERAL: Final = ("uniform_rotation", "direction", "box", "cylinder", "random_kicks")
"""Distributions that draw several numbers at once."""
_READERS: Final[Mapping[str, Callable[[str, object], Any]]] = {
    **dict.fromkeys(("low", "high", "mean", "std", "interval", "rate", "rest_probability"), _number),
    **dict.fromkeys(("mass", "density", "radius", "height"), _size),
    "values": _values,
    "norm": partial(_size, or_zero=True),
    "edges": _edges,
}
"""Readers of the keys of distributions."""
DISTRIBUTIONS: Final[Mapping[str, tuple[Callable[..., Any], ...]]] = {
    "uniform": (_uniform, _require_range),
    "loguniform": (_loguniform, _require_range, _require_logarithm),
    "normal": (_normal, _require_deviation),
    "choice": (_choice,),
    "uniform_rotation": (_rotation,),
    "direction": (_direction,),
    "box": (_box,),
    "cylinder": (_cylinder,),
    "run": (_run,),
    "random_kicks": (_random_kicks, _require_kicks),
}
"""Distributions by name: the function that draws, and the checks of what it is given."""
