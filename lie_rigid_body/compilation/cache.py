"""The folder in which compiled code is kept from one run to the next."""

from __future__ import annotations

import ast
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from importlib.util import resolve_name
from pathlib import Path
from typing import Final

from lie_rigid_body.foundation.wording import printable
from lie_rigid_body.system.portable import is_private, user

_HOMES: Final = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA")
"""Variables of the environment that may name the folder of caches."""


def cache_folder(function: Callable[..., None]) -> Path | None:
    """Folder for the compiled form of a function, made if need be; None if there is no place for it.

    Only this user can write to it, as code that is loaded has to be safe. A folder that others can write to is left
    out, and a line on stderr says so.
    """
    named = [os.environ[name] for name in _HOMES if os.environ.get(name)]
    for home in (*named, os.path.expanduser("~/.cache"), f"{tempfile.gettempdir()}/cache-{user()}"):
        folder = Path(home, "lie_rigid_body", _digest(function))
        with suppress(OSError):
            for each in reversed((folder, *folder.parents)):  # `mkdir` itself gives the mode to the last alone
                if not each.exists():
                    each.mkdir(mode=0o700, exist_ok=True)
            if is_private(folder := folder.resolve()):  # a link on the way to it may be set anew
                return folder
            _say_that_others_write(folder.parent)
    return None


@cache
def _say_that_others_write(folder: Path) -> None:
    """Say once that a folder is not used, unless this process works for another one, which says it."""
    from multiprocessing import parent_process  # only now: it takes a while to load

    if parent_process() is None:
        where = printable(str(folder))
        with suppress(OSError, ValueError):
            print(f"compiled code is not kept in {where}: others may write there or above: chmod go-w", file=sys.stderr)


@cache
def _digest(function: Callable[..., None]) -> str:
    """Digest of all source that goes into the compiled code, and of the versions of Python and of its compiler.

    Numba itself notices only a change of the function's own file, while the code holds kernels and constants of others.
    """
    files = _source_files(function.__module__) | set(Path(__file__).parent.glob("*.py"))
    content = b"".join(hashlib.sha256(path.read_bytes()).digest() for path in sorted(files))
    versions = [sys.version, *(_version(name) for name in ("numba", "llvmlite", "numpy"))]
    return hashlib.sha256(content + "".join(versions).encode()).hexdigest()[:16]


def _source_files(module: str) -> set[Path]:
    """Files of a module and of the modules of its package that it imports, directly or not."""
    package = module.partition(".")[0]
    root, waiting, found = Path(str(sys.modules[package].__file__)).parent.parent, [module], set[Path]()
    while waiting:
        *above, last = waiting.pop().split(".")
        for parts, file in ((above, f"{last}.py"), ([*above, last], "__init__.py")):
            path = root.joinpath(*parts, file)
            if path not in found and path.is_file() and path.is_relative_to(root / package):
                found.add(path)
                waiting += _imports(path.read_bytes(), ".".join(parts))
    return found


def _imports(source: bytes, package: str) -> Iterator[str]:
    """Names that a source imports, modules among them, by their full names."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = resolve_name("." * node.level + (node.module or ""), package)
            yield from (base, *(f"{base}.{alias.name}" for alias in node.names))


def _version(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version  # only now: it loads the library of e-mails

    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def is_kept(function: Callable[..., None]) -> bool:
    """Whether the compiled form of a function is in its folder."""
    folder = cache_folder(function)
    return folder is not None and mark(folder, function).exists()


def mark(folder: Path, function: Callable[..., None]) -> Path:
    """A file that is in the folder as soon as the function has been compiled into it."""
    return folder / f"{function.__module__}.{function.__name__}"
