"""Where compiled code is kept from one run to the next."""

from __future__ import annotations

import hashlib
import inspect
import os
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def cache_folder(loop: Callable[..., None]) -> Path | None:
    """A folder of this user that can be written to, or none."""
    name = f"lie_rigid_body/{_digest(loop)}"
    homes = [os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"), os.path.expanduser("~/.cache")]
    private = str(Path(tempfile.gettempdir()) / f"cache-{os.getuid()}")
    for home in [*homes, private]:
        if home and _is_own_folder(Path(home) / name):
            return Path(home) / name
    return None


def _is_own_folder(path: Path) -> bool:
    """Whether a folder is there, made if need be, that this user owns and may write to: code is loaded from it."""
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        return path.stat().st_uid == os.getuid() and os.access(path, os.W_OK)
    except OSError:
        return False


def _digest(loop: Callable[..., None]) -> str:
    """Of every source beside the loop's own and beside this, as numba itself notices only a change of the one file; of
    Python and of the libraries that make the code.
    """
    folders = (Path(__file__).parent, Path(inspect.getfile(loop)).parent)
    sources = [path for folder in folders for path in sorted(folder.glob("*.py"))]
    content = b"".join(path.read_bytes() for path in sources)
    makers = [sys.version, *(_version(name) for name in ("numba", "llvmlite", "numpy"))]
    return hashlib.sha256(content + "".join(makers).encode()).hexdigest()[:16]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def mark(folder: Path, function: Callable[..., None]) -> Path:
    """Is there once the function has been compiled into the folder."""
    return folder / f"{function.__module__}.{function.__name__}"
