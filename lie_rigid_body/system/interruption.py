"""Signals that ask a process to end: the first decides, where nothing is lost by it, and the fourth ends it."""

from __future__ import annotations

import atexit
import math
import signal
import sys
import threading
import time
from _thread import interrupt_main, start_new_thread
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import ClassVar, Final

END_SIGNALS: Final = tuple(each for each in signal.Signals if each.name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK"))
"""Signals that ask a process to end, as far as the system has them: Ctrl-C, a request, and a terminal that closes."""
MOST_SIGNALS: Final = 4
"""Number of signals of which the last ends the process by its default action."""
LONGEST_CLOSING_S: Final = 10.0
"""Time after the first signal, s, from which any other ends the process by its default action."""
_AGAIN_S: Final = 0.005
"""Time, s, after which a signal is sent again whose KeyboardInterrupt was lost in code without a caller."""


class Interruption:
    """A request to end: where that is `allowed`, the first signal raises KeyboardInterrupt; elsewhere it is noted.

    Attributes
    ----------
    requested : bool
        Whether the process is to end.
    """

    _current: ClassVar[Interruption | None] = None

    def __init__(self) -> None:
        self.requested = False
        self._allowed = self._is_lost = False
        self._count, self._first_s = 0, math.inf
        self._unraisable, self._uncaught = sys.unraisablehook, sys.excepthook

    @classmethod
    def current(cls) -> Interruption:
        """The one that the signals of this process make; in a thread, or where nobody heeds them, one of nothing."""
        return (_in_main_thread() and cls._current) or cls()

    @classmethod
    @contextmanager
    def heeded(cls, *, to_the_end: bool) -> Iterator[Interruption]:
        """A context in which signals are heeded; one within another is the same, and in a thread it heeds none.

        A signal that this process handles itself is left to it, and so is SIGHUP where it is ignored, as under nohup.

        Parameters
        ----------
        to_the_end : bool
            Heed them also afterwards, until the interpreter ends and then ignore them, which keeps the exit status.
            Else the handlers are again what they were.
        """
        if cls._current is not None or not _in_main_thread():
            yield cls.current()
            return
        interruption = cls._current = cls()
        former = {number: signal.getsignal(number) for number in END_SIGNALS}
        defaults = (signal.SIG_DFL, signal.default_int_handler)
        taken = [n for n, f in former.items() if f in defaults or (f == signal.SIG_IGN and n.name != "SIGHUP")]
        sys.unraisablehook, sys.excepthook = interruption._ignored, interruption._printed
        for number in taken:
            signal.signal(number, interruption._handle)
        if to_the_end:
            # the first to be registered is the last to be called: what hangs before it can still be ended
            atexit.register(_ignore, taken)
        try:
            yield interruption
        finally:
            _forget_interrupt()
            cls._current, interruption._is_lost = None, False
            if not to_the_end:
                for number in taken:
                    signal.signal(number, former[number])
                sys.unraisablehook, sys.excepthook = interruption._unraisable, interruption._uncaught

    @contextmanager
    def allowed(self) -> Iterator[None]:
        """A context that the first signal interrupts; one that came before interrupts it at once."""
        before, self._allowed = self._allowed, True
        try:
            if self.requested:
                raise KeyboardInterrupt
            yield
        finally:
            self._allowed = before

    @contextmanager
    def noted(self) -> Iterator[Interruption]:
        """A context within `allowed` that signals do not interrupt."""
        before, self._allowed = self._allowed, False
        try:
            yield self
        finally:
            self._allowed = before

    @contextmanager
    def put_off(self) -> Iterator[None]:
        """A context that signals do not interrupt; one that came in it does so at its end, if that is allowed there."""
        before = self.requested
        with self.noted():
            yield
        if self._allowed and self.requested and not before:
            raise KeyboardInterrupt

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self._is_lost:
            if self._is_hooked(frame):
                return
            self._count, self.requested, self._is_lost = 0, False, False
        count = self._count = self._count + 1  # another signal may be handled amid this
        if count == 1:
            self.requested, self._first_s, self._number = True, time.monotonic(), number
            if self._allowed:
                raise KeyboardInterrupt
        elif count >= MOST_SIGNALS or time.monotonic() - self._first_s > LONGEST_CLOSING_S:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)

    def _ignored(self, lost: sys.UnraisableHookArgs) -> None:
        """Handle what a finaliser or a callback from C raises, which would lose an interrupt."""
        if not self._raises_again(lost.exc_type):
            self._unraisable(lost)

    def _printed(self, kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        """Handle what would be printed, as a library in C does with an interrupt amid its import."""
        if not self._raises_again(kind):
            self._uncaught(kind, error, trace)

    def _raises_again(self, kind: type[BaseException]) -> bool:
        """Raise an exception again in a moment, if it is a KeyboardInterrupt, and tell whether it is."""
        is_interrupt = issubclass(kind, KeyboardInterrupt)
        if is_interrupt:
            self._is_lost = True
            start_new_thread(self._interrupt_again, ())  # a `Thread` takes locks, which the main thread may hold
        return is_interrupt

    def _interrupt_again(self) -> None:
        """Send the signal that was lost until it counts as the first once more."""
        time.sleep(_AGAIN_S)
        while self._is_lost:
            if hasattr(signal, "pthread_kill"):  # which also ends a wait
                signal.pthread_kill(threading.main_thread().ident or 0, self._number)
            else:
                interrupt_main(signal.Signals(self._number))
            time.sleep(_AGAIN_S)

    def _is_hooked(self, frame: FrameType | None) -> bool:
        """Whether code runs within one of the hooks here, where an exception would be lost."""
        hooks = (Interruption._ignored.__code__, Interruption._printed.__code__)
        while frame is not None and frame.f_code not in hooks:
            frame = frame.f_back
        return frame is not None


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _ignore(numbers: list[signal.Signals]) -> None:
    """Ignore signals: the interpreter gives back every other handler before it ends, and a late one would decide."""
    for number in numbers:
        signal.signal(number, signal.SIG_IGN)


def _forget_interrupt() -> None:
    """Tell CPython that a KeyboardInterrupt was handled.

    CPython notes a KeyboardInterrupt that leaves code compiled from a string, as importing a module may run. At its end
    it then kills the process by SIGINT, though the exception was handled further out. Running other code from a string
    clears the note.
    """
    exec("")
