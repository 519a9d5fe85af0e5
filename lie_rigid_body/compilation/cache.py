"""The folder in which compiled code is kept from one run to the next."""

from __future__ import annotations

import ast
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec, resolve_name
from pathlib import Path


def cache_folder(function: Callable[..., None]) -> Path | None:
    """A folder for the compiled form of a function, which only this user can write to; None if there is no place."""
    name = f"lie_rigid_body/{_digest(function)}"
    homes = [os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"), os.path.expanduser("~/.cache")]
    private = str(Path(tempfile.gettempdir()) / f"cache-{os.getuid()}")
    for home in [*homes, private]:
        if home and _is_own_folder(Path(home) / name):
            return Path(home) / name
    return None


def _is_own_folder(path: Path) -> bool:
    """Whether this user owns the folder, made if need be, and may write to it: code that is loaded has to be safe."""
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        return path.stat().st_uid == os.getuid() and os.access(path, os.W_OK)
    except OSError:
        return False


def _digest(function: Callable[..., None]) -> str:
    """A digest of all source that goes into the compiled code, and of the versions of Python and of its compiler.

    Numba itself notices only a change of the function's own file, while the code holds kernels and constants of others.
    """
    files = _source_files(function.__module__) | set(Path(__file__).parent.glob("*.py"))
    content = b"".join(hashlib.sha256(path.read_bytes()).digest() for path in sorted(files))
    versions = [sys.version, *(_version(name) for name in ("numba", "llvmlite", "numpy"))]
    return hashlib.sha256(content + "".join(versions).encode()).hexdigest()[:16]


def _source_files(module: str) -> set[Path]:
    """The file of a module and the files of its package that it imports, directly or not."""
    package, waiting, found = module.partition(".")[0], {module}, dict[str, Path]()
    while waiting:
        name = waiting.pop()
        spec = find_spec(name)
        if spec is None or spec.origin is None:
            continue
        found[name] = Path(spec.origin)
        imported = _imports(found[name].read_bytes(), name if spec.submodule_search_locations else spec.parent)
        waiting |= {one for one in imported if one.partition(".")[0] == package and one not in found}
    return set(found.values())


@cache
def _imports(source: bytes, package: str | None) -> frozenset[str]:
    """Names of the modules that a source imports; ``from package import name`` may import a module of that name."""
    found = set[str]()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = resolve_name("." * node.level + (node.module or ""), package)
            found.add(base)
            found.update(f"{base}.{alias.name}" for alias in node.names if _is_package(base))
    return frozenset(found)


def _is_package(name: str) -> bool:
    spec = find_spec(name)
    return spec is not None and spec.submodule_search_locations is not None


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
