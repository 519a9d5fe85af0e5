"""Programs as estimators: one that reads CSV and prints attitudes, and a ROS 2 node, to which readings are played."""

from __future__ import annotations

import errno
import math
import os
import shlex
import shutil
import subprocess
import tempfile
import time
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import Any, BinaryIO, ClassVar, Final, NamedTuple

import numpy as np

from lie_rigid_body.evaluation.arguments import quantity
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import BagError, InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed, printable, shown
from lie_rigid_body.messages.decoding import Frames
from lie_rigid_body.recording.topic_messages import NO_ORIENTATION, AttitudeTrack, attitudes_of
from lie_rigid_body.runs.bag_of_run import encoded_readings
from lie_rigid_body.runs.run import Run, require_run
from lie_rigid_body.sensors.imu import IMU_SENSOR
from lie_rigid_body.system.bounded_input import real
from lie_rigid_body.system.interpreters import Interpreter, guarded
from lie_rigid_body.system.output_file import reason

HEADER: Final = "t_ns,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z,mag_x,mag_y,mag_z"
"""First line that the program reads: stamps in ns, rad/s, m/s² and T on the body's axes."""
_COLUMNS: Final = (("imu", "gyro"), ("imu", "specific_force"), ("magnetometer", "field"))
"""Sensors, and the arrays of their readings, in the columns of the header."""
ANSWER: Final = "t_ns,x,y,z,w"
"""Columns that the program prints, with this line above them or without."""
MAX_TIMEOUT_S: Final = 1e6
"""Largest limit of the time of one run of an estimator, s; clocks of some platforms end far beyond it."""
_MIN_BYTES: Final = 2**20
_BYTES_OF_A_LINE: Final = 256
"""Largest output of a program: so many bytes, and so many for each line of readings; a line of all digits has 120."""
_MAX_WORDS: Final = 100
"""Largest number of bytes that are repeated of what a program prints."""
PLAYER: Final = "lie_rigid_body.ros.play"
"""Module that plays readings to a node: nothing else here needs ROS."""
ATTITUDE_TOPIC: Final = "imu/data"
"""Topic of the attitudes of a filter, as filters of imu_tools call it."""
_BEGIN_NS: Final = 1_767_225_600 * 10**9
"""Time added to the stamps of a run, ns: the year 2026. A stamp of 0 means that there is no time yet, and a node that
keeps seconds in single precision errs at stamps of today only."""
_FIRST_DAY_NS: Final = 946_684_800 * 10**9
"""First stamp, ns, that is taken for a time of day: the year 2000."""
_GRACE_S: Final = 1.0
"""Time that a player has beyond that of its run, s."""


def time_limit(timeout: object) -> float:
    """Read a limit of the time of one run of a filter, s, above 0 and at most `MAX_TIMEOUT_S`.

    Raises
    ------
    InputError
        If it is anything else.
    """
    limit_s = quantity("timeout", timeout, "seconds", "60")
    if limit_s > MAX_TIMEOUT_S:
        raise InputError(f"timeout: {limit_s:g} s is more than {MAX_TIMEOUT_S:g}: give less")
    return limit_s


def words(command: str) -> list[str]:
    """Program and arguments of a command, as a shell splits it; none where a quotation has no end."""
    with suppress(ValueError):
        return shlex.split(command)
    return []


@short_dataclass
class ProgramEstimator(ABC):
    """An estimator that starts a program for each run.

    Attributes
    ----------
    command : str
        Program and arguments, as for a shell; no shell is started.
    timeout_s : float
        Longest time of a run, s.

    Raises
    ------
    InputError
        If the command has no program, or a quotation without an end, or if the time is no limit.
    """

    kind: ClassVar[str]
    command: str
    timeout_s: float = 60.0

    def __post_init__(self) -> None:
        if not isinstance(self.command, str) or not words(self.command) or "\0" in self.command:
            raise InputError(
                f"{self._name}: give a program as in a shell, quotations closed, such as './my_filter --rate 100'"
            )
        time_limit(self.timeout_s)

    def require_program(self, place: str = "") -> None:
        """Refuse a program that is not there, in a line that begins with the place where it is given.

        Raises
        ------
        InputError
        """
        program = words(self.command)[0]
        if shutil.which(program) is None:
            fault = os.strerror(errno.ENOENT)
            if os.path.exists(program):
                fault = "it is not on PATH" if os.access(program, os.X_OK) else "it is not executable"
                fault = "it is a folder" if os.path.isdir(program) else fault
            raise InputError(f"{place}{self._name} cannot be started: {fault}: give the path of a program")

    def load(self) -> ProgramEstimator:
        """The estimator itself, for a process that is told where one is."""
        return self

    @abstractmethod
    def __call__(self, run: Run) -> object:
        """Estimate of a run, as `Estimate.of` takes it."""

    @property
    def _name(self) -> str:
        return f"{self.kind} {shown(self.command)}"


