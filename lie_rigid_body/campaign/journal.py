"""The rows of a campaign that are finished, kept line by line so that an interruption loses none, and their table."""

from __future__ import annotations

import json
import math
import os
from array import array
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, suppress
from itertools import islice
from pathlib import Path
from typing import Any, Final

from lie_rigid_body import __version__
from lie_rigid_body.campaign.definition import OF_TABLE, SCORES_TABLE, TABLE, Campaign
from lie_rigid_body.campaign.run import BAGS, ERROR, MORE_SCORES, SCORES, BagFolder, Judgement, Row, bag_name
from lie_rigid_body.foundation.arrays import NOT_NUMBERS
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.scenario.parameter_table import BY_NAME
from lie_rigid_body.system.bounded_input import LONGEST_ROW, load_json, open_file
from lie_rigid_body.system.output_file import NO_ROOM, remedy, written
from lie_rigid_body.system.portable import is_others, lock, open_itself

JOURNAL: Final = "runs.jsonl"
"""File of the rows in the folder of a campaign: JSON, the campaign in the first line, a finished run in each other."""
RESUMED: Final = "the same command does the rest"
"""Remedy at the end of a line about a campaign that is not finished."""
_NONE: Final = -1
"""Place of a row that is not in the file."""
_SCORES: Final = {**dict.fromkeys(SCORES, "double"), ERROR: "string"}


