"""Nodes as estimators, each a real process in a domain of its own: started, played to in lock-step, ended."""

from __future__ import annotations

import importlib.util
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from simulator_process import eventually

from lie_rigid_body import Run, diagnose, simulate
from lie_rigid_body.estimates.programs import NodeEstimator, readings_of
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.messages.batch import SENSOR_TOPICS
from lie_rigid_body.runs.ensemble import BlindRun
from lie_rigid_body.testing import node_estimator

pytestmark = [pytest.mark.ros, pytest.mark.long]
SLOW = pytest.mark.slow
BEGIN_NS = 1_767_225_600 * 10**9
"""First stamp of a run that is played, ns."""
EXAMPLES = Path(__file__).parents[2] / "examples" / "complementary_filter"
EXAMPLE = shlex.join([sys.executable, str(EXAMPLES / "complementary_filter_node.py")])
NODE = """
import sys, time
import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from sensor_msgs.msg import Imu

def hear(reading):
    global count
    count += 1
    answer = kind()
    answer.header.stamp = reading.header.stamp
    if fill(answer, reading) is None:
        publisher.publish(answer)

count, kind = 0, Imu
{source}
rclpy.init()
node = rclpy.create_node("scripted")
publisher = node.create_publisher(kind, "imu/data", 10)
node.create_subscription(Imu, "imu/data_raw", hear, 10)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""

Scripted = Callable[..., NodeEstimator]


@pytest.fixture(scope="module")
def run() -> BlindRun:
    return BlindRun.without_truth(simulated(imu_rate=100.0, magnetometer_rate=100.0))


def simulated(**rates: Any) -> Run:
    given: Any = {"gyro_rate": "integrated", "accelerometer_mode": "pivot_gravity", "sensor_grade": "tactical"}
    return simulate("tumbling_cubesat", duration=2.0, **given, **rates)


@pytest.fixture
def scripted(tmp_path: Path) -> Scripted:
    def make(source: str, timeout: float = 60.0) -> NodeEstimator:
        script = tmp_path / "a node.py"
        script.write_text(NODE.replace("{source}", source))
        return node_estimator(shlex.join([sys.executable, str(script)]), timeout)

    return make


def function(run: Run) -> np.ndarray:
    """The filter of the example as a function."""
    spec = importlib.util.spec_from_file_location("complementary_filter", EXAMPLES / "complementary_filter.py")
    assert spec
    assert spec.loader
    module: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert run.imu
    assert run.magnetometer
    field = run.scenario.parameters()["magnetic_field"]
    found: np.ndarray = module.estimate(
        run.imu.t_ns, run.imu.gyro, run.imu.specific_force, run.magnetometer.field, field
    )
    return found


def with_field(run: Run) -> NodeEstimator:
    field: Any = run.scenario.parameters()["magnetic_field"]
    return node_estimator(f"{EXAMPLE} --ros-args -p world_field:='{list(field)}'".replace(", ", ","))


@pytest.mark.usefixtures("isolated_ros")
def test_a_node_gives_what_its_filter_gives_to_the_last_bit(run):
    """Also where several run at once, each in its domain."""
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(with_field(run), [run] * 2))
    for each in found:
        assert np.array_equal(each.t_ns, run.imu.t_ns)
        assert np.array_equal(each.attitude_xyzw, function(run))
        assert each.covariance is None


@pytest.mark.slow
@pytest.mark.usefixtures("isolated_ros")
def test_of_a_slower_magnetometer_the_pairs_are_answered():
    run = BlindRun.without_truth(simulated(imu_rate=100.0, magnetometer_rate=50.0))
    found = node_estimator(EXAMPLE)(run)
    assert run.magnetometer
    assert np.array_equal(found.t_ns, run.magnetometer.t_ns)


@pytest.mark.slow
@pytest.mark.usefixtures("isolated_ros")
def test_a_filter_may_begin_with_its_second_reading_and_tell_a_covariance(run, scripted):
    source = """
kind = PoseWithCovarianceStamped
def fill(answer, reading):
    answer.header.frame_id = "anywhere"
    answer.pose.pose.orientation.z = 0.6
    answer.pose.pose.orientation.w = 0.8
    answer.pose.covariance = [0.0] * 21 + [1.0, 0, 0, 0, 0, 0, 0, 2.0, 0, 0, 0, 0, 0, 0, 3.0]
    return False if count == 1 else None
"""
    found = scripted(source)(run)
    assert np.array_equal(found.t_ns, run.imu.t_ns[1:])
    np.testing.assert_array_equal(found.attitude_xyzw, np.tile([0.0, 0.0, 0.6, 0.8], (len(found), 1)))
    np.testing.assert_array_equal(found.covariance[0], np.diag([1.0, 2.0, 3.0]))


@pytest.mark.usefixtures("isolated_ros")
def test_a_node_hears_readings_and_nothing_of_the_truth(run, scripted):
    source = """
def fill(answer, reading):
    topics = sorted(name for name, _ in node.get_topic_names_and_types())
    if topics != ["/clock", "/imu/data", "/imu/data_raw", "/imu/mag", "/parameter_events", "/rosout"]:
        sys.exit(f"there are {topics}")
    answer.orientation.w = 1.0
