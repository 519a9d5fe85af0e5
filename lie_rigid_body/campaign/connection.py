"""The connection to a Dask scheduler: what arrives by it, whether there is a worker at all, and that it is lost."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

from lie_rigid_body.errors import BagError

if TYPE_CHECKING:
    from distributed import Client, as_completed

WITHOUT_RESULT_S: Final = 5.0
"""Time without a result, s, after which the scheduler is asked whether it has a worker."""
_ANSWER_S: Final = 5.0
"""Longest wait for its answer, s: a scheduler may have much to do."""
_LOOK_S: Final = 0.1
"""Time between two looks at whether the connection is lost, s, while no result comes."""


class SchedulerGoneError(BagError):
    """A scheduler no longer answers, and what was on its way is lost."""


class Connection:
    """A client's connection to its scheduler.

    Parameters
    ----------
    client : Client
    alone : callable, optional
        Is told the address of a scheduler that has no worker, once until it has one.
    """

    def __init__(self, client: Client, alone: Callable[[str], object] | None = None) -> None:
        self._client, self._alone = client, alone
        self._address, self._stream = client.scheduler.address, client.scheduler_comm
        self._was_alone = False

    @property
    def is_lost(self) -> bool:
        """Whether the connection is lost. The client may have made another, on which no earlier result arrives."""
        return self._client.scheduler_comm is not self._stream or bool(self._stream.closed())

    @contextmanager
    def needed(self) -> Iterator[None]:
        """A context that raises one error where the connection is lost: those of Dask are of many kinds.

        Raises
        ------
        SchedulerGoneError
        """
        from distributed import CancelledError
        from distributed.comm import CommClosedError

        try:
            yield
        except Exception as error:
            if self.is_lost or isinstance(error, CommClosedError | CancelledError):
                raise self._gone() from None
            raise

    def arriving(self, pool: as_completed) -> Iterator[tuple[Any, Any]]:
        """Futures of a pool and their results as they arrive.

        Dask's own iterator waits for ever for a result that was about to be sent when the scheduler went.

        Raises
        ------
        SchedulerGoneError
            When all that did arrive is yielded.
        """
        since = time.monotonic()
        while not pool.is_empty():
            if pool.has_ready():
                future, result = next(pool)
                if not (future.status == "cancelled" and self.is_lost):
                    self._was_alone = False
                    yield future, result
                    since = time.monotonic()
            elif self.is_lost:
                break
            elif self._alone is not None and time.monotonic() - since >= WITHOUT_RESULT_S:
                self._look_for_workers(self._alone)
                since = time.monotonic()
            else:
                with pool.thread_condition:
                    pool.thread_condition.wait(_LOOK_S)
        if self.is_lost:
            raise self._gone()

    def _look_for_workers(self, alone: Callable[[str], object]) -> None:
        from distributed import TimeoutError as Late

        with suppress(Late, OSError):
            is_alone = not self._client.nthreads(callback_timeout=_ANSWER_S)
            if is_alone and not self._was_alone:
                alone(self._address)
            self._was_alone = is_alone

    def _gone(self) -> SchedulerGoneError:
        return SchedulerGoneError(f"the scheduler at {self._address} no longer answers")
