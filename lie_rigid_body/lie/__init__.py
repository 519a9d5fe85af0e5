"""Lie groups as arrays: SO(3) on rotation vectors, unit quaternions and matrices, and matrix groups in general."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from lie_rigid_body.lie import quaternion, so3

if TYPE_CHECKING:
    from lie_rigid_body.lie import double_cover
    from lie_rigid_body.lie.circle import U1
    from lie_rigid_body.lie.matrix_lie_group import MatrixLieGroup
    from lie_rigid_body.lie.product import product
    from lie_rigid_body.lie.special_orthogonal import SO
    from lie_rigid_body.lie.special_unitary import SU

__all__ = ["SO", "SU", "U1", "MatrixLieGroup", "double_cover", "product", "quaternion", "so3"]

# Loaded at first use (PEP 562): the general groups need SciPy's linear algebra, SO(3) does not.
_HOMES = {
    "SO": "special_orthogonal",
    "SU": "special_unitary",
    "U1": "circle",
    "MatrixLieGroup": "matrix_lie_group",
    "product": "product",
}


def __getattr__(name: str) -> object:
    if name == "double_cover":
        return import_module("lie_rigid_body.lie.double_cover")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"lie_rigid_body.lie.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
