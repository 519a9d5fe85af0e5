"""The parameter services of the node, which answer every request to set parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.exceptions import ParameterNotDeclaredException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService

from lie_rigid_body.ros.control.parameters import refused
from lie_rigid_body.ros.timing.mailbox import ClosedError
from lie_rigid_body.scenario.parameter_table import BY_NAME
from lie_rigid_body.wording import suggestion

_TYPES: Final = frozenset(kind.value for kind in Parameter.Type)


class AnsweringParameterService(ParameterService):  # type: ignore[misc]
    """rclpy's parameter services, with an answer to what these do not understand.

    On a value of an unknown type rclpy's handler fails, and whoever asked waits for ever.

    Parameters
    ----------
    node : Node
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node)

    def _set_parameters_callback(
        self, request: SetParameters.Request, response: SetParameters.Response
    ) -> SetParameters.Response:
        response.results = [self._set([change]) for change in request.parameters]
        return response

    def _set_parameters_atomically_callback(
        self, request: SetParametersAtomically.Request, response: SetParametersAtomically.Response
    ) -> SetParametersAtomically.Response:
        response.result = self._set(request.parameters)
        return response

    def _set(self, changes: Sequence[ParameterMessage]) -> SetParametersResult:
        """Set all of them or none."""
        for change in changes:
            if change.value.type not in _TYPES:
                return refused(
                    f"{change.name}: type {change.value.type} is none of rcl_interfaces/ParameterType: give 0 to 9"
                )
        try:
            return self._get_node().set_parameters_atomically(list(map(Parameter.from_parameter_msg, changes)))
        except ParameterNotDeclaredException:
            node = self._get_node()
            unknown = next(change.name for change in changes if not node.has_parameter(change.name))
            return refused(f"{unknown}: no such parameter: {suggestion(unknown, BY_NAME, 'parameters')}")
        except ClosedError as error:  # what acts on the change has ended
            return refused(str(error))
