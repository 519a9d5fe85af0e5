"""The parameters of the node: declared from the table of parameters, and validated together as a scenario."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from lie_rigid_body.errors import LieRigidBodyError
from lie_rigid_body.parameters import Parameter, Value
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import PARAMETERS, read_parameters

READ_ONLY: Final = frozenset(
    {"stamped_twist", "epoch_ns", "record_path", "publish_clock", "paused", "publish_tf", "marker_rate", "sensor_grade"}
)
"""Parameters on which message types, stamps, files, publishers and other parameters depend: fixed at the start."""
IMMEDIATE: Final = frozenset({"real_time_factor"})
"""Parameters that take effect without a reset."""

_BY_NAME: Final = {parameter.name: parameter for parameter in PARAMETERS}
_OF_EVERY_NODE: Final = ("use_sim_time", "start_type_description_service", "qos_overrides.")


class NodeParameters:
    """The parameters of a node.

    Parameters
    ----------
    node : Node
    given : mapping of str to object
        Values from the node's own command line. Those of ROS arguments win over them.

    Raises
    ------
    ParameterError
        If a name is unknown or the values make no scenario.
    """

    def __init__(self, node: Node, given: Mapping[str, object]) -> None:
        self._node = node
        values = read_parameters({**given, **_overrides(node)})
        values.update(Scenario.from_parameters(values).parameters())
        for parameter in PARAMETERS:
            node.declare_parameter(
                parameter.name, ros_value(values[parameter.name]), descriptor(parameter), ignore_override=True
            )
        node.add_pre_set_parameters_callback(integers_as_doubles)
        node.add_on_set_parameters_callback(self._validate)

    def values(self) -> dict[str, Any]:
        """The present value of every parameter, by name."""
        return {name: self._node.get_parameter(name).value for name in _BY_NAME}

    def scenario(self) -> Scenario:
        """The scenario of the present values."""
        return Scenario.from_parameters(self.values())

    def on_change(self, act: Callable[[Mapping[str, Any]], None]) -> None:
        """Call ``act`` with the new values, by name, when parameters in `IMMEDIATE` change."""

        def changed(changes: Sequence[RosParameter]) -> None:
            values = {change.name: change.value for change in changes if change.name in IMMEDIATE}
            if values:
                act(values)

        self._node.add_post_set_parameters_callback(changed)

    def _validate(self, changes: Sequence[RosParameter]) -> SetParametersResult:
        """Accept all changes of a request, or refuse all with the reason."""
        new = {change.name: change.value for change in changes if change.name in _BY_NAME}
        try:
            Scenario.from_parameters({**self.values(), **new})
        except LieRigidBodyError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """The description of a parameter for ROS, which ``ros2 param describe`` shows."""
    fixed = parameter.name in READ_ONLY
    described = ParameterDescriptor(
        description=parameter.description,
        additional_constraints="; ".join([*_constraints(parameter), *_effect(parameter.name)]),
        read_only=fixed,
    )
    if parameter.kind == "double" and math.isfinite(parameter.maximum):
        described.floating_point_range = [
            FloatingPointRange(from_value=parameter.minimum, to_value=parameter.maximum, step=0.0)
        ]
    if parameter.kind == "int" and math.isfinite(parameter.maximum):
        described.integer_range = [
            IntegerRange(from_value=int(parameter.minimum), to_value=int(parameter.maximum), step=0)
        ]
    return described


def _constraints(parameter: Parameter) -> Iterable[str]:
    if parameter.choices:
        yield f"one of {', '.join(parameter.choices)}"
    if parameter.lengths:
        yield f"{' or '.join(str(n) for n in parameter.lengths)} finite numbers"


def _effect(name: str) -> Iterable[str]:
    if name in READ_ONLY:
        yield "fixed at the start"
    else:
        yield f"a change takes effect {'at once' if name in IMMEDIATE else 'at the next ~/reset'}"


def integers_as_doubles(changes: list[RosParameter]) -> list[RosParameter]:
    """Take an integer given for a double as that double, as in a parameter file."""
    return [_as_declared(change) for change in changes]


def _as_declared(change: RosParameter) -> RosParameter:
    parameter = _BY_NAME.get(change.name)
    if parameter is None:
        return change
    if parameter.kind == "double" and change.type_ == RosParameter.Type.INTEGER:
        return RosParameter(change.name, RosParameter.Type.DOUBLE, float(change.value))
    if parameter.kind == "double_array" and change.type_ == RosParameter.Type.INTEGER_ARRAY:
        return RosParameter(change.name, RosParameter.Type.DOUBLE_ARRAY, [float(v) for v in change.value])
    return change


def ros_value(value: Value) -> object:
    """A value in the type that rclpy wants: arrays are lists."""
    return list(value) if isinstance(value, tuple) else value


def _overrides(node: Node) -> dict[str, object]:
    """All values that ROS arguments and files give the node, also under names that it does not declare."""
    with node.handle:
        overrides = node.handle.get_parameters(RosParameter)
    return {name: override.value for name, override in overrides.items() if not name.startswith(_OF_EVERY_NODE)}
