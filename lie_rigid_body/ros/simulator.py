"""The live node in its process: made, run, recorded, and ended in good order."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from functools import partial
from typing import Any

from lie_rigid_body import console
from lie_rigid_body.errors import BagError, ExistsError, InputError, ParameterError
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.messages.batch import POSE, SENSOR_TOPICS, TWIST
from lie_rigid_body.parameters import NS
from lie_rigid_body.ros.node import SimulatorNode
from lie_rigid_body.ros.publishing.announcement import announcement, farewell
from lie_rigid_body.ros.publishing.publisher import SCENARIO
from lie_rigid_body.ros.publishing.recorder import Recorder
from lie_rigid_body.ros.session import destroying, initialised, spinning
from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.ros.timing.lockstep import Lockstep
from lie_rigid_body.ros.timing.requests import Mailbox
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.wording import counted


def simulate(given: argparse.Namespace, interruption: Interruption) -> None:
    """Run the node of a command line until it is asked to end."""
    if interruption.requested:
        return
    with initialised(given.ros):
        node = SimulatorNode(partial(gather, given.scenario, given.params_file, given.assignments))
        values, scenario, mailbox = node.parameters.values(), node.parameters.scenario(), Mailbox()
        with (
            destroying(node),
            _started(scenario) as wall,
            spinning(node),
            _lockstep(node, values, mailbox) as lockstep,
            closing(node.publisher),
            _recording(node, values["record_path"], values["real_time_factor"]) as recorder,
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
def _lockstep(node: SimulatorNode, values: Mapping[str, Any], mailbox: Mailbox) -> Iterator[Lockstep | None]:
    """Lock-step with the filter of ``lockstep_topic``, whose answers go into the mailbox; None without a topic."""
    if not values["lockstep_topic"]:
        yield None
        return
    from lie_rigid_body.ros.answers import Answers  # which needs what reads bags

    given = values["lockstep_topic"], values["lockstep_nodes"]
    with closing(Answers(node, node.publisher.publishers, *given)) as answers:
        lockstep = Lockstep(answers.topic, answers.look, round(values["lockstep_timeout"] * NS))
        answers.hear = lambda stamp_ns, _: mailbox.post(partial(lockstep.hear, stamp_ns))
        yield lockstep


@contextmanager
def _recording(node: SimulatorNode, path: str, factor: float) -> Iterator[Recorder | None]:
    """Keep the bag of ``record_path`` open, and finish it whatever happens; None without a path.

    A run that goes as fast as possible, at a real-time factor of 0, waits for the disk. Others are not held up by it.

    Raises
    ------
    ParameterError
        If there can be no such bag.
    BagError
        At the end, if the bag could not be written to its end.
    """
    if not path:
        yield None
        return
    from lie_rigid_body.recording.bag_writer import BagWriter

    try:
        writer = BagWriter(
            path,
            stamped_twist=node.parameters.scenario().stamped_twist,
            wait_for_disk=not factor,
            pose_topic=node.names[POSE],
            twist_topic=node.names[TWIST],
            scenario_topic=node.names[SCENARIO],
            sensor_topics={topic: node.names[topic] for topic in SENSOR_TOPICS},
        )
    except ExistsError:
        kept = f"{path} exists and is kept: give another name, or move it away"
        raise ParameterError("record_path", kept) from None
    except BagError as error:
        raise ParameterError("record_path", str(error)) from None
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
