"""The parameters of the node: declared from the table of parameters, and validated together as a scenario."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from lie_rigid_body.errors import LieRigidBodyError
from lie_rigid_body.parameters import Parameter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_table import BY_NAME, PARAMETERS, read_parameters
from lie_rigid_body.wording import shortened

_NEW_NODE: Final = "start the node anew with it"
FIXED: Final[Mapping[str, str]] = {
    "stamped_twist": f"a topic keeps its type: {_NEW_NODE}",
    "epoch_ns": f"stamps go on rising: {_NEW_NODE}",
    "record_path": f"the bag is begun with the first sample: {_NEW_NODE}",
    "publish_clock": f"publishers are made at the start: {_NEW_NODE}",
    "paused": "it is how the node starts: call ~/pause or ~/resume",
    "publish_tf": f"publishers are made at the start: {_NEW_NODE}",
    "marker_rate": f"publishers are made at the start: {_NEW_NODE}",
    "lockstep_topic": f"the filter is looked for at the start: {_NEW_NODE}",
    "lockstep_nodes": f"they are looked for at the start: {_NEW_NODE}",
    "lockstep_timeout": f"it holds from the start: {_NEW_NODE}",
    "imu_orientation": f"a topic tells the same throughout: {_NEW_NODE}",
    "sensor_grade": f"other parameters depend on it: {_NEW_NODE}",
}
"""Parameters that are fixed at the start, each with the reason and what to do instead."""
IMMEDIATE: Final = frozenset({"real_time_factor"})
"""Parameters that take effect without a reset."""

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
        values = read_parameters({**given, **overrides(node)})
        values.update(Scenario.from_parameters(values).parameters())
        for parameter in PARAMETERS:
            value = values[parameter.name]
            given_value = list(value) if isinstance(value, tuple) else value  # rclpy wants lists
            node.declare_parameter(parameter.name, given_value, descriptor(parameter), ignore_override=True)
        node.add_pre_set_parameters_callback(integers_as_doubles)
        node.add_on_set_parameters_callback(self._validate)

    def values(self) -> dict[str, Any]:
        """The present value of every parameter, by name."""
        return {name: self._node.get_parameter(name).value for name in BY_NAME}

    def scenario(self) -> Scenario:
        """The scenario of the present values."""
        scenario = Scenario.from_parameters(self.values())
        if scenario.sensors.on:
            import scipy.special  # noqa: F401  # noise needs it, and the thread of the samples must not wait for it
        return scenario

    def on_change_of_factor(self, act: Callable[[float], None]) -> None:
        """Call ``act`` with the new real-time factor when this parameter changes."""

        def changed(changes: Sequence[RosParameter]) -> None:
            for change in changes:
                if change.name == "real_time_factor":
                    act(float(change.value))

        self._node.add_post_set_parameters_callback(changed)

    def refusal(self, changes: list[RosParameter]) -> SetParametersResult | None:
        """The reason why a request is refused, or None; rclpy's own says neither why nor what to do."""
        for change in changes:
            if change.name in FIXED:
                return refused(f"{change.name}: fixed at the start, as {FIXED[change.name]}")
        judged = self._validate(integers_as_doubles(changes))
        return None if judged.successful else judged

    def _validate(self, changes: Sequence[RosParameter]) -> SetParametersResult:
        """Accept all changes of a request, or refuse all with the reason."""
        new = {change.name: change.value for change in changes if change.name in BY_NAME}
        try:
            Scenario.from_parameters({**self.values(), **new})
        except LieRigidBodyError as error:
            return refused(str(error))
        return SetParametersResult(successful=True)


def refused(reason: str) -> SetParametersResult:
    """The answer to a request that changes nothing."""
    return SetParametersResult(successful=False, reason=shortened(reason))


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """The description of a parameter for ROS, which ``ros2 param describe`` shows."""
    fixed = parameter.name in FIXED
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
    if name in FIXED:
        yield "fixed at the start"
    else:
        yield f"a change takes effect {'at once' if name in IMMEDIATE else 'at the next ~/reset'}"


def integers_as_doubles(changes: list[RosParameter]) -> list[RosParameter]:
    """Take an integer given for a double as that double, as in a parameter file."""
    return [_as_declared(change) for change in changes]


def _as_declared(change: RosParameter) -> RosParameter:
    parameter = BY_NAME.get(change.name)
    if parameter is None:
        return change
    if parameter.kind == "double" and change.type_ == RosParameter.Type.INTEGER:
        return RosParameter(change.name, RosParameter.Type.DOUBLE, float(change.value))
    if parameter.kind == "double_array" and change.type_ == RosParameter.Type.INTEGER_ARRAY:
        return RosParameter(change.name, RosParameter.Type.DOUBLE_ARRAY, [float(v) for v in change.value])
    return change


def overrides(node: Node) -> dict[str, object]:
    """All values that ROS arguments and files give the node, also under names that it does not declare."""
    with node.handle:
        overrides = node.handle.get_parameters(RosParameter)
    return {name: override.value for name, override in overrides.items() if not name.startswith(_OF_EVERY_NODE)}
