"""The explanation of a motion: its description as text for people and as JSON for programs."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from typing import Final, NamedTuple, cast

from lie_rigid_body.mechanics.top import SpinStability, SymmetricTop
from lie_rigid_body.motion.description import Circulation, Description, Flips
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import GRADE, SENSORS

Row = tuple[str, str]

_WIDTH: Final = 98
"""Width of a line of sentences, characters."""

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
"""Principal axes in words, in ascending order of their moments."""
_SEPARATRIX: Final = (
    "Exactly on the separatrix, between circling axis 1 and circling axis 3: the body rate tends to axis 2 "
    "(intermediate) and never returns. The least disturbance makes it a periodic motion."
)
_STEADY: Final = {
    "stable": "It is stable: a small disturbance stays small.",
    "unstable": "It is unstable: the least disturbance grows until the body turns over, again and again.",
    "neutral": "It is neutral: a small disturbance makes another motion, which drifts away steadily if at all.",
}
_REST: Final = "The body is at rest, and stays so in any attitude."
_MOMENTUM: Final = "kg m²/s"
_IN_THE: Final = "angular momentum in the"
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
    """Lines of the description for a terminal.

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
    """JSON-serialisable data of the description; a number that is not finite becomes null."""
    facts: dict[str, object] = asdict(description)
    facts["conserved"] = [fact._asdict() for fact in _conserved(description)]
    return {"parameters": scenario.parameters(), **{name: _plain(fact) for name, fact in facts.items()}}


def _plain(value: object) -> object:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {name: _plain(content) for name, content in value.items()}
    return [_plain(content) for content in value] if isinstance(value, tuple | list) else value


def _body_lines(description: Description) -> list[str]:
    kind = description.kind
    axes = [
        (_axis_name(kind, i), f"{_number(axis.moment_kg_m2)} kg m²", f"along {_vector(axis.direction)}")
        for i, axis in enumerate(description.axes)
    ]
    return [_KINDS[kind], *([_FLAT] if description.flat else []), *_columns(axes)]


def _motion_lines(description: Description) -> list[str]:
    return [*_wrapped(_regime_sentences(description)), *_columns(_motion_rows(description))]


def _regime_sentences(description: Description) -> str:
    """Regime of the motion, in sentences."""
    kind, steady = description.kind, description.steady
    if steady is not None:
        first, *others = steady.principal
        axis = f"{_vector(steady.axis)} in the body" if others else _axis_name(kind, first)
        return f"A steady rotation about {axis}. {_STEADY[description.axes[first].spin.verdict]}"
    axis = _axis_name(kind, _circled(description))
    path = "on a circle, at a constant rate" if "symmetry" in axis else "on a closed curve"
    circling = f"In the body, the body rate and the momentum circle {axis}, {path}."
    return {"rest": _REST, "separatrix": _SEPARATRIX}.get(description.regime, circling)


def _circled(description: Description) -> int:
    return 0 if description.regime == "about_smallest" else 2


def _motion_rows(description: Description) -> list[Row]:
    """Quantities of the motion by name."""
    steady, circulation = description.steady, description.circulation
    return [
        ("kinetic energy", f"{_number(description.kinetic_energy_j)} J"),
        ("angular momentum", f"{_number(description.angular_momentum_kg_m2_s)} {_MOMENTUM}"),
        ("  in the world frame", f"{_vector(description.world_momentum_kg_m2_s)} {_MOMENTUM}"),
        *([] if steady is None else [("one turn", f"{_number(steady.turn_s)} s")]),
        *([] if circulation is None else _circulation_rows(description, circulation)),
    ]


def _circulation_rows(description: Description, circulation: Circulation) -> list[Row]:
    on_separatrix = description.regime == "separatrix"
    axis = f"axis {_circled(description) + 1}"
    return [
        ("distance from the separatrix", f"1 - m = {_number(circulation.separatrix_distance)}"),
        *(
            _separatrix_rows(circulation)
            if on_separatrix
            else _periodic_rows(circulation, axis, description.symmetric_top)
        ),
    ]


def _separatrix_rows(circulation: Circulation) -> list[Row]:
    first = math.inf if circulation.flips is None else circulation.flips.first_s
    return [
        ("period of the body rate", "infinite"),
        ("turn about the momentum", f"tends to {_number(circulation.precession_rate_rad_s)} rad/s"),
        ("Dzhanibekov flips", f"one, {_number(first)} s after the start" if math.isfinite(first) else "none any more"),
    ]


