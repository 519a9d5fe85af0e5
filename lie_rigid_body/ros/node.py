"""The ROS node: parameters, publishers and services of a live run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import combinations
from typing import Any, Final

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter

from lie_rigid_body.errors import InputError
from lie_rigid_body.messages.batch import POSE, SENSOR_TOPICS, TWIST
from lie_rigid_body.ros.control import standard_services
from lie_rigid_body.ros.control.parameter_service import AnsweringParameterService
from lie_rigid_body.ros.control.parameters import NodeParameters
from lie_rigid_body.ros.control.run_control import RunControl
from lie_rigid_body.ros.control.services import Services
from lie_rigid_body.ros.control.standard_control import StandardControl
from lie_rigid_body.ros.publishing import diagnostics, markers
from lie_rigid_body.ros.publishing.diagnostics import Diagnostics
from lie_rigid_body.ros.publishing.markers import Markers
from lie_rigid_body.ros.publishing.publisher import CLOCK, SCENARIO, SamplePublisher
from lie_rigid_body.ros.publishing.transforms import TF, Transforms
from lie_rigid_body.ros.session import translated_errors
from lie_rigid_body.ros.timing.sink import Sink
from lie_rigid_body.scenario.parameter_file import NODE_NAME

OF_EVERY_NODE: Final = ("/rosout", "/parameter_events")
TOPICS: Final = (POSE, TWIST, SCENARIO, CLOCK, TF, diagnostics.TOPIC, markers.TOPIC, *OF_EVERY_NODE)
"""The topics of the node beside its sensors', wanted or not: each has a type of its own, or means something else."""
SERVICES: Final = (
    *("~/reset", "~/pause", "~/resume", "~/step"),
    *("~/describe_parameters", "~/get_parameter_types", "~/get_parameters", "~/list_parameters", "~/set_parameters"),
    *("~/set_parameters_atomically", "~/get_type_description"),
)
"""The services of the node, those of every node among them, without the standard ones of simulators."""
LOOK_INTERVAL: Final = 25.0
"""Time between two looks for other nodes of the same name, s: one that was killed is seen for 20 s more."""
LOOKS: Final = 2


class SimulatorNode(Node):
    """The node of a live run. It publishes from the start, and offers its services once `serve` is called.

    Parameters
    ----------
    given : callable
        ``given(node_name, namespace)`` returns the parameters of the node's own command line; those of ROS arguments
        win over them.

    Attributes
    ----------
    parameters : NodeParameters
    publisher : SamplePublisher

    Raises
    ------
    LieRigidBodyError
        If the parameters are not valid, two topics have one name, or ROS refuses a topic.
    """

    def __init__(self, given: Callable[[str, str], Mapping[str, object]]) -> None:
        with translated_errors("this node"):
            super().__init__(NODE_NAME, start_parameter_services=False)
        try:
            self._furnish(given)
        except BaseException:
            self.destroy_node()
            raise

    def _furnish(self, given: Callable[[str, str], Mapping[str, object]]) -> None:
        _require_distinct("topics", {topic: self.resolve_topic_name(topic) for topic in (*TOPICS, *SENSOR_TOPICS)})
        _require_distinct("services", {service: self.resolve_service_name(service) for service in SERVICES})
        self.parameters = NodeParameters(self, given(self.get_name(), self.get_namespace()))
        self._answers = AnsweringParameterService(self)
        scenario, values = self.parameters.scenario(), self.parameters.values()
        self.publisher = SamplePublisher(
            self,
            stamped_twist=scenario.stamped_twist,
            sensors=scenario.sensors,
            clock=values["publish_clock"],
            keep_all=values["real_time_factor"] == 0.0,
        )
        self.publisher.set_factor(values["real_time_factor"])
        self._diagnostics = Diagnostics(self)
        self._views = self._make_views(values)
        self._looks = 0
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._look = self.create_timer(LOOK_INTERVAL, self._look_for_namesakes, clock=steady)
        if self.get_parameter("use_sim_time").value:
            self.get_logger().warning("use_sim_time has no effect here: the samples follow a steady clock of this node")
        if scenario.without_effect:
            self.get_logger().warning(scenario.without_effect)

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """As rclpy does, but what is refused is told as everywhere in the package: value, limit and remedy."""
        return self.parameters.refusal(parameter_list) or super().set_parameters_atomically(parameter_list)

    def _look_for_namesakes(self) -> None:
        """Warn of another node of the same name, once those that were killed are forgotten."""
        self._looks += 1
        own = self.get_name(), self.get_namespace()
        found = self.get_node_names_and_namespaces().count(own) > 1
        if found:
            name = self.get_fully_qualified_name()
            self.get_logger().warning(
                f"another node is called {name}: requests may reach either; give one another name "
                "by -r __node:=NAME or -r __ns:=/NAMESPACE"
            )
        if found or self._looks == LOOKS:
            self._look.cancel()

    def _make_views(self, values: Mapping[str, Any]) -> list[Sink]:
        views: list[Sink] = [self._diagnostics]
        if marker_rate := values["marker_rate"]:
            views.append(Markers(self, marker_rate))
        if values["publish_tf"] and Transforms.is_available():
            views.append(Transforms(self))
        return views

    @property
    def sinks(self) -> list[Sink]:
        """The sinks that publish samples or what is made of them."""
        return [self.publisher, *self._views]

    def report_failure(self, reason: str) -> None:
        """Say in the log and in diagnostics why the bag can no longer be written."""
        self.get_logger().error(f"{reason}; publishing goes on")
        self._diagnostics.report_failure(reason)

    @property
    def reset_service(self) -> str:
        """Full name of the reset service, as remapped."""
        return self.resolve_service_name("~/reset")

    def serve(self, control: RunControl) -> None:
        """Offer the services, and let changes of the real-time factor take effect."""
        self.parameters.on_change(self._change_factor(control))
        Services(control, self.parameters.scenario).offer(self)
        if standard_services.is_available():
            standard = StandardControl(control, self.parameters.scenario, self.get_name())
            self._standard = standard_services.StandardServices(standard)
            self._standard.offer(self)

    def _change_factor(self, control: RunControl) -> Callable[[Mapping[str, Any]], None]:
        def act(changed: Mapping[str, Any]) -> None:
            if "real_time_factor" in changed:
                factor = float(changed["real_time_factor"])
                control.change_factor(factor)
                self.publisher.set_factor(factor)

        return act


def _require_distinct(kind: str, full_names: Mapping[str, str]) -> None:
    """Refuse two topics, or services, of one name: some middlewares do if their types differ, others take both."""
    for (one, its_name), (other, other_name) in combinations(full_names.items(), 2):
        if its_name == other_name:
            raise InputError(f"the {kind} {one} and {other} would both be {its_name}: give each a name of its own")
