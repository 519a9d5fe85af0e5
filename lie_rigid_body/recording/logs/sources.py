"""Text files, alone or in a folder or a zip, read line by line within bounds."""

from __future__ import annotations

import re
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Final

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


@short_dataclass
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
        with _refusing(self.name), ExitStack() as stack:
            stream: IO[bytes]
            if self.member:
                archive = stack.enter_context(zipfile.ZipFile(self.path))
                stream = stack.enter_context(archive.open(self.member))
            else:
                stream = stack.enter_context(open_file(self.path))
            while line := stream.readline(MAX_LINE_BYTES + 1):
                size += len(line)
                if len(line) > MAX_LINE_BYTES or b"\0" in line:
                    told = "is no text" if b"\0" in line else f"has a line of more than {MAX_LINE_BYTES} bytes"
                    raise InputError(f"{self.name} {told}, it begins {shown(line[:8])}: give a CSV or a bag")
                if size > MAX_TEXT_BYTES:
                    raise InputError(f"{self.name} has more than {MAX_TEXT_BYTES} bytes of text: give a part of it")
                text = line.decode("utf-8", "surrogateescape").strip("\ufeff\r\n")
                yield text if text.isascii() else _LATIN.sub(lambda byte: chr(ord(byte[0]) - 0xDC00), text)


def sources_of(path: Path) -> list[TextSource]:
    """The text files of a path: the file itself, or the tables in a folder or a zip.

    Raises
    ------
    InputError
        If there is none, or the zip is damaged.
    """
    with _refusing(f"{path}"):
        if path.is_dir():
            inside = sorted(each.name for each in path.iterdir() if each.is_file())
            return [TextSource(path / name) for name in _tables(path, inside)]
        with open_file(path) as stream:
            if stream.read(len(_ZIP)) != _ZIP:
                return [TextSource(path)]
        with zipfile.ZipFile(path) as archive:
            return [TextSource(path, name) for name in _tables(path, sorted(archive.namelist()))]


@contextmanager
def _refusing(name: str) -> Iterator[None]:
    """Context in which a file is read, whose errors name it."""
    try:
        yield
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{name} cannot be read: {reason(error)}: give a CSV or a bag") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError) as error:
        raise InputError(f"{name} is damaged or locked, {error}: unpack the zip, and give the folder") from None


def _tables(path: Path, names: list[str]) -> list[str]:
    """The names of tables among those of files; what an archiver of a Mac puts beside them is left out."""
    found = [name for name in names if name.lower().endswith(_TABLES) and not name.startswith(("__MACOSX", "."))]
    if not found or len(found) > MAX_FILES:
        there = f"{len(found)} tables" if found else listed([shown(name) for name in names]) or "nothing"
        raise InputError(f"{path} holds {there}, where a log has one to {MAX_FILES} CSV files: give a log")
    return found
