"""An output file that replaces an older one only on request, and only once it is complete."""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
from pathlib import Path
from typing import BinaryIO

from lie_rigid_body.errors import BagError


class OutputFile:
    """A new file, open for writing.

    When another file of that name exists and may be overwritten, the new one is written beside it and takes its place
    in `commit`; until then the old one is untouched.

    An unfinished file is closed by `abandon`, which keeps it for rescue unless it was to replace an older one, or by
    `discard`, which always removes it.

    Parameters
    ----------
    path : str or Path
    overwrite : bool
        Whether a regular file of that name may be replaced.

    Raises
    ------
    BagError
        If the file cannot be created, saying why and what to do.
    """

    def __init__(self, path: str | Path, *, overwrite: bool) -> None:
        self.path = Path(path)
        try:
            self._target = self._replaceable(overwrite)
            self._written, self.stream = _new(self.path) if self._target is None else _beside(self._target)
        except FileExistsError:
            raise BagError(f"{self.path} exists and is kept: give another name, or --force to replace it") from None
        except (OSError, ValueError) as error:
            if isinstance(error, FileNotFoundError) and not self.path.parent.is_dir():
                raise BagError(
                    f"{self.path} cannot be created, because the folder {self.path.parent} does not exist: "
                    "make it, or give another one"
                ) from None
            raise BagError(
                f"{self.path} cannot be created: {reason(error)}: give a place where you may write"
            ) from None

    def _replaceable(self, overwrite: bool) -> Path | None:
        """The file to replace, its links followed, or None when a new name is free."""
        if self.path.is_dir():
            raise BagError(f"{self.path} is a folder: give the name of a file in it, such as {self.path / 'out.mcap'}")
        if not (overwrite and self.path.exists()):
            return None
        if not self.path.is_file():
            raise BagError(f"{self.path} is not a regular file and is not replaced: give another name")
        return self.path.resolve()

    @property
    def replaces(self) -> bool:
        """Whether an older file waits to be replaced."""
        return self._target is not None

    def commit(self) -> None:
        """Flush, fsync and close, then replace the older file, if any."""
        self.stream.flush()
        os.fsync(self.stream.fileno())
        self.stream.close()
        if self._target is not None:
            os.replace(self._written, self._target)

    def abandon(self) -> None:
        """Close the unfinished file, and keep it for rescue unless it was to replace an older one."""
        self._close()
        if self.replaces:
            self._written.unlink(missing_ok=True)

    def discard(self) -> None:
        """Close the unfinished file and remove it."""
        self._close()
        self._written.unlink(missing_ok=True)

    def _close(self) -> None:
        with contextlib.suppress(OSError):  # what the buffer still holds may not fit on the disk either
            self.stream.close()


def write_file(path: str | Path, data: bytes, *, overwrite: bool) -> None:
    """Write a whole file, or none at all.

    Raises
    ------
    BagError
        If it exists and may not be replaced, or cannot be written.
    """
    out = OutputFile(path, overwrite=overwrite)
    try:
        out.stream.write(data)
        out.commit()
    except BaseException as error:
        out.discard()  # part of it is of no use, and would stand in the way of the next one
        if not isinstance(error, OSError):
            raise
        raise BagError(f"{path} cannot be written: {reason(error)}: make room, or give another place") from None


def reason(error: Exception) -> str:
    """The message of an error of the operating system, without its number and path."""
    return (isinstance(error, OSError) and error.strerror) or str(error)


def _new(path: Path) -> tuple[Path, BinaryIO]:
    return path, open(path, "xb")


def _beside(target: Path) -> tuple[Path, BinaryIO]:
    """A file of the same permissions in the same folder, which is on the same disk."""
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".part", dir=target.parent)
    os.fchmod(handle, stat.S_IMODE(target.stat().st_mode))
    return Path(name), os.fdopen(handle, "wb")
