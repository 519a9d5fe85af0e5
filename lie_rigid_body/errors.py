"""The errors of the package: one tree, so that callers can catch all of it at once."""

from lie_rigid_body.foundation.errors import (
    BagError,
    ExistsError,
    FilterError,
    InputError,
    LieRigidBodyError,
    ParameterError,
)

__all__ = ["BagError", "ExistsError", "FilterError", "InputError", "LieRigidBodyError", "ParameterError"]