"""
    assert len(scripted(source)(run)) == len(run.imu.t_ns)


def test_messages_are_of_the_first_topic_of_each_sensor_and_the_imus_come_last(run):
    readings = readings_of(run)
    assert [(each.sensor, each.arrival_ns) for each in readings[:2]] == [("magnetometer", BEGIN_NS), ("imu", BEGIN_NS)]
    assert {each.sensor for each in readings} == {"imu", "magnetometer"}
    assert len(readings) == 2 * len(run.imu.t_ns)
    assert "imu/bias" in SENSOR_TOPICS  # which is the truth


SILENT = "def fill(answer, reading): time.sleep(100)"
UNKNOWN = "def fill(answer, reading): answer.orientation_covariance[0] = -1.0"
ODOMETRY = """
kind = Odometry
def fill(answer, reading):
    answer.header.frame_id, answer.child_frame_id = "odom", "base_footprint"
    answer.pose.pose.orientation.w = 1.0
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "timeout", "told"),
    [
        ("sys.exit('the gain is missing')", 60.0, [" 1", "the gain is missing"]),
        pytest.param("def fill(answer, reading): sys.exit(3 if count == 2 else None)", 60.0, ["ended "], marks=SLOW),
        pytest.param(SILENT, 300.0, [f" {BEGIN_NS + 90_000_000} ns in 10 s"], marks=SLOW),
        pytest.param("time.sleep(1000)", 12.0, [" 6 s: ", " /imu/data "], marks=SLOW),
        pytest.param("kind = TwistStamped", 60.0, ["/imu/data ", " TwistStamped"], marks=SLOW),
        pytest.param(ODOMETRY, 60.0, ["odom to base_footprint", "world to base_link"], marks=SLOW),
        pytest.param(UNKNOWN, 60.0, ["orientation"], marks=SLOW),
    ],
)
@pytest.mark.usefixtures("isolated_ros")
def test_what_goes_wrong_is_one_line(source, timeout, told, run, scripted):
    with pytest.raises(InputError) as error:
        scripted(source, timeout)(run)
    line = str(error.value)
    assert line.startswith("node ")
    assert "\n" not in line
    assert [part for part in told if part not in line] == []


@pytest.mark.usefixtures("isolated_ros")
@pytest.mark.parametrize("command", ["/no/such/node", ""])
def test_a_command_that_cannot_be_started_is_refused(command, run):
    with pytest.raises(InputError):
        node_estimator(command)(run)


def test_a_run_without_an_imu_is_refused():
    run = BlindRun.without_truth(simulate(duration=1.0, magnetometer_rate=10.0))
    with pytest.raises(InputError, match="imu_rate"):
        node_estimator(EXAMPLE)(run)


@pytest.mark.slow
@pytest.mark.usefixtures("isolated_ros")
@pytest.mark.parametrize("by", [signal.SIGKILL, signal.SIGINT])
def test_the_node_ends_with_who_asked_for_it(tmp_path, scripted, by):
    born, folder = tmp_path / "pid", tmp_path / "temporary"
    folder.mkdir()
    estimate = scripted(f"import os; open({str(born)!r}, 'w').write(str(os.getpid()))\n{SILENT}")
    script = (
        "from lie_rigid_body import simulate; from lie_rigid_body.testing import node_estimator\n"
        f"node_estimator({estimate.command!r})(simulate(duration=1.0, imu_rate=100.0))"
    )
    with subprocess.Popen([sys.executable, "-c", script], env={**os.environ, "TMPDIR": str(folder)}) as asking:
        eventually(lambda: born.exists() and born.read_text() != "", "a node")
        asking.send_signal(by)
    eventually(lambda: not Path(f"/proc/{born.read_text()}").exists(), "its end")
    left = [path.name for path in folder.iterdir() if path.suffix != ".lock"]
    assert left == [] or by == signal.SIGKILL


@pytest.mark.slow
@pytest.mark.usefixtures("isolated_ros")
def test_a_node_is_diagnosed(run):
    found = diagnose(with_field(run), max_runs=1, imu_rate=40.0, magnetometer_rate=40.0)
    assert found.mistakes == ()
    assert {"follows", "gyro_bias", "needs_rest"} <= {probe.code for probe in found.probes if probe.passed}
    assert not {"converges", "long_run"} & {probe.code for probe in found.probes}
    assert len(found.remarks) > 0
    assert os.environ.get("ROS_DOMAIN_ID") is not None


@SLOW
def test_a_log_is_played_to_a_node_with_its_own_stamps_twice_the_same(tmp_path: Path) -> None:
    """A log of this year: its stamps are times of day already."""
    true = simulated(imu_rate=100.0, magnetometer_rate=100.0)
    assert true.magnetometer is not None
    today_ns = 1_790_000_000 * 10**9
    field = (true.magnetometer.t_ns + today_ns, true.magnetometer.field)
    log = Run.from_arrays(true.imu.t_ns + today_ns, true.imu.gyro, true.imu.specific_force, field)
    estimator = NodeEstimator(EXAMPLE, 60.0)
    first, second = estimator(log), estimator(log)
    assert first.t_ns is not None
    assert set(first.t_ns.tolist()) <= set(log.imu.t_ns.tolist())
    assert np.array_equal(first.attitude_xyzw, second.attitude_xyzw)
    simulated_answer = estimator(BlindRun.without_truth(true))
    assert np.array_equal(first.attitude_xyzw, simulated_answer.attitude_xyzw)


def test_a_middleware_without_domains_of_its_own_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    from lie_rigid_body.estimates.programs import NodeEstimator
    from lie_rigid_body.ros import play, session

    monkeypatch.setattr(session, "get_rmw_implementation_identifier", lambda: session.ZENOH)
    for name in ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOG_DIR"):  # which it sets in its own process
        monkeypatch.setenv(name, os.environ.get(name, ""))
    monkeypatch.setattr(play, "require_ros", lambda: None)
    said = play.played(NodeEstimator("true", 1.0), [])
    assert isinstance(said, str)
    assert "DDS" in said
