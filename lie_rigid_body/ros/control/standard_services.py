"""The standard simulator services, offered where the package simulation_interfaces is installed: a thin adapter.

Every decision is made in `standard_control`; here values are copied from requests and into responses.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Final

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node

from lie_rigid_body.errors import LieRigidBodyError
from lie_rigid_body.parameters import NS
from lie_rigid_body.ros.control.standard_control import (
    CATEGORY_DYNAMIC_OBJECT,
    FEATURES,
    Code,
    EntityState,
    RefusedError,
    StandardControl,
)

PACKAGE: Final = "simulation_interfaces"
FEEDBACK_INTERVAL: Final = 0.1
"""Time between two reports of the action, s: a report of every step would only slow down fast steps."""
CUSTOM_INFO: Final = "a torque-free rigid body; resets keep stamps rising; positions are 0"

PLAIN_SERVICES: Final = (
    *("GetSimulatorFeatures", "ResetSimulation", "GetSimulationState", "SetSimulationState"),
    *("GetEntities", "GetEntityInfo", "GetEntityState", "SetEntityState"),
)
"""Services whose handlers need the request and the response alone."""


def _filled(response: Any, code: int, message: str = "") -> Any:
    response.result.result = int(code)
    response.result.error_message = message
    return response


def _answering(handle: Callable[..., None]) -> Callable[..., Any]:
    """A handler that returns its response, with the result of what the handler given does or raises.

    Whoever asked would wait for ever where an error went on.
    """

    @wraps(handle)
    def answer(self: Any, request: Any, response: Any, *rest: Any) -> Any:
        try:
            handle(self, request, response, *rest)
        except Exception as error:
            code = error.code if isinstance(error, RefusedError) else Code.OPERATION_FAILED
            return _filled(response, code, str(error) or type(error).__name__)
        return _filled(response, Code.OK)

    return answer


class StandardServices:
    """The services and their handlers. Each handler takes a request and the response to fill in, as rclpy gives them.

    Parameters
    ----------
    standard : StandardControl
    """

    def __init__(self, standard: StandardControl) -> None:
        self._standard = standard

    def offer(self, node: Node) -> None:
        """Create the services and the action on a node, under their own names in snake case."""
        from simulation_interfaces import action, msg, srv

        for name in PLAIN_SERVICES:
            node.create_service(getattr(srv, name), f"~/{snake_case(name)}", getattr(self, snake_case(name)))
        node.create_service(
            srv.GetEntitiesStates,
            "~/get_entities_states",
            lambda request, response: self.get_entities_states(request, response, msg.EntityState),
        )
        # steps may take long, and must not keep the other services waiting
        concurrent = ReentrantCallbackGroup()
        node.create_service(srv.StepSimulation, "~/step_simulation", self.step_simulation, callback_group=concurrent)
        self._action = ActionServer(
            node,
            action.SimulateSteps,
            "~/simulate_steps",
            lambda goal: self.simulate_steps(goal, action.SimulateSteps.Result(), action.SimulateSteps.Feedback),
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            callback_group=concurrent,
        )

    def get_simulator_features(self, request: Any, response: Any) -> Any:
        """The features offered."""
        response.features.features = list(FEATURES)
        response.features.spawn_formats = []
        response.features.custom_info = CUSTOM_INFO
        return response

    @_answering
    def reset_simulation(self, request: Any, response: Any) -> None:
        """Begin a new segment."""
        self._standard.reset(request.scope)

    @_answering
    def get_simulation_state(self, request: Any, response: Any) -> None:
        """The run state: stopped, playing or paused."""
        response.state.state = int(self._standard.state())

    @_answering
    def set_simulation_state(self, request: Any, response: Any) -> None:
        """Play, pause, stop or quit."""
        self._standard.set_state(request.state.state)

    @_answering
    def step_simulation(self, request: Any, response: Any) -> None:
        """Send so many samples; answered when they are sent."""
        self._standard.begin_steps(request.steps).wait()

    def simulate_steps(self, goal: ServerGoalHandle, result: Any, feedback: Callable[[], Any]) -> Any:
        """Send so many samples, with feedback, until all are sent or the goal is canceled."""
        try:
            steps, done = self._standard.begin_steps(goal.request.steps), False
            while not done:
                done = steps.wait(FEEDBACK_INTERVAL)
                if goal.is_cancel_requested and not done:
                    self._standard.cancel_steps(steps)
                    goal.canceled()
                    message = f"canceled after {steps.completed} of {steps.total} steps"
                    return _filled(result, Code.OPERATION_FAILED, message)
                progress = feedback()
                progress.completed_steps, progress.remaining_steps = steps.completed, steps.total - steps.completed
                goal.publish_feedback(progress)
        except LieRigidBodyError as error:
            goal.abort()
            return _filled(result, Code.OPERATION_FAILED, str(error))
        goal.succeed()
        return _filled(result, Code.OK)

    @_answering
    def get_entities(self, request: Any, response: Any) -> None:
        """The name of the one body, if it passes the filters."""
        response.entities = self._filtered(request.filters)

    @_answering
    def get_entities_states(self, request: Any, response: Any, empty: Callable[[], Any]) -> None:
        """Name and state of the one body, if it passes the filters; ``empty`` makes the message of a state."""
        names = self._filtered(request.filters)
        response.states = [_with_state(empty(), self._standard.entity_state(name)) for name in names]
        response.entities = names

    def _filtered(self, filters: Any) -> list[str]:
        return self._standard.entities(
            filters.filter,
            [category.category for category in filters.categories],
            tags=bool(filters.tags.tags),
            bounds=bool(filters.bounds.points),
        )

    @_answering
    def get_entity_info(self, request: Any, response: Any) -> None:
        """Description and category of the body."""
        response.info.category.category = CATEGORY_DYNAMIC_OBJECT
        response.info.description = self._standard.entity_info(request.entity)

    @_answering
    def get_entity_state(self, request: Any, response: Any) -> None:
        """Pose, twist and acceleration of the body in the world frame."""
        _with_state(response.state, self._standard.entity_state(request.entity))

    @_answering
    def set_entity_state(self, request: Any, response: Any) -> None:
        """Begin a new segment from any attitude and angular velocity."""
        # before release 2 of simulation_interfaces both are always set
        pose, twist = getattr(request, "set_pose", True), getattr(request, "set_twist", True)
        self._standard.set_entity_state(request.entity, request.state, set_pose=pose, set_twist=twist)


def snake_case(name: str) -> str:
    """A name in snake case: ``GetEntities`` as ``get_entities``."""
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")


def _with_state(message: Any, state: EntityState) -> Any:
    message.header.frame_id = state.frame
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(state.stamp_ns, NS)
    for field, vector in (
        (message.pose.orientation, state.attitude_xyzw),
        (message.twist.angular, state.angular_velocity),
        (message.acceleration.angular, state.angular_acceleration),
    ):
        for name, value in zip("xyzw", vector.tolist(), strict=False):
            setattr(field, name, value)
    return message
