"""What every test run shares: ROS kept to itself, and the parts left out counted."""

from __future__ import annotations

import faulthandler
import gc
import os
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Collection, Iterator
from importlib.abc import MetaPathFinder
from importlib.util import find_spec
from pathlib import Path

import hypothesis
import pytest

import lie_rigid_body
from lie_rigid_body.system.interruption import END_SIGNALS

# By itself each process has as many threads of linear algebra as there are cores, for small matrices. They wait for
# one another in busy loops, which beside other processes takes many times as long as the work. NumPy is not loaded yet.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# The same cases in every run, so that a failure is the change's own; `--hypothesis-profile=explore` looks for new ones.
hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None, database=None, max_examples=25)
hypothesis.settings.register_profile("explore", deadline=None, max_examples=2000)
hypothesis.settings.register_profile("quick", derandomize=True, deadline=None, database=None, max_examples=5)
hypothesis.settings.load_profile("repeatable")

ROS_INSTALLED = find_spec("rclpy") is not None
ROS_LEFT_OUT = "rclpy is not installed"
LIBRARIES = {
    "ahrs",
    "allantools",
    "build",
    "catkin_pkg",
    "colcon_core",
    "colcon_ros",
    "distributed",
    "evo",
    "flint",
    "mcap_ros2",
    "mpmath",
    "plotly",
    "pyarrow",
    "rosbags",
    "twine",
}
"""What rosdep cannot give: where one is not installed, the tests that want it are left out."""
PACKAGE = Path(lie_rigid_body.__file__).parent
ONE_PROCESS = Path(__file__).with_name("one_process.xml")
LONGEST_S = 900
"""Time, s, that a test has at least: more than any takes."""
EACH_S = 60
"""Least time, s, from one watch to the next: each is a thread, which would take as long as a short test."""


class LeftOut(MetaPathFinder):
    """The last resort of an import: skips the test, or all of its file, that wants a library that is not there."""

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        if name in LIBRARIES and is_wanted():
            pytest.skip(f"{name} is not installed", allow_module_level=True)


def is_wanted() -> bool:
    """Whether a test or the package imports. Libraries look for one another, and do without; so do tests that ask."""
    files = [Path(frame.f_code.co_filename) for frame, _ in traceback.walk_stack(sys._getframe(2))]
    caller = next(file for file in files if "importlib" not in str(file))
    if caller.is_relative_to(PACKAGE):
        return True
    is_library = not {"site-packages", "dist-packages"}.isdisjoint(caller.parts) and caller.name != "outcomes.py"
    asks = any("util" in file.name for file in files[: files.index(caller)])  # by importlib.util.find_spec
    return not is_library and not asks


class Watch:
    """Ends a process of xdist in which a test hangs, and tells before where all its threads are."""

    def __init__(self, stderr: int) -> None:
        self._stderr, self._next = stderr, time.monotonic()

    def pytest_runtest_logstart(self) -> None:
        if time.monotonic() >= self._next:
            faulthandler.dump_traceback_later(LONGEST_S + EACH_S, exit=True, file=self._stderr)
            self._next = time.monotonic() + EACH_S

    def pytest_sessionfinish(self) -> None:
        faulthandler.cancel_dump_traceback_later()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--run-slow", action="store_true", help="run the tests marked slow as well")
    parser.addoption("--one-case", action="store_true", help="run the first case of each parametrised test")
    parser.addoption("--write-words", action="store_true", help="write test/words/words.txt anew")


def pytest_configure(config: pytest.Config) -> None:
    # set in many containers; with it every process that a test starts would compile the package anew
    if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
        sys.dont_write_bytecode = False
    # under nohup, or in the background of a script, signals are ignored, and children inherit that
    for number in END_SIGNALS:
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    if "PYTEST_XDIST_WORKER" in os.environ:
        config.pluginmanager.register(Watch(os.dup(2)), "watch")
    complete = os.environ.get("LIE_RIGID_BODY_TEST_ROS") == "required"
    if complete and not ROS_INSTALLED:
        raise pytest.UsageError("this environment should have rclpy and has not: remove it and set it up again")
    if not complete:
        sys.meta_path.append(LeftOut())


