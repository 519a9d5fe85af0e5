"""Command lines: options as rows of tables, what they read, and the decorator that makes a verb of a function."""

from __future__ import annotations

import argparse
import functools
import re
import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn, TypeAlias

from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.wording import listed, shown, suggestion
from lie_rigid_body.system.console import UNUSABLE, Main, complain, program, run, say
from lie_rigid_body.system.portable import MAX_PROCESSES

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

    from lie_rigid_body.scenario import Scenario

_ROS_BEGIN: Final = "--ros-args"
_JSON: Final = "--json"
STDOUT: Final = ""
"""Value of ``--json`` where it is given no file."""
JSON_SUFFIX: Final = ".json"

Argument: TypeAlias = tuple[tuple[str, ...], dict[str, Any]]
"""Row of a parser's table: the names of an argument, and how it is read."""


def argument(*names: str, **how: Any) -> Argument:
    """Row of a parser's table, of what `argparse.ArgumentParser.add_argument` takes."""
    return names, how


class Parser(argparse.ArgumentParser):
    """Parser whose usage errors are one line on stderr, and status 2.

    Parameters
    ----------
    verb : str
    description : str
    *table : Argument
        Rows, in the order of the help.
    either : sequence of Argument, optional
        Rows of which one at most may be given.
    scenario : bool, optional
        Whether ``--scenario``, ``--params-file`` and ``-p`` are read, for `scenario_of`.
    epilog : str, optional
        End of the help.
    """

    def __init__(
        self,
        verb: str,
        description: str,
        *table: Argument,
        either: Sequence[Argument] = (),
        scenario: bool = False,
        epilog: str | None = None,
    ) -> None:
        super().__init__(prog=program(verb), description=description, epilog=epilog, allow_abbrev=False)
        self._negative_number_matcher = re.compile(r"-\.?\d")  # -1deg is a value, and no option
        order = "later wins: defaults < --scenario < --params-file < -p"
        groups: list[tuple[argparse._ActionsContainer, Sequence[Argument]]] = [
            (self, table),
            *([(self.add_mutually_exclusive_group(), either)] if either else []),
            *([(self.add_argument_group("scenario", order), SCENARIO_OPTIONS)] if scenario else []),
        ]
        for group, rows in groups:
            for names, how in rows:
                group.add_argument(*names, **how)

    def parse_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> argparse.Namespace:  # type: ignore[override]
        """Read arguments. A word behind ``--json`` is its file where it ends so: a bag or a filter may stand there."""
        words = list(sys.argv[1:] if args is None else args)
        for place in range(len(words) - 1, -1, -1):
            if words[place] == _JSON and "--" not in words[:place]:
                words[place : place + 2] = _joined(*words[place : place + 2])
        return super().parse_args(words, namespace)  # type: ignore[no-any-return]

    def print_help(self, file: SupportsWrite[str] | None = None) -> None:
        """Print the help on stdout, by `say`."""
        say(self.format_help().rstrip("\n"))

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and end with status 2."""
        complain(self.prog, f"{message}; '{self.prog} --help' explains the arguments")
        raise SystemExit(UNUSABLE)


def _joined(option: str, *following: str) -> list[str]:
    """``--json`` and the word behind it, which is joined to it if it is the name of a JSON file."""
    if following and following[0].lower().endswith(JSON_SUFFIX) and not following[0].startswith("-"):
        return [f"{option}={following[0]}"]
    return [f"{option}={STDOUT}", *following]


def split_ros_arguments(argv: Iterable[str] | None) -> tuple[list[str], list[str]]:
    """Arguments, or those of the process, and those for ROS: ``--ros-args`` and what follows, to ``--`` or the end."""
    own = list[str]()
    ros = list[str]()
    target = own
    for text in sys.argv[1:] if argv is None else argv:
        if text == _ROS_BEGIN:
            target = ros
        elif text == "--" and target is ros:
            target = own
        else:
            target.append(text)
    return own, [_ROS_BEGIN, *ros] if ros else []


def require_suffix(option: str, path: str | None, suffix: str) -> None:
    """Refuse a file to write whose name does not end as its kind.

    Raises
    ------
    InputError
    """
    if path is not None and Path(path).suffix.lower() != suffix:
        raise InputError(f"{option} {path}: only {suffix[1:].upper()} is written: let the name end in {suffix}")


def file_name(text: str) -> str:
    """The name of a file or folder of a command line, for `argparse`.

    Raises
    ------
    argparse.ArgumentTypeError
        If no file can have it, or if it is empty, the folder one is in to the system, or ``-``, a file to the system.
    """
    if not text:
        raise argparse.ArgumentTypeError("'' names no file or folder: give a name")
    if text == "-":
        raise argparse.ArgumentTypeError("'-' stands for no stream here: give a name, ./- for a file called so")
    if "\0" in text:
        raise argparse.ArgumentTypeError(f"{shown(text)} is the name of no file, with its NUL: give a name without")
    return text


def processes(text: str) -> int:
    """The number of processes of a command line, for `argparse`.

    Raises
    ------
    argparse.ArgumentTypeError
        If it is none from 1 to `MAX_PROCESSES`.
    """
    if not (text.isascii() and text.isdigit() and len(text) <= 4 and 1 <= int(text) <= MAX_PROCESSES):
        raise argparse.ArgumentTypeError(f"{shown(text)} is not a number of processes from 1 to {MAX_PROCESSES}")
    return int(text)


def scenario_of(arguments: argparse.Namespace) -> Scenario:
    """The scenario that the arguments of `SCENARIO_OPTIONS` give.

    Raises
    ------
    InputError
        Naming the file that gave a wrong parameter.
    """
    from lie_rigid_body.scenario import Scenario
    from lie_rigid_body.scenario.parameter_file import file_that_gives, merge, sources

    given = sources(arguments.scenario, arguments.params_file, arguments.assignments)
    parameters = merge(given)
    try:
        if parameters.get("motion") == "path":
            from lie_rigid_body.recording.poses import with_path  # only now: it needs what reads bags

            parameters = with_path(parameters)
        return Scenario.from_parameters(parameters)
    except ParameterError as error:
        path = file_that_gives(error.name, given)
        raise error if path is None else InputError(f"{path}: {error}") from None


SCENARIO_OPTIONS: Final = (
    argument("--scenario", metavar="NAME", help="a scenario of the package; 'scenarios' lists them"),
    argument(
        "--params-file",
        metavar="FILE",
        type=file_name,
        action="append",
        default=[],
        help="a ROS 2 parameter file; may be repeated",
    ),
    argument(
        "-p",
        metavar="NAME:=VALUE",
        action="append",
        default=[],
        dest="assignments",
        help="one parameter; may be repeated",
    ),
)
"""Options that `scenario_of` reads."""

FORCE: Final = argument("--force", action="store_true", help="replace outputs that exist")
"""Option of the verbs that write files."""
WORKERS: Final = argument(
    "--workers", metavar="N", type=processes, help="processes on this machine; one per core if absent"
)
"""Option of the verbs that work in several processes."""
ESTIMATOR: Final = (
    argument(
        "estimator",
        metavar="ESTIMATOR",
        nargs="?",
        help="MODULE:FUNCTION, a function of a run that returns attitudes (N, 4), scalar last",
    ),
    argument(
        "--command",
        metavar="PROGRAM",
        help="in its place: a program that reads readings as CSV and prints attitudes, t_ns,x,y,z,w",
    ),
    argument(
        "--node",
        metavar="COMMAND",
        help="in its place: a ROS 2 node that hears imu/data_raw and imu/mag and publishes attitudes on imu/data; one "
        "process a run, in lock-step",
    ),
)
"""Arguments that give an estimator, which `cli.diagnose.given_estimator` reads."""
LOG_OPTIONS: Final = (
    argument("--imu", metavar="TOPIC", help="of a bag with several: the topic of sensor_msgs/Imu"),
    argument("--magnetometer", metavar="TOPIC", help="of a bag with several: the topic of MagneticField"),
    argument(
        "--columns",
        metavar="FIELD=HEADER,...",
        help="columns of other names, or their numbers from 1, perhaps with a unit: t=stamp:ms,gyro_x=2:deg/s",
    ),
)
"""Options of the verbs that read a log."""
TOPIC_OPTION: Final = argument(
    "--topic",
    metavar="NAME:=/TOPIC",
    action="append",
    default=[],
    help="what a topic of the true motion is called in the bag, such as pose:=/truth/pose; may be repeated",
)
"""Option that `topic_names` reads."""


def json_option(what: str) -> Argument:
    """Option of the verbs that have an answer for programs: `STDOUT`, or a file; None where it is not given."""
    told = f"{what}; with OUT.json write it there, and print the answer for people"
    return argument(_JSON, metavar="OUT.json", nargs="?", type=_json_file, help=told)


def _json_file(text: str) -> str:
    if text != STDOUT and Path(text).suffix.lower() != JSON_SUFFIX:
        raise argparse.ArgumentTypeError(f"{shown(text)}: only JSON is written: let the name end in {JSON_SUFFIX}")
    return text


def columns_of(text: str | None) -> dict[str, str | int]:
    """The columns of ``--columns`` by their fields; a whole number is that of a column.

    Raises
    ------
    InputError
        If a part is no assignment.
    """
    found: dict[str, str | int] = {}
    for part in text.split(",") if text else ():
        field, _, header = part.partition("=")
        if not (field and header):
            raise InputError(f"--columns {shown(part)}: not FIELD=HEADER; give for example --columns gyro_x=wx:deg/s")
        found[field.strip()] = int(header) if header.isascii() and header.isdigit() else header.strip()
    return found


def topic_names(assignments: Sequence[str], known: Collection[str]) -> dict[str, str]:
    """The topics of ``--topic`` by their relative names, each of which is known.

    Raises
    ------
    InputError
        If one is no assignment, names no topic that is known, or one that was named before.
    """
    found: dict[str, str] = {}
    for text in assignments:
        name, _, topic = text.partition(":=")
        if not (name and topic):
            raise InputError(f"--topic {shown(text)}: not NAME:=/TOPIC; give for example --topic pose:=/truth/pose")
        if name not in known:
            raise InputError(f"--topic {text}: no topic {name!r}: {suggestion(name, known, 'topics of a body')}")
        if found.setdefault(name, topic) != topic:
            raise InputError(f"--topic {text}: {name} is {found[name]} already: give {listed([name])} once")
    return found


def verb(description: str, *table: Argument, **more: Any) -> Callable[[Callable[[argparse.Namespace], int]], Main]:
    """Decorator of a verb's work, which is given its arguments; the parameters are those of `Parser`, and see `run`."""

    def decorated(work: Callable[[argparse.Namespace], int]) -> Main:
        @run
        @functools.wraps(work)
        def main(argv: Sequence[str] | None = None) -> int:
            return work(Parser(work.__module__.rpartition(".")[2], description, *table, **more).parse_args(argv))

        return main

    return decorated
