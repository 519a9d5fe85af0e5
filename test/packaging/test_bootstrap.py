"""Finding a Python on machines of every kind, and one for the benchmark that PyBullet is built for."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BASE_PYTHON = getattr(sys, "_base_executable", sys.executable)


def find_python(kind: str, **environment: str) -> subprocess.CompletedProcess[str]:
    kept = {name: value for name, value in os.environ.items() if name not in {"PYTHON", "PYTHON_ROS"}}
    command = (str(ROOT / "scripts/find-python.sh"), kind)
    return subprocess.run(command, env=kept | environment, capture_output=True, text=True, timeout=60, check=False)


def executable(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    path.chmod(0o755)
    return path


def test_a_python_is_found_that_runs() -> None:
    found = find_python("headless")
    assert found.returncode == 0
    new_enough = "import sys; sys.exit(sys.version_info < (3, 10))"
    assert subprocess.run((found.stdout.strip(), "-c", new_enough), check=False).returncode == 0


def test_a_shim_that_fails_is_passed_over(tmp_path: Path) -> None:
    for name in ("python3", "python3.12"):
        executable(tmp_path / "bin" / name, "#!/bin/sh\nexit 127\n")
    found = find_python("headless", PATH=f"{tmp_path / 'bin'}:{Path(BASE_PYTHON).parent}:/usr/bin:/bin")
    assert found.returncode == 0
    assert str(tmp_path) not in found.stdout


@pytest.mark.skipif(sys.version_info[:2] != (3, 12), reason="needs a Python 3.12 to be found")
@pytest.mark.parametrize("home", ["pyenv", "with a space"])
def test_a_python_beside_the_path_is_found(tmp_path: Path, home: str) -> None:
    for name in ("python", "python3", "python3.12"):
        executable(tmp_path / "bin" / name, "#!/bin/sh\nexit 1\n")
    executable(tmp_path / home / "versions/3.12.1/bin/python3.12", f'#!/bin/sh\nexec "{BASE_PYTHON}" "$@"\n')
    places = {"HOME": str(tmp_path), "PYENV_ROOT": str(tmp_path / home), "PATH": f"{tmp_path / 'bin'}:/usr/bin:/bin"}
    found = find_python("live", **places)
    assert found.returncode == 0
    assert Path(found.stdout.strip()).is_file()


def test_below_an_activated_environment_its_own_python_is_found(tmp_path: Path) -> None:
    """An environment that is made anew is thrown away before, and its Python with it."""
    made = (BASE_PYTHON, "-m", "venv", "--without-pip", str(tmp_path / "venv"))
    subprocess.run(made, check=True, timeout=60)
    found = find_python("headless", PATH=f"{tmp_path / 'venv' / 'bin'}:{os.environ['PATH']}")
    assert found.returncode == 0
    assert Path(found.stdout.strip()).samefile(BASE_PYTHON)
    assert str(tmp_path) not in found.stdout


@pytest.mark.parametrize(("kind", "given"), [("live", {"PYTHON_ROS": "none"}), ("headless", {"PYTHON": "/bin/false"})])
def test_none_means_none_and_an_unsuitable_choice_is_not_replaced(kind: str, given: dict[str, str]) -> None:
    found = find_python(kind, **given)
    assert (found.returncode, found.stdout) == (3, "")


def test_a_python_without_venv_is_named_with_the_remedy(tmp_path: Path) -> None:
    python = executable(tmp_path / "python3", "#!/bin/sh\necho /usr/bin/python3\nexit 4\n")
    found = find_python("headless", PYTHON=str(python))
    assert found.returncode == 3
    assert "apt install python3-venv" in found.stderr


def make(*arguments: str) -> subprocess.CompletedProcess[str]:
    # A make that runs these tests would make this one a part of itself, and hand on its ARGS.
    theirs = ("MAKE", "MFLAGS", "PYTHON", "ARGS")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(theirs)}
    return subprocess.run(
        ("make", *arguments), cwd=ROOT, env=kept, capture_output=True, text=True, timeout=60, check=False
    )


@pytest.mark.parametrize("target", ["sim", "test", "lint", "bench"])
def test_make_without_any_python_is_one_clear_line(target: str) -> None:
    done = make(target, "PYTHON=/bin/false")
    assert done.returncode != 0
    ours = [line for line in done.stderr.splitlines() if not line.startswith("make: ***")]
    assert len(ours) == 1
    assert "3.10" in ours[0]


@pytest.mark.parametrize(("target", "said"), [("test-oldest", "3.12"), ("test-kilted", "3.13")])
def test_without_its_python_a_target_is_left_out_and_says_so(target: str, said: str) -> None:
    done = make(target, "PYTHON_ROS=none")
    assert done.returncode == 0
    assert said in done.stderr


@pytest.mark.parametrize(
    ("version", "fitting"),
    [("3.11", "headless"), ("3.12", "headless live jazzy"), ("3.14", "headless live kilted"), ("3.15", "headless")],
)
def test_each_version_of_python_has_its_client_library(version: str, fitting: str, tmp_path: Path) -> None:
    """Of Jazzy 3.12, of Kilted the two after it; the Python of the test stands in for that of a version."""
    major, minor = version.split(".")
    told = f"import sys; sys.version_info = ({major}, {minor}, 0, 'final', 0)"
    shim = f'#!/bin/sh\nexec "{BASE_PYTHON}" -c "{told}; code = sys.argv.pop(1); exec(code)" "$4" "$5"\n'
    python = executable(tmp_path / f"python{version}", shim)
    kinds = ("headless", "live", "jazzy", "kilted")
    found = {kind: find_python(kind, PYTHON=str(python)).returncode for kind in kinds}
    assert found == {kind: 0 if kind in fitting.split() else 3 for kind in kinds}


def test_a_python_for_pybullet_is_310_or_311() -> None:
    found = find_python("bench")
    if found.returncode == 3:
        pytest.skip("no Python 3.10 or 3.11 here")
    command = (found.stdout.strip(), "-c", "import sys; print(*sys.version_info[:2])")
    version = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert version.strip() in {"3 10", "3 11"}


@pytest.mark.skipif(sys.version_info < (3, 12), reason="needs a Python that PyBullet is not built for")
def test_another_python_is_not_taken_for_one(tmp_path: Path) -> None:
    python = executable(tmp_path / "python3.11", f'#!/bin/sh\nexec "{BASE_PYTHON}" "$@"\n')
    assert find_python("bench", PYTHON=str(python)).returncode == 3
    assert find_python("headless", PYTHON=str(python)).returncode == 0


def test_its_help_builds_nothing_and_a_mistyped_argument_neither() -> None:
    """PYTHON=/bin/false would stop every set-up."""
    told = make("bench", "PYTHON=/bin/false", "ARGS=--help")
    assert told.returncode == 0
    assert "--save" in told.stdout
    mistyped = make("bench", "PYTHON=/bin/false", "ARGS=--sav")
    assert mistyped.returncode != 0
    assert "'--sav'" in mistyped.stderr
    assert "3.10" not in mistyped.stderr


# A Python that is found, makes an environment of itself alone, and has a pip that ends with 3 when told to.
PYTHON_WITH_PIP = """#!/bin/sh
case "$*" in
    "-I -B -c "*) echo "$0" ;;
    "-m venv "*) mkdir -p "$3/bin" && cp "$0" "$3/bin/python" ;;
    "-m pip "*) echo "Requirement already satisfied: numpy"; echo "Collecting ${*##* }"; exit "$PIP_STATUS" ;;
