"""Processes of Python that have imported the package already: copies of one that waits, at a tenth of the price.

Run as a script this is the process that is copied: it forks for each request that comes through a socket.
"""
# mypy: ignore-errors

from __future__ import annotations

import atexit
import gc
import os
import pickle
import runpy
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
from contextlib import suppress
from importlib import import_module
from io import TextIOWrapper
from pathlib import Path
from types import ModuleType
from typing import Any

PRELOADED = (
    *(f"lie_rigid_body.cli.{verb}" for verb in ("check", "evaluate", "record", "recover", "plot", "campaign")),
    *("lie_rigid_body.cli.checking", "lie_rigid_body.campaign.workers", "scipy.optimize", "tqdm"),
    *("lie_rigid_body.ros.timing.live_run", "lie_rigid_body.ros.timing.lockstep"),
    *(f"{kind}_msgs.msg" for kind in ("diagnostic", "geometry", "nav", "rosgraph", "sensor", "std", "visualization")),
    *("builtin_interfaces.msg", "rcl_interfaces.msg", "rcl_interfaces.srv", "std_srvs.srv"),
)
"""What processes import most. None of it reads the environment, handles a signal, or starts a thread, as rclpy does."""
ITS_OWN = ("PYTHON", "LC_", "LANG", "OPENBLAS_NUM_THREADS", "LD_")
"""Variables, by how they begin, that Python reads as it starts."""
REQUEST_BYTES = 2**17
COLD: type[subprocess.Popen[Any]] = subprocess.Popen
"""Processes that start as ever: where a test is about how they start."""


class WarmPopen(subprocess.Popen):
    """A process, forked from one that is warm where it is one of this Python that nothing hinders."""

    _control: socket.socket | None = None
    _environment: dict[str, str]
    _lock = threading.Lock()
    _status: int | None = None

    def _execute_child(self, args: Any, executable: Any, preexec_fn: Any, *more: Any) -> None:
        close_fds, pass_fds, cwd, env, _, _, shell, *pipes = more[:13]
        session = more[18]
        given = [os.fspath(args)] if isinstance(args, (str, bytes, os.PathLike)) else list(map(os.fspath, args))
        env = dict(os.environ if env is None else env)
        if shell or preexec_fn or pass_fds or executable or not close_fds or not may_be_warm(given, env):
            super()._execute_child(args, executable, preexec_fn, *more)
            return
        request = pickle.dumps((given[1:], os.fspath(cwd or os.getcwd()), env, session))
        if len(request) > REQUEST_BYTES:
            super()._execute_child(args, executable, preexec_fn, *more)
            return
        self._status, told = os.pipe()
        streams = [own if pipe == -1 else pipe for own, pipe in enumerate((pipes[0], pipes[3], pipes[5]))]
        try:
            with self._lock:
                socket.send_fds(warm(), [request], [*streams, told])
        finally:
            os.close(told)
        self.pid = int.from_bytes(os.read(self._status, 8), "little")
        assert self.pid, "the process that is copied has ended"
        self._child_created = True
        self._close_pipe_fds(*pipes)

    def _try_wait(self, wait_flags: int) -> tuple[int, int]:
        if self._status is None:
            return super()._try_wait(wait_flags)
        if wait_flags & os.WNOHANG and not select.select([self._status], [], [], 0)[0]:
            return 0, 0
        told = os.read(self._status, 8)
        os.close(self._status)
        return self.pid, int.from_bytes(told, "little")

    def _internal_poll(self, *arguments: Any, **options: Any) -> int | None:
        if self._status is None:
            return super()._internal_poll(*arguments, **options)
        if self.returncode is None and self._waitpid_lock.acquire(False):
            try:
                if self.returncode is None and (ended := self._try_wait(os.WNOHANG))[0]:
                    self._handle_exitstatus(ended[1])
            finally:
                self._waitpid_lock.release()
        return self.returncode


def may_be_warm(command: list[str], environment: dict[str, str]) -> bool:
    """Whether a command calls this Python, without options, and with the environment that it read as it started."""
    if command[0] != sys.executable or len(command) < 2:
        return False
    is_plain = command[1] in ("-c", "-m") or command[1].endswith(".py")
    if not is_plain or any("sys.modules" in word for word in command) or not hasattr(os, "pidfd_open"):
        return False
    if WarmPopen._control is None:
        WarmPopen._environment = of_python(dict(os.environ))
    return of_python(environment) == WarmPopen._environment


