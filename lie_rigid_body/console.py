"""The console of every executable: arguments, output, one-line errors and exit statuses."""

from __future__ import annotations

import argparse
import functools
import os
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final, NoReturn

from lie_rigid_body.errors import InputError, LieRigidBodyError, ParameterError
from lie_rigid_body.interruption import count_as_handled

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

SUCCESS: Final = 0
UNUSABLE: Final = 2
INTERRUPTED: Final = 130
_BROKEN_PIPE: Final = 141
_PIP_NAMES: Final = {"yaml": "PyYAML"}

Main = Callable[[Sequence[str] | None], int]


class Parser(argparse.ArgumentParser):
    """A parser whose usage errors are one line on stderr, and status 2.

    Parameters
    ----------
    verb : str
    description : str
    """

    def __init__(self, verb: str, description: str) -> None:
        super().__init__(prog=program(verb), description=description, allow_abbrev=False)

    def print_help(self, file: SupportsWrite[str] | None = None) -> None:
        """Print the help on stdout, by `say`."""
        say(self.format_help().rstrip("\n"))

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and end with status 2."""
        complain(self.prog, f"{message}; '{self.prog} --help' explains the arguments")
        raise SystemExit(UNUSABLE)


def program(verb: str) -> str:
    """The command of a verb: an executable of its own where ROS 2 installed this one, else one of ``lie-rigid-body``.

    ROS 2 has executables in ``lib/lie_rigid_body``, where ``python -m lie_rigid_body`` has its ``__main__.py``.
    """
    this = Path(sys.argv[0])
    of_ros = this.parent.name == __package__ and this.suffix != ".py"
    return f"ros2 run {__package__} {verb}" if of_ros else f"lie-rigid-body {verb}"


def how_to_certify(bag: str | Path) -> str:
    """The command that certifies a bag, for a shell."""
    return f"certify them with: {program('check')} {shlex.quote(str(bag))}"


def complain(prog: str, message: str) -> None:
    """Print an error as one line on stderr, if that can be written."""
    with suppress(OSError):
        print(f"{prog}: error: {' '.join(message.splitlines())}", file=sys.stderr)


def say(text: str) -> None:
    """Print on stdout, and report if that fails: every verb answers by this. Where stdout is closed nothing is printed.

    Raises
    ------
    InputError
        If stdout cannot be written.
    BrokenPipeError
        If its reader has gone.
    """
    try:
        print(text, flush=True)
    except BrokenPipeError:
        silence()
        raise
    except OSError as error:
        silence()
        raise InputError(f"stdout cannot be written: {error.strerror}: send it elsewhere") from None


def silence() -> None:
    """Discard what stdout still holds: else the interpreter would try to write it at its end, and fail again."""
    if sys.stdout is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def add_scenario_arguments(parser: argparse.ArgumentParser) -> None:
    """Add ``--scenario``, ``--params-file`` and ``-p``, which `parameters` reads."""
    group = parser.add_argument_group("scenario", "later wins: defaults < --scenario < --params-file < -p")
    group.add_argument("--scenario", metavar="NAME", help="a scenario of the package; 'scenarios' lists them")
    group.add_argument(
        "--params-file", metavar="FILE", action="append", default=[], help="a ROS 2 parameter file; may be repeated"
    )
    group.add_argument(
        "-p",
        metavar="NAME:=VALUE",
        action="append",
        default=[],
        dest="assignments",
        help="one parameter; may be repeated",
    )


def parameters(arguments: argparse.Namespace) -> dict[str, object]:
    """The parameters that the arguments of `add_scenario_arguments` give."""
    from lie_rigid_body.scenario.parameter_file import gather

    return gather(arguments.scenario, arguments.params_file, arguments.assignments)


@contextmanager
def files_named(arguments: argparse.Namespace) -> Iterator[None]:
    """A context that adds to an error about a parameter the name of the file that gave it."""
    from lie_rigid_body.scenario.parameter_file import file_that_gives

    try:
        yield
    except ParameterError as error:
        path = file_that_gives(error.name, arguments.params_file, arguments.assignments)
        raise error if path is None else InputError(f"{path}: {error}") from None


def run(main: Main) -> Main:
    """Wrap a verb's main so that users see one line instead of a traceback, and status codes instead of exceptions.

    Parameters
    ----------
    main : callable
        ``main(argv) -> int`` of a module that is named after its verb.

    Returns
    -------
    callable
        The same, which returns 2 after a `LieRigidBodyError` or a usage error, 130 when interrupted, 141 when the
        reader of stdout has gone.
    """
    verb = main.__module__.rpartition(".")[2]

    @functools.wraps(main)
    def wrapped(argv: Sequence[str] | None = None) -> int:
        return status_of(program(verb), lambda: main(argv))

    return wrapped


def status_of(prog: str, action: Callable[[], int]) -> int:
    """The exit status of an action; its errors are printed on stderr under the name of a program. See `run`."""
    try:
        return action()
    except SystemExit as request:
        return request.code if isinstance(request.code, int) else SUCCESS
    except LieRigidBodyError as error:
        complain(prog, str(error))
        return UNUSABLE
    except ModuleNotFoundError as error:
        complain(prog, missing_library(error))
        return UNUSABLE
    except KeyboardInterrupt:
        count_as_handled()
        complain(prog, "interrupted")
        return INTERRUPTED
    except BrokenPipeError:
        return _BROKEN_PIPE


def missing_library(error: ModuleNotFoundError) -> str:
    """What to install. A module that is missing within this package is a mistake of ours, and raised again."""
    library = (error.name or "").partition(".")[0]
    if library in ("", __package__):
        raise error
    return f"the Python library {library} is not installed: pip install {_PIP_NAMES.get(library, library)}"
