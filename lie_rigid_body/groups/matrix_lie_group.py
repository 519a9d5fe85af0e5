"""Matrix Lie groups: one class for SO(n), SU(n), U(1), their products, and groups given by generators.

Conventions
-----------
The generators Tᵃ are a basis of the algebra over the reals, with [Tᵃ, Tᵇ] = fᵃᵇᶜTᶜ, so that elements are exp(xᵃTᵃ)
without factors of i: eqs. (38) and (42) of A. Lucas, arXiv 1111.1275. For SO(3) they are the basis of `so3.hat`.
Coordinates x have shape (..., d), elements shape (..., n, n); leading axes are carried to the result.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lie_rigid_body.foundation.arrays import Array, Sizes, real_array, require_finite, shaped, whole_number
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import MAX_LINE, shortened
from lie_rigid_body.groups import exponential
from lie_rigid_body.groups.algebra import MatrixLieAlgebra, closed_algebra
from lie_rigid_body.groups.arguments import of_kind, within_doubles
from lie_rigid_body.groups.elements import Elements, GeneratedElements, measured
from lie_rigid_body.groups.exponential import Matrix

ELEMENT_TOLERANCE: Final = 1e-9
"""Largest distance of a matrix from fulfilling a group's equations that counts as round-off."""


@dataclass(frozen=True, eq=False)
class MatrixLieGroup(MatrixLieAlgebra):
    """A group of n×n matrices: its Lie algebra in coordinates, and its elements.

    Made by `SO`, `SU`, `U1`, `product` and `MatrixLieGroup.from_generators`.

    Parameters
    ----------
    generators : ndarray, shape (d, n, n)
        See `MatrixLieAlgebra`.
    name : str
        Name in messages and plots.
    trace_metric : ndarray, shape (d, d)
        gᵃᵇ = c Re tr(Tᵃ†Tᵇ), positive definite. For the antisymmetric and anti-Hermitian generators of a compact group
        it is −c tr(TᵃTᵇ). The scale c is ½ for SO(n) and 2 for SU(n), for which g is the identity in their bases. It is
        1 for U(1) and for groups from generators, and g of a product has the blocks of its factors.
    elements : Elements
        Membership, projection, logarithm and random elements.
    factors : tuple of MatrixLieGroup, optional
        The groups that `product` made it of, in the order of their blocks and coordinates; none for other groups.
    """

    name: str
    trace_metric: Array
    elements: Elements
    factors: tuple[MatrixLieGroup, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        self.trace_metric.setflags(write=False)

    @classmethod
    def from_generators(cls, generators: ArrayLike, *, name: str = "G") -> MatrixLieGroup:
        """The connected group whose algebra is the real span of given matrices.

        Generators give no equations for the elements, so that membership can be decided only in part:

        - `contains` and `log` recognise an element by its principal logarithm. An element whose principal logarithm
          leaves the span, does not exist, or is lost to rounding is not recognised. Such is exp(xᵃTᵃ) with an
          eigenvalue of xᵃTᵃ beyond ±πi, as after a long turn on a torus, or with angles on SU(n) that sum up to 2π.
        - `project` needs equations, and is refused.
        - `Ad`, `inverse` and motions accept every matrix that is not ruled out. It is finite, invertible, of a
          determinant that elements may have, and with an Ad that maps the algebra to itself. Other matrices of the
          normaliser pass as well, as diag(2, 2, 2, ⅛) for rigid motions of space.

        Parameters
        ----------
        generators : array_like, shape (d, n, n)
            Real or complex, linearly independent over the reals, closed under commutation within real combinations.
            Largest entries within 1e-50 … 1e50, so that products of them are numbers.
        name : str

        Raises
        ------
        InputError
            If a generator depends on those before it, is too small or large, or a commutator leaves the span; the
            message names it.

        Examples
        --------
        SE(3), the rigid motions of space, has turns and shifts:

            turns, shifts = np.zeros((2, 3, 4, 4))
            turns[:, :3, :3] = SO(3).generators
            shifts[:, :3, 3] = np.eye(3)
            group = MatrixLieGroup.from_generators(np.concatenate([turns, shifts]), name="SE(3)")
        """
        algebra = closed_algebra(generators)
        return cls(algebra.generators, name, algebra.scaled_trace(1.0), GeneratedElements(algebra))

    @property
    def identity(self) -> Matrix:
        """The unit element, shape (n, n)."""
        return np.eye(self.size, dtype=self.generators.dtype)

    def __repr__(self) -> str:
        return shortened(f"<{self.name}: dimension {self.dimension}, {self.size}×{self.size} matrices>", MAX_LINE)

    def as_matrices(self, A: ArrayLike) -> Matrix:
        """The argument as matrices, shape (..., n, n), of the group's number type; else a `ParameterError`."""
        return shaped(f"matrices of {self.name}", A, (..., self.size, self.size), self.generators.dtype)

    def as_elements(self, A: ArrayLike) -> Matrix:
        """The argument as elements; an `InputError` with the distance from the group, if it is none.

        For a group from generators every matrix passes that is not ruled out; see `from_generators`.
        """
        A = self.as_matrices(A)
        worst = np.max(measured(A, self.elements.certain_distance), initial=0.0)
        if not worst <= ELEMENT_TOLERANCE:
            raise InputError(
                f"a matrix is {worst:.3g} off {self.name} (limit {ELEMENT_TOLERANCE:g}): "
                "give an element of the group, or its projection by project()"
            )
        return A

    @within_doubles
    def exp(self, x: ArrayLike) -> Matrix:
        """The element exp(xᵃTᵃ).

        Parameters
        ----------
        x : array_like, shape (..., d)

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        return exponential.exp(self.hat(x))

    def log(self, A: ArrayLike) -> Array:
        """Coordinates of the logarithm: the principal one, where its eigenvalues' imaginary parts lie within ±π.

        For SU(n) the principal logarithm of an element may have a trace, and then lies outside the algebra. The result
        is the logarithm of least norm within the algebra, which is the principal one where that has no trace.

        Parameters
        ----------
        A : array_like, shape (..., n, n)
            Elements, to within 1e-9.

        Returns
        -------
        ndarray, shape (..., d)

        Raises
        ------
        InputError
            If A is off the group, or its logarithm is not unique: an eigenvalue on the negative real axis (for SU(n):
            two logarithms of equal norm). For a group from generators, also if A is not recognised.
        """
        return self.coordinates(self.elements.log(self.as_elements(A)))

    def inverse(self, A: ArrayLike) -> Matrix:
        """Inverses of elements, shape (..., n, n). Refuses matrices off the group."""
        return self.elements.inverse(self.as_elements(A))

    def Ad(self, A: ArrayLike) -> Array:  # noqa: N802
        """The matrix of hat(y) ↦ A hat(y) A⁻¹ in coordinates; Ad(AB) = Ad(A) Ad(B), Ad(exp x) = exp(ad x).

        Refuses matrices off the group.

        Parameters
        ----------
        A : array_like, shape (..., n, n)

        Returns
        -------
        ndarray, shape (..., d, d)
        """
        A = self.as_elements(A)[..., np.newaxis, :, :]
        return np.swapaxes(self.coordinates(A @ self.generators @ self.elements.inverse(A)), -1, -2)

    def contains(self, A: ArrayLike, tolerance: float = ELEMENT_TOLERANCE) -> NDArray[np.bool_]:
        """Whether matrices are elements to within a tolerance, shape (...), of A with shape (..., n, n).

        For a group from generators an element is recognised by its principal logarithm; see `from_generators`.
        """
        return measured(self.as_matrices(A), self.elements.distance) <= real_array("tolerance", tolerance, ())

    def restored(self, A: ArrayLike) -> Matrix:
        """Elements that round-off has carried a little off the group, projected back if possible, shape (..., n, n)."""
        return self.elements.restored(self._finite_matrices(A))

    @within_doubles
    def project(self, A: ArrayLike) -> Matrix:
        """Elements near matrices: of SO(n) and U(1) the nearest in the Frobenius norm.

        Of SU(n) it is the nearest unitary matrix over the n-th root of its determinant. Near the group that is the
        nearest element to first order in the distance.

        Parameters
        ----------
        A : array_like, shape (..., n, n)
            Any matrices.

        Returns
        -------
        ndarray, shape (..., n, n)

        Raises
        ------
        InputError
            If several elements are equally near, or the group is given by generators.
        """
        return self.elements.project(self._finite_matrices(A))

    def _finite_matrices(self, A: ArrayLike) -> Matrix:
        require_finite(f"matrices of {self.name}", A := self.as_matrices(A))
        return A

    def random(self, rng: np.random.Generator, shape: Sizes = ()) -> Matrix:
        """Independent random elements, shape `shape` + (n, n).

        They are distributed by the Haar measure for SO(n), SU(n), U(1) and their products. For a group from generators
        they are exponentials of standard normal coordinates.
        """
        sizes = (whole_number("shape", size, 0) for size in (shape if np.iterable(shape) else (shape,)))
        return self.elements.random(of_kind(rng, np.random.Generator), tuple(sizes))
