"""An output file that replaces an older one only on request, and only once it is complete; the queue of a disk."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import BinaryIO, Final

from lie_rigid_body.foundation.errors import BagError, ExistsError
from lie_rigid_body.system.bounded_input import as_path

_PART: Final = ".lie_rigid_body-{}.part"
"""Name of an unfinished file, which replaces an older one when it is whole."""
NO_ROOM: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Numbers of errors by which a write fails for want of room."""

MAX_BACKLOG: Final = 32 * 1024**2
"""Bytes that may wait for the disk: at 1000 samples a second those of two minutes."""


class OutputFile:
    """A new file, open for writing.

    When another file of that name exists and may be overwritten, the new one is written beside it. The name of that
    file ends in ``.part``, and it takes the place of the old one in `commit`. `discard` closes an unfinished file.

    Parameters
    ----------
    path : str or Path
    overwrite : bool
        Whether a regular file of that name may be replaced.
    whole : bool, optional
        Whether a file that may be replaced is written beside its place even where no older one has it, so that nobody
        finds part of it under its name.

    Attributes
    ----------
    stream : file
        Stream to write to.
    replaces : bool
        Whether it is written beside its place.

    Raises
    ------
    InputError
        If the path is none, such as a number.
    BagError
        If the file cannot be created, saying why and what to do.
    """

    def __init__(self, path: str | Path, *, overwrite: bool, whole: bool = False) -> None:
        self.path = as_path(path)
        self._is_whole = False
        try:
            self._target = self._place(overwrite)
            exists = self._target.exists()
            self.replaces = overwrite and (exists or whole)
            self._written = self._target
            if self.replaces:
                self._written = self._target.with_name(_PART.format(secrets.token_hex(8)))
            self.stream: BinaryIO = open(self._written, "xb")  # noqa: SIM115 closed by commit or discard
            if exists:  # without the bits by which a program runs as its owner
                os.chmod(self._written, self._target.stat().st_mode & 0o777)
        except FileExistsError:
            raise ExistsError(
                f"{self.path} exists and is kept: give another name, or --force to replace it (Python: overwrite=True)"
            ) from None
        except (OSError, ValueError) as error:
            why = f": {reason(error)}: give a place where you may write"
            if isinstance(error, FileNotFoundError) and not self.path.parent.is_dir():
                why = f", because the folder {self.path.parent} does not exist: make it, or give another one"
            raise BagError(f"{self.path} cannot be created{why}") from None

    def _place(self, overwrite: bool) -> Path:
        """Path that the file will have: the end of a link, if it is given one."""
        if self.path.is_dir():
            raise BagError(f"{self.path} is a folder: give the name of a file, or move it away")
        if self.path.is_symlink() and not self.path.exists():
            raise BagError(f"{self.path} is a link that leads to no file: remove it, or give another name")
        if self.path.exists() and not overwrite:
            raise FileExistsError
        if self.path.exists() and not self.path.is_file():
            raise BagError(f"{self.path} is not a regular file and is not replaced: give another name")
        return self.path.resolve() if self.path.is_symlink() else self.path

    def sync(self) -> None:
        """Flush and fsync: what was written survives a loss of power."""
        self.stream.flush()
        os.fsync(self.stream.fileno())

    def sync_folder(self) -> None:
        """Fsync the folder, as far as it can be: the file is found under its name after a loss of power."""
        with contextlib.suppress(OSError):
            folder = os.open(self._written.parent, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
            try:
                os.fsync(folder)
            finally:
                os.close(folder)

    def commit(self) -> None:
        """Flush, fsync and close, replace the older file, if any, and fsync the folder."""
        self.sync()
        self.stream.close()
        if self.replaces:
            os.replace(self._written, self._target)
        self._is_whole = True
        self.sync_folder()

    def discard(self, *, rescued: bool = False) -> None:
        """Close the unfinished file and remove it, unless it is rescued and was not to replace an older one."""
        with contextlib.suppress(OSError):  # what the buffer still holds may not fit on the disk either
            self.stream.close()
        if not self._is_whole and (self.replaces or not rescued):
            with contextlib.suppress(OSError):  # it may be gone
                self._written.unlink()


def require_other(path: str | Path, others: Iterable[str | Path], kind: str = "input") -> None:
    """Refuse an output that is one of some other files, be it through a link, whether or not it may be replaced.

    Raises
    ------
    BagError
    """
    for other in filter(os.path.exists, others if os.path.exists(path) else ()):
        if os.path.samefile(path, other):
            raise BagError(f"{path} is the {kind} {other} itself, which would be lost: give another name")


def require_room(path: str | Path, inputs: Iterable[str | Path], *, overwrite: bool) -> None:
    """Refuse, before the work for it, a file that `write_file` would refuse after it, and one that is an input.

    Raises
    ------
    BagError
        If it is an input itself, exists and may not be replaced, or cannot be created.
    """
    require_other(path, inputs)
    OutputFile(path, overwrite=overwrite).discard()


def write_file(path: str | Path, data: bytes, *, overwrite: bool) -> None:
    """Write a whole file, or none at all.

    Raises
    ------
    BagError
        If it exists and may not be replaced, or cannot be written.
    """
    with written(path, overwrite=overwrite) as stream:
        stream.write(data)


@contextlib.contextmanager
def written(path: str | Path, *, overwrite: bool) -> Iterator[BinaryIO]:
    """Context in which a file is written; it is whole when that ends, or not there at all.

    Raises
    ------
    BagError
        If it exists and may not be replaced, or cannot be written.
    """
    out = OutputFile(path, overwrite=overwrite, whole=True)
    try:
        yield out.stream
        out.commit()
    except BaseException as error:
        out.discard()  # part of it is of no use, and would stand in the way of the next one
        if not isinstance(error, OSError):
            raise
        raise BagError(f"{path} cannot be written: {reason(error)}: {remedy(error)}, or give another place") from None


def reason(error: Exception) -> str:
    """The message of an error of the operating system, without its number and path."""
    return (isinstance(error, OSError) and error.strerror) or str(error)


def remedy(error: OSError) -> str:
    """Remedy for an error of writing."""
    return "make room" if error.errno in NO_ROOM else "look after the disk"


class DiskQueue:
    """Jobs for a thread of their own, in order. After one that failed none is done.

    Its error is raised in this thread by the next call.

    Parameters
    ----------
    waits : bool
        Whether `put` waits while too much is in the queue; otherwise it refuses more.
    """

    def __init__(self, *, waits: bool) -> None:
        self._waits = waits
        self._thread = ThreadPoolExecutor(1)
        self._jobs: deque[tuple[Future[None], int]] = deque()
        self._failed = False

    def put(self, job: Callable[[], object], size: int = 0) -> None:
        """Have a job done, which keeps so many bytes in memory until then.

        Raises
        ------
        TimeoutError
            If too much is in the queue.
        """
        self._forget(lambda done: done or (self._waits and self._waiting + size > MAX_BACKLOG))
        if not self._waits and self._waiting + size > MAX_BACKLOG:
            raise TimeoutError(f"the disk does not keep up, {self._waiting} bytes wait for it")
        self._jobs.append((self._thread.submit(self._do, job), size))

    @property
    def _waiting(self) -> int:
        return sum(size for _, size in self._jobs)

    def _forget(self, ready: Callable[[bool], bool]) -> None:
        """Take jobs off the queue, oldest first, as long as they are ready; wait for those that are not done."""
        while self._jobs and ready(self._jobs[0][0].done()):
            future, _ = self._jobs.popleft()
            future.result()

    def _do(self, job: Callable[[], object]) -> None:
        if self._failed:
            return
        try:
            job()
        except BaseException:
            self._failed = True
            raise

    def wait(self) -> None:
        """Wait until all is done."""
        self._forget(lambda done: True)

    def finish(self) -> None:
        """Wait until all is done, and end the thread."""
        self.wait()
        self._thread.shutdown()

    def end(self, last: Callable[[], object]) -> None:
        """Leave out what is not begun, and do a last job; wait for it unless the disk is not waited for."""
        self._failed = True
        self._jobs.clear()
        self._thread.submit(last)
        self._thread.shutdown(wait=self._waits)
