"""Torque-free rigid-body motion on SO(3) by the moving-chart update, with a closed form to hold it against."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lie_rigid_body.campaign import Campaign
    from lie_rigid_body.certificate import certify
    from lie_rigid_body.diagnosis import diagnose
    from lie_rigid_body.evaluation import ExactTruth, Limits, SampledTruth, attitude_error, evaluate
    from lie_rigid_body.foundation.errors import BagError, InputError, LieRigidBodyError, ParameterError
    from lie_rigid_body.mechanics import RigidBody, State
    from lie_rigid_body.motion import ClosedForm, MovingChart
    from lie_rigid_body.runs import Estimate, Run, simulate
    from lie_rigid_body.scenario import Scenario

__version__ = "1.0.0"

__all__ = [
    "BagError",
    "Campaign",
    "ClosedForm",
    "Estimate",
    "ExactTruth",
    "InputError",
    "LieRigidBodyError",
    "Limits",
    "MovingChart",
    "ParameterError",
    "RigidBody",
    "Run",
    "SampledTruth",
    "Scenario",
    "State",
    "__version__",
    "attitude_error",
    "certify",
    "diagnose",
    "evaluate",
    "simulate",
]

# Loaded at first use (PEP 562), so that `lie-rigid-body --help` does not wait for NumPy and SciPy.
_HOMES = {
    "BagError": "lie_rigid_body.foundation.errors",
    "Campaign": "lie_rigid_body.campaign",
    "ClosedForm": "lie_rigid_body.motion",
    "Estimate": "lie_rigid_body.runs",
    "ExactTruth": "lie_rigid_body.evaluation",
    "InputError": "lie_rigid_body.foundation.errors",
    "LieRigidBodyError": "lie_rigid_body.foundation.errors",
    "Limits": "lie_rigid_body.evaluation",
    "MovingChart": "lie_rigid_body.motion",
    "ParameterError": "lie_rigid_body.foundation.errors",
    "RigidBody": "lie_rigid_body.mechanics",
    "Run": "lie_rigid_body.runs",
    "SampledTruth": "lie_rigid_body.evaluation",
    "Scenario": "lie_rigid_body.scenario",
    "State": "lie_rigid_body.mechanics",
    "attitude_error": "lie_rigid_body.evaluation",
    "certify": "lie_rigid_body.certificate",
    "diagnose": "lie_rigid_body.diagnosis",
    "evaluate": "lie_rigid_body.evaluation",
    "simulate": "lie_rigid_body.runs",
}


_ROOMS = ("groups", "lie", "mechanics")


def __getattr__(name: str) -> object:
    if name in _ROOMS:
        return import_module(f"{__name__}.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_ROOMS})
