"""The standard simulator services: those that are there, what a reset needs, and what no scenario is made of."""

from __future__ import annotations

from importlib.util import find_spec
from types import SimpleNamespace

import pytest
from standard_simulator import FAILED, NAME, OK, STOPPED, UNSUPPORTED, Simulator, running

from lie_rigid_body.ros.timing.live_run import RunState
from lie_rigid_body.scenario import Scenario

if find_spec("rclpy"):
    from standard_messages import FEATURE_OF, RESPONSES

    from lie_rigid_body.ros.control.services import StandardServices, snake_case

pytestmark = [pytest.mark.ros, pytest.mark.filterwarnings("error::RuntimeWarning")]


def test_names_are_in_snake_case() -> None:
    assert snake_case("GetSimulatorFeatures") == "get_simulator_features"


def test_features_are_those_that_are_served(paused: Simulator) -> None:
    """Numbers of simulation_interfaces/SimulatorFeatures."""
    features = paused.ask("get_simulator_features").features
    served = {"state getting": 10, "state setting": 11, "info": 12, "reset": 20, "reset of the state": 22}
    served |= {"get": 24, "set": 25, "pause": 26, "one step": 31, "steps": 32, "the action": 33, "categories": 8}
    assert set(features.features) == set(served.values())
    assert features.spawn_formats == []
    assert features.custom_info


def test_every_standard_service_is_offered_or_declared_unsupported(paused: Simulator) -> None:
    features = set(paused.ask("get_simulator_features").features.features)
    offered = {name for name in FEATURE_OF if hasattr(paused.services, name)}
    assert offered == set(RESPONSES)
    assert offered == {name for name, feature in FEATURE_OF.items() if feature is None or feature in features}


@pytest.mark.parametrize(
    ("scope", "code"), [(0, OK), (1, UNSUPPORTED), (2, OK), (3, OK), (4, UNSUPPORTED), (5, UNSUPPORTED), (255, OK)]
)
def test_a_reset_needs_the_state_in_its_scope(paused: Simulator, scope: int, code: int) -> None:
    assert paused.code("reset_simulation", scope=scope) == code
    assert len(paused.sink.segments) == (2 if code == OK else 1)


def test_a_parameter_that_makes_no_scenario_is_answered() -> None:
    def broken() -> Scenario:
        return Scenario.from_parameters({"rate": -1.0})

    with running(paused=True) as simulator:
        services = StandardServices(simulator.live, broken, NAME)
        for service, request in (
            (services.reset_simulation, SimpleNamespace(scope=0)),
            (services.set_simulation_state, SimpleNamespace(state=SimpleNamespace(state=STOPPED))),
        ):
            answer = service(request, RESPONSES["reset_simulation"]()).result
            assert (answer.result, "rate" in answer.error_message) == (FAILED, True)
        assert simulator.live.state is RunState.PAUSED


def test_whatever_goes_wrong_is_answered(paused: Simulator) -> None:
    """Else whoever asked would wait for ever."""

    def broken() -> Scenario:
        raise ZeroDivisionError

    services = StandardServices(paused.live, broken, NAME)
    answer = services.reset_simulation(SimpleNamespace(scope=0), RESPONSES["reset_simulation"]()).result
    assert (answer.result, answer.error_message) == (FAILED, "ZeroDivisionError")
