"""Finished runs of a campaign, a row file each, and the tables of all."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from itertools import islice
from pathlib import Path
from typing import Any, Final

from lie_rigid_body import __version__
from lie_rigid_body.campaign.definition import OF_TABLE, SCORES_TABLE, TABLE, Campaign
from lie_rigid_body.campaign.run import BAGS, ERROR, MORE_SCORES, SCORES, Row
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.scenario.parameter_table import BY_NAME
from lie_rigid_body.system.interruption import Interruption
from lie_rigid_body.system.output_file import reason, write_file, written
from lie_rigid_body.system.portable import locked

DEFINITION: Final = "campaign.json"
"""File, in the folder of a campaign, of what the campaign file said, and of the version that draws the runs."""
ROWS: Final = "runs"
"""Folder, in that of a campaign, with a file of JSON for each finished run."""
RESUMED: Final = "the same command does the rest"
"""Remedy at the end of a line about a campaign that is not finished."""
_SCORES: Final = {**dict.fromkeys(SCORES, "double"), ERROR: "string"}


class Results:
    """Rows of the finished runs of a campaign, in its folder.

    They stay in their files, and are read again when they are wanted: a million would take gigabytes. No other process
    works in the folder until `held` is closed.

    Parameters
    ----------
    campaign : Campaign
    folder : Path
        Made if need be, in one that exists.

    Attributes
    ----------
    finished : set of int
        Numbers of the runs that are finished.
    held : ExitStack
        Keeps other processes out of the folder until it is closed.

    Raises
    ------
    InputError
        If the folder holds the runs of another campaign, or other files.
    BagError
        If the folder cannot be used, or another process works in it.
    """

    def __init__(self, campaign: Campaign, folder: Path) -> None:
        self.folder = folder
        self._campaign = campaign
        self._definition = _definition_of(campaign)
        if not folder.parent.is_dir():
            raise BagError(
                f"{folder} cannot be created, because the folder {folder.parent} does not exist: make it, "
                "or give another one"
            )
        with ExitStack() as held:
            try:
                folder.mkdir(exist_ok=True)
                held.enter_context(locked(folder))
                self._begin()
            except BlockingIOError:
                raise BagError(f"another process works in {folder}: wait for its end, or give another folder") from None
            except OSError as error:
                raise BagError(
                    f"{error.filename or folder} cannot be used as a folder: {reason(error)}: give another one"
                ) from None
            self.held = held.pop_all()

    def _begin(self) -> None:
        begun = _read_definition(self.folder)
        if begun is None and any(self.folder.iterdir()):
            raise InputError(f"{self.folder} holds other files and no campaign: give a new folder, or an empty one")
        stems = (path.stem for path in (self.folder / ROWS).glob("*.json"))
        self.finished = {int(stem) for stem in stems if stem.isdecimal() and int(stem) < self._campaign.runs}
        if begun == self._definition:
            self._definition = begun  # as it was written, so that the tables have the same bytes whoever ends it
        elif self.finished:
            raise InputError(f"{self.folder} holds the runs of another campaign or version: give another folder")
        else:
            write_file(self.folder / DEFINITION, _json(self._definition), overwrite=True)
        for name in (BAGS, ROWS):
            (self.folder / name).mkdir(exist_ok=True)

    @classmethod
    def is_begun(cls, campaign: Campaign, folder: Path) -> bool:
        """Whether a folder is that of this campaign, whose scenarios were then found to be possible."""
        return _read_definition(folder) == _definition_of(campaign)

    def __len__(self) -> int:
        return len(self.finished)

    def _path(self, run: int) -> Path:
        return self.folder / ROWS / f"{run:06d}.json"

    def rows(self) -> Iterator[Row]:
        """The rows of the finished runs in the order of their numbers."""
        for run in sorted(self.finished):
            path = self._path(run)
            try:
                yield Row(**json.loads(path.read_bytes()))
            except OSError as error:
                raise BagError(f"{path} cannot be read: {reason(error)}: delete it, and {RESUMED}") from None
            except (TypeError, ValueError):
                raise BagError(f"{path} is damaged: delete it, and {RESUMED}") from None

    def add(self, row: Row) -> None:
        """Keep the row of a run that is finished.

        Raises
        ------
        BagError
            If its file cannot be written.
        """
        with Interruption.current().noted() as interruption:  # a row that is written counts
            try:
                write_file(self._path(row.run), _json(vars(row)), overwrite=True)
            except BagError as error:
                raise BagError(f"{error}; {RESUMED}") from None
            self.finished.add(row.run)
        interruption.heed()

    def forget_without_bags(self) -> list[int]:
        """Count finished runs that lack their bags, or have others, as unfinished, and return their numbers."""
        lacking = [row.run for row in self.rows() if not row.has_bag(self.folder)]
        self.finished.difference_update(lacking)
        return lacking

    def remove_parts(self) -> None:
        """Remove the bags of runs that are not finished and the parts of files, left by processes that were killed."""
        for path in (self.folder / BAGS).glob("*.mcap"):
            if path.is_file() and path.stem.isdecimal() and int(path.stem) not in self.finished:
                path.unlink()
        for path in self.folder.glob("*/.*.part"):
            path.unlink()

    def write_table(self) -> Path:
        """Write the table of all rows, in the order of their numbers, and that of the scores where estimators compare.

        Returns
        -------
        Path
            Path of the first.

        Raises
        ------
        BagError
            If one cannot be written.
        """
        if self._campaign.estimators:
            kinds = {"run": "int", "estimator": "string", "parameters": "string"}
            self._write_parquet(
                SCORES_TABLE, {**kinds, **_SCORES, **dict.fromkeys(MORE_SCORES, "double")}, self._score_cells()
            )
        kinds = {
            "run": "int",
            **{name: BY_NAME[name].kind for name in self._campaign.vary},
            "certified": "bool",
            "attitude_accuracy_rad": "double",
            "bag": "string",
            **(_SCORES if self._campaign.estimator else {}),
        }
        cells = (
            {**vars(row), **row.parameters, **(row.run_scores[0]["scores"] if row.run_scores else {})}
            for row in self.rows()
        )
        return self._write_parquet(TABLE, kinds, cells)

    def _score_cells(self) -> Iterator[dict[str, Any]]:
        for row in self.rows():
            for entry, run_score in zip(self._campaign.entries, row.run_scores, strict=True):
                parameters = json.dumps(entry.parameters, sort_keys=True, ensure_ascii=False)
                yield {"run": row.run, "estimator": entry.name, "parameters": parameters, **run_score["scores"]}

    def _write_parquet(self, name: str, kinds: Mapping[str, str], rows: Iterator[dict[str, Any]]) -> Path:
        """Write a table of rows, of whose cells it takes those in its columns, which have the kinds of parameters."""
        import pyarrow.parquet

        types = {
            "double": pyarrow.float64(),
            "double_array": pyarrow.list_(pyarrow.float64()),
            "int": pyarrow.int64(),
            "string": pyarrow.string(),
            "bool": pyarrow.bool_(),
        }
        schema = pyarrow.schema([(column, types[kind]) for column, kind in kinds.items()])
        schema = schema.with_metadata({OF_TABLE: _json(self._definition)})
        path = self.folder / name
        with written(path, overwrite=True) as stream, pyarrow.parquet.ParquetWriter(stream, schema) as writer:
            while some := list(islice(rows, 10_000)):  # so many are in memory together
                writer.write_table(pyarrow.Table.from_pylist(some, schema))
        return path


def _definition_of(campaign: Campaign) -> dict[str, Any]:
    return {"campaign": json.loads(campaign.to_json()), "software": __version__}


def _read_definition(folder: Path) -> dict[str, Any] | None:
    """Content of the definition in a folder, None where there is none; 5 and 5.0 are equal in it."""
    try:
        found: dict[str, Any] = json.loads((folder / DEFINITION).read_bytes())
    except (OSError, ValueError):
        return None
    return found


def _json(content: Mapping[str, Any]) -> bytes:
    return json.dumps(content).encode()
