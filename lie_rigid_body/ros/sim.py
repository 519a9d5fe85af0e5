"""``sim``: the live node."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from lie_rigid_body import console
from lie_rigid_body.errors import BagError, InputError, ParameterError
from lie_rigid_body.interruption import Interruption
from lie_rigid_body.ros.arguments import Arguments, parse
from lie_rigid_body.wording import counted

if TYPE_CHECKING:
    from lie_rigid_body.recording.bag_writer import BagWriter
    from lie_rigid_body.ros.node import SimulatorNode
    from lie_rigid_body.ros.publishing.announcement import Names
    from lie_rigid_body.ros.publishing.recorder import Recorder
    from lie_rigid_body.scenario import Scenario

REQUIRED_PACKAGES: Final = (
    *("rclpy", "rcl_interfaces", "rosgraph_msgs", "std_msgs", "std_srvs"),
    *("geometry_msgs", "sensor_msgs", "diagnostic_msgs", "visualization_msgs"),
)


@console.run
def main(argv: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT, SIGTERM or SIGHUP.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.

    Returns
    -------
    int
        Exit status: 0 when asked to end, 2 when the input is unusable or the bag could not be written to its end.
    """
    given = parse(sys.argv[1:] if argv is None else argv)
    require_ros()
    _require_readable(given)
    with Interruption.until_exit() as interruption:
        _simulate(given, interruption)
    return console.SUCCESS


def require_ros() -> None:
    """Check that ROS 2 is installed.

    Raises
    ------
    InputError
        Naming the first package that is missing.
    """
    missing = [name for name in REQUIRED_PACKAGES if not _is_installed(name)]
    if missing:
        raise InputError(
            f"{missing[0]} is not installed: source /opt/ros/jazzy/setup.bash; without it, on Python 3.12, "
            "pip install '.[ros]'; or use 'record'"
        )


def _is_installed(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ValueError:  # None in sys.modules
        return False


def _require_readable(given: Arguments) -> None:
    """Check parameters given as ROS arguments, whose errors rclpy reports less clearly."""
    from lie_rigid_body.scenario.parameter_file import parse_assignment, read_sections

    for path in given.ros_params_files:
        read_sections(path, pipes=False)
    for text in given.ros_assignments:
        parse_assignment(text)


def _simulate(given: Arguments, interruption: Interruption) -> None:
    from lie_rigid_body.ros.node import SimulatorNode
    from lie_rigid_body.ros.session import destroying, initialised, spinning
    from lie_rigid_body.scenario.parameter_file import gather

    if interruption.requested:
        return
    with initialised(given.ros):
        node = SimulatorNode(partial(gather, given.scenario, given.params_files, given.assignments))
        path = str(node.parameters.values()["record_path"])
        with destroying(node), spinning(node), _finished(node), _recording(node, path) as recorder:
            _run(node, recorder, path, interruption)


def _run(node: SimulatorNode, recorder: Recorder | None, path: str, interruption: Interruption) -> None:
    from lie_rigid_body.ros.publishing.announcement import announcement, farewell
    from lie_rigid_body.ros.timing.live_run import LiveRun
    from lie_rigid_body.ros.timing.mailbox import Mailbox
    from lie_rigid_body.simulation import Simulation

    scenario = node.parameters.scenario()
    mailbox = Mailbox()
    values = node.parameters.values()
    run = LiveRun(
        Simulation(scenario),
        [*node.sinks, *([recorder] if recorder else [])],
        mailbox,
        interruption,
        wall=None if scenario.epoch_ns else time.time_ns,
        factor=values["real_time_factor"],
        paused=values["paused"],
    )
    node.serve(run)
    _say(announcement(scenario, _names(node, scenario), path))
    try:
        run.run()
    finally:
        mailbox.close()
    _say(farewell(node.get_fully_qualified_name(), run.punctuality))


@contextmanager
def _recording(node: SimulatorNode, path: str) -> Iterator[Recorder | None]:
    """Keep the bag of ``record_path`` open, and finish it whatever happens; None without a path.

    Raises
    ------
    BagError
        At the end, if the bag could not be written to its end.
    """
    from lie_rigid_body.ros.publishing.recorder import Recorder

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
    """Deliver the last samples at the end, also after a recording that failed, before rclpy is shut down."""
    try:
        yield
    finally:
        node.publisher.finish()


def _names(node: SimulatorNode, scenario: Scenario) -> Names:
    from lie_rigid_body.messages.batch import sensor_topics
    from lie_rigid_body.ros.publishing.announcement import Names

    pose, twist, latched = node.publisher.topics
    full_names, domain = node.publisher.sensor_topics, node.context.get_domain_id()
    sensors = tuple(full_names[topic] for topic in sensor_topics(scenario.sensors))
    return Names(node.get_fully_qualified_name(), pose, twist, latched, node.reset_service, domain, sensors)


def _say(text: str) -> None:
    """Print, if the standard output is open: the node works without it."""
    with suppress(InputError):
        console.say(text)
