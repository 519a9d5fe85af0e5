"""The sensors of a log in tables: which columns they are, and their readings in SI units."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import SI, listed, shown, suggestion
from lie_rigid_body.recording.logs.bags import ACCELEROMETER, GYRO, MAGNETOMETER, Vectors
from lie_rigid_body.recording.logs.headings import GRAVITY, UNITS, Heading, heading, sensor_of, unit_key
from lie_rigid_body.recording.logs.sources import lines_of, sources_of
from lie_rigid_body.recording.logs.tables import TextTable, read_table
from lie_rigid_body.recording.logs.times import Clock, as_number, clock_of, share_that_differs

FIELDS: Final = ("t", *(f"{sensor}_{axis}" for sensor in (GYRO, ACCELEROMETER, MAGNETOMETER) for axis in "xyz"))
"""Names by which columns are given."""
GivenColumns: TypeAlias = Mapping[str, str | int]
"""Headers of columns, or their numbers from 1 on, by these names."""
_FIRST_ROWS: Final = 1000
"""Rows by which columns of time are known."""
_READING: Final = np.dtype([("t_ns", np.int64), ("values", np.float64, 3)])
_GIVEN: Final = "given"
"""Word of the headings of columns that the user names."""
_WITHOUT_GRAVITY: Final = {"linear", "user", "free", "without"}
_COMPUTED: Final = {"motion", "fused", "filtered", "smooth", "uncalibrated"}
_OPPOSITE: Final = ("accelerometer acceleration", "motion user", "motion gravity")
"""Beginnings of what SensorLog writes as Apple's systems read it: the opposite of the specific force."""


@short_dataclass
class Triple:
    """Three columns of a table with the axes of a sensor.

    Attributes
    ----------
    table : TextTable
    sensor : str
    columns : list of int
        Those of x, y, z.
    rank : float
        The least is taken: readings come before what a program computes of them.
    without_gravity : bool
        Whether the program takes gravity off.
    """

    table: TextTable
    sensor: str
    columns: list[int]
    rank: float
    without_gravity: bool

    @property
    def heads(self) -> list[Heading]:
        """The headings of its columns."""
        return [self.table.headings[column] for column in self.columns]

    @property
    def name(self) -> str:
        """Its columns, for sentences."""
        return f"{', '.join(head.text for head in self.heads)} of {self.table.source.name}"

    def factor(self) -> tuple[float, str]:
        """Factor of the axes to SI units, and words about the unit."""
        program, of_program = self.table.program
        head, *others = self.heads
        if any(other.unit != head.unit for other in others):
            raise InputError(f"{self.name} differ in their units: give one to all three axes")
        unit = head.unit or of_program.get(self.sensor, "")
        factor = UNITS[self.sensor].get(unit_key(unit))
        told = f"in {unit}{'' if head.unit else f', the unit of {program}'}"
        if factor is None:
            if unit and _GIVEN in head.words:
                known = listed(UNITS[self.sensor])
                raise InputError(f"columns: {shown(unit)} is no unit of a {self.sensor}: give {known}")
            factor = 1.0
            told = f"taken as {SI[self.sensor]}, as {f'{shown(unit)} is no known unit' if unit else 'no unit is given'}"
        elif factor != 1.0:
            told += f", converted to {SI[self.sensor]}"
        if " ".join(head.words).startswith(_OPPOSITE):
            return -factor, f"{told}, with the sign turned, as the program writes the opposite"
        return factor, told


def read_tables(path: Path, columns: GivenColumns) -> tuple[dict[str, Vectors], list[str]]:
    """The readings of a log in tables by their sensors, and sentences about what was taken for what.

    Raises
    ------
    InputError
        If there is no gyro or no time, or a row is at fault.
    """
    sources = sources_of(path)
    tables = [*filter(None, map(read_table, sources))]
    if not tables:
        texts = [f"{source.name} begins {shown(next(filter(None, lines_of(source)), ''))}" for source in sources]
        begins = listed(texts) or "there is no CSV"
        raise InputError(f"{path} has no row of numbers, {begins}: give a CSV of readings, a folder of them, or a bag")
    _name_columns(tables, columns)
    found = defaultdict[str, list[Triple]](list)
    for table in tables:
        for triple in _triples(table):
            found[triple.sensor].append(triple)
    gravity = found.pop(GRAVITY, [])
    if GYRO not in found:
        there = listed(_texts(*tables))
        raise InputError(f"{path} has no gyro, but the columns {there}: name its columns, such as t=1, gyro_x=2:deg/s")
    read = dict[str, Vectors]()
    taken = list[str]()
    for sensor, alike in found.items():
        triple, *others = sorted(alike, key=lambda each: each.rank - 1.5 * (bool(gravity) and each.without_gravity))
        read[sensor], told = _read(triple)
        taken += told
        if others:
            names = listed([each.name for each in others])
            taken.append(f"The {sensor} is not {names}: name its columns, or give its file, to choose another.")
        if triple.without_gravity:
            for vertical in gravity[:1]:
                added, told = _read(vertical)
                t_ns = read[sensor].t_ns
                read[sensor] = Vectors(t_ns, read[sensor].values + added.at(t_ns))
                taken += told
            taken.append(f"{triple.name} is without gravity{', which is added' if gravity else ''}.")
    return read, [*dict.fromkeys(taken)]


