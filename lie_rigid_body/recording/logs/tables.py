"""Tables in text files: the dialect of CSV, the header, and the rows, whose cells stay texts."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Final

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.recording.logs.headings import LAYOUTS, Heading, heading, sensor_of
from lie_rigid_body.recording.logs.sources import TextSource
from lie_rigid_body.recording.logs.times import is_clock, is_number

_FIRST_ROWS: Final = 1000
"""Rows by which columns of time are known."""
_BLOCK: Final = 10_000
_MIN_CELLS: Final = 4
"""Cells of the smallest table: a time and three axes."""
_COMMENTS: Final = ("#", "%", "//", "sep=")
"""Beginnings of lines that are no rows; a header may stand behind the first two."""
_LONG: Final = ("Attribute", "Time stamp", "x", "y", "z")
"""Columns of a table whose rows name their sensor."""


@short_dataclass
class TextTable:
    """The header of a table, and how to read its rows.

    Attributes
    ----------
    source : TextSource
    separator : str
    headings : tuple of Heading
        Those of its columns; without a header they have no words.
    skipped : int
        Lines before its first row.
    words : tuple of str
        Words of the file's name, or of the sensor that its rows name.
    """

    source: TextSource
    separator: str
    headings: tuple[Heading, ...]
    skipped: int
    words: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of the file without its folder."""
        return Path(self.source.name).name

    @property
    def columns(self) -> str:
        """The columns that there are, for errors."""
        return f"the columns {listed([shown(head.text) for head in self.headings])}"

    @property
    def program(self) -> tuple[str, Mapping[str, str]]:
        """The program that is known to write such a table, and its units."""
        return next((LAYOUTS[head.joined] for head in self.headings if head.joined in LAYOUTS), ("", {}))

    def first_rows(self) -> list[list[str]]:
        """The rows by which columns of time are known."""
        return next(self.blocks(_FIRST_ROWS))[1]

    def blocks(self, size: int = _BLOCK) -> Iterator[tuple[list[int], list[list[str]]]]:
        """Numbers of lines, and their cells, block by block.

        Raises
        ------
        InputError
            If a row has not as many cells as the header.
        """
        width = len(self.headings)
        rows = self._rows()
        while block := [*islice(rows, size)]:
            for line, cells in block:
                if len(cells) < width or any(cells[width:]):
                    told = f"has {len(cells)} cells, where the header has {width}"
                    raise InputError(f"{self.source.name}, line {line}: {told}: complete the row or remove it")
            yield [line for line, _ in block], [cells for _, cells in block]

    def _rows(self) -> Iterator[tuple[int, list[str]]]:
        """Numbers of lines, and their cells, of rows that are not blank."""
        lines = (line.strip(" ") for line in islice(self.source.lines(), self.skipped, None))
        reader = csv.reader(lines, delimiter=self.separator, skipinitialspace=True)
        try:
            for cells in reader:
                if any(cells) and not cells[0].startswith(_COMMENTS):
                    yield self.skipped + reader.line_num, cells
        except csv.Error as error:
            line = self.skipped + reader.line_num
            raise InputError(f"{self.source.name}, line {line}: not readable as CSV: {error}: correct it") from None


def read_table(source: TextSource) -> TextTable | None:
    """The table in a text file; None where it has no row.

    Raises
    ------
    InputError
        If it cannot be read, or is no text.
    """
    header = ""
    for number, line in enumerate(source.lines()):
        separator = next((each for each in ";\t," if each in line), " ")
        cells = _cells(line, separator)
        if not line.startswith(_COMMENTS) and _is_row(cells):
            named = _cells(header, separator)
            if len(named) < _MIN_CELLS:
                of_sensor = len(cells) == len(_LONG) and sensor_of(heading(cells[0]).words)
                named = [*_LONG] if of_sensor else [f"{i}" for i in range(1, len(cells) + 1)]
            words = heading(cells[0] if named[0] == _LONG[0] else source.stem).words
            return TextTable(source, separator, tuple(map(heading, named)), number, words)
        if len(cells) >= _MIN_CELLS and not line.startswith(_COMMENTS[2:]):
            header = line.lstrip("#%")
    return None


def _is_row(cells: Sequence[str]) -> bool:
    """Whether cells are those of a row: most that are filled are numbers or times of day."""
    filled = [cell.replace(",", ".") for cell in cells if cell]
    return 2 * sum(is_number(cell) or is_clock(cell) for cell in filled) > len(filled)


def _cells(line: str, separator: str) -> list[str]:
    try:
        row = next(csv.reader([line.strip(" ")], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:  # a cell is too long
        return []
    return [cell.strip() for cell in row]
