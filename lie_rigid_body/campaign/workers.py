"""Processes that carry out the runs of a campaign: of this machine, or of a Dask cluster of the user's own."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from contextlib import closing
from functools import partial
from itertools import islice
from pathlib import Path
from threading import TIMEOUT_MAX
from typing import Final, TypeAlias

from lie_rigid_body.campaign.definition import Campaign
from lie_rigid_body.campaign.run import Row, carry_out, carry_out_elsewhere
from lie_rigid_body.foundation.errors import BagError, LieRigidBodyError
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.system.interpreters import Interpreter, Interpreters
from lie_rigid_body.system.output_file import write_file

Outcome: TypeAlias = tuple[int, Row | Exception]
"""The number of a run, and its row, or the error by which it has none."""

SUBMITTED: Final = 1000
"""Number of runs that a scheduler is given at once."""


def on_this_machine(
    campaign: Campaign, runs: Iterable[int], folder: Path, count: int, *, keep: bool
) -> Generator[Outcome]:
    """Outcomes of runs as they come, from interpreters on this machine.

    Parameters
    ----------
    campaign : Campaign
    runs : iterable of int
        Their numbers.
    folder : Path
        Folder of the campaign, with one for its bags.
    count : int
        Number of interpreters.
    keep : bool
        Whether the bags are kept.
    """

    def outcome(interpreter: Interpreter, run: int) -> Outcome:
        try:
            return run, interpreter.ask(partial(carry_out, campaign, run, folder, keep=keep), TIMEOUT_MAX)
        except LieRigidBodyError as error:
            return run, error
        except EOFError as error:  # as by a system that lacks memory
            return run, BagError(f"run {run} {error}: free some memory, or give fewer --workers")

    with closing(Interpreters(count)) as pool:
        yield from pool.completed(outcome, runs)


def on_a_cluster(
    campaign: Campaign, runs: Iterable[int], folder: Path, address: str, *, keep: bool
) -> Generator[Outcome]:
    """Outcomes of runs as they come, from the workers of a Dask cluster; bags come over the network.

    Parameters
    ----------
    campaign, runs, folder, keep
        As of `on_this_machine`.
    address : str
        Address of the scheduler.

    Raises
    ------
    BagError
        If no scheduler answers there, or no longer.
    """
    from distributed import CancelledError, Client, as_completed

    try:
        client = Client(address)
    except (OSError, ValueError) as error:
        raise BagError(
            f"no Dask scheduler answers at {shown(address)}: {error}: start one there, or give an address such as "
            "tcp://host:8786"
        ) from None
    waiting = iter(runs)
    with client:
        while some := [*islice(waiting, SUBMITTED)]:
            futures = client.map(partial(carry_out_elsewhere, campaign, keep=keep), some, pure=False)
            numbers = {future.key: run for future, run in zip(futures, some, strict=True)}
            try:
                for future, result in as_completed(futures, with_results=True, raise_errors=False):
                    run = numbers[future.key]
                    yield run, result[1] if future.status == "error" else _kept(result, folder)
                    future.release()
            except (CancelledError, OSError):
                raise BagError(f"the scheduler at {address} no longer answers: start one") from None


def _kept(result: tuple[Row, bytes], folder: Path) -> Row | BagError:
    """The row of a run whose bag is written into the folder of the campaign, or why that cannot be."""
    row, bag = result
    try:
        if row.bag is not None:
            write_file(folder / row.bag, bag, overwrite=True)
    except BagError as error:
        return error
    return row
