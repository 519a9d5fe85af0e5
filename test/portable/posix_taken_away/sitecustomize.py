"""A Python whose package `lie_rigid_body` finds nothing that only POSIX has: modules, signals, functions, flags.

Python loads this file at its start from a folder of ``PYTHONPATH``, and so do the processes that it starts, which are
spawned. The standard library and other packages have all that this system gives: elsewhere they have their own ways.
"""

import builtins
import multiprocessing
import os
import signal
import sys
from types import ModuleType

PACKAGE = "lie_rigid_body"
MODULES = """
    _posixshmem _posixsubprocess fcntl grp posix pwd readline resource syslog termios
"""
SIGNALS = """
    SIGALRM SIGBUS SIGCHLD SIGCONT SIGHUP SIGIO SIGKILL SIGPIPE SIGPROF SIGQUIT SIGSTOP SIGTSTP SIGTTIN SIGTTOU
    SIGUSR1 SIGUSR2 SIGWINCH ITIMER_REAL SIG_BLOCK SIG_SETMASK SIG_UNBLOCK alarm getitimer pause pthread_kill
    pthread_sigmask setitimer siginterrupt sigpending sigtimedwait sigwait sigwaitinfo
"""
FUNCTIONS = """
    EX_OK O_CLOEXEC O_DIRECTORY O_DSYNC O_NOATIME O_NOCTTY O_NOFOLLOW O_NONBLOCK O_PATH O_SYNC O_TMPFILE WNOHANG
    chown chroot confstr copy_file_range ctermid fchdir fchmod fchown fdatasync fork forkpty fpathconf fstatvfs
    getegid geteuid getgid getgroups getloadavg getpgid getpgrp getpriority getresuid getsid getuid getxattr
    initgroups killpg lchown lockf major memfd_create minor mkfifo mknod nice openpty pathconf pidfd_open pipe2
    posix_fadvise posix_fallocate posix_spawn pread preadv pwrite pwritev readv register_at_fork
    sched_getaffinity sched_setaffinity sched_yield sendfile setegid seteuid setgid setgroups setpgid
    setpriority setsid setuid setxattr statvfs sync sysconf ttyname uname wait wait3 wait4 waitid writev
"""


def asks(depth):
    """Whether the code that asks for a name is the package's."""
    return str(sys._getframe(depth + 1).f_globals.get("__name__")).partition(".")[0] == PACKAGE


class Without(ModuleType):
    """A module some of whose names the package does not find."""

    def __getattr__(self, name):
        if name in self.__dict__["__hidden__"] and not asks(1):
            return self.__dict__["__hidden__"][name]
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


def take_away(module, names):
    module.__hidden__ = {name: module.__dict__.pop(name) for name in names if name in module.__dict__}
    module.__class__ = Without


def import_of_others(name, *arguments, **named):
    if name in MODULES.split() and asks(1):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return by_itself(name, *arguments, **named)


by_itself, builtins.__import__ = builtins.__import__, import_of_others
multiprocessing.set_start_method("spawn")
take_away(os, FUNCTIONS.split())
take_away(signal, SIGNALS.split())
