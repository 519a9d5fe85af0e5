"""A description of a motion as text for people and as JSON for programs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Final

from lie_rigid_body.cli.conservation_text import conservation_lines, conserved
from lie_rigid_body.cli.motion_text import motion_rows, regime_sentences
from lie_rigid_body.cli.wording import axis_name, columns, number, period, vector, wrapped
from lie_rigid_body.mechanics.spin_stability import SpinStability
from lie_rigid_body.motion.description import Description
from lie_rigid_body.scenario import Scenario

_KINDS: Final = {
    "asymmetric": "An asymmetric top: its three principal moments differ.",
    "oblate": "An oblate symmetric top, like a disc: its two smaller moments are equal.",
    "prolate": "A prolate symmetric top, like a rod: its two larger moments are equal.",
    "spherical": "A spherical top: its three moments are equal, and every axis is a principal one.",
}
_FLAT: Final = "It is flat: the largest moment is the sum of the others, as if all mass lay in one plane."


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
        f"Spinning about each principal axis with {spins}": columns(_spin_rows(description)),
        "Conserved": conservation_lines(description),
    }
    lines = [title] if title else []
    lines.append(
        f"inertia {vector(scenario.inertia)} kg m², initial body rate {vector(scenario.initial_body_rate)} rad/s"
    )
    for heading, content in sections.items():
        lines += ["", heading, *(f"  {line}" for line in content)]
    return "\n".join(lines)


def as_json(scenario: Scenario, description: Description) -> dict[str, object]:
    """The description as JSON-serialisable data; a number that is not finite becomes null."""
    facts: dict[str, object] = asdict(description)
    facts["conserved"] = [fact._asdict() for fact in conserved(description)]
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
    yield from columns(
        (axis_name(description.kind, i), f"{number(axis.moment_kg_m2)} kg m²", f"along {vector(axis.direction)}")
        for i, axis in enumerate(description.axes)
    )


def _motion_lines(description: Description) -> Iterator[str]:
    yield from wrapped(regime_sentences(description))
    yield from columns(motion_rows(description))


def _spin_rows(description: Description) -> Iterator[tuple[str, ...]]:
    for i, axis in enumerate(description.axes):
        course = _neutral(description.kind) if axis.spin.verdict == "neutral" else _course(axis.spin)
        yield f"axis {i + 1}", f"{number(axis.spin.spin_rate_rad_s)} rad/s", axis.spin.verdict, course


def _course(spin: SpinStability) -> str:
    if spin.verdict == "stable":
        return f"a small disturbance circles the axis, once in {period(spin.wobble_rate_rad_s)}"
    tenfold = f"{number(math.log(10.0) / spin.growth_rate_1_s)} s" if spin.growth_rate_1_s else "no finite time"
    return f"a small disturbance grows as exp({number(spin.growth_rate_1_s)} t), tenfold in {tenfold}"


def _neutral(kind: str) -> str:
    return "a disturbed spin is steady too" if kind == "spherical" else "a small disturbance makes it drift steadily"