@short_dataclass
class CommandEstimator(ProgramEstimator):
    """A program that reads readings as CSV and prints attitudes; see `ProgramEstimator` for the parameters."""

    kind: ClassVar[str] = "command"

    def __call__(self, run: Run) -> tuple[Integers, Array]:
        """Stamps, ns, shape (N,), and attitudes world-from-body, scalar last, shape (N, 4), that the program prints.

        Raises
        ------
        InputError
            If it cannot be started, ends with a status other than 0, prints nothing or a line that is no attitude, or
            does not end in time.
        """
        require_run(run)
        with _file() as errors:
            try:
                return _attitudes(self._name, self._output("\n".join([*lines_of(run), ""]), errors))
            except InputError as error:
                raise InputError(f"{error}{last_words(errors)}") from None

    def _output(self, readings: str, errors: BinaryIO) -> str:
        self.require_program()
        # no pipes: what is not read or written in time would stand in them
        with _file() as given, _file() as output:
            given.write(readings.encode())
            given.seek(0)
            try:
                process = subprocess.Popen(
                    words(self.command),
                    stdin=given,
                    stdout=output,
                    stderr=errors,
                    start_new_session=True,  # so that it can be ended with what it starts
                )
            except (OSError, ValueError) as error:  # the second of a text that no program can be given
                raise InputError(
                    f"{self._name} cannot be started: {reason(error)}: give the path of a program"
                ) from None
            with guarded(process):
                self._wait(process, _MIN_BYTES + _BYTES_OF_A_LINE * readings.count("\n"), output, errors)
            if process.returncode:
                raise InputError(f"{self._name} ended with status {process.returncode}: correct it")
            output.seek(0)
            return output.read().decode(errors="replace")

    def _wait(self, process: subprocess.Popen[bytes], most: int, *files: BinaryIO) -> None:
        """Wait for the end of a program, which prints so many bytes at most into each of some files."""
        end = time.monotonic() + self.timeout_s
        while process.returncode is None:
            if time.monotonic() >= end:
                raise InputError(
                    f"{self._name} did not end within {self.timeout_s:g} s: let it end with its input, or give it more"
                )
            with suppress(subprocess.TimeoutExpired):
                process.wait(0.05)  # then it is looked at again how much was printed
            if any(os.fstat(file.fileno()).st_size > most for file in files):
                raise InputError(f"{self._name} prints more than {most} bytes: print {ANSWER} once for each reading")


def last_words(file: BinaryIO) -> str:
    """Words for the end of what a program has printed into a file; none where it has printed nothing."""
    size = os.fstat(file.fileno()).st_size
    os.lseek(file.fileno(), max(0, size - _MAX_WORDS), os.SEEK_SET)
    end = os.read(file.fileno(), _MAX_WORDS)  # its place, which is that of the program too, is the end again
    said = printable(" ".join(end.decode(errors="replace").split()))
    return f"; it says: {'…' * (size > _MAX_WORDS)}{said}" if said else ""


def _file() -> BinaryIO:
    """A file without a name: in memory where a system has such, as a full disk is no fault of the filter."""
    return os.fdopen(os.memfd_create("estimator"), "w+b") if hasattr(os, "memfd_create") else tempfile.TemporaryFile()


def lines_of(run: Run) -> Iterator[str]:
    """Header, and readings of a run in the order of their stamps; those of one stamp share a line.

    A sensor that the run has not leaves its columns empty.
    """
    yield HEADER
    texts = defaultdict[int, list[str]](lambda: [",,"] * len(_COLUMNS))
    for number, (sensor, array) in enumerate(_COLUMNS):
        readings = run.sensors.get(sensor)
        if readings and (rows := readings.arrays[array]) is not None:
            for stamp, row in zip(readings.t_ns.tolist(), rows.tolist(), strict=True):
                texts[stamp][number] = ",".join(map(repr, row))
    for stamp in sorted(texts):
        yield ",".join([str(stamp), *texts[stamp]])