class Journal(AbstractContextManager["Journal"]):
    """The finished runs of a campaign in its folder. Use it as a context manager: only one process may hold it.

    The rows stay in their file, and are read again when they are wanted: a million would take gigabytes.

    Parameters
    ----------
    campaign : Campaign
    folder : Path
        Made if need be, in one that exists.

    Attributes
    ----------
    bags : BagFolder

    Raises
    ------
    InputError
        If the folder holds another campaign, or other files.
    BagError
        If the folder cannot be used, or another process is at work there.
    """

    def __init__(self, campaign: Campaign, folder: Path) -> None:
        self.folder, self.path = folder, folder / JOURNAL
        self._heading = _heading(campaign)
        self._places = array("q", [_NONE]) * campaign.runs
        self._campaign = campaign
        if self.path.exists() and not self.path.is_file():  # of a pipe nothing would ever come
            raise BagError(f"{self.path} is no regular file: move it away, or give another folder")
        try:
            _require_own(folder)
            folder.mkdir(exist_ok=True)
            with ExitStack() as parts:
                # before all else, as a kill then leaves a campaign
                self._file = parts.enter_context(open(self.path, "a+b", opener=open_itself))
                parts.enter_context(lock(self._file))
                if is_others(state := os.fstat(self._file.fileno())) and state.st_size:
                    raise BagError(f"{self.path} is another user's: give a new folder")
                (folder / BAGS).mkdir(exist_ok=True)
                self.bags = BagFolder.of(folder.absolute())
                self._read()
                self._open = parts.pop_all()
        except FileExistsError as error:
            raise BagError(f"{error.filename} is no folder: move it away, or give another folder") from None
        except BlockingIOError:
            raise BagError(f"another process works on {folder}: wait for its end, or give another folder") from None
        except OSError as error:
            if error.errno in NO_ROOM:
                raise self._unwritten(error) from None
            raise BagError(
                f"{error.filename or self.path} cannot be used: {error.strerror}: give another folder"
            ) from None

    @classmethod
    def is_begun(cls, campaign: Campaign, folder: Path) -> bool:
        """Whether a folder holds runs of this campaign, whose scenarios were then found to be possible."""
        try:
            with open_file(folder / JOURNAL) as file:
                return _equal(file.readline(LONGEST_ROW), _heading(campaign))
        except (InputError, OSError):
            return False

    def _read(self) -> None:
        self._file.seek(0)
        first = self._file.readline(LONGEST_ROW)
        if not _equal(first, self._heading):
            if first and not self._is_bare(first):
                raise InputError(f"{self.folder} holds the runs of another campaign or version: give another folder")
            self._file.truncate(0)
            self._write(self._heading)
            return
        self._heading = first  # as it was written, so that the table has the same bytes whoever ends it
        place = len(first)
        while line := self._file.readline(LONGEST_ROW):
            if not line.endswith(b"\n") and len(line) < LONGEST_ROW:  # its process ended in it: that run is done anew
                self._file.truncate(place)
                break
            self._places[self._row(line, place).run] = place
            place += len(line)

    def _is_bare(self, first: bytes) -> bool:
        """Whether a campaign was begun here, and ended before it had a run, as where there was no scheduler.

        It may have ended within its first line, where the disk was full.
        """
        try:
            begun = (
                {"campaign", "software"} == {*load_json(first, JOURNAL)}
                if first.endswith(b"\n")
                else self._heading.startswith(first)
            )
        except (TypeError, ValueError):
            return False
        return begun and not self._file.read(1) and not any((self.folder / BAGS).iterdir())

    def _row(self, line: bytes, place: int) -> Row:
        with suppress(*NOT_NUMBERS):
            row = Row(**load_json(line, JOURNAL))
            if self._is_own(row):
                return row
        raise BagError(f"{self.path} is damaged: byte {place} begins no row of this campaign: delete that line")

    def _is_own(self, row: Row) -> bool:
        """Whether a row that was read is one of this campaign, with a bag in this folder."""
        kinds = (int, bool, float, dict, dict, list)
        fields = (row.run, row.certified, row.attitude_accuracy_rad, row.parameters, row.residuals, row.judgements)
        if [*map(type, fields)] != [*kinds] or row.parameters.keys() != self._campaign.vary.keys():
            return False
        for name, value in row.parameters.items():
            BY_NAME[name].read(value)
        for judgement in row.judgements:
            Judgement.read(judgement)
        return (
            0 <= row.run < len(self._places)
            and (not row.certified or 0.0 <= row.attitude_accuracy_rad < math.inf)
            and row.bag in (None, bag_name(row.run))
            and len(row.judgements) == len(self._campaign.entries)
            and all([*map(type, worst_and_limit)] == [float, float] for worst_and_limit in row.residuals.values())
        )

    def __len__(self) -> int:
        return len(self._places) - self._places.count(_NONE)

    def __contains__(self, run: int) -> bool:
        return self._places[run] != _NONE

    def forget(self, run: int) -> None:
        """Count a finished run as one that is still to be done; its row stays in the file until there is another."""
        self._places[run] = _NONE

    def rows(self) -> Iterator[Row]:
        """The rows of the finished runs in the order of their numbers."""
        for place in (place for place in self._places if place != _NONE):
            try:
                self._file.seek(place)
                line = self._file.readline()
            except OSError as error:
                raise BagError(f"{self.path} cannot be read: {error.strerror}: copy it to a better place") from None
            yield self._row(line, place)

    def add(self, row: Row) -> None:
        """Keep the row of a run that is finished.

        Raises
        ------
        BagError
            If the file cannot be written, or is no longer there.
        """
        self.require_intact()
        place = self._file.seek(0, os.SEEK_END)
        self._write(f"{json.dumps(vars(row))}\n".encode())
        self._places[row.run] = place

    def _unwritten(self, error: OSError) -> BagError:
        return BagError(f"{self.path} cannot be written: {error.strerror}: {remedy(error)}, and {RESUMED}")

    def _write(self, line: bytes) -> None:
        try:
            self._file.write(line)
            self._file.flush()
        except OSError as error:
            raise self._unwritten(error) from None

    def require_intact(self) -> None:
        """Check that the file is still there under its name: else rows and bags are kept for nobody.

        Raises
        ------
        BagError
        """
        with suppress(OSError):
            if os.path.samestat(self.path.stat(), os.fstat(self._file.fileno())):
                return
        raise BagError(f"{self.path} was deleted or moved meanwhile: keep others away, and begin anew")

    def write_table(self) -> Path:
        """Write the table of all rows, in the order of their numbers, and that of the scores where estimators compare.

        Returns
        -------
        Path
            Of the first.

        Raises
        ------
        BagError
            If one cannot be written.
        """
        kinds = {
            "run": "int",
            **{name: BY_NAME[name].kind for name in next(self.rows()).parameters},
            "certified": "bool",
            "attitude_accuracy_rad": "double",
            "bag": "string",
            **(_SCORES if self._campaign.estimator else {}),
        }
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            raise self._unwritten(error) from None
        if self._campaign.estimators:
            more = {
                "run": "int",
                "estimator": "string",
                "parameters": "string",
                **_SCORES,
                **dict.fromkeys(MORE_SCORES, "double"),
            }
            cells = (
                {
                    "run": row.run,
                    "estimator": entry.name,
                    "parameters": json.dumps(entry.parameters, sort_keys=True, ensure_ascii=False),
                    **judgement["scores"],
                }
                for row in self.rows()
                for entry, judgement in zip(self._campaign.entries, row.judgements, strict=True)
            )
            self._write_parquet(SCORES_TABLE, more, cells)
        cells = (
            {**vars(row), **row.parameters, **(row.judgements[0]["scores"] if row.judgements else {})}
            for row in self.rows()
        )
        return self._write_parquet(TABLE, kinds, cells)

    def _write_parquet(self, name: str, kinds: Mapping[str, str], rows: Iterator[dict[str, Any]]) -> Path:
        """Write a table of rows, of whose cells it takes those in its columns, which have the kinds of parameters."""
        import pyarrow.parquet

        types: dict[str, Any] = {
            "double": pyarrow.float64(),
            "double_array": pyarrow.list_(pyarrow.float64()),
            "int": pyarrow.int64(),
            "string": pyarrow.string(),
            "bool": pyarrow.bool_(),
        }
        schema = pyarrow.schema([(column, types[kind]) for column, kind in kinds.items()])
        schema, path = schema.with_metadata({OF_TABLE: self._heading.strip()}), self.folder / name
        try:
            with written(path, overwrite=True) as stream, pyarrow.parquet.ParquetWriter(stream, schema) as writer:
                while some := list(islice(rows, 10_000)):  # so many are in memory together
                    writer.write_table(pyarrow.Table.from_pylist(some, schema))
        except BagError as error:
            raise BagError(f"{error}; {RESUMED}") from None
        return path

    def __exit__(self, *of_an_error: object) -> None:
        with suppress(OSError):  # what could not be written cannot be now
            self._open.close()


