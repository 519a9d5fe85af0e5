"""Close the loop with estimators from elsewhere: Madgwick, Mahony and the EKF of ``ahrs`` on a recorded bag.

Nothing of lie_rigid_body is imported here. The bag is read by ``mcap_ros2``, the attitude is estimated by ``ahrs``, and
the angle to the recorded truth is measured by ``scipy``. Conventions, and those of ``ahrs``:
docs/explanation/three_estimators.md.

    python examples/estimators.py            # records a bag without errors of the sensors and one with, and uses both
    python examples/estimators.py run.mcap   # uses a bag with /pose, /imu/data_raw and /imu/mag of one rate
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
from ahrs.filters import EKF, Madgwick, Mahony
from mcap_ros2.reader import read_ros2_messages
from scipy.spatial.transform import Rotation

Array = np.ndarray

DURATION_S = 45
CONVERGED_S = 30.0
COLUMNS = ("first", "RMS", "largest", "final", "one later", "inverse")
FIRST_GUESS = Rotation.from_rotvec(np.radians(20.0) * np.array([2.0, -1.0, 2.0]) / 3.0)

# A slow tumble, for the filters take each accelerometer reading for the direction of gravity.
MOTION = {
    "initial_attitude_xyzw": [0.1, -0.2, 0.3, 0.9273618495495704],
    "initial_body_rate": [0.2, 0.3, -0.15],
    "motion": "closed_form",
    "rate": 50.0,
    "imu_rate": 50.0,
    "magnetometer_rate": 50.0,
    "gyro_rate": "integrated",
    "accelerometer_mode": "pivot_gravity",
}
# What data sheets of consumer IMUs give; the turn-on biases are what is left after a calibration.
MEMS = {
    "sensor_seed": 1,
    "gyro_noise_density": 1.7e-4,
    "gyro_bias_random_walk": 2e-5,
    "gyro_turn_on_bias": 3e-3,
    "accelerometer_noise_density": 3e-3,
    "accelerometer_bias_random_walk": 1e-4,
    "accelerometer_turn_on_bias": 3e-2,
    "magnetometer_noise_density": 6e-8,
}


@dataclass(frozen=True)
class Readings:
    """A bag as arrays of N samples.

    ``truth`` takes body vectors to world vectors. ``gyro`` (rad/s), ``specific_force`` (m/s², +g along the vertical at
    rest) and ``magnetic`` (T) are on the body's axes, ``field`` (T) on the world's, whose z points up.
    """

    t_s: Array
    truth: Rotation
    gyro: Array
    specific_force: Array
    magnetic: Array
    field: Array


def fail(message: str) -> NoReturn:
    """End with one line and status 2."""
    print(f"estimators.py: error: {message}"[:200], file=sys.stderr)
    sys.exit(2)


def record(path: Path, **parameters: object) -> None:
    """Record a bag, headless."""
    assignments = [f"-p{name}:={value}" for name, value in parameters.items()]
    command = [sys.executable, "-m", "lie_rigid_body", "record", str(path), f"--duration={DURATION_S}", "--quiet"]
    if subprocess.run([*command, *assignments], check=False).returncode:
        fail(f"{path} was not recorded")


def read(path: Path) -> Readings:
    """The readings in a bag."""
    topics = ["/lie_rigid_body/scenario", "/pose", "/imu/data_raw", "/imu/mag"]
    messages: dict[str, list] = {topic: [] for topic in topics}
    try:
        for message in read_ros2_messages(path, topics=topics):
            messages[message.channel.topic].append(message.ros_msg)
    except Exception as error:  # the library fails in many ways on what is no bag
        fail(f"{path} cannot be read: {error!r}: give a bag")
    scenarios, poses, imu, mag = messages.values()
    stamps = [[m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in track] for track in (poses, imu, mag)]
    if not (len(scenarios) == 1 and stamps[0] and stamps[0] == stamps[1] == stamps[2]):
        fail(f"{path}: one run with rate, imu_rate and magnetometer_rate alike is needed: record it so")
    if (stamps[0][-1] - stamps[0][0]) / 1e9 <= CONVERGED_S:
        fail(f"{path}: errors are counted from {CONVERGED_S:g} s on: record more")
    return Readings(
        (np.array(stamps[0]) - stamps[0][0]) / 1e9,
        Rotation.from_quat([[q.x, q.y, q.z, q.w] for q in (m.pose.orientation for m in poses)]),
        vectors(m.angular_velocity for m in imu),
        vectors(m.linear_acceleration for m in imu),
        vectors(m.magnetic_field for m in mag),
        np.array(json.loads(scenarios[0].data)["magnetic_field"]),
    )


def vectors(messages: Iterator) -> Array:
    """Of shape (N, 3)."""
    return np.array([[v.x, v.y, v.z] for v in messages])


def scalar_first(rotation: Rotation) -> Array:
    """The quaternion of `ahrs`."""
    return np.roll(rotation.as_quat(), 1)


def scalar_last(q_wxyz: Array) -> Rotation:
    """The rotation of a quaternion, or of N, of `ahrs`."""
    return Rotation.from_quat(np.roll(q_wxyz, -1, axis=-1))


def about_vertical(angle: float) -> Rotation:
    """A rotation about the world's z."""
    return Rotation.from_rotvec([0.0, 0.0, angle])


