"""Text files, alone or in a folder or a zip, read line by line within bounds."""

from __future__ import annotations

import re
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, TypeAlias

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.system.bounded_input import open_file
from lie_rigid_body.system.output_file import reason

MAX_LINE_BYTES: Final = 2**20
"""Largest size of a line, bytes: one of a thousand columns. A longer one is read as several."""
MAX_ZIP_BYTES: Final = 2**30
"""Largest size of a zip's members, bytes: an hour of three sensors at 1 kHz."""
TextSource: TypeAlias = "Path | zipfile.Path"
"""A file, or a member of a zip."""
_TABLE: Final = re.compile(r"[^.].*\.(csv|txt|tsv|dat)", re.IGNORECASE)
"""Name of a table in a folder or a zip, which is not hidden."""
_ZIP: Final = ".zip"


def lines_of(source: TextSource) -> Iterator[str]:
    """Lines of a text file without their ends and the blanks around them.

    Raises
    ------
    InputError
        If it cannot be read, is damaged, or is no text.
    """
    with _refusing(source), open_file(source) if isinstance(source, Path) else source.open("rb") as stream:
        while line := stream.readline(MAX_LINE_BYTES):
            if b"\0" in line:
                raise InputError(f"{source} is no text, it begins {shown(line[:8])}: give a CSV or a bag")
            try:
                text = line.decode()
            except UnicodeDecodeError:  # older loggers write ° and µ so
                text = line.decode("latin-1")
            yield text.strip("\ufeff\r\n ")


def sources_of(path: Path) -> list[TextSource]:
    """The text files of a path: the file itself, or the tables in a folder or a zip.

    Raises
    ------
    InputError
        If the zip is damaged, or too large.
    """
    every: Iterable[TextSource]
    with _refusing(path):
        if path.is_dir():
            every = path.rglob("*")
        elif path.suffix.lower() == _ZIP:
            archive = zipfile.ZipFile(path)
            size = sum(member.file_size for member in archive.infolist())
            if size > MAX_ZIP_BYTES:
                raise InputError(f"{path} unpacks to {size} bytes, and {MAX_ZIP_BYTES} are read: give a part of it")
            every = [zipfile.Path(archive, name) for name in archive.namelist()]
        else:
            return [path]
        return sorted((each for each in every if each.is_file() and _TABLE.fullmatch(each.name)), key=str)


@contextmanager
def _refusing(source: TextSource) -> Iterator[None]:
    """Context in which a file is read, whose errors name it."""
    try:
        yield
    except InputError:
        raise
    except (OSError, zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError) as error:
        raise InputError(f"{source} cannot be read: {reason(error)}: give a CSV, a folder of them, or a bag") from None
