"""What a filter is given: readings on even times, in SI units, on the body's axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from lie_rigid_body import Run

Array = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])
FRD = np.diag([1.0, -1.0, -1.0])
"""Turns a body whose z points up into one whose z points down, and back."""


@dataclass(frozen=True)
class Readings:
    """Readings of N instants.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (N,)
        Even stamps, ns.
    rate : float
        Readings a second.
    gyro : ndarray, shape (N, 3)
        Body rate, rad/s.
    acc : ndarray, shape (N, 3)
        Specific force, m/s²: +g along the vertical at rest.
    mag : ndarray, shape (N, 3)
        Magnetic field, T.
    field : ndarray, shape (3,)
        Magnetic field in the world (east, north, up), T: a map tells it.
    """

    t_ns: NDArray[np.int64]
    rate: float
    gyro: Array
    acc: Array
    mag: Array
    field: Array

    @classmethod
    def of(cls, run: Run) -> Readings:
        """Those of a run. Where a reading is missing the one before it stands, as in any loop that runs at a rate."""
        if "imu" not in run.sensors or run.magnetometer is None:
            raise ValueError("a filter of the league needs an IMU and a magnetometer")
        rate = float(str(run.scenario.parameters()["imu_rate"]))
        first, last = run.imu.t_ns[0], run.imu.t_ns[-1]
        t_ns = first + np.round(np.arange(round((last - first) * rate / 1e9) + 1) * (1e9 / rate)).astype(np.int64)
        imu, field = (held(stamps, t_ns, rate) for stamps in (run.imu.t_ns, run.magnetometer.t_ns))
        return cls(
            t_ns,
            rate,
            run.imu.gyro[imu],
            run.imu.specific_force[imu],
            run.magnetometer.field[field],
            np.array(run.scenario.parameters()["magnetic_field"]),
        )

    @property
    def dt(self) -> float:
        """Time between two readings, s."""
        return 1.0 / self.rate

    @property
    def first_attitude(self) -> Rotation:
        """What the first readings of gravity and field tell."""
        return self.attitude_of(0)

    def attitude_of(self, k: int) -> Rotation:
        """What one pair of readings tells: the vertical by gravity, the azimuth by the field."""
        return triad(UP, self.field) * triad(self.acc[k], self.mag[k]).inv()

    @property
    def magnetic_north(self) -> float:
        """Angle from the world's y to the horizontal field, against the clock, rad."""
        return float(np.arctan2(-self.field[0], self.field[1]))


def triad(first: Array, second: Array) -> Rotation:
    """The axes that two directions span: x along the first, y across both."""
    across = np.cross(first, second)
    axes = [first, across, np.cross(first, across)]
    return Rotation.from_matrix(np.transpose([axis / np.linalg.norm(axis) for axis in axes]))


def held(stamps: NDArray[np.int64], t_ns: NDArray[np.int64], rate: float) -> NDArray[np.intp]:
    """The reading that stands at each instant: the last one, at most half a period later."""
    return np.maximum(np.searchsorted(stamps, t_ns + int(0.5e9 / rate), side="right") - 1, 0)


def attitudes(quaternions: ArrayLike, *, scalar_first: bool = True) -> Rotation:
    """The rotations of N quaternions, as libraries write them."""
    q = np.asarray(quaternions, dtype=float)
    return Rotation.from_quat(np.roll(q, -1, axis=1) if scalar_first else q)


def magnetic_enu(given: Readings, rotation: Rotation) -> Rotation:
    """To the world, from earth axes whose y is magnetic north and whose z points up."""
    return Rotation.from_rotvec([0.0, 0.0, given.magnetic_north]) * rotation


def magnetic_nwu(given: Readings, rotation: Rotation) -> Rotation:
    """To the world, from earth axes whose x is magnetic north and whose z points up."""
    return Rotation.from_rotvec([0.0, 0.0, given.magnetic_north + np.pi / 2]) * rotation


def magnetic_ned(given: Readings, rotation: Rotation) -> Rotation:
    """To the world, from earth axes whose x is magnetic north and whose z points down."""
    return magnetic_nwu(given, Rotation.from_matrix(FRD) * rotation)
