"""Tables in text files: the dialect of CSV, the header, and the rows, whose cells stay texts."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from itertools import islice
from typing import Final, TypeVar

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import shortened
from lie_rigid_body.recording.logs.headings import LAYOUTS, Heading, heading, sensor_of
from lie_rigid_body.recording.logs.sources import TextSource, lines_of
from lie_rigid_body.recording.logs.times import first_times

T = TypeVar("T")

_MIN_CELLS: Final = 4
"""Cells of the smallest table: a time and three axes."""
_COMMENTS: Final = ("#", "%", "//", "sep=")
"""Beginnings of lines that are no rows; a header may stand behind the first two."""
_LONG: Final = ["Attribute", "Time stamp", "x", "y", "z"]
"""Columns of a table whose rows name their sensor, where no header does."""


@short_dataclass
class TextTable:
    """The header of a table, and how to read its rows.

    Attributes
    ----------
    source : Path
        A file, or a member of a zip.
    separator : str
    headings : list of Heading
        Those of its columns; without a header they have no words.
    skipped : int
        Lines before its first row.
    words : tuple of str
        Words of the file's name, or of the sensor that its rows name.
    """

    source: TextSource
    separator: str
    headings: list[Heading]
    skipped: int
    words: tuple[str, ...]

    @property
    def program(self) -> tuple[str, Mapping[str, str]]:
        """The program that is known to write such a table, and its units."""
        return next((LAYOUTS[head.words] for head in self.headings if head.words in LAYOUTS), ("", {}))

    def rows(self, read: Callable[[list[str]], T]) -> Iterator[T]:
        """Read each row that is neither blank nor a comment by a function of its cells.

        Raises
        ------
        InputError
            If a row has not as many cells as the header, or the function raises a ValueError.
        """
        width = len(self.headings)
        lines = islice(lines_of(self.source), self.skipped, None)
        rows = csv.reader(lines, delimiter=self.separator, skipinitialspace=True)
        try:
            for cells in rows:
                if any(cells) and not cells[0].startswith(_COMMENTS):
                    if len(cells) < width or any(cells[width:]):
                        raise ValueError(f"{len(cells)} cells, where the header has {width}")
                    yield read(cells)
        except InputError:
            raise
        except (csv.Error, ValueError) as error:
            where = f"{self.source}, line {self.skipped + rows.line_num}"
            raise InputError(f"{where}: {shortened(f'{error}')}: correct the row or remove it") from None


def read_table(source: TextSource) -> TextTable | None:
    """The table in a text file; None where it has no row.

    Raises
    ------
    InputError
        If it cannot be read, or is no text.
    """
    header = ""
    for number, line in enumerate(lines_of(source)):
        separator = next((each for each in ";\t," if each in line), " ")
        cells = _cells(line, separator)
        filled = [*filter(None, cells)]
        if not line.startswith(_COMMENTS) and 2 * len(first_times(filled)) > len(filled):
            named = _cells(header, separator)
            of_sensor = sensor_of(heading(cells[0]).words)
            if len(named) < _MIN_CELLS:
                named = _LONG if of_sensor else [f"{i}" for i in range(1, len(cells) + 1)]
            words = heading(cells[0] if of_sensor else source.name.rpartition(".")[0]).words
            return TextTable(source, separator, [*map(heading, named)], number, words)
        if len(cells) >= _MIN_CELLS and not line.startswith(_COMMENTS[2:]):
            header = line.lstrip("#%")
    return None


def _cells(line: str, separator: str) -> list[str]:
    """The cells of a line; of one that is none of CSV, as with a cell too long, the line."""
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    except csv.Error:
        return [line]
