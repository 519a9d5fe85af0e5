"""The states of a simulation as the standard services have them: playing, paused, stopped, and quitting."""

from __future__ import annotations

import pytest
from standard_simulator import (
    ALREADY_THERE,
    FAILED,
    INCORRECT_TRANSITION,
    NAME,
    OK,
    PAUSED,
    PLAYING,
    QUITTING,
    STOPPED,
    UNSUPPORTED,
    Simulator,
    wanted,
)

pytestmark = [pytest.mark.ros, pytest.mark.filterwarnings("error::RuntimeWarning")]


@pytest.mark.parametrize(
    ("before", "to", "code", "after"),
    [
        (PLAYING, PLAYING, ALREADY_THERE, PLAYING),
        (PLAYING, PAUSED, OK, PAUSED),
        (PLAYING, STOPPED, OK, STOPPED),
        (PAUSED, PAUSED, ALREADY_THERE, PAUSED),
        (PAUSED, PLAYING, OK, PLAYING),
        (PAUSED, STOPPED, OK, STOPPED),
        (STOPPED, STOPPED, ALREADY_THERE, STOPPED),
        (STOPPED, PLAYING, OK, PLAYING),
        (STOPPED, PAUSED, INCORRECT_TRANSITION, STOPPED),
        (PLAYING, 4, UNSUPPORTED, PLAYING),
        (PAUSED, 255, UNSUPPORTED, PAUSED),
    ],
)
def test_transitions(paused: Simulator, before: int, to: int, code: int, after: int) -> None:
    if before != PAUSED:
        assert paused.go_to(before) == OK
    assert (paused.state, paused.go_to(to), paused.state) == (before, code, after)


def test_quitting_ends_the_run_and_later_calls_are_answered(playing: Simulator) -> None:
    assert playing.go_to(QUITTING) == OK
    assert playing.interruption.requested
    requests: dict[str, dict[str, object]] = {
        "reset_simulation": {"scope": 0},
        "step_simulation": {"steps": 1},
        "get_entity_state": {"entity": NAME},
        "set_entity_state": {"entity": NAME, "state": wanted()},
    }
    for service, request in requests.items():
        assert playing.code(service, **request) == FAILED, service
