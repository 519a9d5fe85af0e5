"""Distributions of parameters. What is drawn depends on the campaign's seed, the run and the parameter's name alone.

A generator Philox 4×64 with 10 rounds, under a key made of these three, gives raw words, which are the same in every
version of NumPy. Each becomes one uniform number between 0 and 1, and every distribution is made of such numbers.
"""

from __future__ import annotations

import hashlib
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, TypeAlias, TypeGuard

import numpy as np

from lie_rigid_body.errors import InputError
from lie_rigid_body.sensors.noise import uniform
from lie_rigid_body.wording import shortened, shown, suggestion


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
    """

    def __init__(self, seed: int, run: int, name: str) -> None:
        digest = hashlib.sha256(f"{seed} {run} {name}".encode()).digest()
        self._words = np.random.Philox(key=np.frombuffer(digest[:16], dtype="<u8"))
        self.run = run

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
        Where it stands in the file, for messages.
    given : object
        A mapping with the key ``distribution``, and those of that distribution.

    Returns
    -------
    callable
        It draws a value: a number, a word, or a list of numbers.

    Raises
    ------
    InputError
        If there is no such distribution, or its numbers make none.
    """
    if not isinstance(given, Mapping) or not isinstance(given.get("distribution"), str):
        raise InputError(f"{what} is not a distribution: give for example {{distribution: uniform, low: 0, high: 1}}")
    name = given["distribution"]
    if name not in DISTRIBUTIONS:
        hint = suggestion(name, DISTRIBUTIONS, "distributions")
        raise InputError(f"{what}: there is no distribution {shown(name)}: {hint}")
    required, make = DISTRIBUTIONS[name]
    values = {key: value for key, value in given.items() if key != "distribution"}
    allowed = [(key,) if isinstance(key, str) else key for key in required]
    if wrong := _wrong_keys(set(values), allowed):
        keys = ", ".join(map(" or ".join, allowed)) or "nothing more"
        raise InputError(f"{what}: {name} takes {keys}, and {wrong}")
    return make(what, values)


def _wrong_keys(given: set[Any], allowed: Sequence[tuple[str, ...]]) -> str:
    """The first mistake in the keys of a distribution, and the remedy; empty if one of each alternative is given."""
    if unknown := sorted(map(str, given.difference(*allowed))):
        return f"{shortened(unknown[0], 40)} is none of that: leave it out"
    for keys in allowed:
        found = [key for key in keys if key in given]
        if not found:
            return f"{' or '.join(keys)} is missing: add it"
        if len(found) > 1:
            return f"{' and '.join(found)} are given: leave one out"
    return ""


