"""The rows of a campaign that are finished, kept line by line so that an interruption loses none, and their table."""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path
from types import TracebackType
from typing import Any, Final

from lie_rigid_body import __version__
from lie_rigid_body.campaign.definition import Campaign
from lie_rigid_body.campaign.estimator import ERROR
from lie_rigid_body.campaign.run import BAGS, Row
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.scenario.parameter_table import PARAMETERS

JOURNAL: Final = "runs.jsonl"
"""The file of the rows, in the folder of a campaign: the campaign in the first line, a finished run in each other."""
TABLE: Final = "runs.parquet"
"""The table of all runs, written when the last is finished."""


class Journal:
    """The finished runs of a campaign in its folder. Use it as a context manager: only one process may hold it.

    Parameters
    ----------
    campaign : Campaign
    folder : Path
        Made if need be, in one that exists.

    Raises
    ------
    InputError
        If the folder holds another campaign, or other files.
    BagError
        If the folder cannot be used, or another process is at work there.
    """

    def __init__(self, campaign: Campaign, folder: Path) -> None:
        self.folder = folder
        self._heading = json.dumps({"campaign": json.loads(campaign.to_json()), "software": __version__})
        self.rows: dict[int, Row] = {}
        path = folder / JOURNAL
        try:
            _require_own(folder)
            folder.mkdir(exist_ok=True)
            (folder / BAGS).mkdir(exist_ok=True)
            self._file = path.open("a+", encoding="utf-8")
            self._lock()
            self._read()
        except OSError as error:
            raise BagError(f"{path} cannot be used: {error.strerror}: give another folder") from None

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise BagError(
                f"another process works on {self.folder}: wait for its end, or give another folder"
            ) from None

    def _read(self) -> None:
        self._file.seek(0)
        heading, *lines = self._file.read().split("\n")
        if not heading:
            self._write(self._heading)
            return
        if heading != self._heading:
            raise InputError(f"{self.folder} holds the runs of another campaign or version: give another folder")
        if lines and lines[-1]:  # a line that the end of the process cut off: that run is done anew
            self._file.truncate(self._file.tell() - len(lines[-1].encode()))
        for line in lines[:-1]:
            row = Row(**json.loads(line))
            self.rows[row.run] = row

    def add(self, row: Row) -> None:
        """Keep the row of a run that is finished."""
        self._write(json.dumps(row.to_dict()))
        self.rows[row.run] = row

    def _write(self, line: str) -> None:
        self._file.write(line + "\n")
        self._file.flush()

    def write_table(self) -> Path:
        """Write the table of all rows, in the order of their numbers, and return its path."""
        import pyarrow
        import pyarrow.parquet

        rows = [self.rows[run] for run in sorted(self.rows)]
        kinds: dict[str, Any] = {
            "double": pyarrow.float64(),
            "double_array": pyarrow.list_(pyarrow.float64()),
            "int": pyarrow.int64(),
            "string": pyarrow.string(),
            "bool": pyarrow.bool_(),
        }
        of_parameters = {parameter.name: kinds[parameter.kind] for parameter in PARAMETERS}
        columns = {"run": pyarrow.array([row.run for row in rows], pyarrow.int64())}
        for name in rows[0].parameters:
            columns[name] = pyarrow.array([row.parameters[name] for row in rows], of_parameters[name])
        columns["certified"] = pyarrow.array([row.certified for row in rows])
        accuracy = [row.attitude_accuracy_rad for row in rows]
        columns["attitude_accuracy_rad"] = pyarrow.array(accuracy, pyarrow.float64())
        columns["bag"] = pyarrow.array([row.bag for row in rows], pyarrow.string())
        for name in rows[0].scores:
            kind = kinds["string" if name == ERROR else "double"]
            columns[name] = pyarrow.array([row.scores[name] for row in rows], kind)
        path = self.folder / TABLE
        whole = path.with_suffix(".part")
        pyarrow.parquet.write_table(pyarrow.table(columns), whole)
        os.replace(whole, path)
        return path

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._file.close()


def _require_own(folder: Path) -> None:
    """Refuse a folder with anything in it but a campaign, and one in a folder that does not exist."""
    if not folder.parent.is_dir():
        raise BagError(
            f"{folder} cannot be created, because the folder {folder.parent} does not exist: make it, "
            "or give another one"
        )
    if folder.is_dir() and not (folder / JOURNAL).exists() and any(folder.iterdir()):
        raise InputError(f"{folder} holds other files and no campaign: give a new folder, or an empty one")
