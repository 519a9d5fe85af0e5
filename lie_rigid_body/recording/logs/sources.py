"""Text files, alone or in a folder or a zip, read line by line within bounds."""

from __future__ import annotations

import re
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Final

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.system.bounded_input import open_file
from lie_rigid_body.system.output_file import reason

MAX_TEXT_BYTES: Final = 2**30
"""Largest size of the text of a table, bytes: an hour at 1 kHz with 300 characters a line."""
MAX_LINE_BYTES: Final = 2**20
"""Largest size of a line, bytes: one of a thousand columns."""
MAX_FILES: Final = 500
"""Largest number of tables in a folder or a zip."""
_TABLES: Final = (".csv", ".txt", ".tsv", ".dat")
_ZIP: Final = b"PK"
_LATIN: Final = re.compile("[\udc80-\udcff]")
"""Bytes that are not UTF-8, as Python stands them in: older loggers write ° and µ in Latin-1."""


@short_dataclass(frozen=True)
class TextSource:
    """A text file.

    Attributes
    ----------
    path : Path
        Of the file, or of the zip that it is in.
    member : str
        Name in the zip; empty for a file of its own.
    """

    path: Path
    member: str = ""

    @property
    def name(self) -> str:
        """Path of the file, in a zip behind that of the zip."""
        return f"{self.path / self.member}"

    @property
    def stem(self) -> str:
        """Name without folder and suffix."""
        return Path(self.name).stem

    def lines(self) -> Iterator[str]:
        """Lines without their ends.

        Raises
        ------
        InputError
            If it cannot be read, is damaged, is no text, or is longer than is read.
        """
        size = 0
        with self._opened() as stream:
            while line := stream.readline(MAX_LINE_BYTES + 1):
                size += len(line)
                if len(line) > MAX_LINE_BYTES or b"\0" in line:
                    told = "is no text" if b"\0" in line else f"has a line of more than {MAX_LINE_BYTES} bytes"
                    raise InputError(f"{self.name} {told}, it begins {shown(line[:8])}: give a CSV or a bag")
                if size > MAX_TEXT_BYTES:
                    raise InputError(f"{self.name} has more than {MAX_TEXT_BYTES} bytes of text: give a part of it")
                text = line.decode("utf-8", "surrogateescape").strip("\ufeff\r\n")
                yield text if text.isascii() else _LATIN.sub(lambda byte: chr(ord(byte[0]) - 0xDC00), text)

    @contextmanager
    def _opened(self) -> Iterator[BinaryIO]:
        """The bytes of the file, whose errors name it."""
        try:
            if not self.member:
                with open_file(self.path) as stream:
                    yield stream
                return
            with zipfile.ZipFile(self.path) as archive, archive.open(self.member) as member:
                yield member  # type: ignore[misc]
        except OSError as error:
            raise InputError(f"{self.name} cannot be read: {reason(error)}: give a CSV or a bag") from None
        except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError, NotImplementedError) as error:
            if isinstance(error, InputError):
                raise
            raise _damaged(self.path, error) from None


def sources_of(path: Path) -> list[TextSource]:
    """The text files of a path: the file itself, or the tables in a folder or a zip.

    Raises
    ------
    InputError
        If there is none, or the zip is damaged.
    """
    if path.is_dir():
        inside = sorted(each.name for each in path.iterdir() if each.is_file())
        return [TextSource(path / name) for name in _tables(path, inside)]
    if not _is_zip(path):
        return [TextSource(path)]
    try:
        with zipfile.ZipFile(path) as archive:
            inside = sorted(archive.namelist())
    except (zipfile.BadZipFile, ValueError, NotImplementedError, OSError) as error:
        raise _damaged(path, error) from None
    return [TextSource(path, name) for name in _tables(path, inside)]


def _is_zip(path: Path) -> bool:
    try:
        with open_file(path) as stream:
            return stream.read(len(_ZIP)) == _ZIP
    except OSError as error:
        raise InputError(f"{path} cannot be read: {reason(error)}: give the path of a log") from None


def _tables(path: Path, names: list[str]) -> list[str]:
    """The names of tables among those of files; what an archiver of a Mac puts beside them is left out."""
    found = [name for name in names if name.lower().endswith(_TABLES) and not name.startswith(("__MACOSX", "."))]
    if not found or len(found) > MAX_FILES:
        there = f"{len(found)} tables" if found else listed([shown(name) for name in names]) or "nothing"
        raise InputError(f"{path} holds {there}, where a log has one to {MAX_FILES} CSV files: give a log")
    return found


def _damaged(path: Path, error: Exception) -> InputError:
    return InputError(f"{path} is a damaged or locked zip, {error}: unpack it, and give the folder")