def _is_finite(value: object) -> TypeGuard[int | float]:
    """Whether a value is a number that a double can hold."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= sys.float_info.max


def _number(what: str, value: object) -> float:
    if not _is_finite(value):
        raise InputError(f"{what}: {shown(value)} is not a finite number: give one")
    return float(value)


def _range(what: str, low: object, high: object) -> tuple[float, float]:
    first, last = _number(f"{what}.low", low), _number(f"{what}.high", high)
    if first > last:
        raise InputError(f"{what}: low {first:g} is above high {last:g}: exchange them")
    if not math.isfinite(last - first):
        raise InputError(f"{what}: from {first:g} to {last:g} is beyond double precision: bring them nearer")
    return first, last


def _above_0(what: str, value: object) -> Draw:
    """A number, a range [low, high] or a distribution, of a quantity that has to be above 0."""
    return _limited(what, value, lambda drawn: drawn > 0.0, "above 0")


def _limited(what: str, value: object, allows: Callable[[float], bool], limit: str) -> Draw:
    """A number, a range [low, high] or a distribution, of a quantity with a limit, which each draw has to keep."""
    draw = _scalar(what, value)

    def limited(u: Uniforms) -> float:
        drawn = draw(u)
        if not (_is_finite(drawn) and allows(drawn)):
            raise InputError(
                f"{what}: {shown(drawn)} was drawn in run {u.run} and is not a finite number {limit}: "
                "draw from others only"
            )
        return float(drawn)

    return limited


def _scalar(what: str, value: object) -> Draw:
    """A number, a range [low, high] or a distribution."""
    if isinstance(value, Mapping):
        return distribution(what, value)
    if isinstance(value, Sequence) and not isinstance(value, str):
        if len(value) != 2:
            raise InputError(f"{what}: {len(value)} numbers are no range: give [low, high]")
        return _uniform(what, {"low": value[0], "high": value[1]})
    number = _number(what, value)
    return lambda u: number


def _uniform(what: str, given: Mapping[str, object]) -> Draw:
    low, high = _range(what, given["low"], given["high"])
    return lambda u: low + (high - low) * u.next()


def _loguniform(what: str, given: Mapping[str, object]) -> Draw:
    low, high = _range(what, given["low"], given["high"])
    if low <= 0.0:
        raise InputError(f"{what}: low {low:g} has no logarithm: give a number above 0")
    if not math.isfinite(high / low):
        first, last = math.log(low), math.log(high)
        return lambda u: min(max(math.exp(first + u.next() * (last - first)), low), high)
    return lambda u: min(max(low * (high / low) ** u.next(), low), high)


def _normal(what: str, given: Mapping[str, object]) -> Draw:
    mean, deviation = _number(f"{what}.mean", given["mean"]), _number(f"{what}.std", given["std"])
    if deviation < 0.0:
        raise InputError(f"{what}: std {deviation:g} is below 0: give a standard deviation")

    def normal(u: Uniforms) -> float:
        from scipy.special import ndtri

        return mean + deviation * float(ndtri(u.next()))

    return normal


def _choice(what: str, given: Mapping[str, object]) -> Draw:
    values = given["values"]
    if not isinstance(values, list) or not values:
        raise InputError(f"{what}: values is to be a list of at least one: give for example values: [1.0, 2.0]")
    return lambda u: values[int(u.next() * len(values))]


def _rotation(u: Uniforms) -> list[float]:
    """A uniformly distributed rotation: K. Shoemake, "Uniform random rotations", Graphics Gems III (1992) 124."""
    share, first, second = u.next(), 2.0 * math.pi * u.next(), 2.0 * math.pi * u.next()
    a, b = math.sqrt(1.0 - share), math.sqrt(share)
    return [a * math.sin(first), a * math.cos(first), b * math.sin(second), b * math.cos(second)]


def _direction(what: str, given: Mapping[str, object]) -> Draw:
    """A vector whose direction is uniform on the sphere: its z is uniform, by Archimedes."""
    norm = _limited(f"{what}.norm", given["norm"], lambda drawn: drawn >= 0.0, "of at least 0")

    def vector(u: Uniforms) -> list[float]:
        z, angle = 2.0 * u.next() - 1.0, 2.0 * math.pi * u.next()
        radius, length = math.sqrt(1.0 - z * z), norm(u)
        return [length * radius * math.cos(angle), length * radius * math.sin(angle), length * z]

    return vector


def _box(what: str, given: Mapping[str, Any]) -> Draw:
    """Moments m (b² + c²)/12, m (a² + c²)/12, m (a² + b²)/12 of a homogeneous box with edges a, b, c along x, y, z."""
    edges = given["edges"]
    if not isinstance(edges, list) or len(edges) != 3:
        raise InputError(f"{what}: edges is to be a list of three lengths or ranges, m: give [[0.1, 0.3], 0.2, 0.4]")
    lengths = [_above_0(f"{what}.edges", edge) for edge in edges]
    heavy = _mass(what, given)

    def moments(u: Uniforms) -> list[float]:
        a, b, c = (length(u) for length in lengths)
        mass = heavy(u, a * b * c)
        return [mass * (y * y + z * z) / 12.0 for y, z in ((b, c), (a, c), (a, b))]

    return moments


def _cylinder(what: str, given: Mapping[str, Any]) -> Draw:
    """Moments m (3r² + h²)/12 across and m r²/2 about the axis of a homogeneous cylinder, which is the body's z."""
    radius, height = (_above_0(f"{what}.{name}", given[name]) for name in ("radius", "height"))
    heavy = _mass(what, given)

    def moments(u: Uniforms) -> list[float]:
        r, h = radius(u), height(u)
        mass = heavy(u, math.pi * r * r * h)
        across = mass * (3.0 * r * r + h * h) / 12.0
        return [across, across, mass * r * r / 2.0]

    return moments


def _mass(what: str, given: Mapping[str, object]) -> Callable[[Uniforms, float], float]:
    """The mass, kg, of a volume, m³: as given, or from a density, kg/m³."""
    if "mass" in given:
        mass = _above_0(f"{what}.mass", given["mass"])
        return lambda u, volume: mass(u)
    density = _above_0(f"{what}.density", given["density"])
    return lambda u, volume: density(u) * volume


_MASS: Final = ("density", "mass")
DISTRIBUTIONS: Final[Mapping[str, tuple[tuple[str | tuple[str, ...], ...], Callable[..., Draw]]]] = {
    "uniform": (("low", "high"), _uniform),
    "loguniform": (("low", "high"), _loguniform),
    "normal": (("mean", "std"), _normal),
    "choice": (("values",), _choice),
    "uniform_rotation": ((), lambda what, given: _rotation),
    "direction": (("norm",), _direction),
    "box": ((_MASS, "edges"), _box),
    "cylinder": ((_MASS, "radius", "height"), _cylinder),
    "run": ((), lambda what, given: lambda u: u.run),
}
"""Distributions by name: the keys that each takes, alternatives together, and the maker of the function that draws."""