def of_python(environment: dict[str, str]) -> dict[str, str]:
    return {name: value for name, value in environment.items() if name.startswith(ITS_OWN)}


def warm() -> socket.socket:
    """Socket to the process that is copied, which starts with the first request."""
    if WarmPopen._control is None:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            process = COLD(
                [sys.executable, __file__, str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                start_new_session=True,
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )
        WarmPopen._control = ours
        atexit.register(lambda: (ours.close(), process.wait()))
    return WarmPopen._control


def serve(control: socket.socket) -> tuple[Any, list[int]] | None:
    """Fork for each request until nobody can send one; return in the copy with what it is to be."""
    for name in PRELOADED:
        with suppress(ImportError):
            import_module(name)
    assert len(os.listdir("/proc/self/task")) == 1, "threads are not copied"
    sys.path.pop(0)
    gc.collect()
    gc.freeze()
    woken, wake = os.pipe()
    os.set_blocking(wake, False)
    signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    told: dict[int, int] = {}
    while True:
        ready, _, _ = select.select([control, woken], [], [])
        if woken in ready:
            os.read(woken, 4096)
            for pid, status in iter(ended, None):
                with suppress(OSError):  # nobody waits any more
                    os.write(told[pid], status.to_bytes(8, "little"))
                os.close(told.pop(pid))
        if control in ready:
            request, fds, _, _ = socket.recv_fds(control, REQUEST_BYTES, 4)
            if not request:
                return None
            if pid := os.fork():
                told[pid] = fds[3]
                os.write(fds[3], pid.to_bytes(8, "little"))
                for fd in fds[:3]:
                    os.close(fd)
                continue
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            for fd in {*told.values(), fds[3], woken, wake}:
                os.close(fd)
            control.close()
            return pickle.loads(request), fds[:3]


def ended() -> tuple[int, int] | None:
    """A copy that has ended, and how."""
    try:
        pid, status = os.waitpid(-1, os.WNOHANG)
    except ChildProcessError:
        return None
    return (pid, status) if pid else None


def become(request: Any, fds: list[int]) -> None:
    """Be what was asked for, as a new Python would."""
    (kind, *words), folder, environment, session = request
    for number, fd in enumerate(fds):
        os.dup2(fd, number)
    for fd in {*fds} - {0, 1, 2}:
        os.close(fd)
    if session:
        os.setsid()
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    tempfile.tempdir = None
    sys.stdin = sys.__stdin__ = reopened(0, "r")
    sys.stdout = sys.__stdout__ = reopened(1, "w")
    sys.stderr = sys.__stderr__ = reopened(2, "w")
    if kind == "-c":
        code, *rest = words
        sys.argv = [kind, *rest]
        sys.path.insert(0, "")
        main = sys.modules["__main__"] = ModuleType("__main__")
        exec(compile(code, "<string>", "exec"), vars(main))
    elif kind == "-m":
        name, *rest = words
        sys.argv = [kind, *rest]
        sys.path.insert(0, folder)
        runpy.run_module(name, run_name="__main__", alter_sys=True)
    else:
        sys.argv = [kind, *words]
        sys.path.insert(0, str(Path(kind).parent.absolute()))
        runpy.run_path(kind, run_name="__main__")


def reopened(number: int, mode: str) -> Any:
    """A standard stream as Python opens it; None where it is closed."""
    try:
        raw = open(number, f"{mode}b", closefd=False)  # noqa: SIM115 it ends with the process
    except OSError:
        return None
    of_zygote = (sys.stdin, sys.stdout, sys.stderr)[number]
    return TextIOWrapper(
        raw,
        of_zygote.encoding,
        of_zygote.errors,
        newline=None if number == 0 else "\n",
        line_buffering=number == 2 or os.isatty(number),
    )


if __name__ == "__main__":
    asked = serve(socket.socket(fileno=int(sys.argv[1])))
    if asked:
        become(*asked)
