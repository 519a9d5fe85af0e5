"""The sensors of a log in tables: which columns they are, and their readings in SI units."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import listed, shown, suggestion
from lie_rigid_body.recording.logs.bags import ACCELEROMETER, GYRO, MAGNETOMETER, Vectors
from lie_rigid_body.recording.logs.headings import GRAVITY, SI, TIME, UNITS, Heading, sensor_of, unit_key
from lie_rigid_body.recording.logs.sources import sources_of
from lie_rigid_body.recording.logs.tables import TextTable, read_table
from lie_rigid_body.recording.logs.times import Clock, share_that_rises
from lie_rigid_body.system.bounded_input import real

FIELDS: Final = ("t", *(f"{sensor}_{axis}" for sensor in (GYRO, ACCELEROMETER, MAGNETOMETER) for axis in "xyz"))
"""Names by which columns are given."""
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
        return ", ".join(self.table.headings[column].text for column in self.columns) + f" of {self.table.name}"

    def factors(self) -> tuple[Array, str]:
        """Factors of the axes to SI units, shape (3,), and words about the units."""
        known = UNITS[self.sensor]
        program, of_program = self.table.program
        heads = [self.table.headings[column] for column in self.columns]
        units = [head.unit or of_program.get(self.sensor, "") for head in heads]
        factors = self.sign * np.array([known.get(unit_key(unit), 1.0) for unit in units])
        unit = units[0]
        si = SI[self.sensor]
        if len({*units}) > 1:
            raise InputError(f"{self.name} have the units {listed([*map(shown, units)])}: give one to all three axes")
        if not unit:
            told = f"taken as {si}, as no unit is given"
        elif unit_key(unit) in known:
            told = f"in {unit}{'' if heads[0].unit else f', the unit of {program}'}"
            told += "" if abs(factors[0]) == 1.0 else f", converted to {si}"
        elif _GIVEN in heads[0].words:
            raise InputError(f"columns: {shown(unit)} is no unit of a {self.sensor}: give {listed([*known])}")
        else:
            told = f"taken as {si}, as {shown(unit)} is no known unit"
        return factors, told + (", with the sign turned, as the program writes the opposite" if self.sign < 0 else "")


def read_tables(path: Path, columns: Mapping[str, str | int]) -> tuple[dict[str, Vectors], list[str]]:
    """The readings of a log in tables by their sensors, and sentences about what was taken for what.

    Raises
    ------
    InputError
        If there is no gyro or no time, or a row is at fault.
    """
    tables = [table for source in sources_of(path) if (table := read_table(source)) is not None]
    if not tables:
        lines = (line for source in sources_of(path) for line in source.lines() if line.strip())
        begins = next((f"begins {shown(line)}" for line in lines), "is empty")
        raise InputError(f"{path} has no row of numbers, it {begins}: give a CSV of readings, or a bag")
    tables = _named(tables, columns)
    triples = [triple for table in tables for triple in _triples(table)]
    has_gravity = any(triple.sensor == GRAVITY for triple in triples)
    found = dict[str, list[Triple]]()
    for triple in sorted(triples, key=lambda each: each.rank - (has_gravity and 1.5 * each.without_gravity)):
        found.setdefault(triple.sensor, []).append(triple)
    if GYRO not in found:
        there = "; ".join(table.columns for table in tables[:3])
        raise InputError(f"{path} has no gyro, but {there}: name its columns, such as t=1, gyro_x=2:deg/s")
    lacks = ACCELEROMETER in found and found[ACCELEROMETER][0].without_gravity
    chosen = {sensor: alike[0] for sensor, alike in found.items() if sensor != GRAVITY or lacks}
    read = dict[str, Vectors]()
    taken = list[str]()
    for table in tables:
        own = [triple for triple in chosen.values() if triple.table is table]
        read |= _read(table, own, taken) if own else {}
    for sensor, (_, *others) in found.items():
        if others and sensor in chosen:
            names = listed([each.name for each in others])
            taken.append(f"The {sensor} is not {names}: name its columns to choose another.")
    if lacks:
        added = ", which is added" if GRAVITY in read else ""
        taken.append(f"{chosen[ACCELEROMETER].name} is without gravity{added}.")
    if (gravity := read.pop(GRAVITY, None)) is not None:
        force = read[ACCELEROMETER]
        read[ACCELEROMETER] = replace(force, values=force.values + gravity.at(force.t_ns))
    return read, taken


def _named(tables: list[TextTable], columns: Mapping[str, str | int]) -> list[TextTable]:
    """Tables in which the columns that the user names have the headings of their fields."""
    given = [list(table.headings) for table in tables]
    for field, name in columns.items():
        if field not in FIELDS:
            raise InputError(f"columns: no field {shown(field)}: {suggestion(f'{field}', FIELDS, 'fields')}")
        places = [(own, *place) for own, table in zip(given, tables, strict=True) if (place := _find(table, f"{name}"))]
        if not places or (len(tables) > 1 and f"{name}".partition(":")[0].isdecimal()):
            texts = [head.text for table in tables for head in table.headings]
            raise InputError(f"columns: no column {shown(name)}: {suggestion(f'{name}', texts, 'columns')}")
        sensor, _, axis = field.partition("_")
        for own, column, unit in places:
            head = own[column]
            own[column] = Heading(
                head.text, (_GIVEN, sensor if axis else TIME), "xyz".index(axis) if axis else None, unit or head.unit
            )
    return [replace(table, headings=tuple(own)) for table, own in zip(tables, given, strict=True)]


def _find(table: TextTable, name: str) -> tuple[int, str] | None:
    """The column with a header, or of a number from 1 on, and the unit that is given behind it."""
    texts = [head.text for head in table.headings]
    numbers = [f"{i}" for i in range(1, len(texts) + 1)]
    for text, unit in ((name, ""), name.rpartition(":")[::2]):
        for names in (texts, numbers):
            if text in names:
                return names.index(text), unit
    return None


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
        rank = 2.0 * is_free + (not every.isdisjoint(_COMPUTED)) - ("total" in every) - 9.0 * (_GIVEN in words)
        rank -= 0.25 * bool(table.headings[columns[0]].unit)
        yield Triple(table, sensor, columns, rank, is_free, -1.0 if is_opposite else 1.0)


def _read(table: TextTable, triples: Sequence[Triple], taken: list[str]) -> dict[str, Vectors]:
    """The readings of the triples of a table, which is read in one pass."""
    first = table.first_rows()
    times = {triple.sensor: _time_of(table, triple.sensor, first) for triple in triples}
    of_program = table.program[1].get(TIME, "")
    clocks = {
        column: Clock(table.headings[column], [row[column] for row in first], of_program, table.source.name)
        for column in times.values()
    }
    kept = sorted({column for triple in triples for column in triple.columns})
    parts = list[tuple[Integers, Array, dict[int, Integers]]]()
    for lines, rows in table.blocks():
        columns = [*zip(*rows, strict=False)]

        def refuse(row: int, what: str, lines: Sequence[int] = lines) -> InputError:
            return InputError(f"{table.source.name}, line {lines[row]}: {what}: correct or remove the row")

        numbers = np.column_stack([_numbers(columns[column], refuse) for column in kept])
        stamps = {column: clock.at(columns[column], refuse) for column, clock in clocks.items()}
        parts.append((np.array(lines), numbers, stamps))
    numbers_of_lines = np.concatenate([each for each, _, _ in parts])
    values = np.concatenate([each for _, each, _ in parts])
    found = dict[str, Vectors]()
    for triple in triples:
        clock = clocks[times[triple.sensor]]
        t_ns = np.concatenate([each[times[triple.sensor]] for _, _, each in parts])
        own = values[:, [kept.index(column) for column in triple.columns]]
        there = ~np.isnan(own).all(axis=1)
        faulty = there & (np.isnan(own).any(axis=1) | (t_ns == clock.MISSING))
        if faulty.any() or not there.any():
            told = f", line {numbers_of_lines[faulty][0]}: an empty cell" if faulty.any() else " has no row"
            raise InputError(f"{table.source.name}{told} of the {triple.sensor} or of its time: complete it")
        factors, told = triple.factors()
        t_ns, of_time = clock.unwrapped(t_ns[there])
        found[triple.sensor] = Vectors(t_ns, own[there] * factors, triple.name)
        taken += [f"The {triple.sensor} is {triple.name}, {told}."]
        of_time = f"The time is {clock.head.text} of {table.name}, {of_time}."
        taken += [of_time] if of_time not in taken else []
    return found


def _numbers(cells: Sequence[str], refuse: Callable[[int, str], InputError]) -> Array:
    """Numbers of a column, NaN for an empty cell."""
    try:
        found = np.array([float(cell) for cell in cells])
        if np.isfinite(found).all() and "_" not in "".join(cells):
            return found
    except ValueError:  # a cell is empty, has a decimal comma, or is no number
        pass
    found = np.full(len(cells), np.nan)
    for row, cell in enumerate(cells):
        if cell:
            try:
                found[row] = real(cell.replace(",", "."))
            except ValueError:
                raise refuse(row, f"{shown(cell)} is no number") from None
            if not abs(found[row]) < np.inf:
                raise refuse(row, f"{shown(cell)} is not finite")
    return found


def _time_of(table: TextTable, sensor: str, rows: Sequence[Sequence[str]]) -> int:
    """The column of the time of a sensor: one that is called after it, or else the one that rises at most rows."""
    columns = {column: head for column, head in enumerate(table.headings) if head.is_time}
    given = [column for column, head in columns.items() if _GIVEN in head.words]
    own = [column for column, head in columns.items() if sensor_of(head.words) == sensor]
    others = [column for column, head in columns.items() if sensor_of(head.words) is None]
    if not columns:
        raise InputError(f"{table.source.name} has no time, but {table.columns}: name its column, such as t=1")
    return max(given or own or others or columns, key=lambda column: share_that_rises([row[column] for row in rows]))
