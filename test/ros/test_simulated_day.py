"""A day of simulated time, as fast as the machine goes, is still the truth: every sample is there, and certified."""

from __future__ import annotations

import signal
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from simulator_process import SimulatorProcess

from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import read_bag

if find_spec("rclpy"):
    from diagnostic_msgs.msg import DiagnosticArray
    from peer import Peer

pytestmark = pytest.mark.slow

DAY_S = 86_400
RATE = 10
LONGEST_DAY_S = 1200.0
SLOW = "initial_body_rate:=[0.002, 0.003, 0.01]"
"""rad/s: what is turned in a step of 0.1 s to the power 5 is well below 1e-7 rad after all steps of a day."""


@pytest.mark.ros
def test_a_day_at_real_time_factor_0_is_certified(tmp_path: Path, peer: Peer) -> None:
    bag = tmp_path / "day.mcap"
    values = {"real_time_factor": 0.0, "rate": float(RATE), "motion": "closed_form", "record_path": bag, "epoch_ns": 1}
    reports = peer.listen(DiagnosticArray, "/diagnostics")
    with SimulatorProcess(*[part for n, v in values.items() for part in ("-p", f"{n}:={v}")]) as simulator:
        peer.spin_until(lambda: reports and samples_sent(reports[-1]) > DAY_S * RATE, "a day", LONGEST_DAY_S)
        assert simulator.end(signal.SIGINT) == 0
    stamps = read_bag(bag).poses.stamps_ns
    assert stamps[0] == 1
    assert stamps[-1] > DAY_S * 10**9
    assert set(np.diff(stamps).tolist()) == {10**9 // RATE}
    certificate = certify(read_bag(bag))
    assert certificate.messages == ()
    assert certificate.attitude_accuracy < 1e-13


def samples_sent(report: DiagnosticArray) -> int:
    return int(next(pair.value for pair in report.status[0].values if pair.key == "samples sent"))


@pytest.mark.parametrize(
    "motion", [["motion:=closed_form"], ["max_step:=0.1", SLOW]], ids=["closed_form", "moving_chart"]
)
def test_a_day_recorded_headless_is_certified(tmp_path: Path, motion: tuple[str, ...]) -> None:
    bag = tmp_path / "day.mcap"
    assignments = [part for value in (f"rate:={RATE}.0", *motion) for part in ("-p", value)]
    record = ["record", str(bag), "--duration", str(DAY_S), *assignments]
    for arguments in (record, ["check", str(bag)]):
        run = subprocess.run([sys.executable, "-m", "lie_rigid_body", *arguments], capture_output=True, text=True)
        assert run.returncode == 0, run.stdout + run.stderr
    assert f"{DAY_S * RATE} samples" in run.stdout
    assert "CERTIFIED" in run.stdout