def _heading(campaign: Campaign) -> bytes:
    return f"{json.dumps({'campaign': json.loads(campaign.to_json()), 'software': __version__})}\n".encode()


def _equal(heading: bytes, other: bytes) -> bool:
    """Whether two headings say the same, however their numbers are written: 5 or 5.0."""
    try:
        return heading == other or (heading.endswith(b"\n") and _canonical(heading) == _canonical(other))
    except (ValueError, RecursionError):
        return False


def _canonical(heading: bytes) -> str:
    """A heading in which equal numbers are equal text; a negative zero, whose sign is kept in a run, is another."""

    def number(text: str) -> int | float:
        value = float(text)
        return int(value) if value.is_integer() and str(value) != "-0.0" else value

    return json.dumps(json.loads(heading, parse_float=number))


def _require_own(folder: Path) -> None:
    """Refuse a folder with anything in it but a campaign, and one in a folder that does not exist."""
    if not folder.parent.is_dir():
        raise BagError(
            f"{folder} cannot be created, because the folder {folder.parent} does not exist: make it, "
            "or give another one"
        )
    if folder.is_dir() and not (folder / JOURNAL).exists() and any(folder.iterdir()):
        raise InputError(f"{folder} holds other files and no campaign: give a new folder, or an empty one")
    # what is written to a link would replace a file elsewhere
    if links := [path for path in (*folder.glob("*"), *(folder / BAGS).glob("*")) if path.is_symlink()]:
        raise InputError(f"{links[0]} is a link: a campaign writes files of its own alone: move it away")
