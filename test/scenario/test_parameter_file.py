"""Parameter files and assignments mean to us what they mean to a ROS 2 node."""

from __future__ import annotations

import math
import os
from array import array
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import (
    assignments,
    gather,
    parse_assignment,
    read_parameter_file,
    scenario_files,
)

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(text: str, name: str = "params.yaml") -> Path:
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    return write


SCALARS = [
    ("1e-3", 1e-3),
    ("1E+3", 1e3),
    (".5", 0.5),
    ("1.", 1.0),
    ("-.5e-3", -0.5e-3),
    ("+2.5", 2.5),
    ("08", 8.0),
    (".inf", math.inf),
    ("-.INF", -math.inf),
    ("inf", math.inf),
    ("0", 0),
    ("-7", -7),
    ("+7", 7),
    ("010", 8),
    ("0x1F", 31),
    ("-0x1f", -31),
    ("9223372036854775807", 2**63 - 1),
    ("9223372036854775808", 2.0**63),
    ("-9223372036854775809", -(2.0**63)),
    ("0x10000000000000000", 2.0**64),
    ("true", True),
    ("Yes", True),
    ("on", True),
    ("False", False),
    ("n", False),
    ("OFF", False),
    ("null", "null"),
    ("~", "~"),
    ("1:30", "1:30"),
    ("1_000", "1_000"),
    ("2024-01-01", "2024-01-01"),
    ("0b11", "0b11"),
    ("word", "word"),
    ("'1.0'", "1.0"),
    ('"true"', "true"),
    ("''", ""),
    ("!!str 5", "5"),
    ("!!float 100", 100.0),
    ("!!int 7", 7),
    ("!!bool yes", True),
    ("[1.0, -2e0, .5]", [1.0, -2.0, 0.5]),
    ("!!python/tuple [1.0, 2.5]", [1.0, 2.5]),  # as launch_ros writes lists
    ("[]", []),
]


@pytest.mark.parametrize(("text", "value"), SCALARS)
def test_values_are_read_as_rcl_reads_them(text: str, value: object) -> None:
    name, read = parse_assignment(f"a:={text}")
    assert (name, read, type(read)) == ("a", value, type(value))


def test_nan_is_a_number() -> None:
    for text in ("nan", ".nan", ".NaN"):
        read = parse_assignment(f"a:={text}")[1]
        assert isinstance(read, float)
        assert math.isnan(read)


def seen_by_rclpy(path: Path, name: str, namespace: str) -> dict[str, object]:
    """The parameters that a real node takes from a file, without those that every node has."""
    import rclpy
    from rclpy.context import Context
    from rclpy.node import Node

    context = Context()
    rclpy.init(args=["--ros-args", "--params-file", str(path)], context=context)
    try:
        node = Node(name, namespace=namespace, context=context, automatically_declare_parameters_from_overrides=True)
        names = set(node.get_parameters_by_prefix("")) - {"use_sim_time", "start_type_description_service"}
        values = {name: node.get_parameter(name).value for name in names}
        node.destroy_node()
    finally:
        context.try_shutdown()
    return {n: list(value) if isinstance(value, array) else value for n, value in values.items()}


@pytest.mark.ros
def test_values_are_those_that_rclpy_sees(write: Write) -> None:
    scalars = [text for text, value in SCALARS if value != []]  # an empty list has no type there
    path = write("/**:\n  ros__parameters:\n" + "".join(f"    p{i}: {text}\n" for i, text in enumerate(scalars)))
    assert seen_by_rclpy(path, "lie_rigid_body", "/") == read_parameter_file(path)


LAYERS = """
/**/lie_rigid_body: {ros__parameters: {d: deep, c: deep}}
lie_rigid_body: {ros__parameters: {a: exact}}
/**: {ros__parameters: {a: any, b: any, c: any, e: any}}
/*: {ros__parameters: {a: one, b: one}}
sat1:
  lie_rigid_body: {ros__parameters: {a: nested}}
  other: {ros__parameters: {a: nobody}}
/sat2/lie_rigid_body: {ros__parameters: {a: absolute}}
"""


IN_SAT = {"b": "any", "c": "any", "d": "deep", "e": "any"}
MEANT = {
    ("/", "lie_rigid_body"): {"a": "one", "b": "one", "c": "any", "d": "deep", "e": "any"},
    ("/sat1", "lie_rigid_body"): {"a": "nested", **IN_SAT},
    ("/sat2", "lie_rigid_body"): {"a": "absolute", **IN_SAT},
    ("/", "else"): {"a": "one", "b": "one", "c": "any", "e": "any"},
}


