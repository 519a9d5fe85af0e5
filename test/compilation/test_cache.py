"""Compiled code is kept under a name that changes with everything it is made from."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from lie_rigid_body.compilation import cache
from lie_rigid_body.compilation.cache import cache_folder
from lie_rigid_body.motion.moser_veselov import loop as moser_veselov_loop

PACKAGE = {
    "__init__.py": "",
    "constants.py": "from sizes_of_something import SIZE\nFACTOR = 2.0\n",
    "kernels.py": "from made_up.constants import FACTOR\ndef twice(x):\n    return FACTOR * x\n",
    "inner/__init__.py": "",
    "inner/loop.py": "def advance(x):\n    from .. import kernels\n    return kernels.twice(x)\n",
    "inner/neighbour.py": "BESIDE = 1\n",
}


@pytest.fixture
def made_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    folder = tmp_path / "made_up"
    for name, source in PACKAGE.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield folder
    for name in [name for name in sys.modules if name.partition(".")[0] == "made_up"]:
        del sys.modules[name]


@pytest.mark.parametrize(
    ("file", "counts"),
    [("constants.py", True), ("kernels.py", True), ("inner/loop.py", True), ("inner/neighbour.py", False)],
)
def test_a_change_of_any_file_that_the_code_is_made_from_changes_its_name(made_up: Path, file: str, counts: bool):
    advance = importlib.import_module("made_up.inner.loop").advance

    before = cache._digest(advance)
    (made_up / file).write_text(PACKAGE[file] + "# changed\n", encoding="utf-8")
    cache._digest.cache_clear()
    assert (cache._digest(advance) != before) is counts


def test_the_digest_is_that_of_another_process_which_loaded_less_or_more():
    """It follows the imports in the source, not what happens to be loaded: the process that compiles imports little."""
    files = {path.name for path in cache._source_files(moser_veselov_loop.__name__)}
    assert {"double_double.py", "numbers.py", "layout.py", "compiler.py"} <= files
    assert "scenario.py" not in files


def test_the_series_that_a_loop_has_taken_in_are_part_of_it():
    files = cache._source_files("lie_rigid_body.motion.munthe_kaas.loop")
    assert any(path.parts[-2:] == ("lie", "series.py") for path in files)


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The first folder of caches, and beside it another one."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "open" / "first"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "second"))
    (tmp_path / "open").mkdir(mode=0o700)
    cache._say_that_others_write.cache_clear()
    return tmp_path / "open"


def test_code_is_kept_in_the_first_folder_that_is_private(home: Path) -> None:
    found = cache_folder(moser_veselov_loop.advance)
    assert found is not None
    assert found.is_relative_to(home / "first")
    for made in (found, found.parent, home / "first"):
        assert made.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="a folder has no mode here")
@pytest.mark.parametrize("mode", [0o777, 0o707, 0o702])
@pytest.mark.parametrize("which", ["open", "open/first", "open/first/lie_rigid_body"])
def test_where_another_user_may_write_no_code_is_kept(
    home: Path, mode: int, which: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nor in a folder below, which they could move away. One line says so."""
    folder = home.parent / which
    folder.mkdir(parents=True, exist_ok=True)
    folder.chmod(mode)
    for _ in range(2):
        found = cache_folder(moser_veselov_loop.advance)
        assert found is not None
        assert found.is_relative_to(home.parent / "second")
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "first/lie_rigid_body" in said


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="a folder has no mode here")
@pytest.mark.parametrize(
    ("name", "members", "chosen"),
    [("mine", [], "open"), ("mine", ["mine"], "open"), ("mine", ["another"], "second"), ("users", [], "second")],
)
def test_where_a_group_may_write_code_is_kept_if_it_is_that_of_the_user_alone(
    home: Path, name: str, members: list[str], chosen: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those whose primary group it is are not among its members: a group that is called as the user has no others."""
    import grp
    import pwd

    number = os.getgid() or 4711
    monkeypatch.setattr(grp, "getgrgid", lambda number: grp.struct_group((name, "x", number, members)))
    monkeypatch.setattr(pwd, "getpwuid", lambda user: pwd.struct_passwd(("mine", "x", user, number, "", "/", "")))
    home.chmod(0o770)
    os.chown(home, -1, number)
    found = cache_folder(moser_veselov_loop.advance)
    assert found is not None
    assert found.is_relative_to(home.parent / chosen)


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root may give folders away")
@pytest.mark.parametrize("which", ["open", "open/first"])
def test_in_the_folder_of_another_user_no_code_is_kept(home: Path, which: str) -> None:
    folder = home.parent / which
    folder.mkdir(parents=True, exist_ok=True)
    os.chown(folder, 12345, 12345)
    found = cache_folder(moser_veselov_loop.advance)
    assert found is not None
    assert found.is_relative_to(home.parent / "second")


def test_a_link_on_the_way_to_the_folder_is_followed_once(home: Path) -> None:
    """Whoever may set it anew would else choose the code that is loaded."""
    (home.parent / "safe").mkdir(mode=0o700)
    (home / "first").symlink_to(home.parent / "safe")
    found = cache_folder(moser_veselov_loop.advance)
    assert found is not None
    assert found.is_relative_to(home.parent.resolve() / "safe")
