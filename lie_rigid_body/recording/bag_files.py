"""The files that a bag is made of, by the metadata.yaml of their folder or by their names, and the bags in a folder."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.wording import listed, shown
from lie_rigid_body.recording.inflation import COMPRESSED_ONE_BY_ONE
from lie_rigid_body.recording.mcap_contents import McapContents, Progress, TopicFilter, unheard
from lie_rigid_body.recording.mcap_reader import read_file
from lie_rigid_body.system.bounded_input import MAX_METADATA_BYTES, as_path, load_yaml, read_text
from lie_rigid_body.system.output_file import reason
from lie_rigid_body.system.portable import real_path

METADATA_FILE: Final = "metadata.yaml"
"""The file that makes a folder a rosbag2 bag."""

SUFFIXES: Final = (".mcap", ".db3")
"""Suffixes of the names of bags: those in SQLite are found as well, and refused with the remedy."""

_ZSTD: Final = ".zstd"
_PACKED: Final = f".mcap{_ZSTD}"
"""Suffix of files that rosbag2 has compressed as a whole."""
_FOUND: Final = (*SUFFIXES, _PACKED)
"""Suffixes of the files that are looked for in a folder of bags: who opens one that is packed is told so."""
_NUMBER: Final = r"(?P<number>0|[1-9]\d{0,5})"
_NAMES: Final = (
    re.compile(rf"(?P<prefix>.+)_{_NUMBER}\.(mcap|db3)"),
    re.compile(rf"{_NUMBER}_(?P<prefix>.+?)_[\d_.TZ-]+\.(mcap|db3)"),
)
"""Names that rosbag2 gives the files of one recording: ``PREFIX_NUMBER.mcap``, from ROS 2 Lyrical on
``NUMBER_PREFIX_TIME.mcap``."""
_HEADER_BYTES: Final = 64
"""Bytes at the beginning of a file in which the name of its writer begins."""


class BagFiles:
    """The files of a bag in the order of recording.

    Parameters
    ----------
    path : str or Path
        An MCAP file, or a rosbag2 folder of them.
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
        try:
            self.files = [self.path]
            if self.path.is_dir():
                self.files = recording_files(self.path)
                for file in self.files:
                    _require_there(file)
        except OSError as error:
            raise BagError(f"{path} cannot be read: {reason(error)}: give the path of an MCAP file") from None

    def contents(self, wanted: TopicFilter) -> McapContents:
        """Read all files, and count their messages; those that are wanted are kept.

        Raises
        ------
        BagError
            If a file is no bag, cut off or damaged.
        """
        contents = McapContents(wanted)
        for file in self.files:
            for size, found in read_file(file, contents):
                contents.kept.append(found)
                self.progress(size)
        return contents


def recording_files(path: Path) -> list[Path]:
    """The files in a folder of one recording, in the order of recording; those that metadata name need not be there.

    Raises
    ------
    BagError
        If there are none, or those of several recordings, or compressed ones.
    """
    if (path / METADATA_FILE).exists():
        return _named_files(path)
    if packed := sorted(_ending(path, _PACKED), key=natural_order):
        raise BagError(f"{packed[0]} is compressed as a whole: unpack all such files with 'unzstd'")
    files = sorted(_ending(path, *SUFFIXES), key=natural_order)
    if not files:
        raise BagError(f"{path} is a folder without MCAP files: give a bag")
    if len(files) > 1 and not is_one_bag(path):
        raise BagError(f"{path} holds {len(files)} bags, not one recording: give one of them")
    return [file for file in files if file.suffix.lower() == SUFFIXES[0]] or files


def _named_files(folder: Path) -> list[Path]:
    """The files that the metadata of a folder name; of one that was compressed as a whole the unpacked one."""
    metadata = folder / METADATA_FILE
    try:
        content: Any = load_yaml(read_text(metadata, MAX_METADATA_BYTES), str(metadata))
        information = content["rosbag2_bagfile_information"]
        names = [str(name) for name in information["relative_file_paths"]]
        mode = str(information.get("compression_mode")).upper()
    except (InputError, TypeError, LookupError, AttributeError):
        raise BagError(
            f"{metadata} is not the metadata of a rosbag2 bag: remove it, or remake it with 'ros2 bag reindex'"
        ) from None
    if mode == "MESSAGE":
        raise BagError(f"{folder}: {COMPRESSED_ONE_BY_ONE}")
    unpacked = [folder / name.removesuffix(_ZSTD) for name in names]
    files = [each if each.exists() else folder / name for each, name in zip(unpacked, names, strict=True)]
    if not files:
        raise BagError(f"{metadata} names no files: remake it with 'ros2 bag reindex'")
    return files


