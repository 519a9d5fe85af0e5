"""Files from outside, read within bounds: nothing endless, no YAML that multiplies."""

from __future__ import annotations

import errno
import json
import os
import re
import stat
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO, Final

import yaml

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import shown

MAX_CHUNK_BYTES: Final = 256 * 2**20
"""Largest size of an inflated chunk, bytes. Recorders make chunks of some MB, or of one message that is larger."""
MAX_METADATA_BYTES: Final = 2**20
"""Largest size of a metadata.yaml, bytes."""
_REAL: Final = re.compile(r"\s*[-+]?((\d+\.?\d*|\.\d+)(e[-+]?\d+)?|inf(inity)?|nan)\s*", re.ASCII | re.IGNORECASE)
"""How programs write numbers. Python also reads underscores and the digits of all scripts, which tell of a mistake."""


def real(text: str) -> float:
    """Read a number as programs write them.

    Raises
    ------
    ValueError
        If it is none, or Python's alone.
    """
    if not _REAL.fullmatch(text):
        raise ValueError(f"no number: {text!r}")
    return float(text)


def as_path(given: str | PathLike[str], what: str = "file", remedy: str = "that of a file") -> Path:
    """A path that was given from Python.

    Raises
    ------
    InputError
        If it is none, such as None, a number or bytes.
    """
    try:
        return Path(given)
    except TypeError:
        raise InputError(f"{what} {shown(given)} is no path: give {remedy}, as a text or a Path") from None


def open_file(path: str | Path, *, pipes: bool = False) -> BinaryIO:
    """Open a file for reading; of a pipe, where one will do, its writer is waited for.

    Parameters
    ----------
    path : str or Path
    pipes : bool, optional
        Whether a pipe will do, such as the shell makes of ``<(command)``.

    Raises
    ------
    InputError
        If it is no path, a device or a socket, or a pipe that will not do.
    OSError, ValueError
        If it cannot be opened.
    """
    mode = os.stat(as_path(path)).st_mode
    is_pipe = stat.S_ISFIFO(mode)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not (stat.S_ISREG(mode) or (is_pipe and pipes)):
        raise InputError(f"{path} is {'a pipe' if is_pipe else 'a device'}: give a regular file")
    return open(path, "rb")


def read_text(path: str | Path, limit: int, *, kind: str = "a YAML file", pipes: bool = True) -> str:
    """The text of a file or a pipe, in UTF-8.

    Parameters
    ----------
    path : str or Path
    limit : int
        The most bytes it may have.
    kind : str, optional
        What is to be given, for the error.
    pipes : bool, optional
        Whether a pipe will do.

    Raises
    ------
    InputError
        If it cannot be read, is longer or no text.
    """
    try:
        with open_file(path, pipes=pipes) as stream:
            content = stream.read(limit + 1)
        if len(content) > limit:
            raise InputError(f"{path} is longer than the {limit} bytes that such a file may have: give another one")
        return content.decode("utf-8")
    except InputError:
        raise
    except (OSError, ValueError) as error:
        known: dict[type[Exception], str] = {
            FileNotFoundError: f"does not exist: give the path of {kind}",
            IsADirectoryError: "is a folder: give a file in it",
            UnicodeDecodeError: f"is not UTF-8 text: give {kind}",
        }
        other = f"cannot be read: {getattr(error, 'strerror', None) or error}: give another file"
        raise InputError(f"{path} {known.get(type(error), other)}") from None


class BoundedLoader(yaml.SafeLoader):
    """A YAML loader whose result is no larger than its text: without aliases, as in rcl.

    No key is given twice, as readers differ in which of the two they take.
    """

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Refuse an alias."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.MarkedYAMLError(
                problem="aliases (*name) are not read: write the value itself", problem_mark=self.get_mark()
            )
        return super().compose_node(parent, index)

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        """Refuse a key that is given twice."""
        node = super().compose_mapping_node(anchor)
        before = set[str]()
        for key in (key for key, _ in node.value if isinstance(key, yaml.ScalarNode)):
            if key.value in before:
                raise yaml.MarkedYAMLError(problem=f"{key.value!r} is given twice", problem_mark=key.start_mark)
            before.add(key.value)
        return node


def load_json(text: str | bytes, source: str, kind: str = "a JSON file") -> Any:
    """The content of a JSON text.

    Parameters
    ----------
    text : str or bytes
    source : str
        Where it is from, for the error.
    kind : str, optional
        What is to be given, for the error.

    Raises
    ------
    InputError
        If it is not readable, or nested too deeply.
    """
    try:
        return json.loads(text)
    except (RecursionError, ValueError) as error:
        where = f", line {error.lineno}, column {error.colno}" if isinstance(error, json.JSONDecodeError) else ""
        raise InputError(f"{source}{where}: not readable as JSON: give {kind}") from None


def load_yaml(text: str, source: str, loader: type[BoundedLoader] = BoundedLoader) -> Any:
    """The content of a YAML text.

    Parameters
    ----------
    text : str
    source : str
        Where it is from, for the error.
    loader : type, optional

    Raises
    ------
    InputError
        If it is not readable; the message names the line.
    """
    try:
        return yaml.load(text, loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        where = f", line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        raise InputError(f"{source}{where}: not readable as YAML: {error.problem or error.context}") from None
    except RecursionError:
        raise InputError(f"{source}: not readable as YAML: it is nested too deeply: write it flatter") from None
    except Exception as error:  # the constructors fail in many ways on explicit tags
        problem = (str(error).splitlines() or [""])[0] or type(error).__name__
        raise InputError(f"{source}: not readable as YAML: {problem}") from None