esac
"""


def set_up(clone: Path, kind: str, status: int = 0) -> subprocess.CompletedProcess[str]:
    python = executable(clone / "python3", PYTHON_WITH_PIP)
    environment = {**os.environ, "PYTHON": str(python), "PYTHON_ROS": str(python), "PIP_STATUS": str(status)}
    return subprocess.run(
        ("scripts/environment.sh", kind),
        cwd=clone, env=environment, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "scripts", tmp_path / "scripts")
    for name in ("setup.py", "setup.cfg", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)
    return tmp_path


@pytest.mark.parametrize("status", [0, 3])
def test_a_set_up_shows_what_is_fetched_and_fails_with_pip(clone: Path, status: int) -> None:
    done = set_up(clone, "headless", status)
    assert done.returncode == status
    assert done.stdout.splitlines() == ([] if status else [str(clone / ".venv-headless")])
    assert (clone / ".venv-headless/complete").exists() == (status == 0)
    assert done.stderr.splitlines()[1:] == ["Collecting .[fast]"]


def test_the_node_waits_for_no_library_of_the_tests_and_the_tests_add_theirs(clone: Path) -> None:
    for kind, wanted in (("live", [".[ros,fast]"]), ("tests", [".[ros,fast,test,lint]"]), ("live", []), ("tests", [])):
        done = set_up(clone, kind)
        assert done.stdout == f"{clone / '.venv'}\n"
        assert done.stderr.splitlines()[1:] == [f"Collecting {extras}" for extras in wanted]
