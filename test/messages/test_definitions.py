"""Message definitions are those of ROS 2: of its release, as rosbags has it, and as installed."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import pytest
from rosbags.typesys import Stores, get_typestore

from lie_rigid_body.messages import definitions
from lie_rigid_body.messages.definitions import definition

STORE = get_typestore(Stores.ROS2_JAZZY)
WRITTEN = sorted(f"{package}/msg/{name}" for package, name in (each.split("/") for each in definitions._FIELDS))
PRIMITIVES = {"float64": "double", "int32": "int32", "uint32": "uint32", "string": "string"}


def fields(text: str, message_type: str) -> dict[str, dict[str, str]]:
    """Types of the fields of a definition and of its parts, by the name of the type, as rclpy spells them."""
    own, *parts = text.replace("/msg/", "/").split("=" * 80 + "\n")
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
    ours = fields(definition(message_type), message_type)
    assert fields(text, message_type) == ours
    for name in ours:
        package, _, base = name.partition("/")
        assert f"{package}/msg/{base}" in STORE.types


@pytest.mark.ros
@pytest.mark.parametrize("message_type", WRITTEN)
def test_fields_are_those_of_the_installed_messages(message_type: str) -> None:
    for name, expected in fields(definition(message_type), message_type).items():
        package, _, base = name.partition("/")
        assert find_spec(package), package
        kind: Any = getattr(import_module(f"{package}.msg"), base)
        assert kind.get_fields_and_field_types() == expected
