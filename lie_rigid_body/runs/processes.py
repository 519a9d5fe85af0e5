"""Processes in which estimators are called: other Pythons, which are asked something, reply, hang, and die."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from threading import Timer
from typing import Any, BinaryIO, Final

from lie_rigid_body.errors import InputError, LieRigidBodyError, said

STARTING_S: Final = 20.0
"""Least time that a process has to start and to import the estimator, s."""
_SERVE: Final = "import sys; sys.path[:] = {}; from lie_rigid_body.runs.processes import serve; serve()"
_LIBRARIES: Final = ("site-packages", "dist-packages", str(Path(traceback.__file__).parent))
"""Parts of the paths of files that are not the user's."""


class FilterError(InputError):
    """The filter raised an exception, did not return, or returned what is no estimate."""


def told(error: BaseException) -> str:
    """Say an exception of a filter with the last line of the user's own that it came through."""
    package = str(Path(__file__).resolve().parent.parent)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(package)]
    own = [frame for frame in frames if not any(part in frame.filename for part in _LIBRARIES)]
    line = "".join(f"{Path(frame.filename).name} line {frame.lineno}: " for frame in (own or frames)[-1:])
    remedy = "" if isinstance(error, LieRigidBodyError) else ": mend that first"
    return f"the filter failed, {line}{said(error)}{remedy}"


class Interpreter:
    """Another Python, which is asked something, and replies, by what can be pickled.

    It starts when it is asked, and anew where it has ended. It is new, no copy of this one: nothing of the user's main
    module is run again, on any platform.

    Parameters
    ----------
    *arguments : str
        Its command line, of a program that takes its `questions`; by default of one that calls them.
    """

    def __init__(self, *arguments: str) -> None:
        self._arguments = arguments
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def is_running(self) -> bool:
        """Whether it was started, and is not known to have ended."""
        return self._process is not None

    def ask(self, question: object, limit_s: float) -> Any:
        """Ask, and return the reply; an exception that it replies is raised.

        Raises
        ------
        TimeoutError, EOFError
            If it has not replied in so many seconds, or has ended, with its status. Then it is ended.
        """
        process = self._process = self._process or subprocess.Popen(
            [sys.executable, *(self._arguments or ("-c", _SERVE.format(repr(sys.path))))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C of a terminal is for the parent, which ends what it began
        )
        end, timer = time.monotonic() + limit_s, Timer(limit_s, self.kill)
        timer.start()
        try:
            send(process.stdin, question)
            reply = pickle.load(process.stdout)  # type: ignore[arg-type]  # it is a pipe
        except (EOFError, OSError, pickle.UnpicklingError):
            is_late = time.monotonic() >= end
            self.end()
            if is_late:
                raise TimeoutError(f"did not return within {limit_s:g} s") from None
            raise EOFError(f"ended its process, status {process.returncode}") from None
        finally:
            timer.cancel()
        if isinstance(reply, Exception):
            raise reply
        return reply

    def kill(self) -> None:
        """Kill it, and what it started."""
        if self._process is not None:
            kill_all(self._process)

    def end(self) -> None:
        """Kill it and close its streams."""
        self.kill()
        process, self._process = self._process, None
        if process is not None:
            with suppress(OSError):
                process.communicate()


def kill_all(process: subprocess.Popen[Any]) -> None:
    """Kill a process that leads a session of its own, and what it started, which may hold its pipes open."""
    with suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        process.kill()


def questions() -> tuple[BinaryIO, BinaryIO]:
    """The streams of what this process is asked, and of its replies; what it prints goes nowhere from now on."""
    asked, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)
    return asked, replies


def send(stream: Any, item: object) -> None:
    """Pickle something into a stream at once."""
    pickle.dump(item, stream)
    stream.flush()


def serve() -> None:
    """Call what this process is asked, and reply what it returns, until its standard input ends."""
    asked, replies = questions()
    with suppress(EOFError):
        while True:
            question: Callable[[], object] = pickle.load(asked)
            try:
                reply = question()
            except Exception as error:
                reply = error if isinstance(error, InputError) else RuntimeError(repr(error))
            except BaseException as error:  # the estimator's own: no Ctrl-C of a terminal comes here
                reply = FilterError(told(error))
            send(replies, reply)
