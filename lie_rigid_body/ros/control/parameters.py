"""The parameters of the node: declared from the table of parameters, and changed together, as a scenario."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any, Final

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, ParameterType, SetParametersResult
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.exceptions import ParameterNotDeclaredException, ParameterUninitializedException
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import qos_profile_parameters

from lie_rigid_body.foundation.errors import InputError, LieRigidBodyError
from lie_rigid_body.foundation.parameters import Given, Parameter, Value
from lie_rigid_body.foundation.wording import snake_case, suggestion
from lie_rigid_body.recording.poses import with_path
from lie_rigid_body.ros.timing.live_run import live_scenario
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import BY_NAME, PARAMETERS, read_parameters

_PATH: Final = "the path is read at the start"
_FOR_PUBLISHERS: Final = "publishers are made at the start"
_WHY_FIXED: Final = {
    "stamped_twist": "a topic keeps its type",
    "epoch_ns": "stamps go on rising",
    "path_file": _PATH,
    "path_interval": _PATH,
    "path_knots": _PATH,
    "record_path": "the bag is begun with the first sample",
    "publish_clock": _FOR_PUBLISHERS,
    "publish_tf": _FOR_PUBLISHERS,
    "marker_rate": _FOR_PUBLISHERS,
    "lockstep_topic": "the filter is looked for at the start",
    "lockstep_nodes": "they are looked for at the start",
    "lockstep_timeout": "it holds from the start",
    "imu_orientation": "a topic tells the same throughout",
    "sensor_grade": "other parameters depend on it",
}
FIXED: Final = {
    **{name: f"{why}: start the node anew with it" for name, why in _WHY_FIXED.items()},
    "paused": "it is how the node starts: call ~/pause or ~/resume",
}
"""Parameters that are fixed at the start, each with the reason and what to do instead."""
IMMEDIATE: Final = frozenset({"real_time_factor"})
"""Parameters that take effect without a reset."""

_DECLARED_BY_RCLPY: Final = ("use_sim_time", "start_type_description_service")
_OF_PUBLISHERS: Final = "qos_overrides."


class NodeParameters:
    """The parameters of a node, judged together as a scenario whoever sets them, and the services for them.

    The services are this package's own. A refusal gives value, limit and remedy, which that of rclpy does not. On a
    value of an unknown type rclpy's handler fails, and whoever asked waits for ever.

    Parameters
    ----------
    node : Node
        It declares the parameters of ROS arguments by itself.
    given : mapping of str to object
        Values from the node's own command line. Those of ROS arguments win over them.

    Raises
    ------
    ParameterError
        If a name is unknown or the values make no scenario.
    """

    def __init__(self, node: Node, given: Given) -> None:
        self._node = node
        values = read_parameters({**given, **overrides(node)})
        values.update(live_scenario(values).parameters())
        first = [_as_ros(each, values[each.name]) for each in PARAMETERS]
        # rclpy takes an empty list for one of bytes: what may be set later is declared by its type, and set after that
        double_array = RosParameter.Type.DOUBLE_ARRAY
        empty = [one for one in first if one.type_ == double_array and not one.value and one.name not in FIXED]
        declared = [given.type_ if given in empty else given.value for given in first]
        node.declare_parameters(
            "",
            [(each.name, given, descriptor(each)) for each, given in zip(PARAMETERS, declared, strict=True)],
            ignore_override=True,
        )
        node.set_parameters(empty)
        node.add_pre_set_parameters_callback(_in_own_types)
        node.add_on_set_parameters_callback(self._judge)
        handlers: dict[type, Callable[[Any, Any], Any]] = {
            DescribeParameters: partial(_tell, "descriptors", node.describe_parameter),
            GetParameterTypes: partial(_tell, "types", lambda name: node.get_parameter(name).type_.value),
            GetParameters: partial(_tell, "values", lambda name: node.get_parameter(name).get_parameter_value()),
            ListParameters: self._list,
            SetParameters: self._set_each,
            SetParametersAtomically: self._set_together,
        }
        for kind, handle in handlers.items():
            node.create_service(kind, f"~/{snake_case(kind.__name__)}", handle, qos_profile=qos_profile_parameters)

    def values(self) -> dict[str, Any]:
        """The present value of every parameter, by name."""
        return {name: self._node.get_parameter(name).value for name in BY_NAME}

    def scenario(self) -> Scenario:
        """The scenario of the present values."""
        scenario = Scenario.from_parameters(with_path(self.values()))
        if scenario.sensors.on:
            import scipy.special  # noqa: F401  # noise needs it, and the thread of the samples must not wait for it
        return scenario

    def _judge(self, changes: list[RosParameter]) -> SetParametersResult:
        """Whether the parameters make a scenario with some of them changed, all together."""
        new = {change.name: change.value for change in changes}
        try:
            if new.get("use_sim_time") and not self._node.get_parameter("use_sim_time").value:
                raise InputError(
                    "use_sim_time: the samples follow a steady clock of this node, and no /clock: leave it false"
                )
            if own := {name: value for name, value in new.items() if name in BY_NAME}:
                live_scenario({**self.values(), **own})
        except LieRigidBodyError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _set_each(self, request: SetParameters.Request, response: SetParameters.Response) -> SetParameters.Response:
        response.results = [self._set([change]) for change in request.parameters]
        return response

    def _set_together(
        self, request: SetParametersAtomically.Request, response: SetParametersAtomically.Response
    ) -> SetParametersAtomically.Response:
        response.result = self._set(request.parameters)
        return response

    def _set(self, changes: Sequence[ParameterMessage]) -> SetParametersResult:
        """Set all of them or none; without any there is nothing to refuse."""
        if not changes:
            return SetParametersResult(successful=True)
        try:
            read = [self._read(change) for change in changes]
            judged = self._judge(read)  # before rclpy, whose refusals of ranges give no remedy
            return self._node.set_parameters_atomically(read) if judged.successful else judged
        except LieRigidBodyError as error:  # also of what acts on a change, if it has ended
            return SetParametersResult(successful=False, reason=str(error))

    def _read(self, change: ParameterMessage) -> RosParameter:
        """A change in its parameter's own type, as in a parameter file: an integer stands for a double."""
        name = change.name
        kind = change.value.type
        if not 0 < kind <= ParameterType.PARAMETER_STRING_ARRAY:
            raise InputError(f"{name}: type {kind} is that of no value: give 1 to 9 of rcl_interfaces/ParameterType")
        if name in FIXED:
            raise InputError(f"{name}: fixed at the start, as {FIXED[name]}")
        if not self._node.has_parameter(name):
            raise InputError(f"{name or 'empty name'}: no such parameter: {suggestion(name, BY_NAME, 'parameters')}")
        given = RosParameter.from_parameter_msg(change)
        return _as_ros(BY_NAME[name], BY_NAME[name].read(given.value)) if name in BY_NAME else given

    def _list(self, request: Any, response: Any) -> Any:
        response.result = self._node.list_parameters(request.prefixes, request.depth)
        return response


