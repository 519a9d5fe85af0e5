"""The files that a bag is made of, read one after the other."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from lie_rigid_body.bounded_input import as_path, load_yaml, read_text
from lie_rigid_body.errors import BagError, InputError
from lie_rigid_body.recording import folder_metadata
from lie_rigid_body.recording.mcap_contents import McapContents, Progress, Wanted
from lie_rigid_body.recording.mcap_reader import read_file
from lie_rigid_body.recording.output_file import reason
from lie_rigid_body.recording.sqlite_reader import SUFFIX, read_database

METADATA: Final = "metadata.yaml"
"""The file that makes a folder a rosbag2 bag."""

SUFFIXES: Final = (".mcap", SUFFIX)
"""Suffixes of the names of bags."""

LARGEST_METADATA: Final = 2**20
"""Largest size of a metadata.yaml, bytes."""


_KEPT_AT_LEAST: Final = 64 * 2**20
_KEPT_PER_BYTE: Final = 200
"""Limits of the memory for a file's messages, bytes, and bytes per byte of the file; a motion compresses to 1/20."""


def unheard(count: int) -> None:
    """Take no notice of progress."""


class BagFiles:
    """The files of a bag in the order of recording.

    Parameters
    ----------
    path : str or Path
        An MCAP file, or an SQLite file of rosbag2, or a rosbag2 folder of either.
    progress : callable, optional
        Called with the number of bytes that were read since it was called last, in every pass.

    Attributes
    ----------
    files : list of Path

    Raises
    ------
    InputError
        If the path is none, such as a number.
    BagError
        If the path or its metadata cannot be read, or name no files.
    """

    def __init__(self, path: str | Path, progress: Progress = unheard) -> None:
        self.path = as_path(path, "bag", "that of an MCAP file, or of a folder of them")
        self.progress = progress
        self._metadata = self.path / METADATA
        try:
            self._information = _information(self._metadata) if self.path.is_dir() else None
            self.files = _files(self.path, self._information)
        except OSError as error:
            raise BagError(f"{path} cannot be read: {reason(error)}: give the path of an MCAP file") from None

    def contents(self, wanted: Wanted) -> McapContents:
        """Read all files, and count their messages; those that are wanted are kept in the tracks.

        Raises
        ------
        BagError
            If a file is no bag, cut off or damaged, or the folder's metadata do not fit it.
        """
        contents = McapContents()
        for file in self.files:
            read = read_database if file.suffix == SUFFIX else read_file
            before = kept = 0
            for position, found in read(file, contents, wanted):
                kept += contents.keep(found)
                _require_moderate(file, kept)
                self.progress(position - before)
                before = position
        if self._information is not None:
            folder_metadata.hold(self._metadata, self._information, contents)
        return contents


def _require_moderate(file: Path, kept: int) -> None:
    """Refuse messages that take more memory than those of such a file may."""
    size = file.stat().st_size
    if kept > max(_KEPT_AT_LEAST, _KEPT_PER_BYTE * size):
        what = f"messages of {kept} bytes in a file of {size}"
        raise BagError(f"{file} has {what}, more than is read: record it again")


def is_one_bag(folder: Path) -> bool:
    """Whether a folder is that of one rosbag2 recording, by its metadata or by the names of its files.

    Without metadata, as a recorder leaves ``NAME`` that was killed, they are ``NAME_0.mcap``, ``NAME_1.mcap`` …
    """
    if (folder / METADATA).exists():
        return True
    for suffix in SUFFIXES:
        files = {path.name for path in folder.glob(f"*{suffix}")}
        if files:
            return files == {f"{folder.resolve().name}_{i}{suffix}" for i in range(len(files))}
    return False


def _files(path: Path, information: Mapping[str, Any] | None) -> list[Path]:
    """The files of a bag, in the order of recording."""
    if not path.is_dir():
        return [path]
    if information is not None:
        return [path / str(name) for name in information["relative_file_paths"]]
    files = sorted((file for suffix in SUFFIXES for file in path.glob(f"*{suffix}")), key=natural_order)
    if not files:
        raise BagError(f"{path} is a folder without MCAP or SQLite files: give a bag")
    if len(files) > 1 and not is_one_bag(path):
        raise BagError(f"{path} holds {len(files)} bags, not one recording: give one of them")
    return [file for file in files if file.suffix == SUFFIXES[0]] or files


def _information(metadata: Path) -> Mapping[str, Any] | None:
    """Information in a rosbag2 folder's metadata; None without metadata, as a recorder leaves it that was killed."""
    if not metadata.exists():
        return None

    try:
        information: dict[str, Any] = load_yaml(read_text(metadata, LARGEST_METADATA), str(metadata))[
            "rosbag2_bagfile_information"
        ]
        names = [str(name) for name in information["relative_file_paths"]]
    except (InputError, TypeError, LookupError):
        raise BagError(f"{metadata} is not the metadata of a rosbag2 bag: remake it with 'ros2 bag reindex'") from None
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise BagError(f"{metadata} names {twice[0]} twice: remake it with 'ros2 bag reindex'")
    return information


def natural_order(path: Path) -> list[tuple[int, str]]:
    """A key that sorts paths by their names, numbers in them by their values."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", str(path))]
