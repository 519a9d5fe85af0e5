"""Outputs of a verb: files that are refused before the work and written after it, and the answer on stdout."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Final

from lie_rigid_body.command_line import JSON_SUFFIX, STDOUT, require_suffix
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import printable
from lie_rigid_body.system import console
from lie_rigid_body.system.output_file import require_other, require_room, write_file

_SUFFIXES: Final = {"json": JSON_SUFFIX, "report": ".html", "plot": ".png", "out": ".mcap", "parameters": ".yaml"}


def require_outputs(
    given: argparse.Namespace,
    inputs: Iterable[str | Path],
    *options: str,
    with_film: bool = False,
    suffixes: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Refuse files before the work that are of another kind, inputs, one file, or could not be written after it.

    Parameters
    ----------
    given : argparse.Namespace
        Arguments of a verb, with `FORCE`.
    inputs : iterable of str or Path
    *options : str
        Names of the options that name files to write: ``json``, ``report``, ``plot``, ``parameters`` or ``out``; one
        is None where it is not wanted, `STDOUT` where it is none.
    with_film : bool, optional
        Whether a page has a film by plotly, which has to be installed.
    suffixes : mapping of str to str, optional
        Endings of the files of a verb that are not the usual ones.

    Raises
    ------
    InputError, BagError
    """
    wanted = {name: path for name in options if (path := getattr(given, name))}
    for name, path in wanted.items():
        require_suffix(f"--{name}", path, (_SUFFIXES | dict(suffixes))[name])
    if "report" in wanted and with_film and not find_spec("plotly"):
        raise InputError("--report needs plotly: pip install 'lie-rigid-body[report]'")
    paths = [*wanted.values()]
    read = [*inputs] if wanted else []
    for number, path in enumerate(paths):
        require_room(path, read, overwrite=given.force)
        require_other(path, paths[:number], "output")


def emit(
    given: argparse.Namespace,
    files: Mapping[str | None, Callable[[], bytes | None]],
    text: Callable[[], str],
    content: Callable[[], object],
    *,
    passed: bool = True,
) -> int:
    """Write the files of a verb, print its answer on stdout, and return its exit status.

    Parameters
    ----------
    given : argparse.Namespace
        Arguments of the verb, with `FORCE` and `json_option`.
    files : mapping of str or None to callable
        Function that gives the content of each file, by its path, or writes it itself; None where it is not wanted.
    text : callable
        Gives the answer for people; lines that name the files follow it.
    content : callable
        Gives the answer for programs, for JSON; a number that is not finite becomes null.
    passed : bool, optional
        Whether no law and no limit is broken, and no mistake is named.
    """
    os.environ["MPLBACKEND"] = "agg"  # no window is needed, and the one that Jupyter names may not be installed
    made = {path: make() for path, make in files.items() if path is not None}
    for_programs = ""
    if given.json is not None:
        for_programs = json.dumps(json.loads(json.dumps(content()), parse_constant=lambda name: None), indent=2)
    if given.json:
        made[given.json] = f"{for_programs}\n".encode()
    lines = [for_programs] if given.json == STDOUT else [text(), *(f"wrote {printable(name)}" for name in made)]
    for path, data in made.items():
        if data is not None:
            write_file(path, data, overwrite=given.force)
    console.say("\n".join(lines), done=", ".join(f"{name} is written" for name in made))
    return console.SUCCESS if passed else console.BROKEN
