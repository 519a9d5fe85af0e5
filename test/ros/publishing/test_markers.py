"""The picture of the body: a box with the body's own moments, drawn only while somebody looks."""

from __future__ import annotations

from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.ros.timing.sink import Punctuality
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

if find_spec("rclpy"):
    from visualization_msgs.msg import Marker

    from lie_rigid_body.ros.publishing.views import Markers

pytestmark = pytest.mark.ros

NS = 1_000_000_000
INERTIA = [1.0, 0.1, -0.05, 1.4, 0.2, 1.9]
MATRIX = np.array([[1.0, 0.1, -0.05], [0.1, 1.4, 0.2], [-0.05, 0.2, 1.9]])


@pytest.fixture
def publisher() -> Any:
    """A publisher without a network."""
    made = SimpleNamespace(lookers=0, published=[])
    made.publish = made.published.append
    made.get_subscription_count = lambda: made.lookers
    return made


@pytest.fixture
def markers(publisher: Any) -> Markers:
    node: Any = SimpleNamespace(create_publisher=lambda kind, topic, qos: publisher)
    return Markers(node, 20.0)


START = {"initial_body_rate": [0.7, -1.3, 0.4], "initial_attitude_xyzw": [0.5, -0.5, 0.5, 0.5]}
SCENARIO = Scenario.from_parameters({"motion": "closed_form", "inertia": INERTIA, "world_frame": "map", **START})


def feed(markers: Markers, simulation: Simulation, count: int) -> None:
    taken = simulation.take_until(simulation.clock.stamp_ns(simulation.next_sample + count - 1), 10**6)
    markers.write(BatchEncoder(SCENARIO).encode(taken))


def test_nothing_is_drawn_unless_somebody_looks(markers: Markers, publisher: Any) -> None:
    simulation = Simulation(SCENARIO, NS)
    markers.begin_segment(simulation.segment)
    markers.tick(0, Punctuality())
    feed(markers, simulation, 1)
    for k in range(10):
        markers.tick(k * NS, Punctuality())
    assert publisher.published == []
    publisher.lookers = 1
    for steady_ns in range(10 * NS, 11 * NS, NS // 100):
        wait = markers.tick(steady_ns, Punctuality())
        assert 0 < wait <= NS // 20
    assert len(publisher.published) == 20


def test_the_picture_is_of_the_latest_state_in_the_world(markers: Markers, publisher: Any) -> None:
    simulation = Simulation(SCENARIO, NS)
    markers.begin_segment(simulation.segment)
    publisher.lookers = 1
    feed(markers, simulation, 50)
    markers.tick(0, Punctuality())
    [picture] = publisher.published
    box, momentum, rate, trail = picture.markers
    assert [m.type for m in picture.markers] == [Marker.CUBE, Marker.ARROW, Marker.ARROW, Marker.LINE_STRIP]
    assert {(m.header.frame_id, m.header.stamp.sec, m.header.stamp.nanosec) for m in picture.markers} == {
        ("map", 1, 490_000_000)
    }
    state = SCENARIO.make_motion().at(np.array([490_000_000]))[0]
    # copied, as SciPy 1.17 takes no read-only arrays where NumPy is 1.26
    turn = Rotation.from_quat(state.attitude_xyzw.copy())
    require_parallel(rate.points[1], turn.apply(state.body_rate.copy()))
    require_parallel(momentum.points[1], turn.apply(MATRIX @ state.body_rate))
    # the box lies along the principal axes: the inertia of a box of its sides, turned with it, is the body's
    q = box.pose.orientation
    axes = (turn.inv() * Rotation.from_quat([q.x, q.y, q.z, q.w])).as_matrix()
    a, b, c = box.scale.x, box.scale.y, box.scale.z
    inertia = axes @ np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) @ axes.T
    np.testing.assert_allclose(inertia / np.trace(inertia), MATRIX / np.trace(MATRIX), rtol=0, atol=1e-12)
    q = trail.pose.orientation
    point = trail.points[-1]
    require_parallel(point, state.body_rate)
    np.testing.assert_allclose([q.x, q.y, q.z, q.w], state.attitude_xyzw, rtol=0, atol=1e-15)


def test_a_kick_begins_a_new_polhode_and_arrows_go_with_the_body(markers: Markers, publisher: Any) -> None:
    """The longest is that of the arc of the largest momentum, which is conserved; a body at rest has none."""
    kicks = [1.0, *[0.0] * 3, 2.0, *[0.0, 3.0, 4.0]]
    moving = {"translation": "thrown", "initial_position": [5.0, 6.0, 7.0], "gravity": 0.0}
    scenario = Scenario.from_parameters(
        {**SCENARIO.parameters(), **moving, "kicks": kicks, "initial_velocity": [1, 0, 0]}
    )
    simulation = Simulation(scenario, NS)
    markers.begin_segment(simulation.segment)
    publisher.lookers = 1
    for k in range(25):  # ten times a second
        feed(markers, simulation, 10)
        markers.tick(k * NS, Punctuality())
    trails = [len(picture.markers[3].points) for picture in publisher.published]
    assert trails == [*range(1, 11), *range(1, 11), *range(1, 6)]
    first, last = (np.linalg.norm(MATRIX @ rate) for rate in (START["initial_body_rate"], kicks[-3:]))
    for k, length in ((5, first / last), (15, 0.0), (22, 1.0)):
        box, momentum, rate, trail = publisher.published[k].markers
        place = [5.0 + 0.1 * k + 0.09, 6.0, 7.0]
        tail, tip = (np.array([point.x, point.y, point.z]) for point in momentum.points)
        assert np.linalg.norm(tip - tail) == pytest.approx(length, abs=1e-12)
        for point in (rate.points[0], momentum.points[0], box.pose.position, trail.pose.position):
            np.testing.assert_allclose([point.x, point.y, point.z], place, rtol=0, atol=1e-12)


def require_parallel(point: Any, vector: np.ndarray) -> None:
    found = np.array([point.x, point.y, point.z])
    np.testing.assert_allclose(found / np.linalg.norm(found), vector / np.linalg.norm(vector), rtol=0, atol=1e-12)
