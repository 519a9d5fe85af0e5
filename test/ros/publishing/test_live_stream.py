"""The node at work, seen from another process: nothing lost, nothing doubled, all of it true."""

from __future__ import annotations

import json
import re
import signal
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from simulator_process import CATCHING_UP, SimulatorProcess, eventually, finish_client, start_client, without_lateness

from lie_rigid_body import ClosedForm
from lie_rigid_body.cli.check import main as check
from lie_rigid_body.recording.bag_reader import Recording, read_bag
from lie_rigid_body.simulation import Segment

pytestmark = pytest.mark.ros

RATE = 200
PERIOD_NS = 5_000_000
STALL = 1.5
"""s; a node warns when it is later than 1 s."""
COUNTS = {"reset": 250, "stalled": 450}


@dataclass
class Run:
    """What a client received, and how the node ended."""

    seen: dict[str, np.ndarray]
    status: int
    bag: Path
    complained: list[str]

    @property
    def segments(self) -> list[Segment]:
        return [Segment.from_json(str(text)) for text in self.seen["scenarios"]]

    @property
    def recording(self) -> Recording:
        return read_bag(self.bag)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Run]]:
    """Two nodes side by side: one with a reset, ended by SIGINT; one that stalls, ended by SIGTERM."""
    folder = tmp_path_factory.mktemp("live")
    arguments = {
        name: [
            *("-p", f"rate:={RATE}", "-p", f"record_path:={folder / name}.mcap"),
            *("-p", "initial_attitude_xyzw:=[0.1, 0.5, -0.1, 0.854400374531753]"),
            *("--ros-args", "-r", f"__ns:=/{name}"),
        ]
        for name in COUNTS
    }
    with (
        SimulatorProcess(*arguments["reset"]) as reset,
        SimulatorProcess(*arguments["stalled"]) as stalled,
    ):
        clients = [
            start_client(str(folder / "reset.npz"), "/reset", str(COUNTS["reset"]), "100"),
            start_client(str(folder / "stalled.npz"), "/stalled", str(COUNTS["stalled"]), "0"),
        ]
        eventually((folder / "stalled.npz.receiving").exists, "a client that receives")
        stalled.process.send_signal(signal.SIGSTOP)
        time.sleep(STALL)
        stalled.process.send_signal(signal.SIGCONT)
        for client in clients:
            finish_client(client)
        yield {
            "reset": ended(reset, folder / "reset", signal.SIGINT),
            "stalled": ended(stalled, folder / "stalled", signal.SIGTERM),
        }


def ended(simulator: SimulatorProcess, path: Path, number: signal.Signals) -> Run:
    status = simulator.end(number)
    with np.load(path.with_suffix(".npz")) as seen:
        return Run(dict(seen), status, path.with_suffix(".mcap"), simulator.complained)


both = pytest.mark.parametrize("name", list(COUNTS))


@both
def test_no_stamp_is_lost_or_doubled(runs: dict[str, Run], name: str) -> None:
    seen = runs[name].seen
    for topic in ("pose_stamps_ns", "twist_stamps_ns"):
        assert set(np.diff(seen[topic]).tolist()) == {PERIOD_NS}
    assert len(seen["pose_stamps_ns"]) >= COUNTS[name]


@both
def test_pose_and_twist_carry_the_same_stamps(runs: dict[str, Run], name: str) -> None:
    seen = runs[name].seen
    # the two subscriptions may have begun at different samples
    poses, twists = seen["pose_stamps_ns"], seen["twist_stamps_ns"]
    first = max(poses[0], twists[0])
    count = min((poses >= first).sum(), (twists >= first).sum())
    assert np.array_equal(poses[poses >= first][:count], twists[twists >= first][:count])


def test_reset_returns_to_the_start_while_stamps_go_on(runs: dict[str, Run]) -> None:
    run = runs["reset"]
    first, second = run.segments
    [answer] = run.seen["answers"]
    assert re.match(rf"True .*\b{second.start_ns}\b", str(answer))
    stamps = run.seen["pose_stamps_ns"]
    [at] = np.flatnonzero(stamps == second.start_ns)
    assert 0 < at < len(stamps) - 1
    assert first.start_ns < second.start_ns
    assert np.array_equal(run.seen["attitudes_xyzw"][at], second.scenario.start().attitude_xyzw)
    assert np.abs(run.seen["attitudes_xyzw"][at] - run.seen["attitudes_xyzw"][at - 1]).max() > 1e-3


@both
def test_published_states_are_the_closed_form_at_their_stamps(runs: dict[str, Run], name: str) -> None:
    run = runs[name]
    seen, segments = run.seen, run.segments
    assert segments[0].scenario.motion == "moving_chart"
    ends = [*(segment.start_ns for segment in segments[1:]), 2**62]
    for segment, end in zip(segments, ends, strict=True):
        truth = ClosedForm(segment.scenario.body(), segment.scenario.start())
        for stamps, values, field in (
            ("pose_stamps_ns", "attitudes_xyzw", "attitude_xyzw"),
            ("twist_stamps_ns", "body_rates", "body_rate"),
        ):
            part = (seen[stamps] >= segment.start_ns) & (seen[stamps] < end)
            states = truth.at(seen[stamps][part] - segment.start_ns)
            difference = np.abs(seen[values][part] - getattr(states, field)).max(axis=1)
            opposite = np.abs(seen[values][part] + getattr(states, field)).max(axis=1)
            # a quaternion and its opposite are one rotation
            assert np.minimum(difference, opposite if field == "attitude_xyzw" else difference).max() < 1e-10


@both
def test_frames_and_zero_translation(runs: dict[str, Run], name: str) -> None:
    seen = runs[name].seen
    assert seen["frames"].tolist() == ["world", "base_link"]
    assert not seen["positions"].any()


@both
def test_signal_ends_it_with_status_0_and_silence(runs: dict[str, Run], name: str) -> None:
    run = runs[name]
    assert run.status == 0
    # a node that stalled says so
    assert without_lateness(run.complained) == []


@both
def test_bag_holds_what_was_published(runs: dict[str, Run], name: str) -> None:
    run = runs[name]
    recording = run.recording
    assert recording.pose_topic == f"/{name}/pose"
    assert recording.twist_topic == f"/{name}/twist"
    assert set(np.diff(recording.poses.stamps_ns).tolist()) == {PERIOD_NS}
    assert recording.expected_samples == len(recording.poses.stamps_ns)
    texts = [text for _, text in recording.scenario_texts]
    assert texts == run.seen["scenarios"].tolist()
    at = np.searchsorted(recording.poses.stamps_ns, run.seen["pose_stamps_ns"])
    assert np.array_equal(recording.poses.stamps_ns[at], run.seen["pose_stamps_ns"])
    assert np.array_equal(recording.poses.values[:, 3:][at], run.seen["attitudes_xyzw"])


@both
def test_check_accepts_the_bag(runs: dict[str, Run], name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert check(["--json", str(runs[name].bag)]) == 0
    assert json.loads(capsys.readouterr().out)


def test_stall_is_caught_up(runs: dict[str, Run]) -> None:
    """The node noticed a stall that came while the client was receiving; that no stamp is missing is tested above."""
    assert any(CATCHING_UP in line for line in runs["stalled"].complained)
