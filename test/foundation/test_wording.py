"""Values are shown in few words, whatever was given, and no sentence of the package is cut."""

from __future__ import annotations

import re
from array import array

import numpy as np
import pytest

from lie_rigid_body import RigidBody, Scenario, State
from lie_rigid_body.foundation.errors import BagError, InputError, LieRigidBodyError, ParameterError, describe
from lie_rigid_body.foundation.parameters import Parameter
from lie_rigid_body.foundation.wording import MAX_LINE, MAX_VALUE, listed, shortened, shown, suggestion
from lie_rigid_body.scenario.parameter_table import PARAMETERS, read_parameters

HUGE = [
    "x" * 100_000,
    "word " * 20_000,
    "line\n" * 100,
    10**6000,
    -(10**6000),
    [0.1 + k for k in range(10_001)],
    [[["deep"] * 1000] * 1000] * 1000,
    {str(k): k for k in range(1000)},
    np.zeros((1000, 3, 3)),
    np.array([["text"] * 100] * 2),
    np.zeros((3, 0)),
    b"\0" * 1000,
    np.array([1] * 10, object),
    np.array([10**6000] * 10, object),
]


@pytest.mark.parametrize("value", HUGE, ids=lambda value: type(value).__name__)
def test_a_value_is_shown_in_one_short_line(value: object) -> None:
    assert len(shown(value)) <= MAX_VALUE
    assert len(shown(value).splitlines()) == 1


def test_a_value_that_would_control_a_terminal_is_shown_with_escapes() -> None:
    class Hostile:
        def __repr__(self) -> str:
            return "\x1b[2J\n\u202e"

    assert shown(Hostile()) == r"\x1b[2J \u202e"


def test_a_short_value_is_shown_as_it_is() -> None:
    for value in (0.1, -3, "base_link", [1.0, 2.0, 3.0], True, None, (1, 2)):
        assert shown(value) == repr(value)
    assert shown(array("d", [1.0, 2.0])) == "[1.0, 2.0]"


def test_a_cut_is_between_two_words() -> None:
    numbers = str([1.0 / (7 * k + 1) for k in range(100)])
    for most in range(30, 100):
        words = shortened(numbers, most).split(" ")
        assert words.pop() == "..."
        assert words == numbers.split(" ")[: len(words)]
    assert shortened("7" * 500, 60) == f"{'7' * 57}..."


def refusal(parameter: Parameter, value: object) -> str:
    """What a value is refused with."""
    with pytest.raises(ParameterError) as caught:
        parameter.read(value)
    return str(caught.value)


@pytest.mark.parametrize("value", HUGE, ids=lambda value: type(value).__name__)
def test_a_huge_value_of_a_parameter_gives_a_short_line(value) -> None:
    for parameter in PARAMETERS:
        if parameter.kind == "string" and isinstance(value, str) and not parameter.choices:
            continue
        message = refusal(parameter, value)
        assert message.startswith(f"{parameter.name}: ")
        assert re.search(": (give|choose) ", message)
        assert len(message) <= MAX_LINE
        assert len(message.splitlines()) == 1


def test_a_number_out_of_range_is_refused_with_a_remedy() -> None:
    for parameter in PARAMETERS:
        if parameter.kind in ("double", "int"):
            value = -1 if parameter.minimum >= 0 else 2 * parameter.minimum
            said = re.escape(f"{parameter.name}: {value:g} is outside [")
            assert re.match(rf"{said}.*\]: give for example ", refusal(parameter, value))


@pytest.mark.parametrize("name", ["gyro_noise_densty", "nothing_like_it", "x" * 100_000, "rat e"])
def test_an_unknown_parameter_is_refused_with_those_like_it(name: str) -> None:
    said = r"no such parameter: (did you mean|the parameters are inertia, )"
    with pytest.raises(ParameterError, match=said) as caught:
        read_parameters({name: 1.0})
    assert len(str(caught.value)) <= MAX_LINE


@pytest.mark.parametrize("kind", [LieRigidBodyError, InputError, BagError])
def test_an_error_of_the_package_is_one_line_with_all_of_its_words(kind: type[LieRigidBodyError]) -> None:
    sentence = "word " * 1000 + "and so: do that"
    assert str(kind(f"first\n\x1b{sentence}")) == f"first \\x1b{sentence}"


def test_an_exception_of_others_is_described_by_its_class_and_the_beginning_of_its_message() -> None:
    class WordlessError(Exception):
        def __str__(self) -> str:
            raise ValueError

    assert describe(InputError("of the package")) == "of the package"
    assert describe(ValueError("half a character: \ud800")) == "ValueError: half a character: \\ud800"
    assert describe(WordlessError()) == describe(type("WordlessError", (Exception,), {})()) == "WordlessError"
    assert len(describe(KeyError("x " * 10_000))) < 120


@pytest.mark.parametrize(
    "make", [RigidBody, lambda given: State(given, [0, 0, 1]), lambda given: State([0, 0, 0, 1], given)]
)
def test_arrays_that_are_none_are_refused_in_a_short_line(make) -> None:
    for given in ("x" * 10_000, [["a"] * 100] * 100, np.full((100, 4), np.nan), np.ones((500, 7, 2))):
        with pytest.raises(ParameterError) as caught:
            make(given)
        assert len(str(caught.value)) <= MAX_LINE


def test_names_are_listed_up_to_a_number() -> None:
    assert listed(["a", "b"]) == "a, b"
    assert listed(range(100)) == "0, 1, 2, 3, 4 and 95 more"
    assert suggestion("rte", ["rate", "motion"], "parameters") == "did you mean rate?"


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("body_frame", {"world_frame": "base_link"}),
        ("imu_frame", {"imu_frame": "world", "imu_rate": 10.0}),
        ("imu_frame", {"imu_frame": "world", "magnetometer_rate": 10.0}),
    ],
)
def test_a_frame_of_the_body_is_not_that_of_the_world(name: str, given: dict[str, object]) -> None:
    with pytest.raises(ParameterError, match=rf"^{name}: '\w+' is the world_frame as well: give another name$"):
        Scenario.from_parameters(given)
    Scenario.from_parameters({"imu_frame": "base_link", "imu_rate": 10.0})
