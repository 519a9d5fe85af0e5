"""The decisions behind the standard simulator services: no message package is needed here.

The package simulation_interfaces defines the services, their result codes and their fields; `standard_services` is the
adapter to them. Two traps: a result that was never set reads "unsupported" (0), and the twist of an entity is in the
frame of its header, which here is the world frame.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.errors import LieRigidBodyError, ParameterError
from lie_rigid_body.lie import quaternion
from lie_rigid_body.mechanics import State
from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.ros.timing.step_request import StepRequest
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.wording import shown


class Code(IntEnum):
    """Result codes of simulation_interfaces/Result, and those that SetSimulationState adds."""

    FEATURE_UNSUPPORTED = 0
    OK = 1
    NOT_FOUND = 2
    INCORRECT_STATE = 3
    OPERATION_FAILED = 4
    ALREADY_IN_TARGET_STATE = 101
    INCORRECT_TRANSITION = 103


INVALID_POSE: Final = 101
"""A result code that SetEntityState adds; the same number has another meaning in SetSimulationState."""


class StandardState(IntEnum):
    """States of simulation_interfaces/SimulationState."""

    STOPPED = 0
    PLAYING = 1
    PAUSED = 2
    QUITTING = 3


FEATURES: Final = (8, 10, 11, 12, 20, 22, 24, 25, 26, 31, 32, 33)
"""Numbers of simulation_interfaces/SimulatorFeatures. They are categories, getting and setting of an entity's state,
its info, reset, and reset of the state. They are also getting and setting of the simulation's state, pause, one step,
many steps, their action. All others are unsupported, and have no service: spawning, deleting, named poses, bounds,
tags, infos, worlds."""
SCOPE_DEFAULT: Final = 0
SCOPE_STATE: Final = 2
CATEGORY_DYNAMIC_OBJECT: Final = 4
LONGEST_PATTERN: Final = 1000
"""Largest length of a regular expression, characters."""
PATTERN_S: Final = 2.0
"""Longest time that a regular expression may take, s."""
_SEARCH: Final = "import json, re, sys; print(re.search(*json.load(sys.stdin)) is not None)"


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


@dataclass(frozen=True)
class EntityState:
    """Attitude, angular velocity and angular acceleration of the body in the world frame.

    Parameters
    ----------
    frame : str
        Name of the world frame.
    stamp_ns : int
    attitude_xyzw : ndarray, shape (4,)
    angular_velocity : ndarray, shape (3,)
        World frame, rad/s.
    angular_acceleration : ndarray, shape (3,)
        World frame, rad/s².
    """

    frame: str
    stamp_ns: int
    attitude_xyzw: Array
    angular_velocity: Array
    angular_acceleration: Array


class StandardControl:
    """The decisions behind the standard services of one body.

    What cannot be done is raised, as `RefusedError` where it has a code of its own.

    Parameters
    ----------
    run : LiveRun
    scenario : callable
        Returns the scenario of the present parameters.
    entity : str
        The body's name.
    """

    def __init__(self, run: LiveRun, scenario: Callable[[], Scenario], entity: str) -> None:
        self._run = run
        self._scenario = scenario
        self._entity = entity

    def reset(self, scope: int) -> None:
        """Begin a new segment, if the state is in the scope. Stamps go on rising: /clock never goes back."""
        if scope != SCOPE_DEFAULT and not scope & SCOPE_STATE:
            raise RefusedError(
                Code.FEATURE_UNSUPPORTED,
                f"scope {scope} leaves out the state, which is all that a reset changes: give SCOPE_STATE (2) or "
                "SCOPE_ALL (255)",
            )
        self._run.ask(self._run.reset, self._scenario())

    def state(self) -> StandardState:
        """The state of the simulation."""
        return StandardState[self._run.state.name]

    def set_state(self, wanted: int) -> None:
        """Play, pause, stop (pause at the start of a new segment) or quit."""
        present = self.state()
        if wanted not in set(StandardState):
            raise RefusedError(
                Code.FEATURE_UNSUPPORTED, f"state {wanted} is none of 0 stopped, 1 playing, 2 paused, 3 quit"
            )
        if wanted == present:
            raise RefusedError(Code.ALREADY_IN_TARGET_STATE, f"the simulation is {present.name.lower()} already")
        if (present, wanted) == (StandardState.STOPPED, StandardState.PAUSED):
            raise RefusedError(Code.INCORRECT_TRANSITION, "the simulation is stopped: play it before it can be paused")
        actions: dict[int, Callable[[], object]] = {
            StandardState.PLAYING: lambda: self._run.ask(self._run.resume),
            StandardState.PAUSED: lambda: self._run.ask(self._run.pause),
            StandardState.STOPPED: lambda: self._run.ask(self._run.stop, self._scenario()),
            StandardState.QUITTING: lambda: self._run.ask(self._run.quit),
        }
        actions[wanted]()

    def begin_steps(self, count: int) -> StepRequest:
        """Begin to send samples while paused."""
        return self._run.ask(self._run.step, count)

    def cancel_steps(self, steps: StepRequest) -> None:
        """Leave out the rest of the samples asked for."""
        self._run.ask(self._run.cancel, steps)

    def entities(self, pattern: str, categories: Sequence[int], *, tags: bool, bounds: bool) -> list[str]:
        """The entities that pass a filter by name and category; filters by tags and bounds are unsupported."""
        if tags or bounds:
            raise RefusedError(
                Code.FEATURE_UNSUPPORTED, "filters by tags and by bounds are unsupported: leave them out"
            )
        named = not pattern or _is_found(pattern, self._entity)
        return [self._entity] if named and (not categories or CATEGORY_DYNAMIC_OBJECT in categories) else []

    def entity_info(self, entity: str) -> str:
        """A description of the body."""
        self._require_known(entity)
        moments = ", ".join(f"{moment:g}" for moment in self._run.segment.scenario.body().principal_moments)
        return f"a torque-free rigid body with the principal moments {moments} kg m²"

    def entity_state(self, entity: str) -> EntityState:
        """The latest state of the body in the world frame."""
        self._require_known(entity)
        stamp_ns, state = self._run.ask(lambda: self._run.latest)
        scenario, attitude = self._run.segment.scenario, state.attitude_xyzw
        return EntityState(
            scenario.world_frame,
            stamp_ns,
            attitude,
            quaternion.rotate(attitude, state.body_rate),
            quaternion.rotate(attitude, scenario.body().angular_acceleration(state)),
        )

    def set_entity_state(self, entity: str, wanted: Any, *, set_pose: bool, set_twist: bool) -> None:
        """Begin a new segment from any attitude and angular velocity, given in the world frame.

        Parameters
        ----------
        entity : str
        wanted : simulation_interfaces/EntityState, or with its fields
            Without a frame it is in the world frame.
        set_pose, set_twist : bool
            Whether the pose, and the twist, are to be set.
        """
        self._require_known(entity)
        frame, world = wanted.header.frame_id, self._run.segment.scenario.world_frame
        if frame not in ("", world):
            raise LieRigidBodyError(
                f"frame {shown(frame)} is unknown: give pose and twist in {world!r}, or leave it empty"
            )
        position, linear = _components(wanted.pose.position), _components(wanted.twist.linear)
        if set_pose and any(position):
            raise RefusedError(INVALID_POSE, f"position {position} is not 0, where the mass centre stays: give 0")
        if set_twist and any(linear):
            raise LieRigidBodyError(f"linear velocity {linear} is not 0: give 0, the mass centre stays")
        angular = _components(wanted.twist.angular)
        if set_twist and not np.all(np.isfinite(angular)):
            raise LieRigidBodyError(f"angular velocity {angular} is not finite: give numbers")
        attitude_xyzw = _components(wanted.pose.orientation)
        try:
            self._reset_to(attitude_xyzw if set_pose else None, angular if set_twist else None)
        except ParameterError as error:
            if error.name.endswith("attitude_xyzw"):
                raise RefusedError(INVALID_POSE, str(error)) from None
            raise

    def _reset_to(self, attitude_xyzw: list[float] | None, angular: list[float] | None) -> None:
        """Begin a new segment; what is None stays as it is."""
        _, present = self._run.ask(lambda: self._run.latest)
        attitude, rate = present.attitude_xyzw, present.body_rate
        if attitude_xyzw is not None:
            attitude = State(attitude_xyzw, rate).attitude_xyzw
        if angular is not None:
            rate = quaternion.rotate(quaternion.conjugate(attitude), angular)
        self._run.ask(self._run.reset_to, State(attitude, rate))

    def _require_known(self, entity: str) -> None:
        if entity != self._entity:
            raise RefusedError(Code.NOT_FOUND, f"there is no entity {shown(entity)}: the body is {self._entity!r}")


def _is_found(pattern: str, name: str) -> bool:
    """Whether a regular expression finds something in a name.

    Some take for ever, and keep all threads waiting meanwhile: they are tried in a process of their own.

    Raises
    ------
    LieRigidBodyError
        If it is none, or takes too long.
    """
    if len(pattern) > LONGEST_PATTERN:
        raise LieRigidBodyError(
            f"filter {shown(pattern)} has {len(pattern)} characters: give at most {LONGEST_PATTERN}, or none"
        )
    command, given = [sys.executable, "-I", "-c", _SEARCH], json.dumps([pattern, name])
    try:
        done = subprocess.run(command, input=given, capture_output=True, text=True, timeout=PATTERN_S, check=True)
    except subprocess.TimeoutExpired:
        problem = f"takes longer than {PATTERN_S:g} s"
    except subprocess.CalledProcessError as error:
        why = error.stderr.rpartition(": ")[2].strip()
        problem = f"is no regular expression ({why})"
    else:
        return done.stdout == "True\n"
    raise LieRigidBodyError(f"filter {shown(pattern)} {problem}: give another, or none")


def _components(message: Any) -> list[float]:
    """The components x, y, z and, of a quaternion, w."""
    return [getattr(message, name) for name in "xyzw" if hasattr(message, name)]
