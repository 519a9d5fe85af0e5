"""The runs of a campaign on the workers of a Dask cluster, of this machine or elsewhere."""

from __future__ import annotations

import gc
import logging
import os
import signal
import sys
import tempfile
import time
import warnings
from asyncio import TimeoutError as Late  # before Python 3.11 not the built-in one
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import partial
from itertools import islice
from multiprocessing import active_children, resource_tracker
from queue import Empty, SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING, Any, Final, TypeVar

from lie_rigid_body.campaign.definition import Campaign
from lie_rigid_body.campaign.run import BagFolder, Row, carry_out
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.wording import shortened, shown
from lie_rigid_body.system.interruption import Interruption
from lie_rigid_body.system.output_file import write_file
from lie_rigid_body.system.portable import cores, limit

if TYPE_CHECKING:
    from distributed import Client, LocalCluster, as_completed

_Closable = TypeVar("_Closable", bound="Client | LocalCluster")
RUNS_AHEAD: Final = 4
"""Number of runs that wait at each worker: none is idle, and few are lost at an interruption."""

MOST_FAILURES: Final = 20
"""Number of runs that may fail one after another, besides those under way, before no more are begun."""

LONGEST_CLUSTER_CLOSING_S: Final = 15.0
"""Longest wait for a cluster to close, s; Dask kills a worker that has not ended after 9."""

_FILES: Final = 24
"""Most files and connections that are open in the process that starts workers, besides those of each of them.

Measured with 1, 2, 4 and 6 workers: 32, 45, 69 and 93 in all. With fewer Dask may wait for itself.
"""
_FILES_OF_A_WORKER: Final = 13
"""Most files and connections that are open for a worker, in the process that starts it."""
_ANSWERING_S: Final = 10.0
"""Time that a scheduler of one's own has to answer, s, and as long again for the handshake."""

_DEAD: Final = "every process that tried it died"
"""Reason for which a run has no row."""

_QUIET: Final = {
    "distributed.logging.distributed": "critical",
    "distributed.admin.tick.limit": "1h",
    # nobody looks at what these collect, many times a second in every process
    "distributed.admin.tick.interval": "1s",
    "distributed.worker.profile.enabled": False,
    # pages that are given back at once and fetched again take as long as half of a run
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
}
"""Settings of Dask: no messages on stderr, little bookkeeping, and freed memory is kept."""

_MARK: Final = "LIE_RIGID_BODY_CLUSTER"
"""Variable of the environment that tells to which cluster a process belongs."""

WITHOUT_RESULT_S: Final = 5.0
"""Time without a result, s, after which the scheduler is asked whether it has a worker."""


_SAFE_PATH: Final = "PYTHONSAFEPATH", "lie_rigid_body"
"""Variable of the environment that keeps a Python from the modules of its working folder, and its value here."""


@contextmanager
def variable(name: str, value: str) -> Iterator[None]:
    """Context in which a variable of the environment has a value, which processes that begin in it inherit."""
    former = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        os.environ.pop(name, None)
        os.environ.update({} if former is None else {name: former})


def safe_path() -> AbstractContextManager[None]:
    """Context whose Python processes import nothing from their working folder, which may be somebody else's.

    Python 3.10 does not heed that.
    """
    name, value = _SAFE_PATH
    return variable(name, os.environ.get(name, value))


class SchedulerGoneError(BagError):
    """A scheduler no longer answers, and what was on its way is lost."""


