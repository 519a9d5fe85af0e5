"""Signals that ask a process to end: the first decides, where nothing is lost by it; a second ends what closes."""

from __future__ import annotations

import _thread
import atexit
import math
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any, ClassVar, Final

END_SIGNALS: Final = tuple(each for each in signal.Signals if each.name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK"))
"""Signals that ask a process to end, as far as the system has them: Ctrl-C, a request, and a terminal that closes."""
SAME_REQUEST_S: Final = 1.0
"""Time after the first signal, s, within which others are the same request, as of a terminal and of `ros2 launch`."""
_RETRY_S: Final = 0.02
"""Time, s, after which a signal that comes amid an import comes again."""


class Interruption:
    """A request to end: where that is `allowed`, the first signal raises KeyboardInterrupt; elsewhere it is noted.

    Amid an import it waits until that is done: there an exception is lost, or taken for a library that is broken.
    A second signal, `SAME_REQUEST_S` later or more, does so again; elsewhere it ends the process by its default action.

    Attributes
    ----------
    requested : bool
        Whether the process is to end.
    """

    _current: ClassVar[Interruption | None] = None

    def __init__(self) -> None:
        self.requested = False
        self._allowed = False
        self._is_postponed = False
        self._first_s = math.inf

    @classmethod
    def current(cls) -> Interruption:
        """The interruption of the main thread while signals are heeded; elsewhere a new one that never comes."""
        return (_in_main_thread() and cls._current) or cls()

    @classmethod
    @contextmanager
    def heeded(cls, *, to_the_end: bool) -> Iterator[Interruption]:
        """A context in which signals are heeded; one within another is the same, and in a thread it heeds none.

        A signal that this process handles itself is left to it, and so is SIGHUP where it is ignored, as under nohup.

        Parameters
        ----------
        to_the_end : bool
            Whether to note them also afterwards, until the interpreter ends, and then to ignore them, which keeps
            the exit status.
            Else the handlers are again what they were.
        """
        if cls._current is not None or not _in_main_thread():
            yield cls.current()
            return
        interruption = cls()
        cls._current = interruption
        former = {number: signal.getsignal(number) for number in END_SIGNALS}
        defaults = (signal.SIG_DFL, signal.default_int_handler)
        taken = [n for n, f in former.items() if f in defaults or (f == signal.SIG_IGN and n.name != "SIGHUP")]
        if to_the_end:
            sys.unraisablehook = interruption._unraised
        for number in taken:
            signal.signal(number, interruption._handle)
            if to_the_end:  # the interpreter gives back every handler before it ends, and a late signal would decide
                atexit.register(signal.signal, number, signal.SIG_IGN)
        try:
            yield interruption
        finally:
            cls._current = None
            if not to_the_end:
                for number in taken:
                    signal.signal(number, former[number])

    @contextmanager
    def allowed(self) -> Iterator[None]:
        """A context that the first signal interrupts; one that came before interrupts it at once."""
        before = self._allowed
        self._allowed = True
        try:
            self.heed()
            yield
        finally:
            self._allowed = before

    def heed(self) -> None:
        """Raise KeyboardInterrupt if the process is to end, where that is allowed."""
        if self.requested and self._allowed:
            raise KeyboardInterrupt

    @contextmanager
    def noted(self) -> Iterator[Interruption]:
        """A context within `allowed` that signals do not interrupt."""
        before = self._allowed
        self._allowed = False
        try:
            yield self
        finally:
            self._allowed = before

    def _handle(self, number: int, frame: FrameType | None) -> None:
        now_s = time.monotonic()
        is_again = now_s - self._first_s > SAME_REQUEST_S
        was_postponed = self._is_postponed
        self._is_postponed = False
        if self._first_s == math.inf:
            self.requested = True
            self._first_s = now_s
        elif not (is_again or was_postponed):
            return
        if self._allowed:
            if is_again or not _is_importing(frame):
                raise KeyboardInterrupt
            self._is_postponed = True
            _thread.start_new_thread(_send_again, (number,))
        elif is_again and not was_postponed:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)

    def _unraised(self, unraisable: Any) -> None:
        """Let a signal that came amid a destructor come again: there an exception is printed and forgotten."""
        if unraisable.exc_type is KeyboardInterrupt:
            self._is_postponed = True
            _thread.start_new_thread(_send_again, (signal.SIGINT,))
        else:
            sys.__unraisablehook__(unraisable)


def _is_importing(frame: FrameType | None) -> bool:
    while frame is not None and not frame.f_code.co_filename.startswith("<frozen importlib"):
        frame = frame.f_back
    return frame is not None


def _send_again(number: int) -> None:
    time.sleep(_RETRY_S)
    if hasattr(signal, "pthread_kill"):  # it ends what the main thread waits for
        signal.pthread_kill(threading.main_thread().ident or 0, number)
    else:
        signal.raise_signal(number)


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()
