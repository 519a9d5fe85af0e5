"""What is written in more than one place is the same everywhere."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import yaml

import lie_rigid_body

ROOT = Path(__file__).resolve().parents[2]
MANIFEST = ElementTree.parse(ROOT / "package.xml").getroot()


def metadata(*options: str) -> list[str]:
    command = (sys.executable, "-W", "ignore", "setup.py", *options)
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()


def test_one_name_version_and_license() -> None:
    manifest = [MANIFEST.findtext(tag) for tag in ("name", "version", "license")]
    assert manifest == metadata("--name", "--version", "--license")
    assert manifest[1] == lie_rigid_body.__version__
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert [citation["title"].partition(":")[0], citation["version"], citation["license"]] == manifest
    assert [citation["authors"][0]["name"], citation["authors"][0]["email"]] == metadata("--author", "--author-email")


def test_colcon_recognises_an_ament_python_package() -> None:
    assert MANIFEST.findtext("export/build_type") == "ament_python"
    assert "[project]" not in (ROOT / "pyproject.toml").read_text(encoding="utf-8").splitlines()


def test_configuration_is_one_set_of_files() -> None:
    link = ROOT / "lie_rigid_body" / "config"
    assert link.is_symlink()
    assert link.resolve() == ROOT / "config"