def madgwick(given: Readings, first: Rotation) -> Rotation:
    """Its earth has x along magnetic north and z up. Only step by step does it heed a first guess."""
    to_world = about_vertical(np.arctan2(given.field[1], given.field[0]))
    estimator = Madgwick(Dt=given.t_s[1], gain=0.041)
    q = [scalar_first(to_world.inv() * first)]
    for gyro, force, magnetic in zip(given.gyro[1:], given.specific_force[1:], given.magnetic[1:], strict=True):
        q.append(estimator.updateMARG(q[-1], gyro, force, magnetic))
    return to_world * scalar_last(np.array(q))


def mahony(given: Readings, first: Rotation) -> Rotation:
    """Its earth has y along magnetic north and z up."""
    to_world = about_vertical(np.arctan2(-given.field[0], given.field[1]))
    guess = scalar_first(to_world.inv() * first)
    estimate = Mahony(given.gyro, given.specific_force, given.magnetic, Dt=given.t_s[1], q0=guess)
    return to_world * scalar_last(estimate.Q)


def ekf(given: Readings, first: Rotation) -> Rotation:
    """In its frame ENU it expects the direction of gravity, against that of the specific force."""
    options = {"frame": "ENU", "magnetic_ref": given.field, "Dt": given.t_s[1], "q0": scalar_first(first)}
    return scalar_last(EKF(given.gyro, -given.specific_force, given.magnetic, **options).Q)


def gyro_alone(given: Readings, first: Rotation) -> Rotation:
    """The product of the exp(ω Δt), which with an integrated rate is the truth."""
    turns = Rotation.from_rotvec(given.gyro[1:] * np.diff(given.t_s)[:, np.newaxis])
    attitudes = [first]
    for turn in turns:
        attitudes.append(attitudes[-1] * turn)
    return Rotation.concatenate(attitudes)


def angles(one: Rotation, other: Rotation) -> Array:
    """Between rotations, deg."""
    return np.degrees((one.inv() * other).magnitude())


def rms(values: Array) -> float:
    """The root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def report(title: str, given: Readings) -> None:
    """Print the errors; also to the truth one sample later, and those of the inverse, as of a mistaken convention."""
    truth, late = given.truth, given.t_s >= CONVERGED_S
    runs = [
        ("gyro alone", gyro_alone(given, truth[0])),
        *((f.__name__, f(given, truth[0] * FIRST_GUESS)) for f in (madgwick, mahony, ekf)),
    ]
    print(f"{title}: angle to the truth, deg; RMS and largest from {CONVERGED_S:g} s on")
    print("".join(f"{heading:>12}" for heading in ("", *COLUMNS)))
    for name, estimate in runs:
        error, inverse = angles(truth, estimate), angles(truth, estimate.inv())
        later = angles(truth[1:], estimate[:-1])
        numbers = (error[0], rms(error[late]), error[late].max(), error[-1], rms(later[late[1:]]), rms(inverse[late]))
        print(f"{name:>12}" + "".join(f"{number:>12.2g}" for number in numbers))


def main() -> None:
    """Print a table for each bag."""
    print("Attitudes take body vectors to world vectors (x east, y north, z up), scalar last.")
    if len(sys.argv) > 1:
        report(sys.argv[1], read(Path(sys.argv[1])))
        return
    with tempfile.TemporaryDirectory() as folder:
        for title, errors in (("without sensor errors", {}), ("consumer MEMS", MEMS)):
            bag = Path(folder) / f"{title}.mcap"
            record(bag, **MOTION, **errors)
            report(title, read(bag))


if __name__ == "__main__":
    main()
