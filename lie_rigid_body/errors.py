"""The errors of the package: one tree, so that callers can catch all of it at once."""

from __future__ import annotations


class LieRigidBodyError(Exception):
    """Anything this package refuses or cannot do. The message is one line: value, limit, remedy."""


class InputError(LieRigidBodyError, ValueError):
    """An argument, a parameter or a command line is at fault."""


class ParameterError(InputError):
    """A scenario parameter is at fault.

    Parameters
    ----------
    name : str
        The parameter's public name, as in parameter files.
    message : str
        What was given, what is allowed, what to do.
    """

    def __init__(self, name: str, message: str) -> None:
        super().__init__(f"{name}: {message}")
        self.name = name


class BagError(LieRigidBodyError):
    """A recording cannot be written or read."""
