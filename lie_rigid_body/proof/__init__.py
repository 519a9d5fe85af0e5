"""Enclosures of the true motion: balls of real numbers that are proved to hold it, by Arb's ball arithmetic.

A motion is known exactly by its inertia, initial attitude and initial body rate, each a double and so a rational
number. `enclose` holds its state at any later nanosecond, by the exact solution evaluated in balls (`exact_solution`).
Tests hold it against the equations of motion themselves, by Taylor series with a proved remainder. The argument is told
by ``docs/explanation/proofs.md``.

The room needs python-flint. It reads an inertia as `mechanics` does, and shares no formula with the motions that it
judges.
"""

import importlib

from lie_rigid_body.foundation.errors import LieRigidBodyError


class FlintMissingError(LieRigidBodyError, ImportError):
    """python-flint is not installed."""


try:
    importlib.import_module("flint.pyflint")
except ImportError:
    raise FlintMissingError(
        "a proof needs python-flint, which is not installed: pip install 'python-flint>=0.9'"
    ) from None

from lie_rigid_body.proof.enclosure import Enclosure, enclose  # noqa: E402

__all__ = ["Enclosure", "FlintMissingError", "enclose"]
