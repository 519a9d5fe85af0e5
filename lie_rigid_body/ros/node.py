"""The live node: its parameters, publishers and services; made, run, recorded, and ended in good order."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, nullcontext, suppress
from functools import partial
from typing import Any, Final

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter

from lie_rigid_body.foundation.errors import BagError, ExistsError, InputError, ParameterError
from lie_rigid_body.foundation.parameters import NS, Given
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.messages.batch import POSE, SENSOR_TOPICS, TWIST
from lie_rigid_body.ros.control.parameters import NodeParameters
from lie_rigid_body.ros.control.services import SIMULATION_INTERFACES, StandardServices, offer_triggers
from lie_rigid_body.ros.installation import is_installed
from lie_rigid_body.ros.publishing.announcement import announcement, farewell
from lie_rigid_body.ros.publishing.diagnostics import DIAGNOSTICS_TOPIC, Diagnostics
from lie_rigid_body.ros.publishing.publisher import CLOCK, PRIVATE_SCENARIO, SamplePublisher
from lie_rigid_body.ros.publishing.recorder import Recorder
from lie_rigid_body.ros.publishing.views import MARKERS_TOPIC, TF, TF_STATIC, Markers, Transforms
from lie_rigid_body.ros.session import (
    OF_EVERY_NODE,
    destroying,
    initialised,
    require_distinct,
    spinning,
    translated_errors,
)
from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.ros.timing.lockstep import Lockstep
from lie_rigid_body.ros.timing.requests import Mailbox
from lie_rigid_body.ros.timing.sink import Sink
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import NODE_NAME, gather
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system import console
from lie_rigid_body.system.interruption import Interruption

TOPICS: Final = (POSE, TWIST, PRIVATE_SCENARIO, CLOCK, TF, TF_STATIC, DIAGNOSTICS_TOPIC, MARKERS_TOPIC, *OF_EVERY_NODE)
"""The topics of the node beside its sensors', wanted or not: each has a type of its own, or means something else."""
SERVICES: Final = (
    *("~/reset", "~/pause", "~/resume", "~/step"),
    *("~/describe_parameters", "~/get_parameter_types", "~/get_parameters", "~/list_parameters", "~/set_parameters"),
    *("~/set_parameters_atomically", "~/get_type_description"),
)
"""The services of the node, those of every node among them, without the standard ones of simulators."""
LOOK_INTERVAL: Final = 25.0
"""Time between two looks for other nodes of the same name, s: a node that was killed is seen for 20 s more."""
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
    names : dict of str to str
        Full names of the topics and services, as remapped, by their relative names; of ``~``, the node.
    parameters : NodeParameters
    publisher : SamplePublisher
    sinks : list of Sink
        The publisher, and what publishes what is made of the samples.

    Raises
    ------
    LieRigidBodyError
        If the parameters are not valid, two topics have one name, or ROS refuses a topic.
    """

    def __init__(self, given: Callable[[str, str], Given]) -> None:
        with translated_errors("this node"):
            super().__init__(
                NODE_NAME, start_parameter_services=False, automatically_declare_parameters_from_overrides=True
            )
        try:
            self._furnish(given)
        except BaseException:
            self.destroy_node()
            raise

    def _furnish(self, given: Callable[[str, str], Given]) -> None:
        topics = {topic: self.resolve_topic_name(topic) for topic in (*TOPICS, *SENSOR_TOPICS)}
        services = {service: self.resolve_service_name(service) for service in SERVICES}
        require_distinct("topics", topics)
        require_distinct("services", services)
        self.names = {"~": self.get_fully_qualified_name(), **topics, **services}
        self.parameters = NodeParameters(self, given(self.get_name(), self.get_namespace()))
        scenario = self.parameters.scenario()
        values = self.parameters.values()
        in_lockstep = bool(values["lockstep_topic"])
        self.publisher = SamplePublisher(
            self,
            stamped_twist=scenario.stamped_twist,
            sensors=scenario.sensors,
            clock=values["publish_clock"] or in_lockstep,
            keep_all=values["real_time_factor"] == 0.0 or in_lockstep,
            imu_last=in_lockstep,
        )
        self._diagnostics = Diagnostics(self)
        self.sinks: list[Sink] = [self.publisher, self._diagnostics]
        if marker_rate := values["marker_rate"]:
            self.sinks.append(Markers(self, marker_rate))
        if values["publish_tf"] and is_installed("tf2_msgs"):
            self.sinks.append(Transforms(self, self.publisher))
        self._looks = 0
        self._look = self.create_timer(
            LOOK_INTERVAL, self._look_for_namesakes, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        if self.get_parameter("use_sim_time").value:
            self.get_logger().warning("use_sim_time has no effect here: the samples follow a steady clock of this node")
        for sentence in scenario.without_effect:
            self.get_logger().warning(sentence)

    def _look_for_namesakes(self) -> None:
        """Warn of another node of the same name, once those that were killed are forgotten."""
        self._looks += 1
        own = self.get_name(), self.get_namespace()
        found = self.get_node_names_and_namespaces().count(own) > 1
        if found:
            self.get_logger().warning(
                f"another node is called {self.names['~']}: requests may reach either; give one another name "
                "by -r __node:=NAME or -r __ns:=/NAMESPACE"
            )
        if found or self._looks == LOOKS:
            self._look.cancel()

    def report_failure(self, reason: str) -> None:
        """Say in the log and in diagnostics why the bag can no longer be written."""
        self.get_logger().error(f"{reason}; publishing goes on")
        self._diagnostics.report_failure(reason)

    def serve(self, run: LiveRun) -> None:
        """Offer the services, and let changes of the real-time factor take effect."""

        def change_factor(changes: list[Parameter]) -> None:
            for change in changes:
                if change.name == "real_time_factor":
                    run.ask(run.change_factor, change.value)

        self.add_post_set_parameters_callback(change_factor)
        offer_triggers(self, run, self.parameters.scenario)
        if is_installed(SIMULATION_INTERFACES):
            StandardServices(run, self.parameters.scenario, self.get_name()).offer(self)


def simulate(given: argparse.Namespace, interruption: Interruption) -> None:
    """Run the node of a command line until it is asked to end."""
    if interruption.requested:
        return
    with initialised(given.ros):
        node = SimulatorNode(partial(gather, given.scenario, given.params_file, given.assignments))
        values = node.parameters.values()
        scenario = node.parameters.scenario()
        mailbox = Mailbox()
        with (
            destroying(node),
            _started(scenario) as wall,
            spinning(node),
            _lockstep(node, values, mailbox) if values["lockstep_topic"] else nullcontext() as lockstep,
            closing(node.publisher),
            _recording(node, values) if values["record_path"] else nullcontext() as recorder,
        ):
            run = LiveRun(
                Simulation(scenario),
                [*node.sinks, *([recorder] if recorder else [])],
                mailbox,
                interruption,
                wall=wall,
                factor=values["real_time_factor"],
                paused=values["paused"],
                lockstep=lockstep,
                warn=node.get_logger().warning,
            )
            node.serve(run)
            _say(announcement(scenario, node.names, node.context.get_domain_id(), values["record_path"]))
            run.run()
            _say(farewell(node.names["~"], run.punctuality))


@contextmanager
def _started(scenario: Scenario) -> Iterator[Callable[[], int] | None]:
    """The time of day if that stamps the first sample, ns; a start without a stamp is refused before a bag is made."""
    wall = None if scenario.epoch_ns else time.time_ns
    first = Simulation(scenario, wall and wall())
    first.require_stamps(first.next_stamp_ns)
    yield wall


@contextmanager
def _lockstep(node: SimulatorNode, values: Mapping[str, Any], mailbox: Mailbox) -> Iterator[Lockstep]:
    """Lock-step with the filter of ``lockstep_topic``, whose answers go into the mailbox."""
    from lie_rigid_body.ros.answers import Answers  # which needs what reads bags

    given = values["lockstep_topic"], values["lockstep_nodes"]
    with closing(Answers(node, node.publisher.publishers, *given)) as answers:
        lockstep = Lockstep(answers.topic, answers.look, round(values["lockstep_timeout"] * NS))
        answers.hear = lambda stamp_ns, _: mailbox.post(partial(lockstep.hear, stamp_ns))
        yield lockstep


@contextmanager
def _recording(node: SimulatorNode, values: Mapping[str, Any]) -> Iterator[Recorder]:
    """Keep the bag of ``record_path`` open, and finish it whatever happens.

    A run that goes as fast as possible, at a real-time factor of 0, waits for the disk. Others are not held up by it.

    Raises
    ------
    ParameterError
        If there can be no such bag.
    BagError
        At the end, if the bag could not be written to its end.
    """
    from lie_rigid_body.recording.bag_writer import BagWriter

    path = values["record_path"]
    try:
        writer = BagWriter(
            path,
            stamped_twist=node.parameters.scenario().stamped_twist,
            wait_for_disk=not values["real_time_factor"],
            topics=node.names,
        )
    except BagError as error:
        kept = f"{path} exists and is kept: give another name, or move it away"
        raise ParameterError("record_path", kept if isinstance(error, ExistsError) else str(error)) from None
    with writer as bag:
        recorder = Recorder(bag, node.report_failure)
        yield recorder
    if recorder.failure is not None:
        raise recorder.failure
    remapped = (
        f"{topic}:={name}"
        for topic, name in bag.topics.items()
        if topic in SENSOR_TOPICS and not name.endswith(f"/{topic.removeprefix('~/')}")
    )
    names = "".join(f" --topic {console.quoted(remap)}" for remap in remapped)
    certify = f"; {console.how_to_certify(path)}{names}" if bag.sample_count else ""
    _say(f"recorded {counted(bag.sample_count, 'sample')}{certify}")


def _say(text: str) -> None:
    """Print, if the standard output is open: the node works without it."""
    with suppress(InputError):
        console.say(text)
