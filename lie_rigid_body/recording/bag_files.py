"""The files that a bag is made of, held against the metadata.yaml of their folder, and the bags in a folder."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import yaml

from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import shown
from lie_rigid_body.recording.inflation import COMPRESSED_ONE_BY_ONE
from lie_rigid_body.recording.mcap_contents import FileSpan, McapContents, Progress, RawTrack, Wanted, unheard
from lie_rigid_body.recording.mcap_reader import read_file
from lie_rigid_body.system.bounded_input import LARGEST_METADATA, NUMBERS, BoundedLoader, as_path, load_yaml, read_text
from lie_rigid_body.system.output_file import reason
from lie_rigid_body.system.portable import real_path

METADATA_FILE: Final = "metadata.yaml"
"""The file that makes a folder a rosbag2 bag."""

SUFFIXES: Final = (".mcap", ".db3")
"""Suffixes of the names of bags: those in SQLite are found as well, and refused with the remedy."""

_PACKED: Final = ".mcap.zstd"
"""Suffix of files that rosbag2 has compressed as a whole."""
_FOUND: Final = (*SUFFIXES, _PACKED)
"""Suffixes of the files that are looked for in a folder of bags: who opens one that is packed is told so."""
_TOLERANCE_NS: Final = NS
"""Largest error of the start and the duration that a recorder notes, ns: it drops and reorders some messages."""
_TOPIC: Final = ("name", "type", "serialization_format")
_DECIMAL: Final = re.compile("-?(0|[1-9][0-9]*)")
_PER_MESSAGE: Final = 100
"""Memory that a message takes beside its content, about, bytes."""
_KEPT_AT_LEAST: Final = 64 * 2**20
_KEPT_PER_BYTE: Final = 200
"""Limits of the memory for a file's messages, bytes, and bytes per byte of the file; a motion compresses to 1/20."""


class _MetadataLoader(BoundedLoader):
    """A YAML loader of numbers in plain decimal digits, as rosbag2 writes them; all others are texts.

    What ``0311`` or ``3:21`` are depends on the reader: YAML 1.1 and 1.2 differ.
    """


def _number(loader: _MetadataLoader, node: yaml.ScalarNode) -> int | str:
    text = loader.construct_scalar(node)
    return int(text) if _DECIMAL.fullmatch(text) else text


for _tag in NUMBERS:
    _MetadataLoader.add_constructor(_tag, _number)


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
        self._metadata = self.path / METADATA_FILE
        try:
            self._information = _information(self._metadata) if self.path.is_dir() else None
            self.files = _files(self.path, self._information)
        except OSError as error:
            raise BagError(f"{path} cannot be read: {reason(error)}: give the path of an MCAP file") from None

    def contents(self, wanted: Wanted) -> McapContents:
        """Read all files, and count their messages; those that are wanted are kept.

        Raises
        ------
        BagError
            If a file is no bag, cut off or damaged, or the folder's metadata do not fit it.
        """
        contents = McapContents(wanted)
        for file in self.files:
            kept = 0
            for size, found in read_file(file, contents):
                contents.kept.append(found)
                kept += sum(len(messages.data) + len(messages) * _PER_MESSAGE for messages in found.values())
                if kept > max(_KEPT_AT_LEAST, _KEPT_PER_BYTE * file.stat().st_size):
                    raise BagError(
                        f"{file} has messages of {kept} bytes in a file of {file.stat().st_size}, more than is read: "
                        "record it again"
                    )
                self.progress(size)
        if self._information is not None:
            _hold_metadata(self._metadata, self._information, contents)
        return contents


def is_one_bag(folder: Path) -> bool:
    """Whether a folder is that of one rosbag2 recording, by its metadata or by the names of its files.

    Without metadata, as a recorder leaves ``NAME`` that was killed, they are ``NAME_0.mcap``, ``NAME_1.mcap`` …
    """
    if os.path.exists(folder / METADATA_FILE):
        return True
    suffix = next((suffix for suffix in SUFFIXES if _ending(folder, suffix)), "")
    numbers = _numbers(folder, suffix) if suffix else set()
    return bool(numbers) and numbers == {*range(len(numbers))}


