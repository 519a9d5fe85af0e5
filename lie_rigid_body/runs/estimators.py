"""Estimators: functions of a run that return an estimate, by name, and programs that read CSV and print attitudes."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, BinaryIO, Final, TypeAlias

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.bounded_input import real
from lie_rigid_body.errors import InputError, LieRigidBodyError, said
from lie_rigid_body.runs.estimate import Estimate
from lie_rigid_body.runs.estimator_call import leaving_the_process_alone
from lie_rigid_body.runs.run import Run
from lie_rigid_body.short_dataclass import short_dataclass
from lie_rigid_body.wording import printable, shortened, shown

Estimator: TypeAlias = Callable[[Run], Any]

MENDED: Final = "mend it"
"""Remedy at the end of an error line about an estimator that cannot be imported."""
HEADER: Final = "t_ns,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z,mag_x,mag_y,mag_z"
"""First line that the program reads: stamps in ns, rad/s, m/s² and T on the body's axes."""
ANSWER: Final = "t_ns,x,y,z,w"
"""Columns that the program prints, with this line above them or without."""
_LARGEST_OUTPUT: Final = 256 * 2**20
"""Largest number of bytes that the program may print; an attitude takes about 100."""
_PATIENCE_S: Final = 0.05
"""Time, s, after which it is looked at again how much the program has printed."""
_LONGEST_WORDS: Final = 120
"""Largest number of characters of the program's own error that are repeated."""
_LIBRARIES: Final = ("site-packages", "dist-packages", str(Path(traceback.__file__).parent))
"""Parts of the paths of files that are not the user's."""


class FilterError(InputError):
    """The filter raised an exception, did not return, or returned what is no estimate."""


def called(estimate: Estimator, run: Run) -> Estimate:
    """What an estimator returns for a run, with stamps and numbers; its warnings are nobody's.

    Raises
    ------
    FilterError
        With the line in the user's file, or with the shape.
    """
    assert run.imu is not None
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"), leaving_the_process_alone():
            warnings.simplefilter("ignore")
            result = estimate(run)
    except (Exception, SystemExit) as error:
        raise FilterError(told(error)) from None
    try:
        found = Estimate.of(result)
        return found if found.t_ns is not None else replace(found, t_ns=run.imu.t_ns)
    except (TypeError, ValueError) as error:
        raise FilterError(said(error)) from None


def told(error: BaseException) -> str:
    """Say an exception of a filter with the last line of the user's own that it came through."""
    package = str(Path(__file__).resolve().parent.parent)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(package)]
    own = [frame for frame in frames if not any(part in frame.filename for part in _LIBRARIES)]
    line = "".join(f"{Path(frame.filename).name} line {frame.lineno}: " for frame in (own or frames)[-1:])
    remedy = "" if isinstance(error, LieRigidBodyError) else ": mend that first"
    return f"the filter failed, {line}{said(error)}{remedy}"


@short_dataclass(frozen=True)
class NamedFunction:
    """A function that any process of this machine finds by the names of its module and its own.

    Attributes
    ----------
    name : str
        ``module:function``.
    """

    name: str

    def load(self) -> Estimator:
        """The function, in a module of the working directory or one that is installed.

        Raises
        ------
        InputError
            If there is no such module or function.
        """
        module, _, function = self.name.partition(":")
        if not (module and function):
            raise InputError(f"estimator {shown(self.name)}: give MODULE:FUNCTION, such as my_filter:estimate")
        if os.getcwd() not in sys.path:
            sys.path.append(os.getcwd())  # an executable has its own folder there, not where it was started
        what = f"estimator {shown(self.name)}"
        try:
            found: Estimator | None = getattr(import_module(module), function, None)
        except (Exception, SystemExit) as error:
            raise InputError(f"{what} cannot be imported: {shortened(said(error))}: {MENDED}") from None
        if not callable(found):
            raise InputError(f"{what}: {shown(module)} has no function {shown(function)}: define it there")
        return found


@short_dataclass(frozen=True)
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
    timeout_s: float = 60.0

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
                raise InputError(
                    f"{self._name} cannot be started: {error.strerror}: give the path of a program"
                ) from None
            try:
                self._wait(process, output, errors)
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

    def _wait(self, process: subprocess.Popen[bytes], *files: BinaryIO) -> None:
        """Wait for the end of a program; what it prints goes into files."""
        end = time.monotonic() + self.timeout_s
        while process.returncode is None:
            if time.monotonic() >= end:
                raise InputError(
                    f"{self._name} did not end within {self.timeout_s:g} s: let it end with its input, or give it more"
                )
            with suppress(subprocess.TimeoutExpired):
                process.wait(_PATIENCE_S)
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
        yield f"{stamp},{of_imu.get(stamp, ',,,,,')},{of_field.get(stamp, ',,')}"


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


Source: TypeAlias = NamedFunction | CommandEstimator
"""Place at which any process of this machine finds an estimator: its method ``load`` gives it."""


def source_of(estimate: Estimator | str) -> Source | None:
    """Find out how other processes get at an estimator: by ``module:function``, a function's own name, or a program.

    None where they would not find it.
    """
    if isinstance(estimate, str):
        return NamedFunction(estimate)
    if isinstance(estimate, CommandEstimator):
        return estimate
    module, name = getattr(estimate, "__module__", None), getattr(estimate, "__qualname__", "")
    if module in (None, "__main__") or not name.isidentifier() or sys.modules.get(module) is None:
        return None
    with suppress(Exception):
        if getattr(import_module(module), name) is estimate and sys.modules[module].__spec__ is not None:
            return NamedFunction(f"{module}:{name}")
    return None
