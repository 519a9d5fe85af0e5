"""The explanation of a motion: its description as text for people and as JSON for programs."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from typing import Final, NamedTuple

from lie_rigid_body.mechanics.top import SpinStability, SymmetricTop
from lie_rigid_body.motion.description import Circulation, Description, FixedAxisRotation, Flips
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import GRADE, SENSORS

Row = tuple[str, str]

_WIDTH: Final = 98
"""Characters of a line of sentences."""

_KINDS: Final = {
    "asymmetric": "An asymmetric top: its three principal moments differ.",
    "oblate": "An oblate symmetric top, like a disc: its two smaller moments are equal.",
    "prolate": "A prolate symmetric top, like a rod: its two larger moments are equal.",
    "spherical": "A spherical top: its three moments are equal, and every axis is a principal one.",
}
_FLAT: Final = "It is flat: the largest moment is the sum of the others, as if all mass lay in one plane."
_AXIS_NAMES: Final = {
    "asymmetric": ("smallest", "intermediate", "largest"),
    "oblate": ("equal", "equal", "axis of symmetry"),
    "prolate": ("axis of symmetry", "equal", "equal"),
    "spherical": ("equal", "equal", "equal"),
}
"""The principal axes in words, in ascending order of their moments."""
_SEPARATRIX: Final = (
    "Exactly on the separatrix, between circling axis 1 and circling axis 3: the body rate tends to axis 2 "
    "(intermediate) and never returns. The least disturbance makes it a periodic motion."
)
_STEADY: Final = {
    "stable": "It is stable: a small disturbance stays small.",
    "unstable": "It is unstable: the least disturbance grows until the body turns over, again and again.",
    "neutral": "It is neutral: a small disturbance makes another motion, which drifts away steadily if at all.",
}
_MOMENTUM: Final = "kg m²/s"
_TIME: Final = "No torque does work on the body: the Lagrangian does not depend on time."
_SPACE: Final = (
    "Space has no preferred direction: a motion turned as a whole, about any fixed axis, is again a motion. "
    "Seen from the body the momentum moves, but keeps its size."
)
_SPHERE: Final = "The inertia is the same about every axis, so turning the body within itself changes nothing."
_AXIS: Final = "The inertia stays as it is when the body is turned within itself about this axis."
_NO_AXIS: Final = (
    "No symmetry conserves a component of the momentum in the body: about every axis, turning the body within itself "
    "changes the inertia."
)


def as_text(scenario: Scenario, description: Description, title: str = "") -> str:
    """The description in lines for a terminal.

    Parameters
    ----------
    scenario : Scenario
    description : Description
        Of its motion.
    title : str, optional
        The first line.

    Returns
    -------
    str
        Without a final newline.
    """
    spins = "1 rad/s" if description.regime == "rest" else "this angular momentum"
    sections = {
        "Body, with its principal axes in the body frame": _body_lines(description),
        "Motion": _motion_lines(description),
        f"Spinning about each principal axis with {spins}": _columns(_spin_rows(description)),
        "Conserved": _conservation_lines(description),
    }
    if scenario.has_sensors:
        sections[f"Sensors, of the grade {scenario.sensor_grade}"] = _columns(_sensor_rows(scenario))
    lines = [title] if title else []
    lines.append(
        f"inertia {_vector(scenario.inertia)} kg m², initial body rate {_vector(scenario.initial_body_rate)} rad/s"
    )
    for heading, content in sections.items():
        lines += ["", heading, *(f"  {line}" for line in content)]
    return "\n".join(lines)


def as_json(scenario: Scenario, description: Description) -> dict[str, object]:
    """The description as JSON-serialisable data; a number that is not finite becomes null."""
    facts: dict[str, object] = asdict(description)
    facts["conserved"] = [fact._asdict() for fact in _conserved(description)]
    return {"parameters": scenario.parameters(), **{name: _plain(fact) for name, fact in facts.items()}}


def _plain(value: object) -> object:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: _plain(content) for name, content in value.items()}
    return [_plain(content) for content in value] if isinstance(value, tuple | list) else value


def _body_lines(description: Description) -> Iterator[str]:
    yield _KINDS[description.kind]
    if description.flat:
        yield _FLAT
    yield from _columns(
        (_axis_name(description.kind, i), f"{_number(axis.moment_kg_m2)} kg m²", f"along {_vector(axis.direction)}")
        for i, axis in enumerate(description.axes)
    )


def _motion_lines(description: Description) -> Iterator[str]:
    yield from _wrapped(_regime_sentences(description))
    yield from _columns(_motion_rows(description))


def _regime_sentences(description: Description) -> str:
    """The regime of the motion, in sentences."""
    if description.steady is not None:
        return _steady_sentences(description, description.steady)
    if description.regime == "rest":
        return "The body is at rest, and stays so in any attitude."
    if description.regime == "separatrix":
        return _SEPARATRIX
    axis = _axis_name(description.kind, _circled(description))
    path = "on a circle, at a constant rate" if "symmetry" in axis else "on a closed curve"
    return f"In the body, the body rate and the momentum circle {axis}, {path}."


def _circled(description: Description) -> int:
    return 0 if description.regime == "about_smallest" else 2


def _steady_sentences(description: Description, steady: FixedAxisRotation) -> str:
    first, *others = steady.principal
    axis = f"{_vector(steady.axis)} in the body" if others else _axis_name(description.kind, first)
    return f"A steady rotation about {axis}. {_STEADY[description.axes[first].spin.verdict]}"


def _motion_rows(description: Description) -> Iterator[Row]:
    """The quantities of the motion by name."""
    yield "kinetic energy", f"{_number(description.kinetic_energy_j)} J"
    yield "angular momentum", f"{_number(description.angular_momentum_kg_m2_s)} kg m²/s"
    yield "  in the world frame", f"{_vector(description.world_momentum_kg_m2_s)} kg m²/s"
    if description.steady is not None:
        yield "one turn", f"{_number(description.steady.turn_s)} s"
    circulation = description.circulation
    if circulation is None:
        return
    yield "distance from the separatrix", f"1 - m = {_number(circulation.separatrix_distance)}"
    if description.regime == "separatrix":
        yield from _separatrix_rows(circulation)
    else:
        yield from _periodic_rows(circulation, f"axis {_circled(description) + 1}", description.symmetric_top)


def _separatrix_rows(circulation: Circulation) -> Iterator[Row]:
    yield "period of the body rate", "infinite"
    yield "turn about the momentum", f"tends to {_number(circulation.precession_rate_rad_s)} rad/s"
    first = math.inf if circulation.flips is None else circulation.flips.first_s
    yield "Dzhanibekov flips", f"one, {_number(first)} s after the start" if math.isfinite(first) else "none any more"


def _periodic_rows(circulation: Circulation, axis: str, top: SymmetricTop | None) -> Iterator[Row]:
    rate, angle = circulation.precession_rate_rad_s, circulation.advance_per_period_rad
    yield "period of the body rate", f"{_number(circulation.period_s)} s"
    if top is not None:
        yield f"  circling {axis}", f"at {_number(top.body_precession_rate_rad_s)} rad/s"
    yield "mean precession", f"{_number(rate)} rad/s: {axis} circles the momentum once in {_period(rate)}"
    yield f"  tilt of {axis}", _tilt(circulation)
    yield "  advance per period", f"{_number(angle)} rad, {_number(angle / (2.0 * math.pi))} turns about the momentum"
    if top is not None:
        axial, momentum = _degrees(top.rate_to_axis_rad), _degrees(top.rate_to_momentum_rad)
        yield "  tilt of the body rate", f"{axial} from {axis}, {momentum} from the momentum, always"
    if circulation.flips is not None:
        yield from _flip_rows(circulation.flips)


def _tilt(circulation: Circulation) -> str:
    lowest, highest = _degrees(circulation.tilt_min_rad), _degrees(circulation.tilt_max_rad)
    swing = f"{lowest}, always: no nutation" if lowest == highest else f"swings between {lowest} and {highest}"
    return f"{swing} (angle to the momentum)"


def _flip_rows(flips: Flips) -> Iterator[Row]:
    near = _degrees(flips.nearest_angle_rad)
    yield (
        "Dzhanibekov flips" if flips.sudden else "axis 2 turns over",
        f"every {_number(flips.interval_s)} s, the first {_number(flips.first_s)} s after the start",
    )
    if flips.sudden:
        yield "  between flips", f"the momentum comes within {near} of axis 2"
    else:
        yield "  not suddenly", f"the momentum comes within {near} of axis 2, and does not linger there"


def _spin_rows(description: Description) -> Iterator[tuple[str, ...]]:
    for i, axis in enumerate(description.axes):
        outcome = _neutral(description.kind) if axis.spin.verdict == "neutral" else _disturbed(axis.spin)
        yield f"axis {i + 1}", f"{_number(axis.spin.spin_rate_rad_s)} rad/s", axis.spin.verdict, outcome


def _disturbed(spin: SpinStability) -> str:
    if spin.verdict == "stable":
        return f"a small disturbance circles the axis, once in {_period(spin.wobble_rate_rad_s)}"
    tenfold = f"{_number(math.log(10.0) / spin.growth_rate_1_s)} s" if spin.growth_rate_1_s else "no finite time"
    return f"a small disturbance grows as exp({_number(spin.growth_rate_1_s)} t), tenfold in {tenfold}"


def _neutral(kind: str) -> str:
    return "a disturbed spin is steady too" if kind == "spherical" else "a small disturbance makes it drift steadily"


class Conserved(NamedTuple):
    """A conserved quantity, its values in their unit, and the reason."""

    quantity: str
    values: tuple[float, ...]
    unit: str
    why: str


def _conserved(description: Description) -> tuple[Conserved, ...]:
    """The quantities that the symmetries of the motion conserve."""
    energy, momentum = description.kinetic_energy_j, description.world_momentum_kg_m2_s
    return (
        Conserved("kinetic energy", (energy,), "J", _TIME),
        Conserved("angular momentum in the world, all components", momentum, _MOMENTUM, _SPACE),
        *_in_the_body(description),
    )


def _in_the_body(description: Description) -> Iterator[Conserved]:
    along = description.conserved_body_momenta
    values = tuple(component.momentum_kg_m2_s for component in along)
    if description.kind == "spherical":
        yield Conserved("angular momentum in the body, all components", values, _MOMENTUM, _SPHERE)
    elif along:
        yield Conserved(f"angular momentum in the body along {_vector(along[0].direction)}", values, _MOMENTUM, _AXIS)


def _conservation_lines(description: Description) -> Iterator[str]:
    """The conserved quantities, each with the reason below it."""
    for quantity, values, unit, why in _conserved(description):
        yield f"{quantity}: {_number(values[0]) if len(values) == 1 else _vector(values)} {unit}"
        yield from _wrapped(why, indent="  ")
    if not description.conserved_body_momenta:
        yield from _wrapped(_NO_AXIS)


def _sensor_rows(scenario: Scenario) -> Iterator[Row]:
    """The parameters of the sensors that are not at their defaults; of a sensor that is off none."""
    off = {name for sensor in SENSORS.values() if sensor.name not in scenario.sensors.on for name in sensor.names}
    for name, value in scenario.sensor_parameters:
        if name != GRADE and value != SENSORS.parameters[name].default and name not in off:
            yield name, _vector(value) if isinstance(value, tuple) else _text(value)


def _text(value: float | str) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else _number(value)


def _number(value: float) -> str:
    """A number to six digits: enough to recognise it elsewhere."""
    return f"{value:.6g}"


def _degrees(angle_rad: float) -> str:
    """An angle in degrees, to three digits."""
    return f"{math.degrees(angle_rad):.3g}°"


def _period(rate_rad_s: float) -> str:
    """The time of one turn at an angular rate."""
    return f"{_number(2.0 * math.pi / rate_rad_s)} s" if rate_rad_s else "no finite time"


def _vector(values: Sequence[float]) -> str:
    """Numbers in brackets."""
    return "[" + ", ".join(_number(value) for value in values) + "]"


def _axis_name(kind: str, index: int) -> str:
    """A principal axis by its number and in words."""
    return f"axis {index + 1} ({_AXIS_NAMES[kind][index]})"


def _wrapped(sentences: str, indent: str = "") -> list[str]:
    """Sentences broken into lines for a terminal."""
    return textwrap.wrap(sentences, _WIDTH, initial_indent=indent, subsequent_indent=indent)


def _columns(rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    """Rows of cells as lines of aligned columns."""
    table = list(rows)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for row in table:
        yield "   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
