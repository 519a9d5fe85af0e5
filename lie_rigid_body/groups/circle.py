"""The circle group U(1)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.errors import InputError
from lie_rigid_body.groups import logarithm
from lie_rigid_body.groups.elements import Elements
from lie_rigid_body.groups.matrix_lie_algebra import MatrixLieAlgebra
from lie_rigid_body.groups.matrix_lie_group import MatrixLieGroup

Array = NDArray[Any]
Real = NDArray[np.float64]


def U1() -> MatrixLieGroup:  # noqa: N802
    """The group of phases e^{iθ} as 1×1 matrices, with the generator i; its coordinate is the angle θ."""
    algebra = MatrixLieAlgebra(np.array([[[1j]]]))
    return MatrixLieGroup("U(1)", algebra, algebra.trace_metric(1.0), PhaseElements())


class PhaseElements(Elements):
    """Complex numbers of modulus 1, as 1×1 matrices."""

    def distance(self, A: Array) -> Real:
        """How far the modulus is from 1."""
        return np.asarray(np.abs(np.abs(A[..., 0, 0]) - 1.0))

    def project(self, A: Array) -> Array:
        """The number divided by its modulus."""
        modulus = np.abs(A)
        if not np.all(modulus > 0.0):
            raise InputError("no nearest phase: 0 is equally near to all; give a number other than 0")
        return np.asarray(A / modulus)

    def inverse(self, A: Array) -> Array:
        """The complex conjugate."""
        return np.asarray(A.conj())

    def log(self, A: Array) -> Array:
        """The angle, within ±π, times i."""
        angle = np.angle(A)
        if np.any(np.pi - np.abs(angle) <= logarithm.HALF_TURN_MARGIN):
            raise InputError(
                f"no principal logarithm: a phase is −1 (within {logarithm.HALF_TURN_MARGIN:g} rad), where "
                "either sign of the angle is right; give an element closer to 1"
            )
        return np.asarray(1j * angle)

    def random(self, rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
        """Uniform phases."""
        return np.asarray(np.exp(1j * rng.uniform(-np.pi, np.pi, (*shape, 1, 1))))
