"""Whether bags have the bytes that they had before a change, with numba and without.

    python benchmarks/same_bytes.py --save before.json     # in a clone without the change
    python benchmarks/same_bytes.py before.json            # in one with it: status 1 and the names of those that differ

Each scenario of config/ is recorded as it is, with every sensor of the grade mems, and with every fault; each stepper
once; and runs that are long enough for compiled loops. Bags are not compressed, so that only this package decides their
bytes. Hashes are compared on one machine: the noise takes logarithms of the C library.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

SECONDS: Final = 20
LONG: Final = ("-p", "rate:=1000.0", "--duration", "240")
SENSORS: Final = (
    "imu_rate:=100.0",
    "imu_orientation:=true",
    "imu_heading_noise:=0.01",
    "gyro_rate:=integrated",
    "accelerometer_mode:=pivot_gravity",
    "magnetometer_rate:=50.0",
    "attitude_sensor_rate:=5.0",
    "attitude_sensor_roll_noise:=0.001",
    "sun_sensor_rate:=10.0",
    "sun_sensor_noise:=0.001",
    "sensor_grade:=mems",
)
FAULTS: Final = (
    "imu_dropout_probability:=0.01",
    "imu_latency:=0.02",
    "imu_latency_jitter:=0.03",
    "imu_clock_skew:=0.001",
    "gyro_spike_probability:=0.01",
    "gyro_spike_size:=0.5",
    "gyro_noise_burst_interval:=5.0",
    "gyro_noise_burst_duration:=1.0",
    "gyro_noise_burst_density:=0.01",
    "gyro_temperature_drift:=0.01",
    "gyro_temperature_drift_duration:=10.0",
    "accelerometer_stuck_interval:=4.0",
    "accelerometer_stuck_duration:=1.0",
    "accelerometer_saturation_interval:=6.0",
    "accelerometer_saturation_duration:=1.0",
    "accelerometer_saturation_level:=4.0",
    "magnetometer_outage_interval:=5.0",
    "magnetometer_outage_duration:=1.0",
    "magnetic_disturbance_interval:=7.0",
    "magnetic_disturbance_duration:=2.0",
    "magnetic_disturbance_size:=1.0e-5",
    "attitude_sensor_clock_offset:=0.3",
    "sun_sensor_dropout_probability:=0.1",
)


def runs() -> Iterator[tuple[str, list[str]]]:
    """Each run's name, and the arguments of `record` that make it."""
    from lie_rigid_body.motion.moving_chart import METHODS

    sensors, faults = ([word for name in names for word in ("-p", name)] for names in (SENSORS, FAULTS))
    short = ["--duration", str(SECONDS)]
    for path in sorted(Path(__file__).resolve().parent.parent.joinpath("config").glob("*.yaml")):
        scenario = ["--scenario", path.stem]
        yield path.stem, [*scenario, *short]
        yield f"{path.stem}, sensors", [*scenario, *sensors, *short]
        yield f"{path.stem}, faults", [*scenario, *sensors, *faults, *short]
    for method in METHODS:
        few_steps = "max_step:=0.01" if method == "rkmk1" else "max_step:=0.002"
        yield method, ["-p", f"method:={method}", "-p", few_steps, *sensors, *short]
    yield "long", [*LONG]
    yield "long, closed form", ["-p", "motion:=closed_form", *LONG]
    yield "long, faults", ["-p", "motion:=closed_form", *sensors, *faults, *LONG]


def hashes() -> dict[str, str]:
    """SHA-256 of every bag, by the run's name."""
    from lie_rigid_body.cli.record import main as record

    found = {}
    with TemporaryDirectory() as folder:
        path = Path(folder, "bag.mcap")
        for name, arguments in runs():
            status = record([str(path), "--quiet", "--force", "--compression", "none", *arguments])
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest() if status == 0 else f"status {status}"
    return found


def of_a_process(*, compiled: bool) -> dict[str, str]:
    """The hashes that a process with numba finds, or one without."""
    code = "" if compiled else "import sys; sys.modules['numba'] = None; "
    code += "import json, same_bytes; print(json.dumps(same_bytes.hashes()))"
    folder = Path(__file__).resolve().parent
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, check=True, stdout=subprocess.PIPE)
    found: dict[str, str] = json.loads(done.stdout)
    return found


def main() -> int:
    """Write the hashes to a file, or compare them with those of one."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("before", nargs="?", type=Path, help="hashes to compare with")
    parser.add_argument("--save", type=Path, help="file to write the hashes to")
    given = parser.parse_args()
    found = {f"{name} ({how})": digest for how in ("numba", "plain") for name, digest in _of(how).items()}
    if given.save:
        given.save.write_text(json.dumps(found, indent=1) + "\n")
    differ = [name for name, digest in found.items() if digest != found[name.replace("(plain)", "(numba)")]]
    if given.before:
        before = json.loads(given.before.read_text())
        differ += [name for name in {**before, **found} if before.get(name) != found.get(name)]
    print(f"{len(found)} bags; other bytes: {', '.join(dict.fromkeys(differ)) or 'none'}")
    return 1 if differ else 0


def _of(how: str) -> dict[str, str]:
    return of_a_process(compiled=how == "numba")


if __name__ == "__main__":
    sys.exit(main())
