"""The console of every executable: output, progress bars, one-line errors and exit statuses."""

from __future__ import annotations

import functools
import os
import shlex
import sys
import traceback
import warnings
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TextIO

from lie_rigid_body.foundation.errors import (
    PACKAGE,
    PACKAGE_FOLDER,
    ChoiceError,
    InputError,
    LieRigidBodyError,
    describe,
)
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import printable
from lie_rigid_body.foundation.wording import program as program
from lie_rigid_body.system.interruption import Interruption

if TYPE_CHECKING:
    from tqdm import tqdm

SUCCESS: Final = 0
BROKEN: Final = 1
UNUSABLE: Final = 2
INTERRUPTED: Final = 130

DEBUG: Final = "LIE_RIGID_BODY_DEBUG"
"""Environment variable that adds the traceback to every error line."""


Main = Callable[[Sequence[str] | None], int]


def how_to_certify(bag: str | Path) -> str:
    """The command that certifies a bag, for a shell."""
    return f"certify them with: {program('check')} {quoted(bag)}"


def quoted(path: str | Path) -> str:
    """Name of a file for a shell; where folders are divided by a backslash, shells take it in double quotes."""
    if os.sep == "\\":
        from subprocess import list2cmdline  # only here: it takes a while to load

        return list2cmdline([str(path)])
    return printable(shlex.quote(str(path)))


def complain(prog: str, message: str, kind: str = "error") -> None:
    """Print an error or warning as one line on stderr, if that can be written; a terminal wraps it."""
    try:
        line = _printable(f"{prog}: {kind}: {' '.join(message.splitlines())}", sys.stderr)
        print(line, file=sys.stderr, flush=True)
    except OSError:
        silence(sys.stderr)


def trace() -> None:
    """Print the traceback of the error that is handled on stderr, if `DEBUG` asks for it and that can be written."""
    if os.environ.get(DEBUG):
        try:
            traceback.print_exc()
        except OSError:
            silence(sys.stderr)


def say(text: str, done: str = "") -> bool:
    """Print on stdout, and report if that fails: every verb answers by this.

    Where stdout is closed, or its reader has gone, nothing is printed and nothing is wrong.

    Parameters
    ----------
    text : str
        Characters that stdout cannot encode, and those that would control a terminal, are escaped.
    done : str, optional
        What was done already, for the error.

    Returns
    -------
    bool
        Whether there may still be a reader.

    Raises
    ------
    InputError
        If stdout cannot be written.
    """
    try:
        print("\n".join(_printable(line, sys.stdout) for line in text.split("\n")), flush=True)
    except BrokenPipeError:
        silence(sys.stdout)
        return False
    except OSError as error:
        silence(sys.stdout)
        raise InputError(
            f"{done}{', but ' if done else ''}stdout cannot be written: {error.strerror}: send it elsewhere"
        ) from None
    return True


def progress(
    items: Iterable[Any] | None = None, *, unit: str, leave: bool = False, quiet: bool = False, **more: Any
) -> tqdm[Any]:
    """Progress bar on stderr, as a context; it is shown on a terminal only.

    Parameters
    ----------
    items : iterable, optional
        What to go through; else `tqdm.update` takes what is done.
    unit : str
    leave : bool, optional
        Whether it stays when all is done.
    quiet : bool, optional
        Whether it is not shown at all.
    **more
        Further arguments of `tqdm`, such as ``total``.
    """
    from tqdm import tqdm

    tqdm.monitor_interval = 0  # no thread for bars that stand still
    with suppress(OSError):  # of what is no terminal, or none of the system
        if not all(os.get_terminal_size(sys.stderr.fileno())):
            more |= {"ncols": 79, "nrows": 23}  # one less than usual, as tqdm has it: this terminal tells no size
    return tqdm(items, unit=unit, leave=leave, file=sys.stderr, disable=quiet or None, **more)


def progress_of_bags(bags: Iterable[str | Path], passes: int = 3) -> tqdm[Any]:
    """Progress bar of the bytes to be read of bags in so many passes, as a context; its ``update`` takes those read.

    A bag is read three times at most: to open it, to find its segments, and to take its samples.
    """
    return progress(total=passes * sum(map(bytes_of, bags)), unit="B", unit_scale=True, delay=0.5)


