"""The errors of the package: one tree, so that callers can catch all of it at once."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

from lie_rigid_body.foundation.wording import MAX_LINE, printable, shortened, shown

PACKAGE: Final = __name__.partition(".")[0]
"""Name of the package."""
PACKAGE_FOLDER: Final = f"{Path(__file__).parents[1]}{os.sep}"
"""Folder of the package, by which a line of a traceback is known as its own."""


class LieRigidBodyError(Exception):
    """Anything this package refuses or cannot do. The message is one line: value, limit, remedy."""

    def __init__(self, message: str) -> None:
        super().__init__(printable(" ".join(message.splitlines())))


def describe(error: BaseException) -> str:
    """Message of an error of the package; of another error its class and the beginning of its message."""
    if isinstance(error, LieRigidBodyError):
        return str(error)
    message = ""
    with suppress(Exception):  # of a class whose own message fails
        message = shortened(str(error), MAX_LINE // 2)
    return ": ".join(filter(None, (type(error).__name__, message)))


class InputError(LieRigidBodyError, ValueError):
    """An argument, a parameter or a command line is at fault."""


class FilterError(InputError):
    """The filter raised an exception, did not return, or returned what is no estimate."""


class ParameterError(InputError):
    """A parameter of a scenario, or another argument that has a name, is at fault.

    Parameters
    ----------
    name : str
        Public name of the parameter, as in parameter files, or of the argument.
    message : str
        What was given, what is allowed, what to do.
    """

    def __init__(self, name: str, message: str) -> None:
        self.name = name if isinstance(name, str) else shown(name)
        self.message = message
        super().__init__(f"{shortened(self.name)}: {message}")

    def __reduce__(self) -> tuple[type[ParameterError], tuple[str, str]]:
        """The call that makes it anew, with name and message: without the name a pool of processes waits for ever."""
        return type(self), (self.name, self.message)


class BagError(LieRigidBodyError):
    """A recording cannot be written or read."""


class ChoiceError(BagError):
    """A topic that has to be chosen by name, or was, and is none. The remedy is that of Python.

    Parameters
    ----------
    said : str
        What is wrong, with ``{choice}`` where a choice is named.
    name, topic : str
        Relative and full name of the topic that is chosen, or may be.
    """

    def __init__(self, said: str, name: str, topic: str) -> None:
        self._given = said, name, topic
        super().__init__(said.replace("{choice}", f'topics={{"{name}": "{topic}"}}'))

    def __reduce__(self) -> tuple[type, tuple[str, str, str]]:
        return type(self), self._given

    def on_the_command_line(self) -> BagError:
        """Name the option of a verb as remedy."""
        said, name, topic = self._given
        return BagError(said.replace("{choice}", f"--topic {name}:={topic}"))


class ExistsError(BagError):
    """A file of that name exists, and is kept."""