def pytest_unconfigure() -> None:
    sys.meta_path[:] = [finder for finder in sys.meta_path if not isinstance(finder, LeftOut)]


@pytest.hookimpl(hookwrapper=True)
def pytest_collection() -> Iterator[None]:
    """Thousands of tests are made and kept: looking for garbage among them, now or while they run, is in vain."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if not ROS_INSTALLED:
        for item in items:
            if item.get_closest_marker("ros"):
                item.add_marker(pytest.mark.skip(reason=ROS_LEFT_OUT))
    if config.getoption("--one-case"):
        first = {item.nodeid.partition("[")[0]: item for item in reversed(items)}
        leave_out(config, items, {*items}.difference(first.values()))
    if not (config.getoption("--run-slow") or config.getoption("-m")):
        leave_out(config, items, {item for item in items if item.get_closest_marker("slow")})


def leave_out(config: pytest.Config, items: list[pytest.Item], unwanted: Collection[pytest.Item]) -> None:
    if unwanted:
        config.hook.pytest_deselected(items=unwanted)
        items[:] = [item for item in items if item not in unwanted]


@pytest.hookimpl(hookwrapper=True, tryfirst=True)
def pytest_sessionfinish(session: pytest.Session) -> Iterator[None]:
    """Make what was left out the last line of the run, which fails where nothing was run: colcon calls that good."""
    yield
    if session.exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None:
        return
    skipped = [r.longrepr[2] for r in reporter.stats.get("skipped", []) if isinstance(r.longrepr, tuple)]
    reasons = Counter(reason.removeprefix("Skipped: ") for reason in skipped)
    for library in sorted({*LIBRARIES, "chromium"}):
        if count := reasons[f"{library} is not installed"]:
            reporter.write_line(f"left out: {count} files or tests ({library} is not installed)", yellow=True)
    if not ROS_INSTALLED:
        reporter.write_line(f"ROS part left out: {reasons[ROS_LEFT_OUT]} tests ({ROS_LEFT_OUT})", yellow=True)


def pytest_report_teststatus(report: pytest.CollectReport | pytest.TestReport) -> tuple[str, str, str] | None:
    """Name a test as soon as it fails: a run that is ended from outside prints no summary."""
    if not (isinstance(report, pytest.TestReport) and report.failed):
        return None
    kind = "failed" if report.when == "call" else "error"
    return kind, f"\n{kind.upper()} {report.nodeid}\n", kind.upper()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print what campaigns have counted."""
    for report in terminalreporter.stats.get("passed", []):
        if counts := ", ".join(f"{name}: {value}" for name, value in report.user_properties):
            terminalreporter.write_line(f"{report.nodeid.rpartition('::')[2]}: {counts}")


@pytest.fixture(autouse=True)
def own_signals() -> Iterator[None]:
    """What runs in the process of a test changes its signal handlers; afterwards they are pytest's again."""
    handlers = [signal.getsignal(number) for number in END_SIGNALS]
    yield
    for number, handler in zip(END_SIGNALS, handlers, strict=True):
        signal.signal(number, handler)


@pytest.fixture
def asked_here(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What another Python would be asked is done in this process."""
    import one_python  # loads the package

    with one_python.asked_here(tmp_path_factory.getbasetemp()):
        yield


@pytest.fixture(scope="session", autouse=True)
def isolated_ros(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Give this process, and those it starts, a ROS domain of their own on this machine only."""
    if not ROS_INSTALLED:
        yield
        return

    from ros_domains import PROFILES_FILE, own_domain  # by locks that only POSIX has

    with own_domain() as domain, pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        patch.setenv("ROS_LOG_DIR", str(tmp_path_factory.mktemp("ros-log")))
        patch.setenv(PROFILES_FILE, str(ONE_PROCESS))
        for name in ("ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"):
            patch.delenv(name, raising=False)
        yield
