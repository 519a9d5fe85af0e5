"""Outputs of a verb: files that are refused before the work and written after it, and the answer on stdout."""

from __future__ import annotations

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
    outputs: Mapping[str, str | None],
    inputs: Iterable[str | Path],
    *,
    overwrite: bool,
    with_film: bool = False,
    suffixes: Mapping[str, str] = MappingProxyType({}),
) -> None:
    """Refuse files before the work that are of another kind, inputs, one file, or could not be written after it.

    Parameters
    ----------
    outputs : mapping of str to str or None
        Files by the names of their options: ``json``, ``report``, ``plot``, ``parameters`` or ``out``; None where one
        is not wanted, `STDOUT` where it is none.
    inputs : iterable of str or Path
    overwrite : bool
        Whether existing files are replaced.
    with_film : bool, optional
        Whether a page has a film by plotly, which has to be installed.
    suffixes : mapping of str to str, optional
        Endings of the files of a verb that are not the usual ones.

    Raises
    ------
    InputError, BagError
    """
    wanted = {name: path for name, path in outputs.items() if path}
    for name, path in wanted.items():
        require_suffix(f"--{name}", path, (_SUFFIXES | dict(suffixes))[name])
    if "report" in wanted and with_film and not find_spec("plotly"):
        raise InputError("--report needs plotly: pip install 'lie-rigid-body[report]'")
    paths = [*wanted.values()]
    read = [*inputs] if wanted else []
    for number, path in enumerate(paths):
        require_room(path, read, overwrite=overwrite)
        require_other(path, paths[:number], "output")


def emit(
    files: Mapping[str | None, Callable[[], bytes | None]],
    text: Callable[[], str] | None = None,
    content: Callable[[], object] | None = None,
    *,
    as_json: str | None = None,
    overwrite: bool = False,
    passed: bool = True,
) -> int:
    """Write the files of a verb, print its answer on stdout, and return its exit status.

    Parameters
    ----------
    files : mapping of str or None to callable
        Function that gives the content of each file, by its path, or writes it itself; None where it is not wanted.
    text : callable, optional
        Gives the answer for people; lines that name the files follow it.
    content : callable, optional
        Gives the answer for programs, for JSON; a number that is not finite becomes null.
    as_json : str, optional
        File of the answer for programs; `STDOUT`: that is the answer on stdout.
    overwrite : bool, optional
        Whether existing files are replaced.
    passed : bool, optional
        Whether no law and no limit is broken, and no mistake is named.
    """
    os.environ["MPLBACKEND"] = "agg"  # no window is needed, and the one that Jupyter names may not be installed
    made = {path: make() for path, make in files.items() if path is not None}
    for_programs = ""
    if content and as_json is not None:
        for_programs = json.dumps(json.loads(json.dumps(content()), parse_constant=lambda name: None), indent=2)
    if as_json:
        made[as_json] = f"{for_programs}\n".encode()
    if as_json == STDOUT:
        lines = [for_programs]
    else:
        lines = [*([text()] if text else []), *(f"wrote {printable(name)}" for name in made)]
    for path, data in made.items():
        if data is not None:
            write_file(path, data, overwrite=overwrite)
    console.say("\n".join(lines), done=", ".join(f"{name} is written" for name in made))
    return console.SUCCESS if passed else console.BROKEN