@pytest.mark.parametrize(("namespace", "name"), MEANT)
def test_the_last_section_that_means_the_node_wins(write: Write, namespace: str, name: str) -> None:
    assert read_parameter_file(write(LAYERS), name, namespace) == MEANT[namespace, name]


@pytest.mark.ros
@pytest.mark.parametrize(("namespace", "name"), MEANT)
def test_sections_mean_what_they_mean_to_rclpy(write: Write, namespace: str, name: str) -> None:
    assert seen_by_rclpy(write(LAYERS), name, namespace) == MEANT[namespace, name]


def test_groups_become_dotted_names(write: Write) -> None:
    path = write("/**:\n  ros__parameters:\n    a:\n      b: 1\n      c: {d: 2}\n")
    assert read_parameter_file(path) == {"a.b": 1, "a.c.d": 2}


def test_later_ones_win(write: Write) -> None:
    first = write("/**: {ros__parameters: {rate: 1.0, motion: closed_form, epoch_ns: 5}}", "1.yaml")
    second = write("/**: {ros__parameters: {rate: 2.0, epoch_ns: 6}}", "2.yaml")
    given = gather("asymmetric_top", [first, second], ["rate:=3.0", "rate:=4.0"])
    assert given["inertia"] == [0.6, 0.8, 1.0]
    assert (given["rate"], given["epoch_ns"], given["motion"]) == (4.0, 6, "closed_form")
    assert gather(None, [], []) == {}


def test_an_assignment_may_name_the_node_as_for_ros() -> None:
    assert gather(None, [], ["lie_rigid_body:rate:=40.0", "motion:=closed_form"]) == {
        "rate": 40.0,
        "motion": "closed_form",
    }
    with pytest.raises(ParameterError):
        Scenario.from_parameters(gather(None, [], ["other:rate:=40.0"]))


def test_what_every_node_has_is_left_to_nodes(write: Write) -> None:
    path = write("/**: {ros__parameters: {rate: 1.0, use_sim_time: true, qos_overrides: {/pose: {depth: 1}}}}")
    assert gather(None, [path], []) == {"rate": 1.0}


@pytest.mark.parametrize(
    "name", ["use_sim_time", "start_type_description_service", "qos_overrides./pose.publisher.depth"]
)
def test_an_assignment_of_what_every_node_has_is_refused(name: str) -> None:
    with pytest.raises(InputError):
        gather(None, [], [f"{name}:=1"])


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission_is_refused(write: Write) -> None:
    path = write("/**: {ros__parameters: {a: 1}}")
    path.chmod(0)
    with pytest.raises(InputError):
        read_parameter_file(path)


@pytest.mark.parametrize("text", ["", "rate", "rate=3", ":=3", " :=3", "rate:=", "rate:= "])
def test_what_is_no_assignment_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        parse_assignment(text)


@pytest.mark.parametrize("name", scenario_files())
def test_shipped_files_suit_a_node_as_well(name: str) -> None:
    """A node tells double from integer, and a list may not mix them; a comment says what the scenario is."""
    path = scenario_files()[name]
    assert path.read_text().startswith("# ")
    parameters = read_parameter_file(path)
    scenario = Scenario.from_parameters(parameters)
    for key, value in parameters.items():
        declared = scenario.parameters()[key]
        items = value if isinstance(value, list) else [value]
        kinds = {type(item) for item in (declared if isinstance(declared, tuple) else [declared])}
        assert {type(item) for item in items} == kinds
    plain = yaml.safe_load(path.read_text())
    assert list(plain) == ["/**"]


def test_long_numbers_take_little_time() -> None:
    """Were a digit looked at again for each one after it, this would not end."""
    assert parse_assignment(f"rate:={10**5 * '1'}x")[1] == f"{10**5 * '1'}x"
    assert parse_assignment(f"rate:={10**5 * '1'}")[1] == math.inf
    with pytest.raises(InputError):
        parse_assignment(f"rate:=0x{10**5 * 'F'}")


@pytest.mark.parametrize("digits", ["9" * 19, "9" * 30, "-" + "9" * 30])
def test_an_integer_of_any_length_is_refused_by_its_range(digits):
    """One of more than 64 bits is read as a double, as rcl does."""
    with pytest.raises(ParameterError) as refusal:
        Scenario.from_parameters(gather(None, [], [f"epoch_ns:={digits}"]))
    assert refusal.value.name == "epoch_ns"


def test_assignments_are_read_as_the_values_that_they_give() -> None:
    given = {"rate": 1e-05, "inertia": (1.0, 2.0, 3.0), "paused": True, "epoch_ns": 7, "world_frame": "a map"}
    words = assignments(given)
    assert words[::2] == ["-p"] * len(given)
    assert dict(map(parse_assignment, words[1::2])) == {**given, "inertia": [1.0, 2.0, 3.0]}
