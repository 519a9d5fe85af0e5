"""What a motion conserves, and why, in plain sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

from lie_rigid_body.cli.wording import number, vector, wrapped
from lie_rigid_body.motion.description import Description

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


class Conserved(NamedTuple):
    """One conserved quantity, its values in their unit, and the reason."""

    quantity: str
    values: tuple[float, ...]
    unit: str
    why: str


def conserved(description: Description) -> tuple[Conserved, ...]:
    """Everything that the symmetries of this motion conserve."""
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
        yield Conserved(f"angular momentum in the body along {vector(along[0].direction)}", values, _MOMENTUM, _AXIS)


def conservation_lines(description: Description) -> Iterator[str]:
    """Each conserved quantity with the reason below it."""
    for quantity, values, unit, why in conserved(description):
        yield f"{quantity}: {number(values[0]) if len(values) == 1 else vector(values)} {unit}"
        yield from wrapped(why, indent="  ")
    if not description.conserved_body_momenta:
        yield from wrapped(_NO_AXIS)