class Connection:
    """A client's connection to its scheduler.

    Parameters
    ----------
    client : Client
    alone : callable, optional
        Is told the address of a scheduler that has no worker, once until it has one.

    Attributes
    ----------
    address : str
        That of the scheduler.
    """

    def __init__(self, client: Client, alone: Callable[[str], object] | None = None) -> None:
        self._client, self._alone = client, alone
        self.address, self._stream = client.scheduler.address, client.scheduler_comm
        self._was_alone = False

    @property
    def is_lost(self) -> bool:
        """Whether the connection is lost. The client may have made another, on which no earlier result arrives."""
        return self._client.scheduler_comm is not self._stream or bool(self._stream.closed())

    def arriving(self, pool: as_completed) -> Iterator[tuple[Any, Any]]:
        """Futures of a pool and their results as they arrive.

        Dask's own iterator waits for ever for a result that was about to be sent when the scheduler went.

        Raises
        ------
        ConnectionError
            If it is lost, when all that did arrive is yielded.
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
                    pool.thread_condition.wait(0.1)  # s, between two looks at whether the connection is lost
        if self.is_lost:
            raise ConnectionError

    def _look_for_workers(self, alone: Callable[[str], object]) -> None:
        with suppress(Late, OSError):
            is_alone = not self._client.nthreads(callback_timeout=5.0)  # s, as a scheduler may have much to do
            if is_alone and not self._was_alone:
                alone(self.address)
            self._was_alone = is_alone


def require_address(scheduler: str) -> None:
    """Refuse what is no address of a scheduler, before anything is made for it.

    Raises
    ------
    InputError
    """
    from distributed.comm import get_address_host_port

    try:
        host, port = get_address_host_port(scheduler)
    except ValueError:
        host, port = "", 0
    if not (host and 0 < port <= 65535):
        raise InputError(
            f"--scheduler {shown(scheduler)} is not the address of a Dask scheduler: give protocol, host and port, "
            "such as tls://host:8786"
        )


def is_open(scheduler: str) -> bool:
    """Whether an address is of TCP without TLS, which asks nobody for a certificate."""
    return scheduler.partition("://")[0] in ("tcp", "ws", scheduler)


@contextmanager
def client_of(workers: int | None, scheduler: str | None) -> Iterator[Client]:
    """A client of a Dask cluster: of the one at an address, or of one of processes on this machine while it lasts.

    Parameters
    ----------
    workers : int, optional
        Processes of one thread each; as many as cores by default.
    scheduler : str, optional
        Address of the scheduler of a cluster that runs already; one of TLS takes the certificates that Dask's own
        configuration names.

    Raises
    ------
    BagError
        If there is no scheduler at the address.
    """
    import dask
    from distributed import Client

    # lost connections are said in the rows; each logger is silenced by itself, as Dask gives each a level of its own
    for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    dask.config.set(_QUIET)
    if scheduler is not None:
        with _closed_in_time(_client_at(scheduler)) as connected:
            yield connected
        return
    others = active_children()
    with safe_path(), ThreadPoolExecutor(1, initializer=_deafen) as thread:  # before the mark
        thread.submit(resource_tracker.ensure_running).result()
    warnings.filterwarnings("ignore", "resource_tracker")  # where somebody kills it, another one takes its place
    # neither half of a cluster nor one that closes may be interrupted
    with (
        Interruption.current().noted() as interruption,
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as own,
        variable(_MARK, own),  # of all processes that begin here
        variable("TMPDIR", own),  # what they leave there goes with it
        safe_path(),
    ):
        try:
            with (
                _closed_in_time(_own_cluster(workers or cores(), own)) as cluster,
                _closed_in_time(Client(cluster)) as client,
                interruption.allowed(),
            ):
                try:
                    yield client
                finally:
                    _end_what_is_left(own)  # it may hold a worker's connections, whose end would be waited for
        finally:
            sys.path[:] = [place for place in sys.path if not place.startswith(own)]  # which is free for others now
            _end_what_is_left(own)
            for process in {*active_children()}.difference(others):  # there is none, unless the cluster was too late
                process.kill()


def _client_at(scheduler: str) -> Client:
    """A client of a scheduler that answers in time.

    It is made in a thread, which waits without an end where something else answers at the address.

    Raises
    ------
    BagError
        If none does.
    """
    from distributed import Client

    made = SimpleQueue[Client | str]()

    def make() -> None:
        try:
            made.put(Client(scheduler, timeout=_ANSWERING_S))
        except Exception as error:  # of the network, of TLS without a certificate, of a name that cannot be
            told = str(error) or type(error).__name__
        else:
            return
        gc.collect()  # the failed client; where that is collected while another one starts, Dask waits for itself
        made.put(told)

    Thread(target=make, daemon=True).start()
    try:
        found = made.get(timeout=2.0 * _ANSWERING_S)
    except Empty:
        found = f"nothing came within {2.0 * _ANSWERING_S:g} s"
    if isinstance(found, str):
        keys = ", or name its certificates in Dask's tls.yaml" if scheduler.startswith(("tls:", "wss:")) else ""
        raise BagError(
            f"no Dask scheduler answers at {shown(scheduler)}: {shortened(found, 50 if keys else 90)}: "
            f"start one there{keys}"
        )
    return found


def _own_cluster(workers: int, folder: str) -> LocalCluster:
    """A cluster of processes of this machine, which only one with the keys of this process can reach.

    A thread that ignores Ctrl-C starts the cluster, so that all its threads and processes ignore it too.

    Raises
    ------
    BagError
        If a limit of this machine keeps it from starting.
    """
    import dask
    from distributed import LocalCluster, Security

    files, least = limit("RLIMIT_NOFILE"), _FILES + _FILES_OF_A_WORKER * workers
    if files < least:
        raise BagError(f"open files are limited to {files:g} (ulimit -n): allow {least} at least, or fewer workers")
    settings: dict[str, object] = {
        # scheduler and workers cannot be kept from listening for HTTP, by which everybody may ask, without TLS
        "distributed.scheduler.http.routes": [],
        "distributed.worker.http.routes": [],
        # of the scheduler too, which puts its folder onto the path of modules: the default is one that all users share
        "temporary-directory": folder,
    }
    with dask.config.set(settings), ThreadPoolExecutor(1, initializer=_deafen) as thread:
        begun = thread.submit(
            LocalCluster,
            n_workers=workers,
            threads_per_worker=1,
            security=Security.temporary(),
            memory_limit=0,
            dashboard_address="127.0.0.1:0",  # whichever port is free; nothing is shown there
            scheduler_kwargs={"dashboard": False},
            silence_logs=logging.CRITICAL,
        )
        try:
            return begun.result()
        except (OSError, RuntimeError) as error:
            if Interruption.current().requested:  # by a signal to all processes of a group
                raise KeyboardInterrupt from None
            raise BagError(
                f"no workers start here: {shortened(str(error).rstrip('.'), 90)}: allow more open files, memory and "
                "disk space"
            ) from None


def _deafen() -> None:
    """Block what a terminal sends to all of its processes, in this thread, where a system has masks of signals."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})


