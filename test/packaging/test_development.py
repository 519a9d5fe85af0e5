"""What contributors rely on: pinned linters, workflows, pages, the loop of editing."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import yaml

ROOT = Path(__file__).resolve().parents[2]
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
SETUP = (ROOT / "setup.py").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
TARGETS = set(re.findall(r"^([a-z-]+):", MAKEFILE, flags=re.MULTILINE))
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PINNED = dict(re.findall(r'"([\w-]+)==([\w.]+)', SETUP[SETUP.index('"lint": [') :]))


def jobs(workflow: Path) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = yaml.safe_load(workflow.read_text(encoding="utf-8"))["jobs"]
    return found


def steps(workflow: Path) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Each step with its job; a job that calls another workflow has none."""
    return [(job, step) for job in jobs(workflow).values() for step in job.get("steps", [])]


def test_linters_are_pinned_to_one_version() -> None:
    assert {"mypy", "ruff", "scipy-stubs", "types-PyYAML", "types-tqdm"} <= set(PINNED)
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))["repos"][0]["hooks"]
    needed = {need for hook in hooks for need in hook.get("additional_dependencies", [])}
    assert needed == {f"ruff=={PINNED['ruff']}"}


def test_every_make_target_is_in_the_help_and_phony() -> None:
    assert [target for target in TARGETS - {"help"} if f'"make {target} ' not in MAKEFILE] == []
    assert set(re.findall(r"^\.PHONY: (.*)$", MAKEFILE, flags=re.MULTILINE)[0].split()) == TARGETS


def test_every_environment_is_cleaned_away() -> None:
    environment = (ROOT / "scripts" / "environment.sh").read_text(encoding="utf-8")
    folders = set(re.findall(r"folder=(\.venv\S*)", environment))
    assert len(folders) >= 5
    [removed] = re.findall(r"^\trm -rf (\.venv.*)$", MAKEFILE, flags=re.MULTILINE)
    assert folders <= set(removed.split())


def test_workflows_name_targets_that_exist() -> None:
    named: set[str] = set()
    for job, step in (pair for workflow in WORKFLOWS for pair in steps(workflow)):
        for target in re.findall(r"^make (\$\{\{ matrix\.target \}\}|[\w-]+)", step.get("run", ""), flags=re.MULTILINE):
            named.update(job["strategy"]["matrix"]["target"] if "matrix" in target else [target])
    assert {"docs", "test", "test-slow", "test-oldest"} <= named <= TARGETS


def test_the_wheel_and_the_sources_are_tried_on_every_python_and_system() -> None:
    [oldest] = re.findall(r'python_requires=">=3\.(\d+)"', SETUP)
    named = set(re.findall(r'"Operating System :: (?:\w+ :: )?(\w+)"', SETUP))
    of = jobs(ROOT / ".github" / "workflows" / "build.yml")
    for name in ("wheel", "source-distribution"):
        assert of[name]["needs"] == "distributions"
        assert of[name]["strategy"]["matrix"]["python"] == [f"3.{minor}" for minor in range(int(oldest), 15)]
        systems = {system.partition("-")[0] for system in of[name]["strategy"]["matrix"]["system"]}
        assert systems == {{"Linux": "ubuntu", "MacOS": "macos", "Windows": "windows"}[system] for system in named}
        assert any("scripts/try_installed.py" in step.get("run", "") for step in of[name]["steps"])


def test_only_what_was_built_and_tried_is_published_and_without_a_secret() -> None:
    assert [workflow.name for workflow in WORKFLOWS if "secrets." in workflow.read_text(encoding="utf-8")] == []
    trusted = [job for workflow in WORKFLOWS for job in jobs(workflow).values() if "id-token" in str(job)]
    assert [job["permissions"] for job in trusted] == [{"id-token": "write"}]
    of = jobs(ROOT / ".github" / "workflows" / "publish.yml")
    assert trusted == [of["pypi"]]
    assert of["pypi"]["needs"] == "build"
    assert of["build"] == {"needs": "the-tag-is-the-version", "uses": "./.github/workflows/build.yml"}


def test_a_workflow_does_in_the_container_of_ros_what_users_do() -> None:
    [job] = jobs(ROOT / ".github" / "workflows" / "ros.yml").values()
    assert job["container"] == "ros:${{ matrix.distribution }}"
    assert {each["distribution"] for each in job["strategy"]["matrix"]["include"]} == {"jazzy", "lyrical"}
    commands = "\n".join(step.get("run", "") for step in job["steps"])
    wanted = ("rosdep install", "colcon build", "colcon test", "ros2 run", "ros2 bag record", "examples/filter_in_ci")
    assert [command for command in wanted if command not in commands] == []
    libraries = re.findall(
        r'^        "?([\w-]+)', SETUP[SETUP.index('"test": [') : SETUP.index("# The last brings")], re.M
    )
    installed = set(commands.split())
    assert {"plotly", "pyarrow", "distributed", "python-flint"} <= installed
    by_rosdep = {"setuptools", "wheel"}
    assert [name for name in libraries if not name.isupper() and name not in installed | by_rosdep | {"f"}] == []


def test_a_run_of_tests_without_a_test_fails() -> None:
    """As colcon calls it good where pytest has collected nothing, which it says by a status of its own."""
    command = [sys.executable, "-m", "pytest", __file__, "-k", "of_no_such_name"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stdout


def test_workflows_run_tests_in_folders_that_exist() -> None:
    named = {name for workflow in WORKFLOWS for name in re.findall(r"\btest/\w+", workflow.read_text(encoding="utf-8"))}
    assert named
    assert [name for name in named if not any((ROOT / name).glob("test_*.py"))] == []


def test_contributing_names_what_exists() -> None:
    assert set(re.findall(r"`make ([\w-]+)", CONTRIBUTING)) <= TARGETS
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", CONTRIBUTING):
        assert (ROOT / target).is_file(), target


def test_rosdoc2_builds_our_site() -> None:
    named = ElementTree.parse(ROOT / "package.xml").getroot().findtext("export/rosdoc2")
    assert named is not None
    _, settings = yaml.safe_load_all((ROOT / named).read_text(encoding="utf-8"))
    [builder] = settings["builders"]
    assert {"name", "output_dir"} <= set(builder["sphinx"])  # it refuses a builder without them
    assert (ROOT / builder["sphinx"]["sphinx_sourcedir"] / "conf.py").is_file()


def test_the_loop_of_editing_leaves_no_room_of_mathematics_or_bags_out() -> None:
    quick = (ROOT / "scripts" / "quick.sh").read_text(encoding="utf-8")
    folders = {path.name for path in (ROOT / "test").iterdir() if any(path.glob("test_*.py"))}
    named = set(re.findall(r"test/(\w+)(?=[ \n])", quick))
    left_out = "benchmarks cli compilation conformance diagnosis examples inspection league packaging report ros system"
    assert folders - named == {*left_out.split()}
