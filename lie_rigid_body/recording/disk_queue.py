"""The queue of a disk: a thread does what takes time there, one job after the other."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Final

LARGEST_BACKLOG: Final = 32 * 1024**2
"""Bytes that may wait for the disk: at 1000 samples a second those of two minutes."""


class DiskQueue:
    """Jobs for a thread of their own, in order. After one that failed none is done.

    Its error is raised in this thread by the next call.

    Parameters
    ----------
    waits : bool
        Whether `put` waits while too much is in the queue; otherwise it refuses more.
    """

    def __init__(self, *, waits: bool) -> None:
        self._waits = waits
        self._thread = ThreadPoolExecutor(1)
        self._jobs: deque[tuple[Future[None], int]] = deque()
        self._failed = False

    def put(self, job: Callable[[], object], size: int = 0) -> None:
        """Have a job done, which keeps so many bytes in memory until then.

        Raises
        ------
        TimeoutError
            If too much is in the queue.
        """
        self._forget(lambda done: done or (self._waits and self._waiting + size > LARGEST_BACKLOG))
        if not self._waits and self._waiting + size > LARGEST_BACKLOG:
            raise TimeoutError(f"the disk does not keep up, {self._waiting} bytes wait for it")
        self._jobs.append((self._thread.submit(self._do, job), size))

    @property
    def _waiting(self) -> int:
        return sum(size for _, size in self._jobs)

    def _forget(self, ready: Callable[[bool], bool]) -> None:
        """Take jobs off the queue, oldest first, as long as they are ready; wait for those that are not done."""
        while self._jobs and ready(self._jobs[0][0].done()):
            future, _ = self._jobs.popleft()
            future.result()

    def _do(self, job: Callable[[], object]) -> None:
        if self._failed:
            return
        try:
            job()
        except BaseException:
            self._failed = True
            raise

    def wait(self) -> None:
        """Wait until all is done."""
        self._forget(lambda done: True)

    def finish(self) -> None:
        """Wait until all is done, and end the thread."""
        self.wait()
        self._thread.shutdown()

    def end(self, last: Callable[[], object]) -> None:
        """Leave out what is not begun, and do a last job; wait for it unless the disk is not waited for."""
        self._failed = True
        self._jobs.clear()
        self._thread.submit(last)
        self._thread.shutdown(wait=self._waits)
