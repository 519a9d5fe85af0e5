"""The node at work, seen from another process through a reset and a stall: nothing lost, nothing doubled, all true."""

from __future__ import annotations

import signal
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from broken_bag import stamps_in_whole_chunks
from mcap.reader import make_reader
from simulator_process import CATCHING_UP, RawClient, SimulatorProcess, assignments, eventually

from lie_rigid_body import ClosedForm, simulate
from lie_rigid_body.certificate import certify
from lie_rigid_body.lie import quaternion
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.simulation import Segment

if find_spec("rclpy"):
    from peer import Peer

pytestmark = pytest.mark.ros

PERIOD_NS = 5_000_000
STALL = 1.5
"""s; a node warns when it is later than 1 s."""
TOPICS = ("pose", "twist")


def recorded(path: Path) -> dict[str, list[bytes]]:
    found: dict[str, list[bytes]] = {topic: [] for topic in TOPICS}
    with path.open("rb") as stream:
        for _, channel, message in make_reader(stream).iter_messages([f"/{topic}" for topic in TOPICS]):
            found[channel.topic.removeprefix("/")].append(message.data)
    return found


def require_heard_as_recorded(seen: dict[str, list[bytes]], bag: Path) -> None:
    sent = recorded(bag)
    for topic in TOPICS:  # the client hears each from some sample on
        assert 100 < len(seen[topic]) <= len(sent[topic])
        assert seen[topic] == sent[topic][-len(seen[topic]) :], topic


@pytest.mark.slow
def test_a_kicked_and_carried_body_is_live_what_it_is_simulated(peer: Peer, tmp_path: Path) -> None:
    """Poses and twists as another process hears them, to the last bit; their bag is certified."""
    bag = tmp_path / "live.mcap"
    given: dict[str, Any] = {
        "kicks": [0.21, 1.0, -2.0, 0.5, 0.43, 0.0, 0.0, 0.0, 0.6, 0.1, 0.2, 3.0],
        "kick_period": 0.9,
        "translation": "carried",
        "initial_position": [1.0, -2.0, 0.5],
        "initial_velocity": [0.3, 0.0, -0.1],
        "sway_acceleration": [1.0, 2.0, 3.0],
        "vibration_acceleration": [2.0, 0.0, 1.0],
        "gyro_rate": "integrated",
        "imu_rate": 111.0,
        "accelerometer_lever_arm": [0.1, 0.0, 0.2],
        "rate": 200.0,
        "epoch_ns": 10**18,
    }
    live = assignments(record_path=bag, real_time_factor=5.0, paused="true", **given)
    with SimulatorProcess(*live) as simulator, RawClient(tmp_path / "seen", *TOPICS) as client:
        client.meet(lambda: peer.stamp("step"))
        assert peer.call("resume").success
        eventually(lambda: max(stamps_in_whole_chunks(bag), default=0) > 10**18 + 8 * 10**9, "samples of eight seconds")
        assert peer.call("pause").success
        last_ns = peer.stamp("step")
        seen = client.finish(dict.fromkeys(TOPICS, last_ns))
        assert simulator.end(signal.SIGINT) == 0
    run = simulate(duration=(last_ns - 10**18) / 1e9 + 0.001, **given)
    assert run.position is not None
    assert run.velocity is not None
    assert len(run.kicks.t_ns) > 25
    speed = quaternion.rotate(quaternion.conjugate(run.truth.attitude_xyzw), run.velocity)
    wanted = {
        "pose": np.concatenate([run.position, run.truth.attitude_xyzw], axis=1),
        "twist": np.concatenate([speed, run.truth.body_rate], axis=1),
    }
    for topic, numbers in wanted.items():
        width = 8 * numbers.shape[1]  # they come last in both messages
        assert len(seen[topic]) > 1000
        assert b"".join(message[-width:] for message in seen[topic]) == numbers[-len(seen[topic]) :].tobytes()
    certificate = certify(bag)
    assert certificate.passed, certificate.messages


@pytest.mark.slow
def test_without_a_limit_of_speed_a_client_loses_nothing(peer: Peer, tmp_path: Path) -> None:
    """The bytes are those of a headless recording: `test_live_faults`."""
    bag = tmp_path / "live.mcap"
    given = assignments(rate=1000.0, real_time_factor=0.0, paused="true", record_path=bag)
    with SimulatorProcess(*given) as simulator, RawClient(tmp_path / "seen", *TOPICS) as client:
        client.meet(lambda: peer.stamp("step"))
        size = bag.stat().st_size
        assert peer.call("resume").success
        eventually(lambda: bag.stat().st_size > size, "samples in the bag")
        seen = client.finish(dict.fromkeys(TOPICS, peer.stamp("pause") - 1_000_000))
        assert simulator.end(signal.SIGTERM) == 0
    require_heard_as_recorded(seen, bag)


def test_what_is_published_is_recorded_and_true(peer: Peer, tmp_path: Path) -> None:
    bag, start = tmp_path / "live.mcap", "[0.1, 0.5, -0.1, 0.854400374531753]"
    given = assignments(rate=200.0, record_path=bag, initial_attitude_xyzw=start)
    with SimulatorProcess(*given) as simulator, RawClient(tmp_path / "seen", *TOPICS) as client:
        client.meet(lambda: time.sleep(0.01))
        reset_ns = peer.stamp("reset")
        simulator.process.send_signal(signal.SIGSTOP)
        time.sleep(STALL)
        simulator.process.send_signal(signal.SIGCONT)
        eventually(lambda: any(CATCHING_UP in line for line in simulator.complained), "a word about the stall")
        eventually(lambda: max(stamps_in_whole_chunks(bag), default=0) > reset_ns + 2 * 10**9, "what was due meanwhile")
        assert peer.call("pause").success
        last_ns = peer.stamp("step")
        seen = client.finish(dict.fromkeys(TOPICS, last_ns))
        assert simulator.end(signal.SIGINT) == 0
    assert simulator.errors() == []
    require_heard_as_recorded(seen, bag)
    recording = read_bag(bag)
    stamps = recording.poses.stamps_ns
    assert stamps.tolist() == recording.twists.stamps_ns.tolist()
    assert set(np.diff(stamps).tolist()) == {PERIOD_NS}
    assert (stamps[-1], len(stamps)) == (last_ns, recording.expected_samples)
    first, second = (Segment.from_json(text) for _, text in recording.scenario_texts)
    assert second.start_ns == reset_ns
    [at] = np.flatnonzero(stamps == reset_ns)
    assert 0 < at < len(stamps) - 1
    attitudes, rates = recording.poses.values[:, 3:], recording.twists.values[:, 3:]
    for segment, part in ((first, slice(at)), (second, slice(at, None))):
        states = ClosedForm(segment.scenario.body(), segment.scenario.start()).at(stamps[part] - segment.start_ns)
        # a quaternion and its opposite are one rotation
        cosine = np.abs(np.sum(attitudes[part] * states.attitude_xyzw, axis=1))
        assert np.abs(cosine - 1.0).max() < 1e-14
        assert np.abs(rates[part] - states.body_rate).max() < 1e-10
    assert certify(bag).passed
