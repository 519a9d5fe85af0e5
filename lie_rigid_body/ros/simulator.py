"""The live node in its process: made, run, recorded, and ended in good order."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING

from lie_rigid_body import console
from lie_rigid_body.errors import BagError, InputError, ParameterError
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.messages.batch import sensor_topics
from lie_rigid_body.parameters import NS
from lie_rigid_body.ros.arguments import Arguments
from lie_rigid_body.ros.node import SimulatorNode
from lie_rigid_body.ros.publishing.announcement import Names, announcement, farewell
from lie_rigid_body.ros.publishing.recorder import Recorder
from lie_rigid_body.ros.session import destroying, initialised, spinning
from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.ros.timing.lockstep import Lockstep
from lie_rigid_body.ros.timing.requests import Mailbox
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.wording import counted

if TYPE_CHECKING:
    from lie_rigid_body.recording.bag_writer import BagWriter


def simulate(given: Arguments, interruption: Interruption) -> None:
    """Run the node of a command line until it is asked to end."""
    if interruption.requested:
        return
    with initialised(given.ros):
        node = SimulatorNode(partial(gather, given.scenario, given.params_files, given.assignments))
        path = str(node.parameters.values()["record_path"])
        with destroying(node), spinning(node), _finished(node), _recording(node, path) as recorder:
            _run(node, recorder, path, interruption)


def _run(node: SimulatorNode, recorder: Recorder | None, path: str, interruption: Interruption) -> None:
    scenario = node.parameters.scenario()
    values = node.parameters.values()
    mailbox, lockstep = Mailbox(), None
    if (answers := node.answers) is not None:
        lockstep = Lockstep(answers.topic, answers.look, round(values["lockstep_timeout"] * NS))
        answers.tell(lambda stamp_ns, _: mailbox.post(partial(lockstep.hear, stamp_ns)))
    run = LiveRun(
        Simulation(scenario),
        [*node.sinks, *([recorder] if recorder else [])],
        mailbox,
        interruption,
        wall=None if scenario.epoch_ns else time.time_ns,
        factor=values["real_time_factor"],
        paused=values["paused"],
        lockstep=lockstep,
    )
    node.serve(run)
    _say(announcement(scenario, _names(node, scenario), path))
    run.run()
    _say(farewell(node.get_fully_qualified_name(), run.punctuality))


@contextmanager
def _recording(node: SimulatorNode, path: str) -> Iterator[Recorder | None]:
    """Keep the bag of ``record_path`` open, and finish it whatever happens; None without a path.

    Raises
    ------
    BagError
        At the end, if the bag could not be written to its end.
    """
    if not path:
        yield None
        return
    with _open_bag(node, path) as bag:
        recorder = Recorder(bag, node.report_failure)
        yield recorder
    if recorder.failure is not None:
        raise recorder.failure
    _say(f"recorded {counted(bag.sample_count, 'sample')}; {console.how_to_certify(path)}")


def _open_bag(node: SimulatorNode, path: str) -> BagWriter:
    from lie_rigid_body.recording.bag_writer import BagWriter

    if os.path.lexists(path):
        raise ParameterError("record_path", f"{path} exists and is kept: give another name, or move it away")
    pose, twist, scenario = node.publisher.topics
    try:
        return BagWriter(
            path,
            stamped_twist=node.parameters.scenario().stamped_twist,
            wait_for_disk=False,
            pose_topic=pose,
            twist_topic=twist,
            scenario_topic=scenario,
            sensor_topics=node.publisher.sensor_topics,
        )
    except BagError as error:
        raise ParameterError("record_path", str(error)) from None


@contextmanager
def _finished(node: SimulatorNode) -> Iterator[None]:
    """Deliver the last samples and hear the last answers, also after a failed recording, before rclpy is shut down."""
    try:
        yield
    finally:
        node.publisher.finish()
        if node.answers is not None:
            node.answers.close()


def _names(node: SimulatorNode, scenario: Scenario) -> Names:
    pose, twist, latched = node.publisher.topics
    full_names, domain = node.publisher.sensor_topics, node.context.get_domain_id()
    sensors = tuple(full_names[topic] for topic in sensor_topics(scenario.sensors))
    return Names(
        node.get_fully_qualified_name(), pose, twist, latched, node.resolve_service_name("~/reset"), domain, sensors
    )


def _say(text: str) -> None:
    """Print, if the standard output is open: the node works without it."""
    with suppress(InputError):
        console.say(text)