def _tell(field: str, told: Callable[[str], Any], request: Any, response: Any) -> Any:
    """Answer with what is told of each parameter; with nothing where one is not there or has no value, as rclpy."""
    with suppress(ParameterNotDeclaredException, ParameterUninitializedException):
        setattr(response, field, [told(name) for name in request.names])
    return response


def _in_own_types(changes: list[RosParameter]) -> list[RosParameter]:
    """Changes in their parameters' own types, as far as they can be read: what cannot is refused after that."""
    read = list[RosParameter]()
    for change in changes:
        own = BY_NAME.get(change.name)
        with suppress(LieRigidBodyError):
            change = change if own is None else _as_ros(own, own.read(change.value))
        read.append(change)
    return read


def _as_ros(parameter: Parameter, value: Value) -> RosParameter:
    """A value as rclpy wants it, with lists, which may be empty."""
    kind = RosParameter.Type.DOUBLE_ARRAY if parameter.kind == "double_array" else None
    return RosParameter(parameter.name, kind, list(value) if isinstance(value, tuple) else value)


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """The description of a parameter for ROS, which ``ros2 param describe`` shows."""
    fixed = parameter.name in FIXED
    low = parameter.minimum
    high = parameter.maximum
    when = "at once" if parameter.name in IMMEDIATE else "at the next ~/reset"
    told = (
        *([f"one of {', '.join(parameter.choices)}"] if parameter.choices else []),
        *([parameter.wanted_numbers] if parameter.lengths else []),
        "fixed at the start" if fixed else f"a change takes effect {when}",
    )
    kind = parameter.kind if math.isfinite(high) else ""
    return ParameterDescriptor(
        description=parameter.description,
        additional_constraints="; ".join(told),
        read_only=fixed,
        floating_point_range=[FloatingPointRange(from_value=low, to_value=high)] if kind == "double" else [],
        integer_range=[IntegerRange(from_value=int(low), to_value=int(high))] if kind == "int" else [],
    )


def overrides(node: Node) -> dict[str, object]:
    """All values that ROS arguments and files give the node, also under names that it will not declare.

    The node has declared them by itself, as they are; here they are undeclared, to be declared as what they are.
    """
    names = node.list_parameters([], ListParameters.Request.DEPTH_RECURSIVE).names
    given = {name: node.get_parameter(name).value for name in names if name not in _DECLARED_BY_RCLPY}
    for name in given:
        node.undeclare_parameter(name)
    return {name: value for name, value in given.items() if not name.startswith(_OF_PUBLISHERS)}
