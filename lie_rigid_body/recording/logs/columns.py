"""The sensors of a log in tables: which columns they are, and their readings in SI units."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Final, TypeAlias

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import SI, listed, shown, suggestion
from lie_rigid_body.recording.logs.bags import ACCELEROMETER, GYRO, MAGNETOMETER, Vectors
from lie_rigid_body.recording.logs.headings import GRAVITY, TIME, UNITS, heading, sensor_of, unit_key
from lie_rigid_body.recording.logs.sources import lines_of, sources_of
from lie_rigid_body.recording.logs.tables import TextTable, read_table
from lie_rigid_body.recording.logs.times import clock_of, share_that_rises

FIELDS: Final = ("t", *(f"{sensor}_{axis}" for sensor in (GYRO, ACCELEROMETER, MAGNETOMETER) for axis in "xyz"))
"""Names by which columns are given."""
GivenColumns: TypeAlias = Mapping[str, str | int]
"""Headers of columns, or their numbers from 1 on, by these names."""
_FIRST_ROWS: Final = 1000
"""Rows by which columns of time are known."""
_GIVEN: Final = "given"
"""Word of the headings of columns that the user names."""
_WITHOUT_GRAVITY: Final = {"linear", "user", "free", "without"}
_COMPUTED: Final = {"motion", "fused", "filtered", "smooth", "uncalibrated"}
_APPLE: Final = ("accelerometer", "acceleration")
"""Words of SensorLog, which writes what Apple's systems read: the opposite of the specific force."""


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
    sign : float
        The sign of the specific force in it.
    """

    table: TextTable
    sensor: str
    columns: list[int]
    rank: float
    without_gravity: bool
    sign: float

    @property
    def name(self) -> str:
        """Its columns, for sentences."""
        return ", ".join(self.table.headings[column].text for column in self.columns) + f" of {self.table.source.name}"

    def factor(self) -> tuple[float, str]:
        """Factor of the axes to SI units, and words about the unit."""
        known = UNITS[self.sensor]
        program, of_program = self.table.program
        heads = [self.table.headings[column] for column in self.columns]
        given = {head.unit: None for head in heads}
        if len(given) > 1:
            raise InputError(f"{self.name} have the units {listed([*map(shown, given)])}: give one to all three axes")
        unit = heads[0].unit or of_program.get(self.sensor, "")
        factor = known.get(unit_key(unit), 0.0)
        told = f"taken as {SI[self.sensor]}, as {f'{shown(unit)} is no known unit' if unit else 'no unit is given'}"
        if unit and not factor and _GIVEN in heads[0].words:
            raise InputError(f"columns: {shown(unit)} is no unit of a {self.sensor}: give {listed([*known])}")
        if factor:
            told = f"in {unit}{'' if heads[0].unit else f', the unit of {program}'}"
            told += "" if factor == 1.0 else f", converted to {SI[self.sensor]}"
        if self.sign < 0.0:
            told += ", with the sign turned, as the program writes the opposite"
        return self.sign * (factor or 1.0), told


def read_tables(path: Path, columns: GivenColumns) -> tuple[dict[str, Vectors], list[str]]:
    """The readings of a log in tables by their sensors, and sentences about what was taken for what.

    Raises
    ------
    InputError
        If there is no gyro or no time, or a row is at fault.
    """
    tables = [*filter(None, map(read_table, sources_of(path)))]
    if not tables:
        lines = (f"begins {shown(line)}" for source in sources_of(path) for line in lines_of(source) if line)
        begins = next(lines, "is empty")
        raise InputError(f"{path} has no row of numbers, it {begins}: give a CSV of readings, or a bag")
    _name_columns(tables, columns)
    found = defaultdict[str, list[Triple]](list)
    for table in tables:
        for triple in _triples(table):
            found[triple.sensor].append(triple)
    gravity = found.pop(GRAVITY, [])
    for alike in found.values():
        alike.sort(key=lambda each: each.rank - 1.5 * (bool(gravity) and each.without_gravity))
    if GYRO not in found:
        there = "; ".join(table.columns for table in tables[:3])
        raise InputError(f"{path} has no gyro, but {there}: name its columns, such as t=1, gyro_x=2:deg/s")
    read = dict[str, Vectors]()
    taken = list[str]()
    for sensor, (triple, *others) in found.items():
        read[sensor], told = _read(triple)
        taken += told
        if others:
            names = listed([each.name for each in others])
            taken.append(f"The {sensor} is not {names}: name its columns, or give its file, to choose another.")
    if ACCELEROMETER in found and found[ACCELEROMETER][0].without_gravity:
        force = read[ACCELEROMETER]
        for triple in gravity[:1]:
            vertical, told = _read(triple)
            taken += told
            read[ACCELEROMETER] = replace(force, values=force.values + vertical.at(force.t_ns))
        added = ", which is added" if gravity else ""
        taken.append(f"{found[ACCELEROMETER][0].name} is without gravity{added}.")
    return read, [*dict.fromkeys(taken)]


def _name_columns(tables: list[TextTable], columns: GivenColumns) -> None:
    """Give the columns that the user names the headings of their fields."""
    for field, name in columns.items():
        if field not in FIELDS:
            raise InputError(f"columns: no field {shown(field)}: {suggestion(f'{field}', FIELDS, 'fields')}")
        places = [(table, *place) for table in tables if (place := _find(table, f"{name}"))]
        if not places or (len(tables) > 1 and f"{name}".partition(":")[0].isdecimal()):
            texts = [head.text for table in tables for head in table.headings]
            raise InputError(f"columns: no column {shown(name)}: {suggestion(f'{name}', texts, 'columns')}")
        for table, column, unit in places:
            head = table.headings[column]
            given = heading(f"{_GIVEN} {'time' if field == 't' else field} ({unit or head.unit})")
            table.headings[column] = replace(given, text=head.text)


def _find(table: TextTable, name: str) -> tuple[int, str] | None:
    """The column with a header, or of a number from 1 on, and the unit that is given behind it."""
    places = {text: i for i, head in enumerate(table.headings) for text in (f"{i + 1}", head.text)}
    return next(
        ((places[text], unit) for text, unit in ((name, ""), name.rpartition(":")[::2]) if text in places), None
    )


def _triples(table: TextTable) -> Iterator[Triple]:
    """The triples of a table."""
    groups = dict[tuple[str, ...], dict[int, int]]()
    for column, head in enumerate(table.headings):
        if head.axis is not None:
            groups.setdefault(head.words, {}).setdefault(head.axis, column)
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
        is_opposite = sensor in (ACCELEROMETER, GRAVITY) and (words[:1] == ("motion",) or words[:2] == _APPLE)
        columns = [axes[axis] for axis in range(3)]
        has_unit = bool(table.headings[columns[0]].unit)
        rank = 2.0 * is_free + (not every.isdisjoint(_COMPUTED)) - ("total" in every)
        rank -= 9.0 * (_GIVEN in words) + 0.25 * has_unit
        yield Triple(table, sensor, columns, rank, is_free, -1.0 if is_opposite else 1.0)


def _read(triple: Triple) -> tuple[Vectors, list[str]]:
    """The readings of a triple, and sentences about its unit and its time."""
    table = triple.table
    first = [cells for _, cells in islice(table.rows(), _FIRST_ROWS)]
    column = _time_of(table, triple.sensor, first)
    head = table.headings[column]
    clock = clock_of(head, [row[column] for row in first], table.program[1].get(TIME, ""))
    if clock is None:
        remedy = f"name another column, or its unit, such as t={head.text}:ms"
        told = f"size and steps of {shown(head.text)}, in {len(first)} rows, are those of no time"
        raise InputError(f"{table.source}: {told}: {remedy}")
    t_ns, values = table.read(column, clock.read, triple.columns)
    if not len(t_ns):
        raise InputError(f"{table.source} has no row of the {triple.sensor}: complete it")
    factor, of_unit = triple.factor()
    t_ns, of_time = clock.unwrapped(t_ns)
    sentences = [
        f"The {triple.sensor} is {triple.name}, {of_unit}.",
        f"The time is {head.text} of {table.source.name}, {of_time}.",
    ]
    return Vectors(t_ns, factor * values), sentences


def _time_of(table: TextTable, sensor: str, rows: Sequence[Sequence[str]]) -> int:
    """The column of the time of a sensor: one that is called after it, or else the one that rises at most rows."""

    def fitness(column: int) -> tuple[bool, bool, bool, float]:
        """How well a column goes with the sensor, by its words and by the share of its times that rise."""
        words = table.headings[column].words
        named = sensor_of(words)
        return _GIVEN in words, named == sensor, named is None, share_that_rises([row[column] for row in rows])

    columns = [column for column, head in enumerate(table.headings) if head.is_time]
    if not columns:
        raise InputError(f"{table.source} has no time, but {table.columns}: name its column, such as t=1")
    return max(columns, key=fitness)