def _end_what_is_left(mark: str) -> None:
    """Kill what estimators began and left: the processes with a mark that are no workers."""
    import psutil

    own = {os.getpid(), *(child.pid for child in active_children())}
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            if process.pid not in own and process.environ().get(_MARK) == mark:
                process.kill()


@contextmanager
def _closed_in_time(what: _Closable) -> Iterator[_Closable]:
    """A context at whose end a client or a cluster is closed, within `LONGEST_CLUSTER_CLOSING_S`."""
    try:
        yield what
    finally:
        with suppress(Late), Interruption.current().noted():
            what.close(timeout=LONGEST_CLUSTER_CLOSING_S)


def finished(
    client: Client,
    campaign: Campaign,
    runs: Iterable[int],
    folder: BagFolder,
    *,
    bags: bool,
    elsewhere: bool,
    alone: Callable[[str], object],
) -> Iterator[tuple[int, Row | BaseException]]:
    """Carry out runs, and yield their numbers and rows as they are finished, in any order.

    Parameters
    ----------
    client : Client
    campaign : Campaign
    runs : iterable of int
        Their numbers.
    folder : BagFolder
    bags : bool
        Whether the bags are kept.
    elsewhere : bool
        Whether workers may be on machines that do not see the folder: then each bag comes over the network.
    alone : callable
        Is told the address of a scheduler elsewhere that has no worker, once until it has one.

    Yields
    ------
    int
    Row or BaseException
        The latter is what the run failed of, where it has no row, such as the death of every worker that Dask gave it
        to. No more are begun after `MOST_FAILURES` in a row.

    Raises
    ------
    SchedulerGoneError
        If the scheduler no longer answers; all that came from it is yielded before.
    """
    from distributed import KilledWorker, as_completed
    from distributed.comm import CommClosedError

    waiting, numbers, in_a_row = iter(runs), dict[str, int](), 0
    do = partial(carry_out, campaign, folder=None if elsewhere else folder, keep=bags)

    def submitted(some: list[int]) -> Any:
        """Runs on their way, together, as each way takes Dask milliseconds."""
        futures = client.map(do, some, pure=False) if some else []
        numbers.update((future.key, run) for future, run in zip(futures, some, strict=True))
        return futures

    def outcome(future: Any, result: Any) -> tuple[int, Any]:
        """The number of a run and what came of it, which is kept here and forgotten elsewhere."""
        found = result[1] if future.status == "error" else _kept(result, folder)
        future.release()
        return numbers.pop(future.key), BagError(_DEAD) if isinstance(found, KilledWorker) else found

    connection = Connection(client, alone if elsewhere else None)
    try:
        at_once = RUNS_AHEAD * max(1, len(client.nthreads()))
        pool = as_completed(submitted([*islice(waiting, at_once)]), with_results=True, raise_errors=False)
        for count, arrived in enumerate(connection.arriving(pool), 1):
            if count % (at_once // 2) == 0 and not connection.is_lost:
                pool.update(submitted([*islice(waiting, at_once // 2)]))
            run, found = outcome(*arrived)
            in_a_row = in_a_row + 1 if isinstance(found, BaseException) else 0
            yield run, found
            if in_a_row == MOST_FAILURES + at_once:
                return
    except Exception as error:  # those of Dask are of many kinds
        if connection.is_lost or isinstance(error, CommClosedError | CancelledError):
            raise SchedulerGoneError(f"the scheduler at {connection.address} no longer answers") from None
        raise


def _kept(result: tuple[Row, bytes | None], folder: BagFolder) -> Row | BagError:
    """The row of a run, with its bag, which came over the network, in the folder; or why that cannot be written."""
    row, content = result
    if row.bag is not None and content is not None:
        try:
            write_file(folder.path_of(row.run), content, overwrite=True)
        except BagError as error:
            return error
    return row
