"""The ROS node: publishers, parameters and services around a live run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.node import Node

from lie_rigid_body.ros import standard_services
from lie_rigid_body.ros.diagnostics import Diagnostics
from lie_rigid_body.ros.markers import Markers
from lie_rigid_body.ros.outlet import Outlet
from lie_rigid_body.ros.parameters import NodeParameters
from lie_rigid_body.ros.publisher import SamplePublisher
from lie_rigid_body.ros.run_control import RunControl
from lie_rigid_body.ros.services import Services
from lie_rigid_body.ros.standard_control import StandardControl
from lie_rigid_body.ros.transforms import Transforms
from lie_rigid_body.scenario.parameter_file import NODE_NAME


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
        scenario, held = self.parameters.scenario(), self.parameters.held()
        self.publisher = SamplePublisher(
            self,
            stamped_twist=scenario.stamped_twist,
            sensors=scenario.sensors,
            clock=held["publish_clock"],
            unhurried=held["real_time_factor"] == 0.0,
        )
        self.publisher.follow(held["real_time_factor"])
        self._views = self._make_views(held)
        if self.get_parameter("use_sim_time").value:
            self.get_logger().warning("use_sim_time has no effect here: the samples follow a steady clock of this node")

    def _make_views(self, held: Mapping[str, Any]) -> list[Outlet]:
        views: list[Outlet] = [Diagnostics(self)]
        if marker_rate := held["marker_rate"]:
            views.append(Markers(self, marker_rate))
        if held["publish_tf"] and Transforms.is_available():
            views.append(Transforms(self))
        return views

    @property
    def outlets(self) -> list[Outlet]:
        """Where the samples go."""
        return [self.publisher, *self._views]

    @property
    def reset_service(self) -> str:
        """Full name of the reset service."""
        return self.resolve_service_name("~/reset")

    def serve(self, control: RunControl) -> None:
        """Offer the services, and let parameters act that do so at once."""
        self.parameters.act(self._follow(control))
        Services(control, self.parameters.scenario).offer(self)
        if standard_services.is_available():
            standard = StandardControl(control, self.parameters.scenario, self.get_name())
            self._standard = standard_services.StandardServices(standard)
            self._standard.offer(self)

    def _follow(self, control: RunControl) -> Callable[[Mapping[str, Any]], None]:
        def act(changed: Mapping[str, Any]) -> None:
            if "real_time_factor" in changed:
                factor = float(changed["real_time_factor"])
                control.change_factor(factor)
                self.publisher.follow(factor)

        return act
