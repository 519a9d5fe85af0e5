"""Runs what works without ROS in this process: ``python every_verb.py FOLDER`` leaves in the folder what it gave.

Verbs that are named behind the folder are left out.

What the verbs print is in files as well, in the characters of a console of Windows, which has no ≤ and no √.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

RUN = ["--scenario", "tumbling_cubesat", "--duration", "4", "-p", "imu_rate:=50.0", "-p", "magnetometer_rate:=20.0"]
SENSORS = ["-p", "sensor_grade:=mems", "-p", "sensor_seed:=3"]
CAMPAIGN = """
runs: 3
seed: 7
duration: 0.25
scenario: tumbling_cubesat
parameters: {rate: 100.0, imu_rate: 100.0}
vary: {sensor_seed: {distribution: run}, initial_attitude_xyzw: {distribution: uniform_rotation}}
"""
VERBS: dict[str, tuple[list[str], int]] = {
    "record": (["record", "run.mcap", *RUN, *SENSORS, "--chunk-size", "4096"], 0),
    "again": (["record", "run.mcap", *RUN, *SENSORS, "--chunk-size", "4096", "--force"], 0),
    "kept": (["record", "run.mcap", *RUN], 2),
    "other": (["record", "other.mcap", "-p", "motion:=closed_form", "--duration", "2"], 0),
    "check": (["check", "run.mcap"], 0),
    "several": (["check", "run.mcap", "other.mcap", "--json"], 0),
    "a_folder": (["record", "none.mcap", "--params-file", ".", "--duration", "1"], 2),
    "plot": (["plot", "run.mcap", "-o", "run.png"], 0),
    "evaluate": (["evaluate", "run.mcap", "--estimate", "/pose", "--json"], 0),
    "recover": (["recover", "cut.mcap", "-o", "rescued.mcap"], 0),
    "explain": (["explain", "--scenario", "dzhanibekov"], 0),
    "scenarios": (["scenarios"], 0),
    "campaign": (["campaign", "campaign.yaml", "--out", "campaign", "--workers", "1"], 0),
}


def main(folder: Path, *left_out: str) -> None:
    from lie_rigid_body import MovingChart, RigidBody, State, simulate
    from lie_rigid_body.__main__ import main as verb
    from lie_rigid_body.system.interruption import Interruption

    os.chdir(folder)
    Path("campaign.yaml").write_text(CAMPAIGN, encoding="utf-8")
    for name, (arguments, expected) in VERBS.items():
        if name in left_out:
            continue
        if name == "recover":
            Path("cut.mcap").write_bytes(Path("run.mcap").read_bytes()[:-9000])
        with printed_in(Path(f"{name}.txt")):
            status = verb(arguments)
        if status != expected:
            raise SystemExit(f"{name}: status {status}\n" + Path(f"{name}.txt").read_text(encoding="cp1252"))
    run = simulate("tumbling_cubesat", duration=1.0, imu_rate=10.0, sensor_grade="mems")
    arrays = {"attitude": run.truth.attitude_xyzw, "gyro": run.imu.gyro, "force": run.imu.specific_force}
    Path("arrays.json").write_text(json.dumps({name: array.tolist() for name, array in arrays.items()}))
    with Interruption.heeded(to_the_end=False) as interruption:
        try:
            with interruption.allowed():
                signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            Path("interrupted").touch()
    if "compile" not in left_out:
        Path("compiled").write_text(str(MovingChart(RigidBody([1, 2, 3]), State([0, 0, 0, 1], [0, 1, 0])).compile()))


@contextmanager
def printed_in(path: Path) -> Iterator[None]:
    """A context whose standard streams are a file."""
    own = sys.stdout, sys.stderr
    with path.open("w", encoding="cp1252") as file:
        sys.stdout = sys.stderr = file
        try:
            yield
        finally:
            sys.stdout, sys.stderr = own


if __name__ == "__main__":  # it is imported by each process that is spawned
    main(Path(sys.argv[1]), *sys.argv[2:])
