"""The verdicts on many bags, found by parallel processes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import wait as wait_for
from typing import Final

from lie_rigid_body import console
from lie_rigid_body.certificate import certify
from lie_rigid_body.errors import BagError, LieRigidBodyError
from lie_rigid_body.interruption import ENDING, Interruption
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.report.overview import Verdict
from lie_rigid_body.system import cores

_KILLED: Final = "the process that read it was killed, perhaps for its memory: free some, and check it alone"

Judge = Callable[[str], list[Verdict]]


def judge(inertia: Sequence[float] | None, topics: Mapping[str, str], bag: str) -> list[Verdict]:
    """Judge all bodies of a bag; whatever is wrong with the bag is its verdict."""
    try:
        return judge_bodies(bag, Bag.all_of(bag, lambda count: None, topics), inertia)
    except Exception as error:
        return [_unusable(bag, None, error)]


def judge_bodies(
    bag: str, bodies: Mapping[str, Bag | BagError], inertia: Sequence[float] | None = None
) -> list[Verdict]:
    """Judge the bodies of a bag, as `Bag.all_of` finds them; what is wrong with one is its verdict."""
    return [_of_body(bag, name if len(bodies) > 1 else None, found, inertia) for name, found in bodies.items()]


def _of_body(bag: str, body: str | None, found: Bag | BagError, inertia: Sequence[float] | None) -> Verdict:
    try:
        if isinstance(found, BagError):
            raise found
        return Verdict(bag, body, certify(found, inertia))
    except Exception as error:
        return _unusable(bag, body, error)


def _unusable(bag: str, body: str | None, error: Exception) -> Verdict:
    if os.environ.get(console.DEBUG):
        traceback.print_exc()
    reason = console.explanation(error)
    return Verdict(bag, body, None, reason if isinstance(error, LieRigidBodyError) else f"{bag}: {reason}")


def judge_all(
    bags: Sequence[str], inertia: Sequence[float] | None = None, topics: Mapping[str, str] | None = None
) -> list[Verdict]:
    """Judge bags by as many processes as there are cores; the verdicts come in the order of the bags.

    Parameters
    ----------
    bags : sequence of str
    inertia : sequence of float, optional
        To be used in place of the declared one, kg m².
    topics : mapping of str to str, optional
        Topics that are called otherwise, by their relative names.
    """
    one = partial(judge, inertia, topics or {})
    with Interruption() as interruption:
        found = _by_processes(one, bags, cores(), interruption)
        for i, verdicts in enumerate(found):
            if verdicts is None:  # a process that died took others with it: each again, in a process of its own
                (again,) = _by_processes(one, [bags[i]], 1, interruption)
                found[i] = again or [Verdict(bags[i], None, None, f"{bags[i]}: {_KILLED}")]
    return [verdict for verdicts in found for verdict in verdicts or []]


def _by_processes(one: Judge, bags: Sequence[str], most: int, interruption: Interruption) -> list[list[Verdict] | None]:
    """Verdicts on each bag by so many processes at most; None for a bag whose process died."""
    context = multiprocessing.get_context()
    with _pool(ProcessPoolExecutor(min(most, len(bags)), context, _begin)) as pool:
        futures = [pool.submit(one, bag) for bag in bags]
        with interruption.allowed():  # not before: what a fork calls would swallow a KeyboardInterrupt
            for _ in console.progress(as_completed(futures), total=len(bags), unit=" bags"):
                pass
        return [None if isinstance(future.exception(), BrokenProcessPool) else future.result() for future in futures]


@contextmanager
def _pool(pool: ProcessPoolExecutor) -> Iterator[ProcessPoolExecutor]:
    """A context after which the processes of a pool have ended, at once if it is left by an exception."""
    others = set(multiprocessing.active_children())
    try:
        yield pool
    except BaseException:
        for process in set(multiprocessing.active_children()) - others:
            process.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _begin() -> None:
    """Begin a process that leaves Ctrl-C, and a terminal that closes, to its parent, and ends with it."""
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=lambda: (wait_for([parent.sentinel]), os._exit(1)), daemon=True).start()
