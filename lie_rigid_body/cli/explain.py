"""``explain``: what the mathematics says about a scenario, before it is run: text for people and JSON for programs."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final, cast

from lie_rigid_body.cli.scenarios import describe as describe_file
from lie_rigid_body.command_line import FORCE, argument, json_option, scenario_of, verb
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import NS, Value, Vector
from lie_rigid_body.foundation.wording import numerals

if TYPE_CHECKING:
    from lie_rigid_body.motion import Description
    from lie_rigid_body.report.answer import Part, Parts
    from lie_rigid_body.scenario import Scenario

_TOPS: Final = {
    "asymmetric": (
        "An asymmetric top: its three principal moments differ.",
        ("smallest", "intermediate", "largest"),
    ),
    "oblate": (
        "An oblate symmetric top, like a disc: its two smaller moments are equal.",
        ("equal", "equal", "axis of symmetry"),
    ),
    "prolate": (
        "A prolate symmetric top, like a rod: its two larger moments are equal.",
        ("axis of symmetry", "equal", "equal"),
    ),
    "spherical": (
        "A spherical top: its three moments are equal, and every axis is a principal one.",
        ("equal", "equal", "equal"),
    ),
}
"""Kinds of bodies: a sentence, and the principal axes in words, in ascending order of their moments."""
_FLAT: Final = "It is flat: the largest moment is the sum of the others, as if all mass lay in one plane."
_REGIMES: Final = {
    "rest": "The body is at rest, and stays so in any attitude.",
    "steady": "A steady rotation about {axis}. {stability}",
    "separatrix": "Exactly on the separatrix, between circling axis 1 and circling axis 3: the body rate tends to "
    "axis 2 (intermediate) and never returns. The least disturbance makes it a periodic motion.",
    "circling": "In the body, the body rate and the momentum circle {axis}, {path}.",
}
_SPINS: Final = {
    "stable": (
        "It is stable: a small disturbance stays small.",
        "a small disturbance circles the axis, once in {wobble}",
    ),
    "unstable": (
        "It is unstable: the least disturbance grows until the body turns over, again and again.",
        "a small disturbance grows as exp({spin.growth_rate_1_s:.6g} t), tenfold in {tenfold}",
    ),
    "neutral": (
        "It is neutral: a small disturbance makes another motion, which drifts away steadily if at all.",
        "a small disturbance makes it drift steadily",
    ),
    "spherical": ("", "a disturbed spin is steady too"),
}
"""Stabilities of spins: a sentence on the motion, and what becomes of a spin that is disturbed."""
_MOTION: Final = (
    ("any", "kinetic energy", "{d.kinetic_energy_j:.6g} J"),
    ("any", "angular momentum", "{d.angular_momentum_kg_m2_s:.6g} kg m²/s"),
    ("any", "  in the world frame", "{momentum} kg m²/s"),
    ("steady", "one turn", "{d.steady.turn_s:.6g} s"),
    ("circling", "distance from the separatrix", "1 - m = {c.separatrix_distance:.6g}"),
    ("separatrix", "period of the body rate", "infinite"),
    ("separatrix", "turn about the momentum", "tends to {c.precession_rate_rad_s:.6g} rad/s"),
    ("last flip", "Dzhanibekov flips", "one, {c.flips.first_s:.6g} s after the start"),
    ("no flip", "Dzhanibekov flips", "none any more"),
    ("periodic", "period of the body rate", "{c.period_s:.6g} s"),
    ("symmetric", "  circling {axis}", "at {d.symmetric_top.body_precession_rate_rad_s:.6g} rad/s"),
    ("periodic", "mean precession", "{c.precession_rate_rad_s:.6g} rad/s: {axis} circles the momentum once in {turn}"),
    ("nutating", "  tilt of {axis}", "swings between {lowest} and {highest} (angle to the momentum)"),
    ("regular", "  tilt of {axis}", "{lowest}, always: no nutation (angle to the momentum)"),
    (
        "periodic",
        "  advance per period",
        "{c.advance_per_period_rad:.6g} rad, {turns:.6g} turns about the momentum",
    ),
    ("symmetric", "  tilt of the body rate", "{to_axis} from {axis}, {to_momentum} from the momentum, always"),
    (
        "sudden",
        "Dzhanibekov flips",
        "every {c.flips.interval_s:.6g} s, the first {c.flips.first_s:.6g} s after the start",
    ),
    ("sudden", "  between flips", "the momentum comes within {nearest} of axis 2"),
    (
        "slow",
        "axis 2 turns over",
        "every {c.flips.interval_s:.6g} s, the first {c.flips.first_s:.6g} s after the start",
    ),
    ("slow", "  not suddenly", "the momentum comes within {nearest} of axis 2, and does not linger there"),
)
"""Quantities of motions: the case in which each is told, its name and its value."""
_ARCS: Final = {
    "rest": "",
    "steady": "a steady rotation",
    "separatrix": "on the separatrix",
    "about_smallest": "circles axis 1",
    "about_largest": "circles axis 3",
}
"""Regimes of arcs, in words."""
_PATH: Final = (
    "The motion is a smooth spline through {knots} knots, which ends after {duration_s:.6g} s. The acceleration has an "
    "RMS of {rms_acceleration_m_s2:.3g} m/s². It is prescribed: no law of mechanics conserves anything."
)
"""Sentences about a path."""
_WHY: Final = {
    "time": "No torque does work on the body: the Lagrangian does not depend on time.",
    "space": "Space has no preferred direction: a motion turned as a whole, about any fixed axis, is again a motion. "
    "Seen from the body the momentum moves, but keeps its size.",
    "sphere": "The inertia is the same about every axis, so turning the body within itself changes nothing.",
    "axis": "The inertia stays as it is when the body is turned within itself about this axis.",
    "no axis": "No symmetry conserves a component of the momentum in the body: about every axis, turning the body "
    "within itself changes the inertia.",
}
"""Symmetries by which something is conserved, or nothing is."""


@verb(
    "Tell what the mathematics says about a scenario, without running it.",
    argument("name", metavar="NAME", nargs="?", help="a scenario of the package, as by --scenario"),
    json_option("print it for programs; infinite and absent numbers are null"),
    FORCE,
    scenario=True,
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    from lie_rigid_body.motion import describe
    from lie_rigid_body.report.answer import Sentences, as_text
    from lie_rigid_body.report.outputs import emit, require_outputs
    from lie_rigid_body.scenario.facts import beyond_rotation
    from lie_rigid_body.scenario.parameter_file import scenario_files

    require_outputs(given, given.params_file, "json")
    if given.name is not None and given.scenario is not None:
        raise InputError(f"two scenarios, {given.name} and --scenario {given.scenario}: give one of them")
    name = given.scenario = given.scenario or given.name
    scenario = scenario_of(given)
    title = (
        f"{name}: {describe_file(scenario_files()[name])}"
        if name and not (given.params_file or given.assignments)  # which make another of it
        else ""
    )
    if path := scenario.path():
        told = {"knots": len(path), "duration_s": path.last_ns / NS, "rms_acceleration_m_s2": path.rms_acceleration()}
        parts: Parts = [Sentences([_PATH.format(**told)])]
        data: dict[str, Any] = {"path": told}
    else:
        description = describe(scenario.body(), scenario.start())
        parts = _parts(scenario, description)
        data = {**asdict(description), "conserved": _conserved(description), **beyond_rotation(scenario)}
    return emit(
        given,
        {},
        lambda: as_text([*parts, *_other_parts(scenario)], title),
        lambda: {"parameters": scenario.parameters(), **data},
    )


def _parts(scenario: Scenario, description: Description) -> Parts:
    """Answer about a scenario and its motion."""
    from lie_rigid_body.report.answer import Sentences, Table

    spins = "1 rad/s" if description.regime == "rest" else "this angular momentum"
    inertia = _vector(scenario.inertia)
    rate = _vector(scenario.initial_body_rate)
    until = " until the first kick" if scenario.kicks else ""
    return [
        Sentences([f"inertia {inertia} kg m², initial body rate {rate} rad/s"]),
        Table((), _body_rows(description), "Body, with its principal axes in the body frame"),
        Sentences([_TOPS[description.kind][0], *([_FLAT] if description.flat else [])]),
        Table((), _motion_rows(description), f"Motion{until}"),
        Sentences([_regime(description)]),
        Table((), [*_spin_rows(description)], f"Spinning about each principal axis with {spins}"),
        Sentences([*_conservation(description)], f"Conserved{until}"),
    ]


def _other_parts(scenario: Scenario) -> Parts:
    """Tables of kicks, mass centre and sensors, where there are some, and what has no effect."""
    from lie_rigid_body.report.answer import Sentences, Table
    from lie_rigid_body.scenario.facts import beyond_rotation

    beyond = beyond_rotation(scenario)
    return [
        Table((), [*_fact_rows(scenario, beyond["sway"])], "Kicks and mass centre"),
        *_arc_table(beyond),
        Table((), _sensor_rows(scenario), f"Sensors, of the grade {scenario.sensor_grade}"),
        Sentences([f"{sentence}." for sentence in scenario.without_effect], "Without effect"),
    ]


def _body_rows(description: Description) -> list[tuple[str, ...]]:
    """Principal axes, their moments and directions."""
    return [
        (_axis_name(description, i), f"{axis.moment_kg_m2:.6g} kg m²", f"along {_vector(axis.direction)}")
        for i, axis in enumerate(description.axes)
    ]


def _regime(description: Description) -> str:
    """Regime of the motion, in sentences."""
    if steady := description.steady:
        first, *others = steady.principal
        axis = f"{_vector(steady.axis)} in the body" if others else _axis_name(description, first)
        return _REGIMES["steady"].format(axis=axis, stability=_SPINS[description.axes[first].spin.verdict][0])
    axis = _axis_name(description, _circled(description))
    return _REGIMES.get(description.regime, _REGIMES["circling"]).format(
        axis=axis, path="on a circle, at a constant rate" if "symmetry" in axis else "on a closed curve"
    )


def _circled(description: Description) -> int:
    """Index of the principal axis that the momentum circles in the body, if it does."""
    return 0 if description.regime == "about_smallest" else 2


def _motion_rows(description: Description) -> list[tuple[str, str]]:
    """Quantities of the motion by name: the rows of `_MOTION` that its cases have."""
    cases = {"any", "steady" if description.steady else "circling" if description.circulation else "rest"}
    values: dict[str, object] = {"momentum": _vector(description.world_momentum_kg_m2_s)}
    if circulation := description.circulation:
        lowest = _degrees(circulation.tilt_min_rad)
        highest = _degrees(circulation.tilt_max_rad)
        values |= {
            "axis": f"axis {_circled(description) + 1}",
            "turn": _period(circulation.precession_rate_rad_s),
            "turns": circulation.advance_per_period_rad / math.tau,
            "lowest": lowest,
            "highest": highest,
        }
        endless = description.regime == "separatrix"
        cases |= {"separatrix"} if endless else {"periodic", "regular" if lowest == highest else "nutating"}
        if flips := circulation.flips:
            values["nearest"] = _degrees(flips.nearest_angle_rad)
            last = "last flip" if math.isfinite(flips.first_s) else "no flip"
            cases.add(last if endless else "sudden" if flips.sudden else "slow")
        if top := description.symmetric_top:
            cases.add("symmetric")
            values |= {"to_axis": _degrees(top.rate_to_axis_rad), "to_momentum": _degrees(top.rate_to_momentum_rad)}
    return [
        (name.format(**values), value.format(d=description, c=circulation, **values))
        for case, name, value in _MOTION
        if case in cases
    ]


def _spin_rows(description: Description) -> Iterator[tuple[str, ...]]:
    """Spins about the principal axes, and what becomes of each when it is disturbed."""
    for i, axis in enumerate(description.axes, 1):
        spin = axis.spin
        tenfold = f"{math.log(10.0) / spin.growth_rate_1_s:.6g} s" if spin.growth_rate_1_s else "no finite time"
        _, sentence = _SPINS["spherical" if description.kind == "spherical" else spin.verdict]
        yield (
            f"axis {i}",
            f"{spin.spin_rate_rad_s:.6g} rad/s",
            spin.verdict,
            sentence.format(spin=spin, tenfold=tenfold, wobble=_period(spin.wobble_rate_rad_s)),
        )


def _conserved(description: Description) -> list[dict[str, Any]]:
    """Quantities that the symmetries of the motion conserve, each with its values, their unit, and the reason."""
    body = "angular momentum in the body"
    along = description.conserved_body_momenta
    found = {
        "kinetic energy": ((description.kinetic_energy_j,), "J", "time"),
        "angular momentum in the world, all components": (description.world_momentum_kg_m2_s, "kg m²/s", "space"),
    }
    if along:
        is_sphere = description.kind == "spherical"
        name = f"{body}, all components" if is_sphere else f"{body} along {_vector(along[0].direction)}"
        values = tuple(component.momentum_kg_m2_s for component in along)
        found[name] = (values, "kg m²/s", "sphere" if is_sphere else "axis")
    return [
        {"quantity": name, "values": values, "unit": unit, "why": _WHY[symmetry]}
        for name, (values, unit, symmetry) in found.items()
    ]


def _conservation(description: Description) -> Iterator[str]:
    """Conserved quantities, their values, and the reasons."""
    for fact in _conserved(description):
        values = fact["values"]
        value = f"{values[0]:.6g}" if len(values) == 1 else _vector(values)
        yield f"{fact['quantity']}: {value} {fact['unit']}. {fact['why']}"
    if not description.conserved_body_momenta:
        yield _WHY["no axis"]


def _arc_table(beyond: dict[str, Any]) -> Iterator[Part]:
    """Table of the first arcs, where there are kicks."""
    from lie_rigid_body.report.answer import Table

    kicks = beyond["kicks"]
    if not kicks["count"]:
        return
    rows = [
        (
            str(number),
            f"{arc['begin_s']:.6g}",
            "at rest" if arc["regime"] == "rest" else _vector(arc["body_rate"]),
            _ARCS[arc["regime"]],
        )
        for number, arc in enumerate(beyond["arcs"])
    ]
    all_arcs = "endlessly many" if kicks["period_s"] else str(kicks["count"] + 1)
    heading = f"The first {len(rows)} of {all_arcs} arcs: free motions, each with an energy and a momentum of its own"
    yield Table(("arc", "from, s", "body rate, rad/s", "motion"), rows, heading)


def _fact_rows(scenario: Scenario, sway: dict[str, Any] | None) -> Iterator[tuple[str, str]]:
    """Kicks and translation, and sizes of the sway."""
    from lie_rigid_body.scenario.facts import facts

    for fact, phrase in facts(scenario).items():
        yield fact, phrase
        if fact == "mass centre" and sway is not None:
            for name, key, unit in (("speed", "speed_m_s", "m/s"), ("displacement", "displacement_m", "m")):
                most = sway[f"{key}_at_most"]
                yield f"  {name}", f"{_vector(sway[f'{key}_rms'])} {unit} RMS, at most {most:.6g} {unit}"


def _sensor_rows(scenario: Scenario) -> list[tuple[str, str]]:
    """The parameters of the sensors that are not at their defaults; of a sensor that is off none."""
    from lie_rigid_body.sensors import GRADE, SENSORS

    off = scenario.sensors.off_parameters if scenario.has_sensors else SENSORS.parameters
    return [
        (name, _value(value))
        for name, value in scenario.sensor_parameters
        if name != GRADE and value != SENSORS.parameters[name].default and name not in off
    ]


def _value(value: Value) -> str:
    """A parameter as it is written, its numbers to six digits: enough to recognise them elsewhere."""
    if isinstance(value, bool | str):
        return str(value).lower() if isinstance(value, bool) else value
    return _vector(cast(Vector, value)) if isinstance(value, tuple) else f"{value:.6g}"


def _degrees(angle_rad: float) -> str:
    """An angle in degrees, to three digits."""
    return f"{math.degrees(angle_rad):.3g}°"


def _period(rate_rad_s: float) -> str:
    """The time of one turn at an angular rate."""
    return f"{math.tau / rate_rad_s:.6g} s" if rate_rad_s else "no finite time"


def _vector(values: Sequence[float]) -> str:
    """Numbers in brackets."""
    return f"[{numerals(values)}]"


def _axis_name(description: Description, index: int) -> str:
    """A principal axis by its number and in words."""
    return f"axis {index + 1} ({_TOPS[description.kind][1][index]})"