def _ending(folder: Path, *suffixes: str) -> list[Path]:
    """Files of a folder whose names end so, in capitals or not."""
    return [path for path in folder.glob("*") if path.name.lower().endswith(suffixes)]


def _numbers(folder: Path, suffix: str) -> set[int]:
    """Numbers of the files of a folder, if all are called as those of one recording; else none."""
    of_one = re.compile(rf"{re.escape(real_path(folder).name)}_(0|[1-9]\d{{0,5}}){re.escape(suffix)}")
    found = [of_one.fullmatch(path.name) for path in _ending(folder, suffix)]
    return {int(match[1]) for match in found if match} if all(found) else set()


def whole_of(file: Path) -> Path | None:
    """The folder of the bag that was split into several files, of which this is one; None if it is not."""
    folder = file.parent
    parts = _ending(folder, file.suffix) if file.suffix in SUFFIXES and file.is_file() else []
    return folder if len(parts) > 1 and is_one_bag(folder) else None


def missing_beside(file: Path) -> str | None:
    """The first file that is missing where all in a folder are called as those of a bag that was split; else None."""
    numbers = _numbers(file.parent, file.suffix) if file.suffix in SUFFIXES and file.is_file() else set()
    missing = {*range(max(numbers, default=0))} - numbers
    return f"{real_path(file).parent.name}_{min(missing)}{file.suffix}" if missing else None


def left_out(folder: Path, names: Iterable[str]) -> list[str]:
    """The names of bags in a folder that are none of those given."""
    return sorted({path.name for path in _ending(folder, *SUFFIXES)} - {*names})


def _files(path: Path, information: Mapping[str, Any] | None) -> list[Path]:
    """The files of a bag, in the order of recording."""
    if not path.is_dir():
        return [path]
    if information is not None:
        return [path / str(name) for name in information["relative_file_paths"]]
    if packed := sorted(_ending(path, _PACKED), key=natural_order):
        raise BagError(f"{packed[0]} is compressed as a whole: unpack all such files with 'unzstd'")
    files = sorted(_ending(path, *SUFFIXES), key=natural_order)
    if not files:
        raise BagError(f"{path} is a folder without MCAP files: give a bag")
    if len(files) > 1 and not is_one_bag(path):
        raise BagError(f"{path} holds {len(files)} bags, not one recording: give one of them")
    here = real_path(path)
    if away := [file.name for file in files if not real_path(file).is_relative_to(here)]:
        raise BagError(f"{path} holds {shown(away[0])}, a link out of it: give a whole bag")
    return [file for file in files if file.suffix.lower() == SUFFIXES[0]] or files


def _information(metadata: Path) -> Mapping[str, Any] | None:
    """Information in a rosbag2 folder's metadata; None without metadata, as a recorder leaves it that was killed."""
    if not metadata.exists():
        return None

    try:
        information: dict[str, Any] = load_yaml(read_text(metadata, LARGEST_METADATA), str(metadata), _MetadataLoader)[
            "rosbag2_bagfile_information"
        ]
        names = [str(name) for name in information["relative_file_paths"]]
    except (InputError, TypeError, LookupError):
        raise BagError(
            f"{metadata} is not the metadata of a rosbag2 bag: remove it, or remake it with 'ros2 bag reindex'"
        ) from None
    here, places = real_path(metadata.parent), set[Path]()
    for name in names:
        place = here / name if "\0" in name else real_path(here / name)
        if not place.is_relative_to(here):
            raise BagError(f"{metadata} names {shown(name)}, which is outside of its folder: give a whole bag")
        if place in places:
            raise BagError(f"{metadata} names {shown(name)} twice: remake it with 'ros2 bag reindex'")
        places.add(place)
    return information


