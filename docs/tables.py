"""Tables of the reference, from the tables of the code: ``python docs/tables.py`` writes them into their pages.

A table stands between two marks, ``<!-- begin of table NAME -->`` and ``<!-- end of table NAME -->``. What is outside
of the marks is written by hand.
"""

from __future__ import annotations

import argparse
import math
import re
from collections import defaultdict
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Final
from unittest.mock import patch

from lie_rigid_body.__main__ import VERBS, main
from lie_rigid_body.command_line import Parser
from lie_rigid_body.foundation.parameters import Parameter
from lie_rigid_body.ros.sim import parse
from lie_rigid_body.scenario.parameter_table import OWN
from lie_rigid_body.sensors import SENSORS
from lie_rigid_body.sensors.parameters import WINDOW_PARAMETERS

DOCS: Final = Path(__file__).resolve().parent
MARKED: Final = re.compile(r"(?<=<!-- begin of table )([\w-]+)( -->\n).*?(?=<!-- end of table \1 -->)", re.DOTALL)
FAULTY: Final = ("imu", "magnetometer", "attitude_sensor", "sun_sensor", "gyro", "accelerometer")
"""Names with which the parameters of faults begin that several sensors have."""

USUAL: Final = ["0", "1e9"]
"""Limits of most parameters of sensors, which their pages tell."""
HEAD: Final = ("name", "type", "default", "meaning")
KINDS: Final = {"double_array": "double{}", "string_array": "string[]"}


def table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """A table in Markdown."""
    lines = [head, ("---",) * len(head), *rows]
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines)


def kind(parameter: Parameter) -> str:
    """The type of a parameter, as a ROS 2 interface file writes it."""
    lengths = [] if isinstance(parameter.lengths, range) else parameter.lengths
    return KINDS.get(parameter.kind, parameter.kind).format(" or ".join(f"[{n}]" for n in lengths) or "[]")


def default(parameter: Parameter) -> str:
    """The default of a parameter, as a parameter file writes it."""
    value = parameter.default
    if isinstance(value, tuple):
        return f"`[{', '.join(f'{part:g}' if isinstance(part, float) else str(part) for part in value)}]`"
    return f"`{str(value).lower()}`" if isinstance(value, bool) else f"`{value!r}`" if value == "" else f"`{value}`"


def meaning(parameter: Parameter) -> str:
    """What a parameter is, and the values that it may have, unless these are the usual ones."""
    limits = [short(limit) for limit in (parameter.minimum, parameter.maximum) if math.isfinite(limit)]
    limits = [] if limits == USUAL else limits
    choices = "" if all(c in parameter.description for c in parameter.choices) else ", ".join(parameter.choices)
    ranges = f" ({' to '.join(limits)})" if len(limits) == 2 else f" (from {limits[0]})" if limits else ""
    return parameter.description.rstrip(".") + ranges + (f": {choices}" if choices else "")


def short(number: float) -> str:
    """A number with as few characters as it needs."""
    return re.sub(r"e([+-])0*", lambda sign: "e" + sign[1].replace("+", ""), f"{number:g}")


def parameters(chosen: Iterable[Parameter]) -> str:
    """A row for each parameter."""
    return table(HEAD, ((f"`{p.name}`", kind(p), default(p), meaning(p)) for p in chosen))


def faults(chosen: Iterable[Parameter]) -> str:
    """A row for each parameter of a fault, of all sensors that have it."""
    alike: dict[str, list[Parameter]] = defaultdict(list)
    for parameter in chosen:
        sensor = next((name for name in FAULTY if parameter.name.startswith(f"{name}_")), "")
        alike[parameter.name.removeprefix(sensor)].append(parameter)
    rows = (
        (
            ", ".join(f"`{p.name}`" for p in several),
            kind(several[0]),
            ", ".join(dict.fromkeys(map(default, several))),
            in_common([meaning(p) for p in several]),
        )
        for several in alike.values()
    )
    return table(HEAD, rows)


def in_common(texts: list[str]) -> str:
    """One sentence for several that differ in the sensor at their beginning, or in units."""
    if len(texts) > 1:
        texts = [re.sub(r"^[A-Z][\w ]*?[:,] ", "", text) for text in texts]
    words = zip(*(re.findall(r"[;,]|\s+|[^\s;,]+", text) for text in texts), strict=True)
    said = "".join(", ".join(dict.fromkeys(several)) for several in words)
    return said[0].upper() + said[1:]


