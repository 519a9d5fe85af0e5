"""Message definitions are those of ROS 2: of its release, as rosbags has it, and as installed."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import pytest
from rosbags.typesys import Stores, get_typestore

from lie_rigid_body.messages import definitions
from lie_rigid_body.messages.definitions import definition, has_fields_of, redefined

STORE = get_typestore(Stores.ROS2_JAZZY)
WRITTEN = sorted(definitions._PARTS)
PRIMITIVES = {"float64": "double", "int32": "int32", "uint32": "uint32", "string": "string"}


def fields(message_type: str) -> dict[str, dict[str, str]]:
    """Types of the fields of a definition and of its parts, by the name of the type, as rclpy spells them."""
    own, *parts = definition(message_type).split("=" * 80 + "\n")
    texts = {message_type.replace("/msg/", "/"): own}
    for part in parts:
        head, _, text = part.partition("\n")
        texts[head.removeprefix("MSG: ")] = text
    found = {}
    for name, text in texts.items():
        package = name.partition("/")[0]
        lines = [line.split() for line in text.splitlines()]
        found[name] = {field: spelt(kind, package) for kind, field, *_ in lines}
    return found


def spelt(kind: str, package: str) -> str:
    base, bracket, size = kind.partition("[")
    base = PRIMITIVES.get(base) or (base if "/" in base else f"{package}/{base}")
    return base + bracket + size


@pytest.mark.parametrize("message_type", WRITTEN)
def test_fields_are_those_of_the_release(message_type: str) -> None:
    text, _ = STORE.generate_msgdef(message_type, ros_version=2)
    assert has_fields_of(text, message_type)
    for name in fields(message_type):
        package, _, base = name.partition("/")
        assert f"{package}/msg/{base}" in STORE.types


@pytest.mark.ros
@pytest.mark.parametrize("message_type", WRITTEN)
def test_fields_are_those_of_the_installed_messages(message_type: str) -> None:
    for name, expected in fields(message_type).items():
        package, _, base = name.partition("/")
        assert find_spec(package), package
        kind: Any = getattr(import_module(f"{package}.msg"), base)
        assert kind.get_fields_and_field_types() == expected


PART = f"{'=' * 80}\nMSG: geometry_msgs/Quaternion\n"
ELSEWHERE = "MSG: evil_msgs/Quaternion\nfloat64 w\nfloat64 z\nfloat64 y\nfloat64 x\n"
FORGED = {
    "another package": ("Quaternion orientation", "evil_msgs/Quaternion orientation"),
    "a type of another package": (PART, f"{'=' * 80}\n{ELSEWHERE}{PART}"),
    "a type twice, the false one first": (PART, f"{PART}float64 w\nfloat64 z\nfloat64 y\nfloat64 x\n{PART}"),
    "a type twice, once of nothing": (PART, f"{PART}{PART}"),
    "two fields in turn": ("float64 x 0\nfloat64 y 0\n", "float64 y 0\nfloat64 x 0\n"),
    "a field that some readers take for a comment": ("float64 x 0\n", "#\x85float64 x 0\n"),
    "a field that some readers take for a constant": ("float64 x 0\n", "float64 x 0\nuint8[] a =1\n"),
    "a field that some readers take for one more": ("float64 x 0\n", "float64 x 0\nstring s a=b\n"),
}
"""What is put into the definition of a pose, and in the place of what; each misleads who reads by it."""


@pytest.mark.parametrize("how", FORGED)
def test_other_fields_are_not_those_of_the_type(how: str) -> None:
    honest, forged = FORGED[how]
    text = definition(definitions.POSE_STAMPED)
    assert has_fields_of(text, definitions.POSE_STAMPED)
    assert honest in text
    assert not has_fields_of(text.replace(honest, forged), definitions.POSE_STAMPED)


def test_comments_constants_defaults_and_line_ends_are_of_no_account() -> None:
    text = definition(definitions.POSE_STAMPED).replace(" 0\n", "  # and more\n").replace("\n", "\r\n")
    assert has_fields_of(f"uint8 A=1\nuint8 B = 2\n\n{text}", definitions.POSE_STAMPED)


PRIVATE = ("a type of another package", "a field that some readers take for a comment", "a type twice, once of nothing")
"""What misleads those alone who read that topic."""
FOREIGN = "geometry_msgs/Quaternion q\n"
"""Definition of a message of others that has an attitude."""


@pytest.mark.parametrize("how", FORGED)
def test_a_message_of_others_may_not_give_other_fields_to_a_type_of_ours(how: str) -> None:
    honest, forged = FORGED[how]
    text = definition(definitions.POSE_STAMPED)
    _, *parts = text.partition(PART)
    foreign = FOREIGN + "".join(parts)
    assert redefined(foreign, "others_msgs/msg/Other") == []
    if honest in foreign and how not in PRIVATE:
        assert "geometry_msgs/Quaternion" in redefined(foreign.replace(honest, forged), "others_msgs/msg/Other")
    assert redefined(text.replace("Point position", "Point other"), "geometry_msgs/msg/PoseStamped") == [
        "geometry_msgs/Pose"
    ]
    assert redefined("float64 w\n", "geometry_msgs/msg/Quaternion") == ["geometry_msgs/Quaternion"]


@pytest.mark.parametrize(
    "name",
    [
        "geometry_msgs//Quaternion",
        "geometry_msgs/Quaternion/",
        "geometry_msgs/msg//Quaternion",
        "geometry_msgs/./Quaternion",
    ],
)
def test_a_type_of_ours_is_known_by_any_name_that_a_reader_takes_for_it(name: str) -> None:
    """rosbags reads names as paths."""
    assert redefined(f"string s\n{'=' * 80}\nMSG: {name}\nfloat64 w\n", "others_msgs/msg/Other") == [
        "geometry_msgs/Quaternion"
    ]
    assert redefined("float64 w\n", name) == ["geometry_msgs/Quaternion"]


def test_a_type_without_a_name_is_none_of_ours() -> None:
    assert redefined(definition(definitions.POSE_STAMPED), "") == []
    assert redefined("Quaternion q\n", "") == []


@pytest.mark.parametrize(
    "comment", ["MSG: geometry_msgs/Quaternion", "a\u2028b", "a\x85b", "a\rb", "a\x0bb", "MSG: nothing/Other"]
)
def test_a_comment_in_a_message_of_others_is_of_no_account(comment: str) -> None:
    _, *parts = definition(definitions.POSE_STAMPED).partition(PART)
    foreign = f"{FOREIGN}string text # {comment}\n{''.join(parts)}"
    assert redefined(foreign, "others_msgs/msg/Other") == []
    assert (
        redefined(f"{foreign}{PART}float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n", "others_msgs/msg/Other") == []
    )
