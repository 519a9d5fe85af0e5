"""An output file that replaces an older one only on request, and only once it is complete; the queue of a disk."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from io import BufferedWriter, FileIO
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Final

from lie_rigid_body.foundation.errors import BagError, ExistsError
from lie_rigid_body.system.bounded_input import as_path
from lie_rigid_body.system.portable import is_others, lock, real_path, user

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

_UNFINISHED: Final = (".lie_rigid_body-", ".part")
"""Beginning and end of the name of an unfinished file, which replaces an older one when it is whole."""
NO_ROOM: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Numbers of errors by which a write fails for want of room."""

LARGEST_BACKLOG: Final = 32 * 1024**2
"""Bytes that may wait for the disk: at 1000 samples a second those of two minutes."""


class OutputFile:
    """A new file, open for writing.

    When another file of that name exists and may be overwritten, the new one is written beside it and takes its place
    in `commit`. Until then the old one is untouched.

    An unfinished file is closed by `discard`. What a killed process has left beside a file that it was to replace is
    removed when the next output file is made in that folder.

    Parameters
    ----------
    path : str or Path
    overwrite : bool
        Whether a regular file of that name may be replaced.

    Attributes
    ----------
    replaces : bool
        Whether an older file waits to be replaced.

    Raises
    ------
    InputError
        If the path is none, such as a number.
    BagError
        If the file cannot be created, saying why and what to do.
    """

    def __init__(self, path: str | Path, *, overwrite: bool) -> None:
        self.path = as_path(path)
        self._lock = contextlib.ExitStack()
        try:
            self._target = self._replaceable(overwrite)
            self.replaces = self._target is not None
            _remove_rests((self._target or self.path).parent)  # now, as nothing is to come between a file and its use
            if self._target is None:
                self._written, self._file = self.path, _GrowingFile(self.path)
            else:
                self._written, self._file, self._lock = _beside(self._target)
        except FileExistsError:
            raise ExistsError(
                f"{self.path} exists and is kept: give another name, or --force to replace it (Python: overwrite=True)"
            ) from None
        except (OSError, ValueError) as error:
            why = f": {reason(error)}: give a place where you may write"
            if isinstance(error, FileNotFoundError) and not self.path.parent.is_dir():
                why = f", because the folder {self.path.parent} does not exist: make it, or give another one"
            raise BagError(f"{self.path} cannot be created{why}") from None
        self.stream = BufferedWriter(self._file)
        self._identity, self._is_whole = os.fstat(self._file.fileno()), False

    def _replaceable(self, overwrite: bool) -> Path | None:
        """The file to replace, its links followed, or None when a new name is free."""
        for link in (self.path, self.path.parent):
            if link.is_symlink() and is_others(link.lstat()):
                raise BagError(f"{link} is a link of another user and is not followed: give another name")
        if self.path.is_dir():
            raise BagError(f"{self.path} is a folder: give the name of a file, or move it away")
        if self.path.is_symlink() and not self.path.exists():
            raise BagError(f"{self.path} is a link that leads to no file: remove it, or give another name")
        if not (overwrite and self.path.exists()):
            return None
        if not self.path.is_file():
            raise BagError(f"{self.path} is not a regular file and is not replaced: give another name")
        # the name itself where it is no link: one that somebody puts there meanwhile is replaced, and not followed
        return real_path(self.path) if self.path.is_symlink() else real_path(self.path.parent) / self.path.name

    def sync(self) -> None:
        """Flush and fsync: what was written survives a loss of power."""
        self.stream.flush()
        os.fsync(self._file.fileno())

    def sync_name(self) -> None:
        """Fsync the folder, as far as it can be: the file is found under its name after a loss of power."""
        with contextlib.suppress(OSError):
            folder = os.open(self._written.parent, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
            try:
                os.fsync(folder)
            finally:
                os.close(folder)

    def draft(self, data: bytes) -> None:
        """Write all buffered bytes, and behind them a draft, which the next write replaces."""
        self.stream.flush()
        self._file.draft(data)

    def require_intact(self) -> None:
        """Check that what was written so far is still there, under its name and at its length.

        Raises
        ------
        BagError
            If another program has taken it away.
        """
        if damage := self._damage():
            raise BagError(f"{self.path} is lost: {damage} meanwhile: keep others away, and write it again")

    def _damage(self) -> str:
        try:
            there = self._written.stat()
        except (FileNotFoundError, NotADirectoryError):
            return "the file was deleted or moved"
        if not os.path.samestat(there, self._identity):
            return "another file took its place"
        if there.st_size != self._file.length:
            return f"another program made it {there.st_size} bytes long instead of {self._file.length}"
        return ""

    def commit(self) -> None:
        """Flush and fsync, replace the older file, if any, and close."""
        self.sync()
        self.require_intact()
        self.stream.close()
        if self._target is not None:
            os.replace(self._written, self._target)  # while it is still locked
        self._is_whole = True
        self._unlock()

    def discard(self, *, rescued: bool = False) -> None:
        """Close the unfinished file and remove it, unless it is rescued and was not to replace an older one."""
        is_own = False
        with contextlib.suppress(OSError):  # another file may have taken its place
            is_own = not self._is_whole and os.path.samestat(self._written.stat(), self._identity)
        with contextlib.suppress(OSError):  # what the buffer still holds may not fit on the disk either
            self.stream.close()
        if is_own and (self.replaces or not rescued):  # closed before, as not every system removes an open file
            self._written.unlink(missing_ok=True)
        self._unlock()

    def _unlock(self) -> None:
        with contextlib.suppress(OSError):  # of a disk that fails: nothing is lost by it
            self._lock.close()


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
    out = OutputFile(path, overwrite=overwrite)
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
    """What to do about an error of writing."""
    return "make room" if error.errno in NO_ROOM else "look after the disk"


class _GrowingFile(FileIO):
    """A new file that is written at its end only: where another program cuts it, no hole of zeros hides the loss.

    Attributes
    ----------
    length : int
        How many bytes it is to have: those that were written, and a draft of those that follow.
    """

    def __init__(self, path: Path, permissions: int = 0o666) -> None:
        super().__init__(path, "xb", opener=lambda name, flags: os.open(name, flags | os.O_APPEND, permissions))
        self.length = self._drafted = 0

    def write(self, data: ReadableBuffer, /) -> int:
        if self._drafted and os.fstat(self.fileno()).st_size == self.length:  # a shorter file would get zeros
            self.length = self.truncate(self.length - self._drafted)
        self._drafted = 0
        count = super().write(data)
        self.length += count
        return count

    def draft(self, data: bytes) -> None:
        """Write bytes that the next ones replace. A process that is killed leaves them."""
        self._drafted = self.write(data)


def _beside(target: Path) -> tuple[Path, _GrowingFile, contextlib.ExitStack]:
    """Locked file in the same folder, which is on the same disk, and its lock.

    It has the permissions of the older file, if that is of the same user; another's is not to say who may write.
    """
    begin, end = _UNFINISHED
    older = target.lstat()
    is_own = older.st_uid == user()
    while True:
        path = target.with_name(f"{begin}{secrets.token_hex(8)}{end}")
        file = _GrowingFile(path, permissions=0o600 if is_own else 0o666)
        held = contextlib.ExitStack()
        with contextlib.suppress(OSError):  # where there are no locks, nobody gets one either
            held = lock(file)
        if os.fstat(file.fileno()).st_nlink:
            if is_own:  # without the bits by which a program runs as its owner
                os.chmod(file.fileno() if os.chmod in os.supports_fd else path, older.st_mode & 0o777)
            return path, file, held
        file.close()  # it was taken for a rest before it was locked
        held.close()


def _remove_rests(folder: Path) -> None:
    """Remove the unfinished files of killed processes: theirs are no longer locked."""
    for path in folder.glob("*".join(_UNFINISHED)):
        with contextlib.suppress(OSError):
            with open(path, "r+b") as rest:
                held = lock(rest)
            with held:
                path.unlink()


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
        self._forget(lambda done: done or (self._waits and self._waiting + size > LARGEST_BACKLOG))
        if not self._waits and self._waiting + size > LARGEST_BACKLOG:
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