def parser_of(verb: str) -> Parser:
    """What reads the command line of a verb: it is asked for its help. That of ``sim`` is there without ROS as well."""
    found: list[Parser] = []
    with patch.object(Parser, "print_help", lambda self, file=None: found.append(self)), suppress(SystemExit):
        if verb == "sim":
            parse(["--help"])
        else:
            main([verb, "--help"])
    return found[0]


def arguments(verb: str) -> list[tuple[str, str]]:
    """How each argument of a verb is written, and what it means."""
    return [(form(action), sentence(action)) for action in parser_of(verb)._actions if action.dest != "help"]


def in_several() -> dict[tuple[str, str], list[str]]:
    """The arguments that several verbs have in the same words, and these verbs."""
    found: dict[tuple[str, str], list[str]] = defaultdict(list)
    for verb in VERBS:
        for argument in arguments(verb):
            found[argument].append(verb)
    return {argument: verbs for argument, verbs in found.items() if len(verbs) > 1}


def common_options() -> str:
    """A row for each argument that several verbs have."""
    return table(("argument", "meaning"), in_several())


def options(verb: str) -> str:
    """The heading of a verb, and its arguments: those that other verbs have as well by their names alone."""
    shared = in_several()
    own = [argument for argument in arguments(verb) if argument not in shared]
    also = [name for name, said in arguments(verb) if (name, said) in shared]
    parts = [
        f"## {verb}",
        parser_of(verb).description or "",
        *([table(("argument", "meaning"), own)[:-1]] if own else []),
    ]
    return "\n\n".join([*parts, *([f"In common with others: {', '.join(also)}."] if also else [])]) + "\n"


def form(action: argparse.Action) -> str:
    """How an argument is written."""
    value = action.metavar or ("|".join(map(str, action.choices)) if action.choices else action.dest.upper())
    if not action.option_strings:
        return f"`{value}`{' …' if action.nargs in ('+', '*') else ''}"
    names = ", ".join(f"`{name}{f' {value}' if action.nargs != 0 else ''}`" for name in action.option_strings)
    return names + (" (needed)" if action.required else "")


def sentence(action: argparse.Action) -> str:
    """What an argument means, with its default."""
    return (action.help or "") % {"default": action.default}


def _of_sensors(*names: str) -> list[Parameter]:
    """Parameters of some sensors, without those of their faults."""
    return [parameter for name in names for parameter in SENSORS[name].parameters]


def _shared() -> list[Parameter]:
    """Parameters of several sensors, without those of faults."""
    alone = {parameter.name for sensor in SENSORS.values() for parameter in sensor.all_parameters}
    return [p for p in SENSORS.parameters.values() if p.name not in alone and p not in WINDOW_PARAMETERS]


def _of_faults() -> list[Parameter]:
    others = [*_shared(), *_of_sensors(*SENSORS)]
    return [parameter for parameter in SENSORS.parameters.values() if parameter not in others]


TABLES: Final[dict[str, Callable[[], str]]] = {
    "parameters": lambda: parameters(OWN),
    "imu": lambda: parameters([*_shared(), *_of_sensors("imu", "magnetometer")]),
    "sensors": lambda: parameters(_of_sensors("attitude_sensor", "sun_sensor")),
    "faults": lambda: faults(_of_faults()),
    "options": lambda: "\n".join(map(options, VERBS)),
    "common-options": common_options,
}
"""What makes each table."""


def pages() -> dict[Path, str]:
    """Each page that has such a table, with its tables as they should be."""
    found = {}
    for page in sorted(DOCS.rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        if not TABLES.keys().isdisjoint(name for name, _ in MARKED.findall(text)):
            found[page] = MARKED.sub(_filled, text)
    return found


def _filled(found: re.Match[str]) -> str:
    return f"{found[1]}{found[2]}\n{TABLES[found[1]]()}\n" if found[1] in TABLES else found[0]


if __name__ == "__main__":
    for page, text in pages().items():
        page.write_text(text, encoding="utf-8")
        print(page.name)
