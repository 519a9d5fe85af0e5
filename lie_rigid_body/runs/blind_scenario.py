"""Scenarios as a filter may know them: without the start, the motion and the seed."""

from __future__ import annotations

from dataclasses import fields
from functools import lru_cache, partial
from typing import Final, NoReturn

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import Value
from lie_rigid_body.scenario import Scenario

WITHHELD: Final = (
    "initial_attitude_xyzw",
    "initial_body_rate",
    *("kicks", "kick_period", "translation", "initial_position", "initial_velocity"),
    *("sway_acceleration", "sway_band", "sway_seed"),
    *("motion", "path_file", "path_interval", "path_knots"),
    "sensor_seed",
)
"""Parameters that would tell the truth, or the noise."""


class WithheldError(InputError, AttributeError):
    """Something was asked of a run or a scenario that would tell the truth."""


def refuse(name: str, *_: object, **__: object) -> NoReturn:
    """Raise the error for something that would tell the truth, whatever arguments it is called with."""
    raise WithheldError(
        f"{name} would tell the truth, which this run withholds: estimate from what run.imu and run.magnetometer read"
    )


class BlindScenario(Scenario):
    """A scenario without its start and its seed."""

    @classmethod
    @lru_cache(maxsize=32)  # a filter is run many times on few scenarios
    def of(cls, scenario: Scenario, given: tuple[str, ...] = ()) -> BlindScenario:
        """Scenario as a filter may know it, with those of the withheld parameters that it is given."""
        withheld = {*WITHHELD}.difference(given)
        told = {name: value for name, value in scenario.parameters().items() if name not in withheld}
        if scenario.parameters().get("motion") == "path" and "initial_attitude_xyzw" in told:
            told["initial_attitude_xyzw"] = tuple(scenario.start().attitude_xyzw.tolist())
        known = Scenario.from_parameters(told)
        blind = object.__new__(cls)
        vars(blind).update({f.name: getattr(known, f.name) for f in fields(known) if f.name not in withheld})
        vars(blind)["sensor_parameters"] = tuple(pair for pair in known.sensor_parameters if pair[0] not in withheld)
        return blind

    def parameters(self) -> dict[str, Value]:
        """Names and values of the parameters but those that are withheld."""
        own = {name: value for name, value in vars(self).items() if name not in ("sensors", "sensor_parameters")}
        return {**own, **dict(self.sensor_parameters)}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, BlindScenario) and self.parameters() == other.parameters()

    def __hash__(self) -> int:
        return hash(self.sensor_parameters)


def _given(name: str, scenario: BlindScenario) -> object:
    """A parameter that is withheld, where this scenario gives it."""
    if name not in vars(scenario):
        refuse(f"scenario.{name}")
    return vars(scenario)[name]


for _name in WITHHELD:
    setattr(BlindScenario, _name, property(partial(_given, _name)))
