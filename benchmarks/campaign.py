"""What a run of a campaign costs, beside the `mcap` library's writer alone on the same messages.

    python benchmarks/campaign.py                      # runs of a minute, ten minutes, an hour at 100 Hz with an IMU
    python benchmarks/campaign.py --longest 60
    python benchmarks/campaign.py --save               # also writes the table of docs/reference/costs.md

A run is simulated, recorded and certified in a process of its own, as a worker does it. Its cost is the processor time
of all threads, the median of some runs; compiling is over before. To the library only its own time is charged. The
last line but one is the whole command on its workers, rows and table included: what more runs cost more. The
last is the same with two compiled filters that are compared.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, Final

from bag_tasks import HOUR, MINUTE, Spent, alone, arguments, tell, write_plainly
from checking import compile_loops
from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.run import BAGS, carry_out

SAMPLED: Final = {"rate": 100.0, "imu_rate": 100.0}
VARY: Final = {
    "initial_attitude_xyzw": {"distribution": "uniform_rotation"},
    "initial_body_rate": {"distribution": "direction", "norm": [0.01, 0.5]},
    "inertia": {"distribution": "box", "mass": 8.0, "edges": [[0.1, 0.3], [0.1, 0.3], [0.1, 0.4]]},
    "gyro_noise_density": {"distribution": "loguniform", "low": 1e-5, "high": 1e-3},
    "sensor_seed": {"distribution": "run"},
}
RUNS: Final = {MINUTE: 21, 10 * MINUTE: 5, HOUR: 3}
"""Of each length, s, of which the median counts."""
ESTIMATORS: Final = {
    f"gain {gain}": {"function": "compiled_filter:estimate", "parameters": {"gain": gain}} for gain in (0.1, 0.5)
}
FEW, MANY = 10, 70
"""Runs of the whole command."""


def definition(runs: int, duration: int) -> dict[str, Any]:
    """A campaign as its file says it."""
    base = {"scenario": "tumbling_cubesat", "parameters": SAMPLED, "vary": VARY}
    return {"runs": runs, "seed": 7, "duration": float(duration), **base}


def costs(duration: int) -> tuple[float, float]:
    """Processor times of a run, and of the library's writer on its messages, s."""
    compile_loops()
    campaign = Campaign(**definition(RUNS[duration], duration))
    with TemporaryDirectory() as folder:
        Path(folder, BAGS).mkdir()
        both = [_costs(campaign, run, Path(folder)) for run in range(campaign.runs)]
    ours, plain = zip(*both, strict=True)
    return median(ours), median(plain)


def _costs(campaign: Campaign, number: int, folder: Path) -> tuple[float, float]:
    with Spent() as ours:
        carry_out(campaign, number, folder, keep=True)
    plain = write_plainly(campaign.scenario_of(number), round(campaign.duration * 1e9) - 1, folder / "plain.mcap")
    return ours.cpu, plain.spent.cpu


def whole_command(runs: int, estimators: dict[str, Any]) -> float:
    """Processor time of the command with so many runs of a minute, of all its processes, s."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "campaign.yaml")
        path.write_text(json.dumps({**definition(runs, MINUTE), **estimators}), encoding="utf-8")  # JSON is YAML
        command = [sys.executable, "-m", "lie_rigid_body", "campaign", str(path), "--out", str(Path(folder, "out"))]
        before = os.times()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=Path(__file__).parent)
        after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main() -> None:
    """Print the costs and their ratio."""
    given = arguments(__doc__, longest=HOUR)
    compile_loops()
    lines = [("a run of", "processor time", "memory")]
    names = {MINUTE: "a minute", 10 * MINUTE: "ten minutes", HOUR: "an hour"}
    of_minute = 0.0
    for duration in (length for length in RUNS if length <= given.longest):
        (ours, plain), memory = alone(costs, duration)
        of_minute = of_minute or plain
        print(f"{names[duration]}: {ours:.3f} s, the library's writer alone {plain:.3f} s", flush=True)
        lines.append((names[duration], f"{ours / plain:.2f}", f"{memory:.0f} MiB"))
    for estimators, name in (({}, ""), ({"estimators": ESTIMATORS}, ", two filters compared")):
        whole = (whole_command(MANY, estimators) - whole_command(FEW, estimators)) / (MANY - FEW)
        print(f"a minute, by the whole command{name}: {whole:.3f} s", flush=True)
        lines.append((f"a minute, by the whole command{name}", f"{whole / of_minute:.2f}", ""))
    tell("campaign", lines, save=given.save)


if __name__ == "__main__":
    main()
