"""Signals that ask a process to end, acted on only where nothing is lost."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Final

_NAMES: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
ENDING: Final[tuple[signal.Signals, ...]] = tuple(getattr(signal, name) for name in _NAMES if hasattr(signal, name))
"""Signals that ask a process to end, as far as the system has them: Ctrl-C, a request, and a terminal that closes."""


class Interruption:
    """A context in which these signals raise KeyboardInterrupt inside `allowed`, and are only noted elsewhere.

    Attributes
    ----------
    requested : bool
        Whether a signal came.
    """

    def __init__(self) -> None:
        self.requested = False
        self._allowed = False

    def install(self) -> None:
        """Handle the signals from now on; but SIGHUP stays ignored under nohup."""
        heeded = [n for n in ENDING if n.name != "SIGHUP" or signal.getsignal(n) != signal.SIG_IGN]
        self._previous = {number: signal.signal(number, self._handle) for number in heeded}

    @classmethod
    @contextmanager
    def until_exit(cls) -> Iterator[Interruption]:
        """A context of all that a process does, after which the signals are ignored.

        A second Ctrl-C would spoil the exit status, as the interpreter gives up every handler before it ends.
        """
        interruption = cls()
        interruption.install()
        try:
            yield interruption
        finally:
            for number in ENDING:
                signal.signal(number, signal.SIG_IGN)

    def __enter__(self) -> Interruption:
        self.install()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        for number, handler in self._previous.items():
            # once asked to end, the process ends: a second request in its last moments must not tear it
            signal.signal(number, signal.SIG_IGN if self.requested else handler)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if _waiting is not None:
            _waiting.append(number)
            return
        self.requested = True
        if self._allowed:
            self._allowed = False
            raise KeyboardInterrupt

    @contextmanager
    def allowed(self) -> Iterator[None]:
        """A context that the signals may interrupt; one that came before interrupts it at once."""
        self._allowed = True
        try:
            if self.requested:
                raise KeyboardInterrupt
            yield
        except KeyboardInterrupt:
            self._allowed = False  # the next signal must not leave the code that counts this one
            count_as_handled()
            raise
        finally:
            self._allowed = False


_waiting: list[int] | None = None
"""Signals that came while they are put off; None where they are acted on."""


@contextmanager
def put_off() -> Iterator[None]:
    """Context that no signal interrupts, for what must not be left half made; one that came is acted on at its end."""
    global _waiting
    came: list[int] = []
    _waiting = came
    try:
        yield
    finally:
        _waiting = None
        for number in came:
            signal.raise_signal(number)


@contextmanager
def interruptible() -> Iterator[None]:
    """A context in which each of these signals raises KeyboardInterrupt, but not while one is handled: none tears that.

    Signals that the process ignores, as SIGHUP under nohup, or handles itself are left to it, and in a thread all are.
    """
    own = threading.current_thread() is threading.main_thread()
    handlers = {number: signal.getsignal(number) for number in ENDING if own}
    taken = {n: handler for n, handler in handlers.items() if handler in (signal.SIG_DFL, signal.default_int_handler)}
    for number in taken:
        signal.signal(number, _interrupt)
    try:
        yield
    finally:
        for number, handler in taken.items():
            if signal.getsignal(number) is _interrupt:  # an Interruption that was requested ignores them to the end
                signal.signal(number, handler)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if _waiting is not None:
        _waiting.append(number)
    elif not isinstance(sys.exc_info()[1], KeyboardInterrupt):
        raise KeyboardInterrupt


def count_as_handled() -> None:
    """Tell CPython that a KeyboardInterrupt is being handled.

    CPython notes a KeyboardInterrupt that leaves code compiled from a string, as importing a module may run. At its end
    it then kills the process by SIGINT, though the exception was handled further out. Running other code from a string
    clears the note.
    """
    exec("")
