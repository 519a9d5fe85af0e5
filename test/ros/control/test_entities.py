"""The body as the one entity of the standard services: filters find it, and what it is is told."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest
from simulator_process import DEADLINE
from standard_simulator import FAILED, NAME, NOT_FOUND, OK, UNSUPPORTED, Simulator, wanted

from sampled import sampled

if find_spec("rclpy"):
    from standard_messages import RESPONSES, entity_filters, entity_state

pytestmark = [pytest.mark.ros, pytest.mark.filterwarnings("error::RuntimeWarning")]


@pytest.mark.parametrize(
    ("pattern", "categories", "code", "found"),
    [
        ("", (), OK, [NAME]),
        ("lie_.*", (), OK, [NAME]),
        ("rigid", (), OK, [NAME]),
        ("^robot", (), OK, []),
        ("", (4,), OK, [NAME]),
        ("", (0, 4), OK, [NAME]),
        ("", (1, 2), OK, []),
        ("^robot", (4,), OK, []),
        ("(", (), FAILED, []),
    ],
)
def test_filters(paused: Simulator, pattern: str, categories: tuple[int, ...], code: int, found: list[str]) -> None:
    answer = paused.ask("get_entities", filters=entity_filters(pattern, categories))
    assert (answer.result.result, answer.entities) == (code, found)
    both = paused.services.get_entities_states(
        SimpleNamespace(filters=entity_filters(pattern, categories)), RESPONSES["get_entities_states"](), entity_state
    )
    assert (both.result.result, both.entities) == (code, found)
    alone = paused.ask("get_entity_state", entity=NAME).state
    assert both.states == [alone for _ in found]


@pytest.mark.parametrize(
    "pattern", sampled(["((((.+)+)+)+)+x", "x" * 1_000_000, "a{99999999999999999999}", "(" * 900], every=4)
)
def test_what_no_regular_expression_may_do_is_answered(paused: Simulator, pattern: str) -> None:
    """It recurses, is endless, overflows or takes years; other requests are answered meanwhile."""
    with ThreadPoolExecutor(1) as other:
        answer = other.submit(paused.ask, "get_entities", filters=entity_filters(pattern))
        assert paused.code("reset_simulation", scope=0) == OK
        found = answer.result(DEADLINE)
    assert (found.result.result, found.entities) == (FAILED, [])


@pytest.mark.parametrize("field", ["tags", "bounds"])
def test_filters_by_tags_and_bounds_are_unsupported(paused: Simulator, field: str) -> None:
    filters = entity_filters()
    if field == "tags":
        filters.tags.tags = ["x"]
    else:
        filters.bounds.points = [object()]
    assert paused.code("get_entities", filters=filters) == UNSUPPORTED


def test_what_the_body_is(paused: Simulator) -> None:
    answer = paused.ask("get_entity_info", entity=NAME)
    assert (answer.result.result, answer.info.category.category, answer.info.tags) == (OK, 4, [])
    moments = np.linalg.eigvalsh([[1.0, 0.1, -0.05], [0.1, 1.4, 0.2], [-0.05, 0.2, 1.9]])
    assert all(f"{moment:g}" in answer.info.description for moment in moments)


@pytest.mark.parametrize("service", ["get_entity_info", "get_entity_state", "set_entity_state"])
def test_other_entities_are_not_found(paused: Simulator, service: str) -> None:
    assert paused.code(service, entity="robot", state=wanted()) == NOT_FOUND
    assert len(paused.sink.segments) == 1
