"""The command lines with ``ros2`` that users are shown are those of one list, and mean what the package has."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable

import pytest

from lie_rigid_body.__main__ import VERBS
from lie_rigid_body.report import score_options
from lie_rigid_body.ros import launching
from lie_rigid_body.ros.sim import given_to_ros, parse
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather
from reader import FENCED, ROOT, blocks, commands
from tables import parser_of

LIST = ROOT / "test" / "data" / "ros2_commands.txt"
COMMANDS = [line for line in LIST.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
PARSERS: dict[str, Callable[[list[str]], object]] = {
    "check": parser_of("check").parse_args,
    "record": parser_of("record").parse_args,
    "evaluate": score_options.parse,
}


def shown(text: str) -> set[str]:
    """The commands in blocks and in code within a line, without what follows an argument of the user's own."""
    spans = re.findall(r"`(ros2 [^`]+)`", FENCED.sub("", text))
    return {own for text in (*commands(*blocks(text, "bash", "console")), *spans) for own in parts(text)}


def parts(text: str) -> list[str]:
    """The commands of a line: substituted ones by themselves, and that around them up to the first of these."""
    inner = re.findall(r"\$\((ros2 [^)]+)\)", text)
    outer = re.findall(r"^(ros2 .+)", re.split(r"\$\(|…|  #", text)[0])
    return [command.strip() for command in (*inner, *outer)]


def start(command: str) -> str:
    return " ".join(command.split()[:3])


def test_the_list_is_sorted() -> None:
    assert sorted(set(COMMANDS)) == COMMANDS


def test_what_the_pages_show_is_the_list() -> None:
    found = set().union(*(shown(page.read_text(encoding="utf-8")) for page in PAGES))
    assert found - set(COMMANDS) == set(), f"try them on a real ROS 2, then add them to {LIST.name}"
    assert set(COMMANDS) - found == set()


def test_what_the_package_prints_is_in_the_list() -> None:
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "lie_rigid_body").rglob("*.py"))
    found = set(re.findall(r"\bros2 [a-z]+ [a-z_]+", sources))
    own = {"ros2 run my_package"}  # stands for a package of the user's
    assert found - own - {start(command) for command in COMMANDS} == set()


def test_no_option_of_quality_hides_what_is_latched() -> None:
    assert [command for command in COMMANDS if "topic echo" in command and "--qos" in command] == []


@pytest.mark.parametrize("command", [command for command in COMMANDS if start(command) == "ros2 run lie_rigid_body"])
def test_executables_understand_their_arguments(command: str) -> None:
    verb, *words = shlex.split(command)[3:]
    assert f'f"{verb} = ' in (ROOT / "setup.py").read_text(encoding="utf-8")
    assert verb in VERBS
    if verb == "sim":
        given = parse(words)
        of_ros = given_to_ros(given.ros, "-p", "--param")
        own = [text for text in of_ros if not text.startswith("qos_overrides.")]  # which every node has
        Scenario.from_parameters(gather(given.scenario, given.params_file, [*given.assignments, *own]))
    elif words:
        PARSERS[verb](words)


@pytest.mark.parametrize("command", [command for command in COMMANDS if command.startswith("ros2 launch")])
def test_launch_files_have_their_arguments(command: str) -> None:
    package, file, *words = shlex.split(command)[2:]
    assert package == "lie_rigid_body"
    text = (ROOT / "launch" / file).read_text(encoding="utf-8")
    names = {word.partition(":=")[0] for word in words}
    assert {name for name in names - set(launching.descriptions()) if f'"{name}"' not in text} == set()


def test_topics_and_services_are_those_of_the_node() -> None:
    page = (ROOT / "docs" / "ros.md").read_text(encoding="utf-8")
    for command in COMMANDS:
        if command.startswith(("ros2 topic", "ros2 service")):
            [name] = re.findall(r"(?<= )/[\w/]+", command)
            own = name.replace("/lie_rigid_body/", "~/").lstrip("/")
            assert f"| `{own}`" in page or f", `{own}`" in page, command