def _require_there(file: Path) -> None:
    if not file.exists():
        metadata = file.parent / METADATA_FILE
        there = listed([each.name for each in _ending(file.parent, *SUFFIXES)]) or "no bag"
        remedy = f"rename it back, or remove {METADATA_FILE}"
        raise BagError(f"{metadata} names {shown(file.name)}, and there is {there}: {remedy}")


def is_one_bag(folder: Path) -> bool:
    """Whether a folder is that of one rosbag2 recording, by its metadata or by the names of its files.

    Without metadata, as a recorder leaves it that was killed, they have the numbers from 0 on, whatever the folder is
    called. Files of this package, which are no parts of a recording, are called after their folder as well.
    """
    if os.path.exists(folder / METADATA_FILE):
        return True
    suffix = next((suffix for suffix in SUFFIXES if _ending(folder, suffix)), "")
    prefix, numbers = _numbers(folder, suffix)
    if not numbers or numbers != {*range(len(numbers))}:
        return False
    return prefix == real_path(folder).name or not any(map(_is_own, _ending(folder, suffix)))


def _is_own(file: Path) -> bool:
    """Whether this package, and no recorder, wrote a file."""
    with suppress(OSError), open(file, "rb") as stream:
        return b"lie_rigid_body " in stream.read(_HEADER_BYTES)
    return False


def _ending(folder: Path, *suffixes: str) -> list[Path]:
    """Files of a folder whose names end so, in capitals or not."""
    return [path for path in folder.glob("*") if path.name.lower().endswith(suffixes)]


def _numbers(folder: Path, suffix: str) -> tuple[str, set[int]]:
    """Prefix and numbers of the files of a folder, if all are called as those of one recording; else none."""
    names = [path.name for path in _ending(folder, suffix)]
    for pattern in _NAMES:
        found = [match for name in names if (match := pattern.fullmatch(name))]
        prefixes = {match["prefix"] for match in found}
        if found and len(found) == len(names) and len(prefixes) == 1:
            return prefixes.pop(), {int(match["number"]) for match in found}
    return "", set()


def whole_of(file: Path) -> Path | None:
    """The folder of the bag that was split into several files, of which this is one; None if it is not."""
    folder = file.parent
    several = _ending(folder, file.suffix) if file.suffix in SUFFIXES and file.is_file() else []
    return folder if len(several) > 1 and is_one_bag(folder) else None


def natural_order(path: Path) -> list[tuple[int, str]]:
    """A key that sorts paths by their names, numbers in them by their values."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", str(path))]


def bags_in(folder: Path) -> list[Path]:
    """The bags in a folder and the folders below it: files and rosbag2 folders, each as one.

    Folders that are hidden, or symbolic links, are left out.

    Parameters
    ----------
    folder : Path
        If it is a rosbag2 folder itself, it is the only bag.

    Returns
    -------
    list of Path
        By their names, numbers in them in their order. A folder that cannot be read, or has no bag in it, stands for
        itself: whoever opens it is told why it is none.
    """
    found = list[Path]()
    for here, folders, files in os.walk(folder, onerror=lambda error: found.append(Path(error.filename))):
        if is_one_bag(Path(here)):
            found.append(Path(here))
            folders.clear()
        else:
            seen = (name for name in files if not name.startswith("."))
            found.extend(Path(here, name) for name in seen if name.lower().endswith(_FOUND))
            folders[:] = [name for name in folders if not name.startswith(".")]
    return sorted(found, key=natural_order) or [folder]


def files_of(bag: str | Path) -> Iterator[Path]:
    """The files of a bag, or of all bags in a folder, whatever is wrong with them."""
    if not Path(bag).is_dir():
        yield Path(bag)
        return
    for each in bags_in(Path(bag)):
        with suppress(BagError):
            yield from BagFiles(each).files
        yield from (file for file in each.glob("*") if file.suffix.lower() in SUFFIXES or file.name == METADATA_FILE)
