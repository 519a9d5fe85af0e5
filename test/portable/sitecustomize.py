"""A Python without what only POSIX has: modules, signals and functions are taken away before anything else is loaded.

Python finds this file at its start in a folder of ``PYTHONPATH``, and so do the processes that it starts, which are
spawned. What the standard library itself does on this system with a name that another system lacks is kept for it.
"""

import multiprocessing.popen_fork
import os
import shutil
import signal
import subprocess
import sys

MODULES = ("fcntl", "grp", "pwd", "resource", "syslog", "termios", "tty", "_posixshmem")
SIGNALS = ("SIGALRM", "SIGHUP", "SIGKILL", "SIGPIPE", "SIGQUIT", "SIGUSR1", "SIGUSR2")
FUNCTIONS_OF_SIGNALS = ("alarm", "pthread_kill", "pthread_sigmask", "setitimer", "sigpending", "sigwait")
FUNCTIONS = (
    "O_DIRECTORY O_NOCTTY O_NOFOLLOW O_NONBLOCK chown fchmod fork forkpty getegid geteuid getgid getgroups getpgid "
    "getpgrp getuid initgroups killpg lchown mkfifo mknod nice posix_fadvise posix_fallocate pread preadv pwrite pwritev "
    "register_at_fork sched_getaffinity sched_setaffinity setgid setpgid setsid setuid statvfs fstatvfs sync "
    "wait3 wait4"
).split()

kill = int(signal.SIGKILL)
statvfs = os.statvfs


def disk_usage(path):
    found = statvfs(path)
    return shutil._ntuple_diskusage(found.f_blocks * found.f_frsize, 0, found.f_bavail * found.f_frsize)


subprocess.Popen.kill = lambda process: process.send_signal(kill)
multiprocessing.popen_fork.Popen.kill = lambda process: process._send_signal(kill)
shutil.disk_usage = disk_usage
multiprocessing.set_start_method("spawn")
sys.modules.update(dict.fromkeys(MODULES))
for module, names in ((signal, SIGNALS + FUNCTIONS_OF_SIGNALS), (os, FUNCTIONS)):
    for name in names:
        delattr(module, name)
