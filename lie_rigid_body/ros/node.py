"""The ROS node: publishers, parameters and services around a live run."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rclpy.node import Node
from std_srvs.srv import Trigger

from lie_rigid_body.parameter_file import NODE_NAME
from lie_rigid_body.ros.parameters import NodeParameters
from lie_rigid_body.ros.publisher import SamplePublisher
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Segment

Reset = Callable[[Scenario], Segment]


class SimulatorNode(Node):
    """What other nodes see of the simulation.

    Parameters
    ----------
    given : callable
        ``given(node_name, namespace)`` gives the parameters that come from elsewhere than ROS, which outdoes them.

    Attributes
    ----------
    parameters : NodeParameters
    publisher : SamplePublisher

    Raises
    ------
    LieRigidBodyError
        If the parameters make no scenario.
    """

    def __init__(self, given: Callable[[str, str], Mapping[str, object]]) -> None:
        super().__init__(NODE_NAME)
        self.parameters = NodeParameters(self, given(self.get_name(), self.get_namespace()))
        scenario = self.parameters.scenario()
        self.publisher = SamplePublisher(self, stamped_twist=scenario.stamped_twist)
        if self.get_parameter("use_sim_time").value:
            self.get_logger().warning("use_sim_time has no effect here: the samples follow a steady clock of this node")

    @property
    def reset_service(self) -> str:
        """Full name of the reset service."""
        return self.resolve_service_name("~/reset")

    def serve(self, reset: Reset) -> None:
        """Offer the services.

        Parameters
        ----------
        reset : callable
            Begins a new segment; may raise whatever goes wrong.
        """
        self._reset = reset
        self.create_service(Trigger, "~/reset", self._on_reset)

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            segment = self._reset(self.parameters.scenario())
        except Exception as error:
            response.success, response.message = False, str(error)
        else:
            response.success = True
            response.message = f"the sample stamped {segment.start_ns} ns begins the motion anew"
        return response
