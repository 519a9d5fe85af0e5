"""What is written in more than one place is the same everywhere."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

import lie_rigid_body
from lie_rigid_body.sensors import SENSORS
from rooms import MODULES, imported, imports

ROOT = Path(__file__).resolve().parents[2]
MANIFEST = ElementTree.parse(ROOT / "package.xml").getroot()

CHANGELOG = ROOT / "CHANGELOG.rst"
# What rosdep cannot give to a package that is released, or what is used where it is installed.
WITHOUT_KEY = {"distributed", "flint", "lz4", "mcap", "plotly", "pyarrow", "simulation_interfaces"}
WITHOUT_KEY |= {"zstandard"}
WITHOUT_KEY |= {"hypothesis", "pytest"}  # by `testing`, which only tests import
FOR_TYPES_ALONE = {"_typeshed", "typing_extensions"}
KEY_OF = {name: f"python3-{name}" for name in ("matplotlib", "numba", "numpy", "pandas", "scipy", "tqdm")}
KEY_OF |= {"mpl_toolkits": "python3-matplotlib", "yaml": "python3-yaml"}


def metadata(*options: str) -> list[str]:
    command = (sys.executable, "-W", "ignore", "setup.py", *options)
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()


def test_one_name_version_and_license() -> None:
    manifest = [MANIFEST.findtext(tag) for tag in ("name", "version", "license")]
    *said, author, email = metadata("--name", "--version", "--license", "--author", "--author-email")
    assert manifest == said
    assert manifest[1] == lie_rigid_body.__version__
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert [citation["title"].partition(":")[0], citation["version"], citation["license"]] == manifest
    assert [citation["authors"][0]["name"], citation["authors"][0]["email"]] == [author, email]


def test_colcon_recognises_an_ament_python_package() -> None:
    assert MANIFEST.findtext("export/build_type") == "ament_python"
    assert "[project]" not in (ROOT / "pyproject.toml").read_text(encoding="utf-8").splitlines()


def test_configuration_is_one_set_of_files() -> None:
    """A link in a clone; a source distribution, which holds no links, has copies."""
    inside, outside = ROOT / "lie_rigid_body" / "config", ROOT / "config"
    assert inside.is_symlink() or (ROOT / "PKG-INFO").is_file()
    names = [str(file.relative_to(outside)) for file in outside.rglob("*.*") if file.is_file()]
    assert [name for name in names if (inside / name).read_bytes() != (outside / name).read_bytes()] == []


def test_what_is_imported_is_a_dependency() -> None:
    """In every module of the package, and in the launch files, which start a program of another package."""
    launches = [path.read_text(encoding="utf-8") for path in (ROOT / "launch").glob("*.py")]
    names = {name for module in MODULES for name in imported(module)}
    names |= {name for source in launches for name in imports(source, "lie_rigid_body")}
    found = {name.partition(".")[0] for name in names}
    found -= {*sys.stdlib_module_names, *WITHOUT_KEY, "lie_rigid_body", *FOR_TYPES_ALONE}
    wanted = {KEY_OF.get(name, name) for name in found}
    wanted |= {message_type.partition("/")[0] for message_type in SENSORS.topics.values()}  # imported by these names
    wanted |= {"tf2_ros", "nav_msgs"}  # a program of the one is started; topics of the other may be evaluated
    assert wanted == {str(dependency.text) for dependency in MANIFEST.findall("exec_depend")}


def test_the_manifest_is_valid_for_the_build_farm() -> None:
    """As bloom reads it."""
    package = pytest.importorskip("catkin_pkg.package")
    warnings: list[str] = []
    manifest = package.parse_package(ROOT / "package.xml", warnings=warnings)
    manifest.validate(warnings=warnings)
    assert warnings == []
    assert [manifest.get_build_type(), manifest.licenses] == ["ament_python", ["Apache-2.0"]]
    assert (ROOT / manifest.licenses[0].file).is_file()


def test_the_changelog_is_one_that_bloom_reads() -> None:
    """The newest version in it is the package's; what is *Forthcoming* above it is for the next one."""
    changelog = pytest.importorskip("catkin_pkg.changelog")
    found = changelog.get_changelog_from_path(str(ROOT), "lie_rigid_body")
    versions = [version for version, _, _ in found.foreach_version()]
    assert versions[0] == MANIFEST.findtext("version")
    bullets = [len(content.bullets) for _, _, contents in found.foreach_version() for content in contents]
    text = CHANGELOG.read_text(encoding="utf-8")
    assert text.splitlines()[1] == "Changelog for package lie_rigid_body"
    assert sum(bullets) == len(re.findall(r"^\* ", text[text.index(versions[0]) :], flags=re.MULTILINE))


def test_launch_files_carry_the_notice_of_the_licence(capsys: pytest.CaptureFixture[str]) -> None:
    """In a clone the licence and the guide are checked as well. Other files have no notice."""
    main = pytest.importorskip("ament_copyright.main", reason="ament_copyright is not installed").main
    launches = [str(path) for path in (ROOT / "launch").glob("*.launch.py")]
    assert main([*launches, str(ROOT / "LICENSE"), str(ROOT / "CONTRIBUTING.md"), "--verbose"]) == 0
    said = capsys.readouterr().out
    assert [path for path in launches if f"{path}: copyright=" not in said] == []
