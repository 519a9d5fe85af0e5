"""A program as an estimator: readings as CSV on its standard input, attitudes as CSV on its standard output."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, BinaryIO, Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.bounded_input import real
from lie_rigid_body.errors import InputError
from lie_rigid_body.runs.estimators import Estimator
from lie_rigid_body.runs.run import Run
from lie_rigid_body.wording import printable, short_repr, shortened, shown

HEADER: Final = "t_ns,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z,mag_x,mag_y,mag_z"
"""First line that the program reads: stamps in ns, rad/s, m/s² and T on the body's axes."""
ANSWER: Final = "t_ns,x,y,z,w"
"""Columns that the program prints, with this line above them or without."""
TIMEOUT_S: Final = 60.0
_NO_IMU: Final = ",,,,,"
_NO_FIELD: Final = ",,"
_LARGEST_OUTPUT: Final = 256 * 2**20
"""Largest number of bytes that the program may print; an attitude takes about 100."""
_PATIENCE_S: Final = 0.05
"""Time, s, after which it is looked at again how much the program has printed."""
_LONGEST_WORDS: Final = 120
"""Largest number of characters of the program's own error that are repeated."""


@dataclass(frozen=True)
class CommandEstimator:
    """An estimator that starts a program for each run.

    Attributes
    ----------
    command : str
        Program and arguments, as for a shell; no shell is started.
    timeout_s : float
        Longest time of a run, s.
    """

    command: str
    timeout_s: float = TIMEOUT_S

    __repr__ = short_repr

    def load(self) -> Estimator:
        """The estimator itself, for a process that is told where one is."""
        return self

    def __call__(self, run: Run) -> tuple[Integers, Array]:
        """Stamps, ns, shape (N,), and attitudes world-from-body, scalar last, shape (N, 4), that the program prints.

        Raises
        ------
        InputError
            If it cannot be started, ends with a status other than 0, prints nothing or a line that is no attitude, or
            does not end in time.
        """
        return _attitudes(self._name, self._output("\n".join([HEADER, *_lines(run), ""])))

    @property
    def _name(self) -> str:
        return f"command {shown(self.command)}"

    def _output(self, readings: str) -> str:
        arguments = shlex.split(self.command)
        if not arguments:
            raise InputError("command '': give a program, such as './my_filter --rate 100'")
        # no pipes: what is not read or written in time would stand in them
        with tempfile.TemporaryFile() as given, tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
            given.write(readings.encode())
            given.seek(0)
            try:
                process = subprocess.Popen(
                    arguments,
                    stdin=given,
                    stdout=output,
                    stderr=errors,
                    start_new_session=True,  # so that it can be ended with what it starts
                )
            except OSError as error:
                what = f"{self._name} cannot be started: {error.strerror}"
                raise InputError(f"{what}: give the path of a program") from None
            try:
                self._wait(process, [output, errors])
            finally:
                kill_all(process)
                process.wait()
            if process.returncode:
                errors.seek(0)
                text = errors.read(_LARGEST_OUTPUT).decode(errors="replace")
                words = shortened(printable(" ".join(text.split())), _LONGEST_WORDS) or "it says nothing"
                raise InputError(f"{self._name} ended with status {process.returncode}: {words}: mend it")
            output.seek(0)
            try:
                return output.read().decode()
            except UnicodeDecodeError:
                raise InputError(f"{self._name} prints what is no text: print {ANSWER} in each line") from None

    def _wait(self, process: subprocess.Popen[bytes], files: Sequence[BinaryIO]) -> None:
        """Wait for the end of a program; what it prints goes into files."""
        end, is_running = time.monotonic() + self.timeout_s, True
        while is_running:
            try:
                process.wait(max(0.0, min(_PATIENCE_S, end - time.monotonic())))
                is_running = False
            except subprocess.TimeoutExpired:
                if time.monotonic() >= end:
                    what = f"{self._name} did not end within {self.timeout_s:g} s"
                    raise InputError(f"{what}: let it end with its input, or give it more") from None
            if any(os.fstat(file.fileno()).st_size > _LARGEST_OUTPUT for file in files):
                raise InputError(
                    f"{self._name} prints more than {_LARGEST_OUTPUT} bytes: print {ANSWER} once for each reading"
                )


def kill_all(process: subprocess.Popen[Any]) -> None:
    """Kill a process that leads a session of its own, and what it started, which may hold its pipes open."""
    with suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        process.kill()


def _lines(run: Run) -> Iterator[str]:
    """Readings of a run in the order of their stamps; those of one stamp share a line."""
    imu, magnetometer = run.imu, run.magnetometer
    of_imu = {} if imu is None else _texts(imu.t_ns, np.hstack([imu.gyro, imu.specific_force]))
    of_field = {} if magnetometer is None else _texts(magnetometer.t_ns, magnetometer.field)
    for stamp in sorted({*of_imu, *of_field}):
        yield f"{stamp},{of_imu.get(stamp, _NO_IMU)},{of_field.get(stamp, _NO_FIELD)}"


def _texts(t_ns: Integers, rows: Array) -> dict[int, str]:
    """Rows by their stamps, with all digits."""
    return {stamp: ",".join(map(repr, row)) for stamp, row in zip(t_ns.tolist(), rows.tolist(), strict=True)}


def _attitudes(name: str, output: str) -> tuple[Integers, Array]:
    lines = output.splitlines()
    first = 1 if lines and lines[0].replace(" ", "") == ANSWER else 0
    stamps, rows = [], []
    for number, line in enumerate(lines[first:], first + 1):
        try:
            stamp, *numbers = line.split(",")
            x, y, z, w = map(real, numbers)
            real(stamp)
            stamps.append(int(stamp))
        except ValueError:
            raise InputError(f"{name} prints, line {number}: {shown(line)}: print {ANSWER} in each line") from None
        rows.append((x, y, z, w))
    if not rows:
        raise InputError(f"{name} prints no attitude: print {ANSWER} for each reading, and flush at the end")
    try:
        return np.array(stamps, dtype=np.int64), np.array(rows, dtype=np.float64)
    except OverflowError:
        raise InputError(f"{name} prints a stamp beyond 64 bits: repeat the t_ns of the reading") from None