def _periodic_rows(circulation: Circulation, axis: str, top: SymmetricTop | None) -> list[Row]:
    rate, angle = circulation.precession_rate_rad_s, circulation.advance_per_period_rad
    rows = [
        ("period of the body rate", f"{_number(circulation.period_s)} s"),
        ("mean precession", f"{_number(rate)} rad/s: {axis} circles the momentum once in {_period(rate)}"),
        (f"  tilt of {axis}", _tilt(circulation)),
        ("  advance per period", f"{_number(angle)} rad, {_number(angle / math.tau)} turns about the momentum"),
    ]
    if top is not None:
        axial, momentum = _degrees(top.rate_to_axis_rad), _degrees(top.rate_to_momentum_rad)
        rows.insert(1, (f"  circling {axis}", f"at {_number(top.body_precession_rate_rad_s)} rad/s"))
        rows.append(("  tilt of the body rate", f"{axial} from {axis}, {momentum} from the momentum, always"))
    return rows + ([] if circulation.flips is None else _flip_rows(circulation.flips))


def _tilt(circulation: Circulation) -> str:
    lowest, highest = _degrees(circulation.tilt_min_rad), _degrees(circulation.tilt_max_rad)
    swing = f"{lowest}, always: no nutation" if lowest == highest else f"swings between {lowest} and {highest}"
    return f"{swing} (angle to the momentum)"


def _flip_rows(flips: Flips) -> list[Row]:
    times = f"every {_number(flips.interval_s)} s, the first {_number(flips.first_s)} s after the start"
    near = f"the momentum comes within {_degrees(flips.nearest_angle_rad)} of axis 2"
    if flips.sudden:
        return [("Dzhanibekov flips", times), ("  between flips", near)]
    return [("axis 2 turns over", times), ("  not suddenly", f"{near}, and does not linger there")]


def _spin_rows(description: Description) -> Iterator[tuple[str, ...]]:
    for i, axis in enumerate(description.axes):
        outcome = _disturbed(axis.spin, description.kind)
        yield f"axis {i + 1}", f"{_number(axis.spin.spin_rate_rad_s)} rad/s", axis.spin.verdict, outcome


def _disturbed(spin: SpinStability, kind: str) -> str:
    """Sentence about a spin that is disturbed."""
    tenfold = f"{_number(math.log(10.0) / spin.growth_rate_1_s)} s" if spin.growth_rate_1_s else "no finite time"
    drifts = "a disturbed spin is steady too" if kind == "spherical" else "a small disturbance makes it drift steadily"
    return {
        "stable": f"a small disturbance circles the axis, once in {_period(spin.wobble_rate_rad_s)}",
        "unstable": f"a small disturbance grows as exp({_number(spin.growth_rate_1_s)} t), tenfold in {tenfold}",
        "neutral": drifts,
    }[spin.verdict]


class Conserved(NamedTuple):
    """A conserved quantity, its values in their unit, and the reason."""

    quantity: str
    values: tuple[float, ...]
    unit: str
    why: str


def _conserved(description: Description) -> list[Conserved]:
    """Quantities that the symmetries of the motion conserve."""
    found = [
        Conserved("kinetic energy", (description.kinetic_energy_j,), "J", _TIME),
        Conserved(f"{_IN_THE} world, all components", description.world_momentum_kg_m2_s, _MOMENTUM, _SPACE),
    ]
    if along := description.conserved_body_momenta:
        is_sphere = description.kind == "spherical"
        which = "body, all components" if is_sphere else f"body along {_vector(along[0].direction)}"
        values = tuple(component.momentum_kg_m2_s for component in along)
        found.append(Conserved(f"{_IN_THE} {which}", values, _MOMENTUM, _SPHERE if is_sphere else _AXIS))
    return found


def _conservation_lines(description: Description) -> Iterator[str]:
    """Conserved quantities, each with the reason below it."""
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
            yield name, _vector(cast(Sequence[float], value)) if isinstance(value, tuple) else _text(value)


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
    return f"{_number(math.tau / rate_rad_s)} s" if rate_rad_s else "no finite time"


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
