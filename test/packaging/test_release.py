"""What is released works where no clone is: the wheel, and the source distribution that colcon builds."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tarfile
import venv
from pathlib import Path

import pytest
from test_layouts import (
    NOT_SOURCES,
    ROOT,
    assert_works,
    borrow_libraries,
    clean_environment,
    colcon_layout,
    names,
    pip_install,
    run,
)

import lie_rigid_body
from lie_rigid_body.__main__ import VERBS

pytestmark = pytest.mark.slow
VERSION = lie_rigid_body.__version__


@pytest.fixture(scope="module")
def distributions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a wheel and a source distribution, the wheel built from the latter as `build` does it."""
    pytest.importorskip("build")
    home = tmp_path_factory.mktemp("release")
    copy = home / "clone"
    shutil.copytree(ROOT, copy, symlinks=True, ignore=NOT_SOURCES)
    build = (sys.executable, "-m", "build", "--no-isolation", "--outdir", str(home / "dist"), str(copy))
    run(*build, cwd=home, env=clean_environment(home))
    return home / "dist"


@pytest.fixture
def unpacked(distributions: Path, tmp_path: Path) -> Path:
    """The source distribution in a workspace of colcon."""
    with tarfile.open(distributions / f"lie_rigid_body-{VERSION}.tar.gz") as archive:
        archive.extractall(tmp_path / "src", filter="data")
    return tmp_path / "src" / f"lie_rigid_body-{VERSION}"


def test_there_are_a_wheel_and_sources_that_an_index_takes(distributions: Path, tmp_path: Path) -> None:
    wheel, sources = sorted(distributions.iterdir(), key=lambda path: path.suffix, reverse=True)
    assert [wheel.name, sources.name] == [
        f"lie_rigid_body-{VERSION}-py3-none-any.whl",
        f"lie_rigid_body-{VERSION}.tar.gz",
    ]
    pytest.importorskip("twine")
    check = (sys.executable, "-m", "twine", "check", "--strict", str(wheel), str(sources))
    said = run(*check, cwd=tmp_path, env=clean_environment(tmp_path))
    assert said.count("PASSED") == 2


def test_the_wheel_in_an_empty_environment_does_what_the_first_screen_shows(
    distributions: Path, tmp_path: Path
) -> None:
    home = tmp_path / "environment"
    venv.create(home, symlinks=True)
    borrow_libraries(home)
    [wheel] = distributions.glob("*.whl")
    pip_install(tmp_path, home / "bin/python", str(wheel))
    said = try_installed(home / "bin/python", ROOT, tmp_path)
    assert said.startswith(f"lie_rigid_body {VERSION} ")


@pytest.mark.parametrize("version", ["3.10"])
def test_the_wheel_works_with_another_python(distributions: Path, tmp_path: Path, version: str) -> None:
    """With the libraries that pip chooses for it."""
    python = python_of(version)
    run(str(python), "-m", "venv", "environment", cwd=tmp_path, env=clean_environment(tmp_path))
    inside = tmp_path / "environment/bin/python"
    [wheel] = distributions.glob("*.whl")
    install = (str(inside), "-m", "pip", "install", "--no-compile", str(wheel))
    done = subprocess.run(install, cwd=tmp_path, env=clean_environment(tmp_path), capture_output=True, check=False)
    if done.returncode != 0:
        pytest.skip("pip reaches no index of packages")
    said = try_installed(inside, ROOT, tmp_path).partition("\n")[0]
    assert said.startswith(f"lie_rigid_body {VERSION} ")
    assert f" {version}." in said


def test_colcon_builds_the_unpacked_sources(unpacked: Path, tmp_path: Path) -> None:
    layout = colcon_layout(tmp_path)
    assert names(layout.executables) == {*VERBS} | {"lie-rigid-body"}
    assert_works(layout, tmp_path / "install", tmp_path)


def test_the_sources_are_the_clone(unpacked: Path) -> None:
    """Every file that git knows, so that what is unpacked can be tested and its pages built."""
    listed = subprocess.run(("git", "ls-files"), cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        pytest.skip("this is no clone")
    tracked = listed.stdout.splitlines()
    assert len(tracked) > 500
    assert [name for name in tracked if not (unpacked / name).exists()] == []


def try_installed(python: Path, release: Path, folder: Path) -> str:
    """What the script says that users' first steps are tried with."""
    program = (str(python), str(ROOT / "scripts/try_installed.py"), str(release))
    done = subprocess.run(
        program, cwd=folder, env=clean_environment(folder), capture_output=True, text=True, timeout=600, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def python_of(version: str) -> Path:
    """An interpreter that runs; a shim on the path may fail."""
    beside = Path.home().glob(f".pyenv/versions/{version}.*/bin/python{version}")
    for candidate in (*beside, shutil.which(f"python{version}")):
        if candidate and subprocess.run((candidate, "-c", "import ensurepip"), capture_output=True).returncode == 0:
            return Path(candidate)
    pytest.skip(f"there is no Python {version} here")
