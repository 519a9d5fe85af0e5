"""What a run of a campaign costs, beside the `mcap` library's writer alone on the same messages.

    python benchmarks/campaign.py             # 20 runs of 60 s at 100 Hz with an IMU

A run is simulated, recorded and certified in this process, as a worker does it. Its cost is the processor time of all
threads, the median of the runs; compiling is over before. To the library only its own time is charged.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.run import BAGS, carry_out
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.motion.moser_veselov.loop import LOOP
from lie_rigid_body.simulation import Simulation
from recording import PlainBag, Spent, run

DURATION = 60
VARY = {
    "initial_attitude_xyzw": {"distribution": "uniform_rotation"},
    "initial_body_rate": {"distribution": "direction", "norm": [0.01, 0.5]},
    "inertia": {"distribution": "box", "mass": 8.0, "edges": [[0.1, 0.3], [0.1, 0.3], [0.1, 0.4]]},
    "gyro_noise_density": {"distribution": "loguniform", "low": 1e-5, "high": 1e-3},
    "sensor_seed": {"distribution": "run"},
}


def costs(campaign: Campaign, number: int, folder: Path) -> tuple[float, float]:
    """Processor times of a run of the campaign, and of the library's writer, s."""
    ours = Spent()
    with ours:
        carry_out(campaign, number, str(folder))
    scenario, plain = campaign.scenario_of(number), PlainBag(folder / "plain.mcap")
    simulation = Simulation(scenario)
    last_ns = simulation.clock.last_ns_before(campaign.exact_duration)
    run(simulation, last_ns, plain.write, BatchEncoder(scenario))
    plain.finish()
    return ours.cpu, plain.spent.cpu


def main() -> None:
    """Print the costs and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=20)
    given = parser.parse_args()
    LOOP.compile()
    campaign = Campaign(given.runs, 7, DURATION, "tumbling_cubesat", {"rate": 100.0, "imu_rate": 100.0}, VARY)
    with TemporaryDirectory() as folder:
        Path(folder, BAGS).mkdir()
        ours, plain = map(median, zip(*(costs(campaign, i, Path(folder)) for i in range(given.runs)), strict=True))
    print(f"a run {ours:.3f} s, the library's writer alone {plain:.3f} s of processor time: {ours / plain:.2f}")


if __name__ == "__main__":
    main()