def _name_columns(tables: list[TextTable], columns: GivenColumns) -> None:
    """Give the columns that the user names the headings of their fields."""
    for field, given in columns.items():
        if field not in FIELDS:
            raise InputError(f"columns: no field {shown(field)}: {suggestion(f'{field}', FIELDS, 'fields')}")
        found = [
            (table, column, f"{given}"[len(name) + 1 :])
            for table in tables
            for column, head in enumerate(table.headings)
            for name in (head.text, f"{column + 1}" if len(tables) == 1 else head.text)
            if f"{given}:".startswith(f"{name}:")
        ]
        if not found:
            known = suggestion(f"{given}", _texts(*tables), "columns")
            raise InputError(f"columns: no column {shown(given)}: {known}")
        for table, column, unit in found:
            head = table.headings[column]
            named = heading(f"{_GIVEN} {'time' if field == 't' else field} ({unit or head.unit})")
            table.headings[column] = replace(named, text=head.text)


def _texts(*tables: TextTable) -> list[str]:
    """The headers of all columns."""
    return [head.text for table in tables for head in table.headings]


def _triples(table: TextTable) -> Iterator[Triple]:
    """The triples of a table."""
    groups = defaultdict[tuple[str, ...], dict[int, int]](dict)
    for column, head in enumerate(table.headings):
        if head.axis is not None:
            groups[head.words].setdefault(head.axis, column)
    is_ros = any(head.words[-2:] == ("angular", "velocity") for head in table.headings)  # whose linear has gravity
    for words, axes in groups.items():
        sensor = sensor_of(words or table.words)
        if _GIVEN in words and len(axes) < 3:
            raise InputError(f"columns: {sensor} has {len(axes)} of its three axes: name x, y and z")
        if sensor is None or len(axes) < 3:
            continue
        every = {*words, *(table.words if sensor_of(table.words) else ())}
        of_logger = table.program[0] == "Sensor Logger" and every == {ACCELEROMETER}
        is_free = sensor == ACCELEROMETER and (of_logger or not (is_ros or every.isdisjoint(_WITHOUT_GRAVITY)))
        has_unit = bool(table.headings[axes[0]].unit)
        rank = 2.0 * is_free + (not every.isdisjoint(_COMPUTED)) - 9.0 * (_GIVEN in words) - 0.25 * has_unit
        yield Triple(table, sensor, [axes[axis] for axis in range(3)], rank, is_free)


def _read(triple: Triple) -> tuple[Vectors, list[str]]:
    """The readings of a triple, and sentences about its unit and its time."""
    table = triple.table
    column, clock = _time_of(table, triple.sensor)

    def reading(cells: list[str]) -> tuple[int, tuple[float, ...]] | None:
        texts = [cells[axis] for axis in triple.columns]
        return (clock.read(cells[column]), tuple(map(as_number, texts))) if any(texts) else None

    read = np.fromiter(filter(None, table.rows(reading)), _READING)
    if not len(read):
        raise InputError(f"{table.source} has no row of the {triple.sensor}: complete it")
    factor, of_unit = triple.factor()
    t_ns, of_time = clock.unwrapped(read["t_ns"])
    sentences = [
        f"The {triple.sensor} is {triple.name}, {of_unit}.",
        f"The time is {table.headings[column].text} of {table.source.name}, {of_time}.",
    ]
    return Vectors(t_ns, factor * read["values"]), sentences


def _time_of(table: TextTable, sensor: str) -> tuple[int, Clock]:
    """The column of the time of a sensor: one that is called after it, or else the one that differs at most rows."""
    rows = [*islice(table.rows(list), _FIRST_ROWS)]
    times = {column: [row[column] for row in rows] for column, head in enumerate(table.headings) if head.is_time}

    def fitness(column: int) -> tuple[bool, int, float]:
        words = table.headings[column].words
        return _GIVEN in words, {sensor: 2, None: 1}.get(sensor_of(words), 0), share_that_differs(times[column])

    for column in sorted(times, key=fitness, reverse=True)[:1]:
        clock = clock_of(table.headings[column], times[column])
        if clock is not None:
            return column, clock
    there = listed(_texts(table))
    raise InputError(f"{table.source} has no time of known unit, but the columns {there}: name it, such as t=1:ms")
