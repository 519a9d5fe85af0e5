"""Parameters as ROS 2 users give them: parameter files, those of the named scenarios among them, and assignments.

Scalars are read as rcl reads them, which is not how YAML 1.1 does: ``1e-3`` is a number, ``010`` is eight, ``null`` is
a word. So a file means the same to the node and to the headless verbs.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeAlias

import yaml

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.parameters import Given
from lie_rigid_body.foundation.wording import program, shown, suggestion
from lie_rigid_body.system.bounded_input import BoundedLoader, load_yaml, read_text

CONFIG: Final = Path(__file__).parent.parent / "config"
"""The folder of the named scenarios."""

NODE_NAME: Final = "lie_rigid_body"
PARAMETERS_KEY: Final = "ros__parameters"

MAX_FILE_BYTES: Final = 128 * 1024
"""Largest size of a parameter file, bytes: YAML takes 10 µs a byte."""

FilePath: TypeAlias = str | Path
Source: TypeAlias = tuple[FilePath | None, Given]
"""A parameter file, or None for the command line, and the parameters that it gives."""

_NODE_ONLY: Final = re.compile(r"use_sim_time|start_type_description_service|qos_overrides\..*")
"""Parameters that every ROS 2 node has and no scenario."""

_TEXT: Final = "tag:yaml.org,2002:str"
_TRUE: Final = frozenset({"Y", "y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"})
_FALSE: Final = frozenset({"N", "n", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"})
_INTEGER: Final = re.compile(r"([-+]?)(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)")
_MAX_DIGITS: Final = 24
"""Largest number of characters of an integer that is tried with 64 bits; octal ones are the longest."""
_FLOAT: Final = re.compile(
    r"[-+]?((\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?|\.?inf|infinity|\.?nan)", re.IGNORECASE | re.ASCII
)


def read_parameter_file(path: FilePath, node_name: str = NODE_NAME, namespace: str = "/") -> Given:
    """The parameters that a ROS 2 parameter file gives a node.

    Parameters
    ----------
    path : str or Path
    node_name : str, optional
    namespace : str, optional
        Of the node.

    Returns
    -------
    dict of str to object
        By dotted name. Where several sections mean the node, the later one wins, as in rclpy: not the more exact one.

    Raises
    ------
    InputError
        If the file cannot be read, is not such a file, or means other nodes only.
    """
    sections = read_sections(path)
    full_name = f"{namespace.rstrip('/')}/{node_name}"
    meant = [values for name, values in sections if _means(name, full_name)]
    if not meant:
        names = ", ".join(name for name, _ in sections)
        raise InputError(f"{path} has no section for the node {full_name}, only for {names}: name one /**")
    return dict(item for values in meant for item in _flatten(values))


def read_sections(path: FilePath, *, pipes: bool = True) -> list[tuple[str, Given]]:
    """The sections of a ROS 2 parameter file, whichever nodes they mean.

    Parameters
    ----------
    path : str or Path
    pipes : bool, optional
        Whether a pipe will do, which can be read once.

    Returns
    -------
    list of (str, mapping of str to object)
        Node names or patterns, and what the file gives these nodes.

    Raises
    ------
    InputError
        If the file cannot be read, or is not such a file.
    """
    content = read_yaml(path, pipes=pipes)
    if not isinstance(content, dict):
        raise InputError(f"{path} is not a parameter file: begin it with '/**:' and '{PARAMETERS_KEY}:' below that")
    sections = list(_sections(content, "", str(path)))
    if not sections:
        raise InputError(f"{path} has no '{PARAMETERS_KEY}:': put it below '/**:', and 'name: value' lines below it")
    return sections


def read_yaml(path: FilePath, *, pipes: bool = True) -> Any:
    """The content of a YAML file whose plain scalars are read as rcl reads them.

    Raises
    ------
    InputError
        If the file cannot be read, is not YAML, or gives a key twice.
    """
    return load_yaml(read_text(path, MAX_FILE_BYTES, pipes=pipes), str(path), _Loader)


def assignments(parameters: Given) -> list[str]:
    """Words of a command line that give parameters: ``-p`` and an assignment each, which `parse_assignment` reads."""
    words = []
    for name, value in parameters.items():
        text = value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))
        words += ["-p", f"{name}:={text}"]
    return words


def recording(bag: str, duration_s: float, parameters: Given, scenario: str | None = None) -> str:
    """The command, for a shell, that records a run of a scenario with parameters over its own."""
    named = ["--scenario", scenario] if scenario else []
    return shlex.join(
        [*program("record").split(), bag, "--duration", f"{duration_s:g}", *named, *assignments(parameters)]
    )


def parse_assignment(text: str, option: str = "-p") -> tuple[str, object]:
    """The name and the value of a ``name:=value`` assignment.

    Parameters
    ----------
    text : str
    option : str, optional
        What it was given to, for the error.

    Returns
    -------
    tuple of str and object

    Raises
    ------
    InputError
        If there is no ``:=``, no name or no value.
    """
    name, sign, value = text.partition(":=")
    name = name.strip()
    if not (sign and name and value.strip()):
        raise InputError(f"{option} {shown(text)} is not NAME:=VALUE: give for example {option} rate:=200.0")
    return name, load_yaml(value, f"{option} {shown(text)}", _Loader)


def gather(
    scenario: str | None,
    files: Sequence[FilePath],
    assignments: Sequence[str],
    node_name: str = NODE_NAME,
    namespace: str = "/",
) -> dict[str, object]:
    """All parameters given, later ones over earlier ones: scenario, files in order, assignments in order.

    Parameters
    ----------
    scenario : str or None
        Name of a file of ``config/``.
    files : sequence of paths
    assignments : sequence of str
    node_name, namespace : str, optional
        Of the node that the files are read for.

    Returns
    -------
    dict of str to object

    Raises
    ------
    InputError
    """
    return merge(sources(scenario, files, assignments, node_name, namespace))


def files_read(scenario: str | None, files: Sequence[FilePath]) -> list[FilePath]:
    """The files that `gather` reads."""
    return [*([scenario_file(scenario)] if scenario is not None else []), *files]


def sources(
    scenario: str | None,
    files: Sequence[FilePath],
    assignments: Sequence[str],
    node_name: str = NODE_NAME,
    namespace: str = "/",
) -> list[Source]:
    """The sources that `gather` merges, each read once: a pipe can be read no second time."""
    given = [(path, read_parameter_file(path, node_name, namespace)) for path in files_read(scenario, files)]
    # one for ROS may name the node: NODE:NAME:=VALUE
    assigned = {name.removeprefix(f"{node_name}:"): value for name, value in map(parse_assignment, assignments)}
    if of_nodes := [name for name in assigned if _NODE_ONLY.fullmatch(name)]:
        raise InputError(f"-p {of_nodes[0]}: every ROS 2 node has it, and no scenario: give it to sim after --ros-args")
    return [*given, (None, assigned)]


def merge(given: Sequence[Source]) -> dict[str, object]:
    """The parameters of all sources, later ones over earlier ones, without those of files that no scenario has."""
    merged = {name: value for _, values in given for name, value in values.items()}
    return {name: value for name, value in merged.items() if not _NODE_ONLY.fullmatch(name)}


def file_that_gives(name: str, given: Sequence[Source]) -> FilePath | None:
    """The file whose value of a parameter wins in `merge`, or None if it came from elsewhere."""
    return next((path for path, values in reversed(given) if name in values), None)


def scenario_files() -> dict[str, Path]:
    """The parameter files of the named scenarios.

    Returns
    -------
    dict of str to Path
        By name, as given to ``--scenario``; in the order of the names.

    Raises
    ------
    InputError
        If the package is imported from a zip file, whose files have no path.
    """
    if not CONFIG.is_dir():
        raise InputError(f"{CONFIG} is no folder: unpack the package, as pip does, or give a parameter file")
    return {file.stem: file for file in sorted(CONFIG.glob("*.yaml"))}


def scenario_file(name: str) -> Path:
    """The parameter file of a named scenario.

    Raises
    ------
    InputError
        If there is none of that name; the message lists them.
    """
    files = scenario_files()
    if name not in files:
        hint = suggestion(name, files, "scenarios")
        raise InputError(f"scenario {shown(name)} is unknown: {hint}; 'scenarios' lists all")
    return files[name]


class _Loader(BoundedLoader):
    """A YAML loader that reads plain scalars as rcl does."""

    def compose_scalar_node(self, anchor: Any) -> yaml.ScalarNode:
        """Read a scalar that is said to be a text, ``!!str 5``, as if it were quoted."""
        is_text = self.peek_event().tag == _TEXT  # type: ignore[no-untyped-call]
        node = super().compose_scalar_node(anchor)
        node.style = '"' if is_text else node.style
        return node


def _plain(text: str) -> object:
    """The value of an unquoted scalar: bool, int or float, or else the text itself."""
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    if integer := _INTEGER.fullmatch(text):
        return _integer(*integer.groups())
    if _FLOAT.fullmatch(text):
        return float(re.sub(r"\.(?=[inIN])", "", text))
    return text


def _integer(sign: str, digits: str) -> int | float:
    """An integer if it has 64 bits, and a double beyond."""
    is_hexadecimal = digits[:2] in ("0x", "0X")
    if len(digits) <= _MAX_DIGITS:
        value = int(sign + digits, 16 if is_hexadecimal else 8 if digits[0] == "0" else 10)
        if -(2**63) <= value < 2**63:
            return value
    return float.fromhex(sign + digits) if is_hexadecimal else float(sign + digits)


def _construct_scalar(loader: _Loader, node: yaml.ScalarNode) -> object:
    text = loader.construct_scalar(node)
    if node.style in ("'", '"'):
        return text
    if text == "":
        raise yaml.MarkedYAMLError(None, None, "a value is missing", node.start_mark)
    return _plain(str(text))


def _construct_mapping(loader: _Loader, node: yaml.MappingNode) -> Given:
    mapping: dict[str, object] = {}
    for key_node, value_node in node.value:
        if not isinstance(key_node, yaml.ScalarNode):
            raise yaml.MarkedYAMLError(None, None, "a key is not a word", key_node.start_mark)
        mapping[str(key_node.value)] = loader.construct_object(value_node, deep=True)
    return mapping


_Loader.yaml_implicit_resolvers = {}


_Loader.add_constructor(_TEXT, _construct_scalar)
_Loader.add_constructor("tag:yaml.org,2002:map", _construct_mapping)
# lists as launch_ros writes them
_Loader.add_constructor("tag:yaml.org,2002:python/tuple", partial(_Loader.construct_sequence, deep=True))


def _sections(content: Given, name: str, source: str) -> Iterator[tuple[str, Given]]:
    """Every ``ros__parameters`` mapping, with the node name or pattern it stands under."""
    for key, value in content.items():
        if key == PARAMETERS_KEY:
            if not name:
                raise InputError(f"{source}: '{PARAMETERS_KEY}:' stands at the top: put it below '/**:'")
            if not isinstance(value, Mapping):
                raise InputError(f"{source}: '{PARAMETERS_KEY}:' of {name} holds {value!r}: give 'name: value' lines")
            yield name, value
        elif isinstance(value, Mapping):
            yield from _sections(value, f"{name}/{key.lstrip('/')}", source)
        else:
            raise InputError(f"{source}: {key!r} stands outside of '{PARAMETERS_KEY}:': put it below that")


def _means(pattern: str, full_name: str) -> bool:
    """Whether a section's name means the node: ``*`` is one name, ``**`` any number of them."""
    parts = (re.escape(part) for part in pattern.strip("/").split("/"))
    expression = "".join({r"\*\*": r"(/\w+)*", r"\*": r"/\w+"}.get(part, f"/{part}") for part in parts)
    return re.fullmatch(expression, full_name) is not None


def _flatten(values: Given, prefix: str = "") -> Iterator[tuple[str, object]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value
