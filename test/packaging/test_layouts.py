"""Every way to install the package gives working executables that find the shipped scenarios."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

from lie_rigid_body.__main__ import VERBS

ROOT = Path(__file__).resolve().parents[2]
UNWANTED = ".git .venv* .cache .*_cache .hypothesis __pycache__ *.egg-info build install log dist"
NOT_SOURCES = shutil.ignore_patterns(*UNWANTED.split())
CONFIGURATION = {str(file.relative_to(ROOT / "config")) for file in (ROOT / "config").rglob("*.*") if file.is_file()}
SCENARIOS = {file.stem for file in (ROOT / "config").glob("*.yaml")}


@dataclass(frozen=True)
class Layout:
    """One installation: where its executables are, and what has to be set to run them."""

    executables: Path
    environment: Mapping[str, str]
    by_verb: bool

    def python(self) -> str:
        """The interpreter that the executables name in their first line."""
        return (self.executables / "lie-rigid-body").read_text(encoding="utf-8").splitlines()[0].removeprefix("#!")

    def run(self, verb: str, *arguments: str, cwd: Path) -> str:
        program = [verb] if self.by_verb else ["lie-rigid-body", verb]
        return run(str(self.executables / program[0]), *program[1:], *arguments, cwd=cwd, env=self.environment)


def run(*command: str, cwd: Path, env: Mapping[str, str]) -> str:
    done = subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, f"{command} gave {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def clean_environment(home: Path) -> dict[str, str]:
    """This process's environment without what pytest or a sourced workspace put into it."""
    dropped = ("PYTEST", "COLCON", "AMENT", "PYTHONPATH", "COV_CORE")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(dropped)}
    return kept | {"COLCON_HOME": str(home / "colcon"), "PIP_DISABLE_PIP_VERSION_CHECK": "1"}


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    """A copy of the clone, so that no build folder appears in the clone itself."""
    copy = tmp_path / "src" / "lie_rigid_body"
    shutil.copytree(ROOT, copy, symlinks=True, ignore=NOT_SOURCES)
    return copy


def colcon(workspace: Path, verb: str, *arguments: str) -> str:
    pytest.importorskip("colcon_ros")
    start = "import sys; from colcon_core.command import main; sys.argv[0] = 'colcon'; sys.exit(main())"
    return run(sys.executable, "-c", start, verb, *arguments, cwd=workspace, env=clean_environment(workspace))


def colcon_layout(workspace: Path, *options: str) -> Layout:
    """Build the workspace, and take the environment that its own set-up script makes."""
    said = colcon(workspace, "build", *options)
    assert "Finished <<< lie_rigid_body" in said
    script = ". install/local_setup.sh && env -0"
    lines = run("sh", "-c", script, cwd=workspace, env=clean_environment(workspace)).split("\0")
    environment = dict(line.partition("=")[::2] for line in lines if line)
    return Layout(workspace / "install/lie_rigid_body/lib/lie_rigid_body", environment, by_verb=True)


def names(folder: Path) -> set[str]:
    return {file.name for file in folder.iterdir()}


def assert_works(layout: Layout, code: Path, tmp_path: Path) -> None:
    """The executables run the code that was installed, find the scenarios, and certify what they record."""
    script = "import lie_rigid_body; print(lie_rigid_body.__file__)"
    found = run(layout.python(), "-c", script, cwd=tmp_path, env=layout.environment)
    assert Path(found.strip()).is_relative_to(code)
    config = Path(found.strip()).parent / "config"
    assert [name for name in CONFIGURATION if not (config / name).is_file()] == []
    listed = layout.run("scenarios", cwd=tmp_path)
    assert [name for name in sorted(SCENARIOS) if name not in listed] == []
    name = min(SCENARIOS)
    said = layout.run("record", "my out.mcap", "--scenario", name, "--duration", "0.5", cwd=tmp_path)
    command = "ros2 run lie_rigid_body check" if layout.by_verb else "lie-rigid-body check"
    assert said.splitlines()[-1].endswith(f": {command} 'my out.mcap'")
    layout.run("check", "my out.mcap", cwd=tmp_path)
    # pytest finds the plugin for tests of filters by itself
    markers = run(layout.python(), "-m", "pytest", "--markers", cwd=tmp_path, env=layout.environment)
    assert "@pytest.mark.attitude_run(" in markers


SLOW = pytest.mark.slow


