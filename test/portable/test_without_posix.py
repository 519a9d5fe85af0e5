"""What runs without ROS runs where Python has nothing that only POSIX gives, to the same bytes.

`posix_taken_away` hides that from the package, and from no other: so any use of it, at import or later, is an error.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import every_verb
import pytest

HERE = Path(__file__).parent
Python = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def without_posix(tmp_path_factory: pytest.TempPathFactory) -> Python:
    """Runs a Python without POSIX, whose processes are such as well."""
    cache = tmp_path_factory.mktemp("cache")

    def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, "PYTHONPATH": str(HERE / "posix_taken_away"), "NUMBA_CACHE_DIR": str(cache)}
        return subprocess.run(
            [sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False
        )

    return run


def files(folder: Path) -> dict[str, list[bytes]]:
    """Lines of all files."""
    found = {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*")) if path.is_file()}
    return {name: path.read_bytes().split(b"\n") for name, path in found.items()}


@pytest.mark.long
@pytest.mark.skipif(not find_spec("pyarrow"), reason="pyarrow is not installed")
@pytest.mark.parametrize(
    "left_out", [("campaign", "plot", "compile"), pytest.param((), marks=pytest.mark.slow)], ids=len
)
def test_every_verb_gives_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, asked_here: None, without_posix: Python, left_out: tuple[str, ...]
) -> None:
    ordinary, portable = tmp_path / "ordinary", tmp_path / "portable"
    ordinary.mkdir()
    portable.mkdir()
    monkeypatch.chdir(ordinary)
    every_verb.main(ordinary, *left_out)
    done = without_posix(every_verb.__file__, portable, *left_out)
    assert (done.returncode, done.stderr) == (0, "")
    here, there = files(ordinary), files(portable)
    differing = {name for name in here.keys() | there.keys() if here.get(name) != there.get(name)}
    assert {name: (here.get(name), there.get(name)) for name in differing} == {}


@pytest.mark.parametrize(
    "code",
    [
        "import fcntl",
        "from os import O_DIRECTORY",
        "import signal; signal.SIGHUP",
        "import os; os.getuid()",
        "import os; os.sched_getaffinity(0)",
    ],
)
def test_a_use_of_posix_would_be_seen(code: str, tmp_path: Path, without_posix: Python) -> None:
    """At import, and in every process that another starts."""
    package = tmp_path / "lie_rigid_body"
    package.mkdir()
    (package / "__init__.py").write_text(code)
    spawned = (
        "import subprocess, sys; sys.exit(subprocess.run([sys.executable, '-c', 'import lie_rigid_body']).returncode)"
    )
    done = without_posix("-c", f"import os; os.chdir({str(tmp_path)!r}); {spawned}")
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith(("ModuleNotFoundError", "ImportError", "AttributeError"))