def _hold_metadata(metadata: Path, information: Mapping[str, Any], contents: McapContents) -> None:
    """Refuse metadata that do not fit the files; what they leave out is not missed.

    Parameters
    ----------
    metadata : Path
        The metadata.yaml.
    information : mapping
        What it says under ``rosbag2_bagfile_information``.
    contents : McapContents
        Of all files.

    Raises
    ------
    BagError
        Naming the first entry that does not fit.
    """
    if str(information.get("compression_mode")).upper() == "MESSAGE":
        raise BagError(f"{metadata.parent}: {COMPRESSED_ONE_BY_ONE}")
    try:
        what = next(_misfits(metadata.parent, information, contents), "")
    except (TypeError, LookupError, AttributeError, ValueError):
        what = "structure: not that of a rosbag2 bag"
    if what:
        raise BagError(f"{metadata} does not fit its files: {what}: remake it with 'ros2 bag reindex'")
    for topic in information.get("topics_with_message_count", ()):  # of one without messages no file need tell
        name, message_type, encoding = (str(topic["topic_metadata"][part]) for part in _TOPIC)
        track = RawTrack(name, message_type, encoding)
        contents.tracks.setdefault(track.key, track)


def _misfits(folder: Path, said: Mapping[str, Any], contents: McapContents) -> Iterator[str]:
    """Contradictions between metadata and files, each with the declared value and the one found."""
    spans = contents.files
    whole = FileSpan("", sum(s.count for s in spans), min(s.first_ns for s in spans), max(s.last_ns for s in spans))
    for name in left_out(folder, map(str, said["relative_file_paths"])):
        yield f"relative_file_paths: {name} is left out"
    yield from _differs("storage_identifier", said.get("storage_identifier", "mcap"), "mcap")
    yield from _differs("compression_mode", str(said.get("compression_mode") or "NONE").upper(), "NONE")
    yield from _span_misfits("", said, whole)
    if "topics_with_message_count" in said:
        topics = _each_once(
            (tuple(topic["topic_metadata"][name] for name in _TOPIC), topic)
            for topic in said["topics_with_message_count"]
        )
        found = {(track.topic, track.message_type, track.encoding): track.count for track in contents.tracks.values()}
        for key in {**topics, **found}:
            count = topics[key]["message_count"] if key in topics else 0
            yield from _differs(f"messages on topic {key[0]}", count, found.get(key, 0))
    if said.get("files") is not None:
        names, by_name = [*map(str, said["relative_file_paths"])], _each_once((f["path"], f) for f in said["files"])
        yield from _differs("files", sorted(by_name), sorted(names))
        for name, span in zip(names, spans, strict=True):
            yield from _span_misfits(f"{span.name}: ", by_name[name], span)


def _each_once(said: Iterable[tuple[Any, Any]]) -> dict[Any, Any]:
    """What is said of each name; a ValueError if one comes twice."""
    found: dict[Any, Any] = {}
    for name, what in said:
        if found.setdefault(name, what) is not what:
            raise ValueError("twice")
    return found


def _span_misfits(whose: str, said: Mapping[str, Any], found: FileSpan) -> Iterator[str]:
    yield from _differs(f"{whose}message_count", said.get("message_count", found.count), found.count)
    if found.count and "starting_time" in said:
        start = said["starting_time"]["nanoseconds_since_epoch"]
        yield from _differs(f"{whose}starting_time", start, found.first_ns, _TOLERANCE_NS)
    if found.count and "duration" in said:
        length = found.last_ns - found.first_ns
        yield from _differs(f"{whose}duration", said["duration"]["nanoseconds"], length, _TOLERANCE_NS)


def _differs(what: str, said: Any, found: Any, by: int = 0) -> Iterator[str]:
    if abs(said - found) > by if by else said != found:
        yield f"{what}: {said!r:.40} said, {found!r:.40} found"


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