@SLOW
@pytest.mark.parametrize("options", [("--symlink-install",), ("--merge-install",)], ids=" ".join)
def test_colcon_build(sources: Path, tmp_path: Path, options: tuple[str, ...]) -> None:
    workspace = sources.parents[1]
    layout = colcon_layout(workspace, *options)
    if "--merge-install" in options:
        layout = Layout(workspace / "install/lib/lie_rigid_body", layout.environment, by_verb=True)
    prefix = layout.executables.parents[1]
    assert names(layout.executables) == {*VERBS} | {"lie-rigid-body"}
    assert (prefix / "share/ament_index/resource_index/packages/lie_rigid_body").is_file()
    assert names(prefix / "share/lie_rigid_body") >= {"package.xml", "config", "launch"}
    config = prefix / "share/lie_rigid_body/config"
    assert names(config) == names(sources / "config")
    assert [name for name in CONFIGURATION if not (config / name).is_file()] == []
    assert names(prefix / "share/lie_rigid_body/launch") >= {file.name for file in sources.glob("launch/*.launch.py")}
    assert_works(layout, workspace, tmp_path)
    assert_colcon_test_runs_pytest(workspace, *options)


def assert_colcon_test_runs_pytest(workspace: Path, *options: str) -> None:
    merged = [option for option in options if option == "--merge-install"]
    one = ("--pytest-args", "test/packaging/test_development.py")
    colcon(workspace, "test", "--return-code-on-test-failure", *merged, *one)
    result = (workspace / "build/lie_rigid_body/pytest.xml").read_text(encoding="utf-8")
    assert 'failures="0"' in result
    assert "test_linters_are_pinned_to_one_version" in result


@SLOW
def test_install_as_a_distribution_package(sources: Path, tmp_path: Path) -> None:
    """What bloom's Debian rules do."""
    root = tmp_path / "root"
    where = (
        "--root",
        str(root),
        "--prefix",
        "/opt/ros/jazzy",
        "--install-scripts",
        "/opt/ros/jazzy/lib/lie_rigid_body",
    )
    install = (sys.executable, "setup.py", "install", "--single-version-externally-managed", *where)
    run(*install, cwd=sources, env=clean_environment(tmp_path))
    prefix = root / "opt/ros/jazzy"
    (site,) = prefix.glob("lib/python3*/site-packages")
    environment = clean_environment(tmp_path) | {"PYTHONPATH": str(site)}
    layout = Layout(prefix / "lib/lie_rigid_body", environment, by_verb=True)
    assert names(layout.executables) == {*VERBS} | {"lie-rigid-body"}
    assert_works(layout, site, tmp_path)


@SLOW
@pytest.mark.parametrize("options", [(), ("--editable",)], ids=" ".join)
def test_pip_install_in_an_environment(sources: Path, tmp_path: Path, options: tuple[str, ...]) -> None:
    """The short names stay out of an environment's bin, which is everybody's."""
    home = tmp_path / "environment"
    venv.create(home, symlinks=True)
    borrow_libraries(home)
    before = names(home / "bin")
    pip_install(tmp_path, home / "bin/python", *options, str(sources))
    assert names(home / "bin") == before | {"lie-rigid-body"}
    layout = Layout(home / "bin", clean_environment(tmp_path), by_verb=False)
    assert_works(layout, sources if options else home, tmp_path)


@SLOW
def test_pip_install_in_a_folder(sources: Path, tmp_path: Path) -> None:
    target = tmp_path / "target"
    pip_install(tmp_path, Path(sys.executable), "--target", str(target), str(sources))
    environment = clean_environment(tmp_path) | {"PYTHONPATH": str(target)}
    assert names(target / "bin") == {"lie-rigid-body"}
    assert_works(Layout(target / "bin", environment, by_verb=False), target, tmp_path)


def pip_install(tmp_path: Path, python: Path, *arguments: str) -> None:
    pip = (sys.executable, "-m", "pip", "--python", str(python), "install")
    offline = ("--no-index", "--no-deps", "--no-build-isolation", "--ignore-installed", "--no-compile")
    run(*pip, *offline, *arguments, cwd=tmp_path, env=clean_environment(tmp_path))


def borrow_libraries(home: Path) -> None:
    """Let an environment see the libraries of this one, so that nothing is downloaded."""
    site = run(
        str(home / "bin/python"), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=home, env={}
    )
    Path(site.strip(), "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
