"""Torque-free rigid-body motion on SO(3) by the moving-chart update, with a closed form to hold it against."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # for type checkers and editors, in the form that exports a name again
    from lie_rigid_body.campaign import Campaign as Campaign
    from lie_rigid_body.certificate import certify as certify
    from lie_rigid_body.diagnosis import diagnose as diagnose
    from lie_rigid_body.evaluation import ExactTruth as ExactTruth
    from lie_rigid_body.evaluation import Limits as Limits
    from lie_rigid_body.evaluation import SampledTruth as SampledTruth
    from lie_rigid_body.evaluation import attitude_error as attitude_error
    from lie_rigid_body.evaluation import evaluate as evaluate
    from lie_rigid_body.foundation.errors import BagError as BagError
    from lie_rigid_body.foundation.errors import InputError as InputError
    from lie_rigid_body.foundation.errors import LieRigidBodyError as LieRigidBodyError
    from lie_rigid_body.foundation.errors import ParameterError as ParameterError
    from lie_rigid_body.inspection import inspect as inspect
    from lie_rigid_body.mechanics import RigidBody as RigidBody
    from lie_rigid_body.mechanics import State as State
    from lie_rigid_body.motion import ClosedForm as ClosedForm
    from lie_rigid_body.motion import MovingChart as MovingChart
    from lie_rigid_body.motion import describe as describe
    from lie_rigid_body.runs import Estimate as Estimate
    from lie_rigid_body.runs import Run as Run
    from lie_rigid_body.runs import simulate as simulate
    from lie_rigid_body.scenario import Scenario as Scenario
    from lie_rigid_body.scenario import random_kicks as random_kicks

__version__ = "1.0.0"

# Loaded at first use (PEP 562), so that `lie-rigid-body --help` does not wait for NumPy and SciPy.
_NAMES = {
    "campaign": "Campaign",
    "certificate": "certify",
    "diagnosis": "diagnose",
    "evaluation": "ExactTruth Limits SampledTruth attitude_error evaluate",
    "foundation.errors": "BagError InputError LieRigidBodyError ParameterError",
    "inspection": "inspect",
    "mechanics": "RigidBody State",
    "motion": "ClosedForm MovingChart describe",
    "runs": "Estimate Run simulate",
    "scenario": "Scenario random_kicks",
}
_HOMES = {name: room for room, names in _NAMES.items() for name in names.split()}
_ROOMS = ("groups", "lie", "mechanics")

__all__ = sorted([*_HOMES, "__version__"])


def __getattr__(name: str) -> object:
    if name in _ROOMS:
        return import_module(f"{__name__}.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_ROOMS})