def _attitudes(name: str, output: str) -> tuple[Integers, Array]:
    lines = output.splitlines()
    first = 1 if lines and lines[0].replace(" ", "") == ANSWER else 0
    stamps = []
    rows = []
    for number, line in enumerate(lines[first:], first + 1):
        try:
            stamp, *numbers = line.split(",")
            x, y, z, w = map(real, numbers)
            real(stamp)
            stamps.append(np.int64(int(stamp)))
            if not 0.0 < math.hypot(x, y, z, w) < math.inf:
                raise ValueError("no rotation")
        except (ValueError, OverflowError):
            raise InputError(
                f"{name} prints, line {number}: {shown(line)}: print {ANSWER} in each line, not NaN, not all 0"
            ) from None
        rows.append((x, y, z, w))
    if not rows:
        raise InputError(f"{name} prints no attitude: print {ANSWER} for each reading, and flush at the end")
    return np.array(stamps, dtype=np.int64), np.array(rows, dtype=np.float64)


class Reading(NamedTuple):
    """A message of a sensor."""

    arrival_ns: int
    sensor: str
    stamp_ns: int
    payload: bytes


class Answered(NamedTuple):
    """Publications of a node: the full name and the type of its topic, and the messages."""

    topic: str
    message_type: str
    payloads: list[bytes]


@dataclass(frozen=True, repr=False)
class NodeEstimator(ProgramEstimator):
    """A ROS 2 node, such as ``ros2 run my_package my_filter``; see `ProgramEstimator` for the other parameters.

    Attributes
    ----------
    topic : str
        Topic of its attitudes.
    """

    kind: ClassVar[str] = "node"
    topic: str = ATTITUDE_TOPIC

    def __call__(self, run: Run) -> Estimate:
        """Attitudes that the node publishes, with their covariances where all have one.

        Raises
        ------
        InputError
            If it cannot be started, ends, hears no IMU, publishes no attitude of the body, or leaves a reading without
            an answer.
        """
        require_run(run)
        run = run.declared()
        answered = self._played(readings_of(run))
        try:
            found = attitudes_of(*answered)
        except BagError as error:
            raise InputError(f"{self._name}: {error}") from None
        track = self._of_body(answered.topic, found, (run.scenario.world_frame, run.scenario.body_frame))
        stamps, first = np.unique(track.stamps_ns, return_index=True)  # of two answers to a reading the first
        P = track.covariance
        told = None if P is None or not P[first].any(axis=(1, 2)).all() else P[first]
        return Estimate(track.attitude_xyzw[first], stamps - _later_ns(run), told)

    def _played(self, readings: tuple[Reading, ...]) -> Answered:
        player = Interpreter()
        try:
            reply: Answered | str = player.ask(partial(_play, self, readings), self.timeout_s + _GRACE_S)
        except (EOFError, TimeoutError):
            raise InputError(
                f"{self._name} did not end within {self.timeout_s:g} s: give it more, or play it less"
            ) from None
        finally:
            player.end()
        if isinstance(reply, str):
            raise InputError(f"{self._name} {reply}")
        return reply

    def _of_body(self, topic: str, found: Mapping[Frames, AttitudeTrack], frames: Frames) -> AttitudeTrack:
        """The attitudes of the body's frames; without frames of two of the only ones that there are."""
        (first, *others) = found or [frames]
        if first not in found or not len(found[first]):
            raise InputError(f"{self._name}: {topic} {NO_ORIENTATION}")
        if frames in found:
            return found[frames]
        if others or first[1]:
            told = listed([" to ".join(filter(None, pair)) for pair in found])
            raise InputError(
                f"{self._name}: {topic} is of {told}, and not of {' to '.join(frames)}: name the frames so"
            )
        return found[first]


def _play(estimator: NodeEstimator, readings: tuple[Reading, ...]) -> Any:
    return import_module(PLAYER).played(estimator, readings)


def readings_of(run: Run) -> tuple[Reading, ...]:
    """The readings of a run as messages in the order in which they arrive, those of the IMU after others.

    Raises
    ------
    InputError
        If there is no IMU.
    """
    require_run(run)
    if "imu" not in run.sensors:
        raise InputError("a run without an IMU cannot be played to a node: give imu_rate")
    return tuple(sorted(_readings(run), key=lambda reading: (reading.arrival_ns, reading.sensor == IMU_SENSOR.name)))


def _later_ns(run: Run) -> int:
    """Time that is added to the stamps of a run, ns: none to those of a log that are times of day."""
    return 0 if int(run.imu.t_ns[0]) >= _FIRST_DAY_NS else _BEGIN_NS


def _readings(run: Run) -> Iterator[Reading]:
    later_ns = _later_ns(run)
    for sensor, arrays, payloads in encoded_readings(run.sensors, run.scenario, later_ns):  # the others tell the truth
        stamps = arrays.t_ns + later_ns
        arrival = arrays.arrival_ns + later_ns
        yield from map(Reading, arrival.tolist(), [sensor.name] * len(stamps), stamps.tolist(), payloads)
