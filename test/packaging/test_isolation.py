"""A test run keeps its ROS traffic to itself, and says what it left out."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from said import numbers

CONFTEST = Path(__file__).resolve().parents[1] / "conftest.py"
TESTS = """
import pytest

@pytest.mark.ros
@pytest.mark.parametrize("number", range(3))
def test_with_ros(number): ...

@pytest.mark.slow
def test_slow(): ...

def test_quick(): ...

def test_with_a_library():
    import allantools
"""
START = """
import importlib.machinery, sys, pytest
find = importlib.machinery.PathFinder.find_spec
importlib.machinery.PathFinder.find_spec = lambda name, *rest: None if name == "allantools" else find(name, *rest)
sys.modules["rclpy"] = None
sys.exit(pytest.main(sys.argv[1:]))
"""
WITH_A_LIBRARY = "import allantools\ndef test_a(): ...\ndef test_b(): ..."


@pytest.fixture
def project(tmp_path: Path) -> Path:
    for file in (CONFTEST, CONFTEST.with_name("ros_domains.py")):
        shutil.copy(file, tmp_path)
    (tmp_path / "test_parts.py").write_text(TESTS, encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n    ros\n    slow\n", encoding="utf-8")
    (tmp_path / "test_noise.py").write_text(WITH_A_LIBRARY, encoding="utf-8")
    return tmp_path


def run_without_ros(project: Path, *options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "LIE_RIGID_BODY"))}
    command = (sys.executable, "-c", START, "-p", "no:cacheprovider", *options)
    alone = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    return subprocess.run(
        command, cwd=project, env=kept | alone | environment, capture_output=True, text=True, check=False
    )


def test_tests_left_out_are_counted(project: Path) -> None:
    done = run_without_ros(project)
    assert done.returncode == 0
    assert "1 passed, 5 skipped, 1 deselected" in done.stdout
    library, ros = done.stdout.splitlines()[-2:]
    assert (numbers(library), "allantools" in library) == ([2], True)
    assert (numbers(ros)[:1], "ROS" in ros) == ([3], True)


def test_ros_that_should_be_there_is_missed(project: Path) -> None:
    done = run_without_ros(project, LIE_RIGID_BODY_TEST_ROS="required")
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert "rclpy" in done.stderr


@pytest.mark.parametrize("options", [("--run-slow",), ("-m", "slow or not ros")])
def test_slow_tests_run_when_asked_for(project: Path, options: tuple[str, ...]) -> None:
    assert "2 passed" in run_without_ros(project, *options).stdout


@pytest.mark.ros
def test_domain_is_private() -> None:
    assert 1 <= int(os.environ["ROS_DOMAIN_ID"]) <= 101
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert not Path(os.environ["ROS_LOG_DIR"]).is_relative_to(Path.home() / ".ros")


@pytest.mark.ros
def test_processes_started_by_a_test_share_its_domain() -> None:
    script = "import rclpy; rclpy.init(); print(rclpy.get_default_context().get_domain_id()); rclpy.shutdown()"
    done = subprocess.run((sys.executable, "-c", script), capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == os.environ["ROS_DOMAIN_ID"]