def bytes_of(bag: str | Path) -> int:
    """Number of bytes of a bag's files; 0 where there are none."""
    path = Path(bag)
    files = path.glob("*.mcap") if path.is_dir() else [path]
    return sum(file.stat().st_size for file in files if file.is_file())


def silence(stream: TextIO) -> None:
    """Discard what a stream still holds: else the interpreter would try to write it at its end, and fail again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _printable(line: str, stream: TextIO) -> str:
    """A line with escapes in place of what a stream cannot encode and of what would control a terminal."""
    encoding = getattr(stream, "encoding", None) or "utf-8"
    return printable(line).encode(encoding, "backslashreplace").decode(encoding)


def seconds(stamp_ns: int) -> str:
    """A stamp in seconds, to the nanosecond."""
    return f"{stamp_ns // NS}.{stamp_ns % NS:09d}"


def size(count: int) -> str:
    """A number of bytes as people read it."""
    units = ("B", "kB", "MB", "GB", "TB")
    power = min((len(str(count)) - 1) // 3, len(units) - 1)
    return f"{count / 1000**power:.4g} {units[power]}"


def run(main: Main) -> Main:
    """Wrap a verb's main so that users see one line instead of a traceback, and status codes instead of exceptions.

    Parameters
    ----------
    main : callable
        ``main(argv) -> int`` of a module that is named after its verb.

    Returns
    -------
    callable
        The same, which returns 130 when interrupted by SIGINT, SIGTERM or SIGHUP, and 2 after a usage error and any
        other exception.
    """

    @functools.wraps(main)
    def wrapped(argv: Sequence[str] | None = None) -> int:
        def action() -> int:
            with Interruption.current().allowed():
                return main(argv)

        return status_of(program(main.__module__.rpartition(".")[2]), action, to_the_end=argv is None)

    return wrapped


def status_of(prog: str, action: Callable[[], int], *, to_the_end: bool = False) -> int:
    """The exit status of an action, which signals interrupt where it allows that. See `run`.

    Parameters
    ----------
    prog : str
        Name under which errors are printed on stderr.
    action : callable
    to_the_end : bool, optional
        Whether the process ends with this status, whatever signals still come. See `Interruption.heeded`.
    """
    if to_the_end and not sys.warnoptions:  # numbers beyond doubles are infinite in what is printed, and that is all
        warnings.simplefilter("ignore", RuntimeWarning)
    # where one is closed, what is printed goes nowhere
    sys.stdout = sys.stdout or open(os.devnull, "w")  # noqa: SIM115 it ends with the process
    sys.stderr = sys.stderr or open(os.devnull, "w")  # noqa: SIM115
    with Interruption.heeded(to_the_end=to_the_end):
        try:
            return action()
        except SystemExit as request:
            if not isinstance(request.code, str):
                return request.code or SUCCESS
            complain(prog, request.code)
        except KeyboardInterrupt:
            complain(prog, "interrupted")
            return INTERRUPTED
        except Exception as error:
            trace()
            complain(prog, explanation(error))
    return UNUSABLE


def explanation(error: Exception) -> str:
    """One line about an exception for the user."""
    if isinstance(error, ChoiceError):
        error = error.on_the_command_line()
    if isinstance(error, LieRigidBodyError):
        return describe(error)
    if isinstance(error, MemoryError):
        return "there is not enough memory: give less at once, or free some"
    if isinstance(error, OSError):
        where = f" ({error.filename})" if error.filename else ""
        return f"the system says {error.strerror or error}{where}: see to that, and try again"
    if isinstance(error, ModuleNotFoundError) and missing_library(error):
        return missing_library(error)
    if isinstance(error, ImportError):
        return f"a library is missing or broken: {error}: install the requirements of the package again"
    imported = [f.filename for f in traceback.extract_tb(error.__traceback__) if f.name == "<module>"]
    if imported and not imported[-1].startswith(PACKAGE_FOLDER):  # a library that fails so, as by an odd variable
        return f"{imported[-1]} cannot be imported ({error}): correct the environment, or install it again"
    return f"this is a bug, please report it ({describe(error)}); {DEBUG}=1 shows where"


def missing_library(error: ModuleNotFoundError) -> str:
    """A line that says what to install; empty where the missing module is one of this package, which is a bug."""
    library = (error.name or "").partition(".")[0]
    if library in ("", PACKAGE):
        return ""
    return f"the Python library {library} is not installed: pip install {'PyYAML' if library == 'yaml' else library}"
