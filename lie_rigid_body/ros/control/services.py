"""Services of the node: reset, pause, resume and step, and the standard simulator services where they are installed.

The package simulation_interfaces defines the standard ones, their result codes and their fields. Two traps: a result
that was never set reads "unsupported" (0), and the twist of an entity is in the frame of its header, which here is the
world frame.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from functools import wraps
from typing import Any, Final

import numpy as np
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from std_srvs.srv import Trigger

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import LieRigidBodyError, ParameterError, describe
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import numerals, shown, snake_case
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion.mass_centre import MassCentre
from lie_rigid_body.ros.control.filters import is_found
from lie_rigid_body.ros.timing.live_run import LiveRun, RunState
from lie_rigid_body.scenario import Scenario

SIMULATION_INTERFACES: Final = "simulation_interfaces"


class Code(IntEnum):
    """Result codes of simulation_interfaces/Result, and those that SetSimulationState adds."""

    FEATURE_UNSUPPORTED = 0
    OK = 1
    NOT_FOUND = 2
    OPERATION_FAILED = 4
    ALREADY_IN_TARGET_STATE = 101
    INCORRECT_TRANSITION = 103


INVALID_POSE: Final = 101
"""A result code that SetEntityState adds; the same number has another meaning in SetSimulationState."""
QUITTING: Final = 3
"""The state of simulation_interfaces/SimulationState that a run is never in; the others are those of `RunState`."""
FEATURES: Final = (8, 10, 11, 12, 20, 22, 24, 25, 26, 31, 32, 33)
"""Numbers of simulation_interfaces/SimulatorFeatures. They are categories, getting and setting of an entity's state,
its info, reset, and reset of the state. They are also getting and setting of the simulation's state, pause, one step,
many steps, their action. All others are unsupported, and have no service: spawning, deleting, named poses, bounds,
tags, infos, worlds."""
CUSTOM_INFO: Final = "a rigid body, torque-free between kicks; resets keep stamps rising"
PLAIN_SERVICES: Final = (
    *("GetSimulatorFeatures", "ResetSimulation", "GetSimulationState", "SetSimulationState"),
    *("GetEntities", "GetEntityInfo", "GetEntityState", "SetEntityState"),
)
"""Standard services whose handlers need the request and the response alone."""
FEEDBACK_INTERVAL: Final = 0.1
"""Time between two reports of the action, s: a report of every step would only slow down fast steps."""
SCOPE_DEFAULT: Final = 0
SCOPE_STATE: Final = 2
CATEGORY_DYNAMIC_OBJECT: Final = 4


def offer_triggers(node: Node, run: LiveRun, scenario: Callable[[], Scenario]) -> None:
    """Create the services that need no package but std_srvs.

    Parameters
    ----------
    node : Node
    run : LiveRun
    scenario : callable
        Returns the scenario of the present parameters, or raises what is wrong with them.
    """

    def reset() -> str:
        segment = run.ask(run.reset, scenario())
        return f"the sample stamped {segment.start_ns} ns begins the motion anew"

    def pause() -> str:
        return f"time stands still at {run.ask(run.pause)} ns"

    def resume() -> str:
        run.ask(run.resume)
        return "time goes on"

    def step() -> str:
        run.ask(run.step, 1).wait()
        stamp_ns, _ = run.ask(lambda: run.latest)
        return f"sent the sample stamped {stamp_ns} ns"

    for action in (reset, pause, resume):
        node.create_service(Trigger, f"~/{action.__name__}", _triggered(action))
    # a step waits for its sample, and must not keep the other services waiting
    node.create_service(Trigger, "~/step", _triggered(step), callback_group=ReentrantCallbackGroup())


def _triggered(action: Callable[[], str]) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
    """A service handler that answers with the text an action returns, or with its error."""

    def handle(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            response.message = action()
            response.success = True
        except Exception as error:
            response.message = describe(error)
        return response

    return handle


class RefusedError(LieRigidBodyError):
    """A request that is not fulfilled, with a result code other than `Code.OPERATION_FAILED`.

    Parameters
    ----------
    code : int
    message : str
    """

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


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
            return _filled(response, code, describe(error))
        return _filled(response, Code.OK)

    return answer


class StandardServices:
    """The standard services of one body. Each handler takes a request and the response to fill in, as rclpy has them.

    Parameters
    ----------
    run : LiveRun
    scenario : callable
        Returns the scenario of the present parameters, or raises what is wrong with them.
    entity : str
        The body's name.
    """

    def __init__(self, run: LiveRun, scenario: Callable[[], Scenario], entity: str) -> None:
        self._run = run
        self._scenario = scenario
        self._entity = entity

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
        response.features.custom_info = CUSTOM_INFO
        return response

    @_answering
    def reset_simulation(self, request: Any, response: Any) -> None:
        """Begin a new segment, if the state is in the scope. Stamps go on rising: /clock never goes back."""
        if request.scope != SCOPE_DEFAULT and not request.scope & SCOPE_STATE:
            raise RefusedError(
                Code.FEATURE_UNSUPPORTED,
                f"scope {request.scope} leaves out the state, which is all that a reset changes: give SCOPE_STATE (2) "
                "or SCOPE_ALL (255)",
            )
        self._run.ask(self._run.reset, self._scenario())

    @_answering
    def get_simulation_state(self, request: Any, response: Any) -> None:
        """The run state: stopped, playing or paused."""
        response.state.state = int(self._run.state)

    @_answering
    def set_simulation_state(self, request: Any, response: Any) -> None:
        """Play, pause, stop (pause at the start of a new segment) or quit."""
        present = self._run.state
        wanted = request.state.state
        actions = {
            RunState.STOPPED: lambda: self._run.ask(self._run.stop, self._scenario()),
            RunState.PLAYING: lambda: self._run.ask(self._run.resume),
            RunState.PAUSED: lambda: self._run.ask(self._run.pause),
            QUITTING: lambda: self._run.ask(self._run.quit),
        }
        if wanted not in actions:
            raise RefusedError(
                Code.FEATURE_UNSUPPORTED, f"state {wanted} is none of 0 stopped, 1 playing, 2 paused, 3 quit"
            )
        if wanted == present:
            raise RefusedError(Code.ALREADY_IN_TARGET_STATE, f"the simulation is {present.name.lower()} already")
        if (present, wanted) == (RunState.STOPPED, RunState.PAUSED):
            raise RefusedError(Code.INCORRECT_TRANSITION, "the simulation is stopped: play it before it can be paused")
        actions[wanted]()

    @_answering
    def step_simulation(self, request: Any, response: Any) -> None:
        """Send so many samples while paused; answered when they are sent."""
        self._run.ask(self._run.step, request.steps).wait()

    def simulate_steps(self, goal: ServerGoalHandle, result: Any, feedback: Callable[[], Any]) -> Any:
        """Send so many samples while paused, with feedback, until all are sent or the goal is canceled."""
        try:
            steps = self._run.ask(self._run.step, goal.request.steps)
            done = False
            while not done:
                done = steps.wait(FEEDBACK_INTERVAL)
                if goal.is_cancel_requested and not done:
                    self._run.ask(self._run.cancel, steps)
                    goal.canceled()
                    message = f"canceled after {steps.completed} of {steps.total} steps"
                    return _filled(result, Code.OPERATION_FAILED, message)
                progress = feedback()
                progress.completed_steps = steps.completed
                progress.remaining_steps = steps.total - steps.completed
                goal.publish_feedback(progress)
        except LieRigidBodyError as error:
            goal.abort()
            return _filled(result, Code.OPERATION_FAILED, str(error))
        goal.succeed()
        return _filled(result, Code.OK)

    @_answering
    def get_entities(self, request: Any, response: Any) -> None:
        """The name of the one body, if it passes the filters."""
        response.entities = self._entities(request.filters)

    @_answering
    def get_entities_states(self, request: Any, response: Any, empty: Callable[[], Any]) -> None:
        """Name and state of the one body, if it passes the filters; ``empty`` makes the message of a state."""
        names = self._entities(request.filters)
        response.states = [self._with_state(empty()) for _ in names]
        response.entities = names

    def _entities(self, filters: Any) -> list[str]:
        """The entities that pass a filter by name and category; filters by tags and bounds are unsupported."""
        if filters.tags.tags or filters.bounds.points:
            raise RefusedError(
                Code.FEATURE_UNSUPPORTED, "filters by tags and by bounds are unsupported: leave them out"
            )
        if filters.filter and not is_found(filters.filter, self._entity):
            return []
        categories = [each.category for each in filters.categories]
        return [self._entity] if not categories or CATEGORY_DYNAMIC_OBJECT in categories else []

    @_answering
    def get_entity_info(self, request: Any, response: Any) -> None:
        """Description and category of the body."""
        self._require_known(request.entity)
        scenario = self._run.segment.scenario
        moments = numerals(scenario.body().principal_moments)
        response.info.category.category = CATEGORY_DYNAMIC_OBJECT
        body = f"a torque-free rigid body with the principal moments {moments} kg m²"
        response.info.description = "a body on a path" if scenario.path() else body

    @_answering
    def get_entity_state(self, request: Any, response: Any) -> None:
        """Pose, twist and acceleration of the body in the world frame."""
        self._require_known(request.entity)
        self._with_state(response.state)

    def _with_state(self, message: Any) -> Any:
        """A simulation_interfaces/EntityState, filled with the latest state of the body."""
        scenario, stamp_ns, state, centre = self._latest()
        attitude = state.attitude_xyzw
        message.header.frame_id = scenario.world_frame
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, NS)
        acceleration = scenario.body().angular_acceleration(state)
        if path := scenario.path():
            acceleration = path.angular_acceleration(np.array([stamp_ns - self._run.segment.start_ns]))[0]
        _fill(message.pose.position, centre.position)
        _fill(message.pose.orientation, attitude)
        _fill(message.twist.linear, centre.velocity)
        _fill(message.twist.angular, quaternion.rotate(attitude, state.body_rate))
        _fill(message.acceleration.linear, centre.acceleration)
        _fill(message.acceleration.angular, quaternion.rotate(attitude, acceleration))
        return message

    def _latest(self) -> tuple[Scenario, int, State, MassCentre]:
        """The scenario, and stamp (ns), state and mass centre of the latest sample."""
        segment, (stamp_ns, state) = self._run.ask(lambda: (self._run.segment, self._run.latest))
        centre = segment.scenario.mass_centre().at(np.array([stamp_ns - segment.start_ns]))
        return segment.scenario, stamp_ns, state, centre[0]

    @_answering
    def set_entity_state(self, request: Any, response: Any) -> None:
        """Begin a new segment from any pose and twist, given in the world frame or without a frame."""
        self._require_known(request.entity)
        if self._run.segment.scenario.path():
            raise LieRigidBodyError("motion path prescribes the state: set motion to another, and reset")
        # before release 2.1 of simulation_interfaces both are always set
        pose = request.state.pose if getattr(request, "set_pose", True) else None
        twist = request.state.twist if getattr(request, "set_twist", True) else None
        frame = request.state.header.frame_id
        world = self._run.segment.scenario.world_frame
        if frame not in ("", world):
            raise LieRigidBodyError(
                f"frame {shown(frame)} is unknown: give pose and twist in {world!r}, or leave it empty"
            )
        try:
            self._run.ask(self._run.reset_to, self._changed(pose, twist))
        except ParameterError as error:
            if error.name.endswith(("attitude_xyzw", "initial_position")):
                raise RefusedError(INVALID_POSE, str(error)) from None
            raise

    def _changed(self, pose: Any | None, twist: Any | None) -> dict[str, object]:
        """Parameters of the latest state with another pose, and another twist; what is None goes on as it is.

        The velocity of a sway is no part of ``initial_velocity``, which stays that of the scenario.
        """
        scenario, _, present, centre = self._latest()
        attitude = present.attitude_xyzw
        rate = present.body_rate
        position = centre.position.tolist()
        is_carried = scenario.translation == "carried"
        velocity = list(scenario.initial_velocity) if is_carried else centre.velocity.tolist()
        if pose is not None:
            position = _components(pose.position)
            attitude = State(_components(pose.orientation), rate).attitude_xyzw
        if twist is not None:
            velocity = _components(twist.linear)
            if scenario.translation == "none" and any(velocity):
                raise LieRigidBodyError(
                    f"linear velocity {velocity} is not 0, and translation none moves no mass centre: give 0, or set "
                    "translation to thrown or carried and reset"
                )
            angular = _components(twist.angular)
            if not np.all(np.isfinite(angular)):
                raise LieRigidBodyError(f"angular velocity {angular} is not finite: give numbers")
            rate = quaternion.rotate(quaternion.conjugate(attitude), angular)
        return {
            "initial_attitude_xyzw": State(attitude, rate).attitude_xyzw.tolist(),
            "initial_body_rate": rate.tolist(),
            "initial_position": position,
            "initial_velocity": velocity,
        }

    def _require_known(self, entity: str) -> None:
        if entity != self._entity:
            raise RefusedError(Code.NOT_FOUND, f"there is no entity {shown(entity)}: the body is {self._entity!r}")


def _components(message: Any) -> list[float]:
    """The components x, y, z and, of a quaternion, w."""
    return [getattr(message, name) for name in "xyzw" if hasattr(message, name)]


def _fill(message: Any, vector: Array) -> None:
    for name, value in zip("xyzw", vector.tolist(), strict=False):
        setattr(message, name, value)
