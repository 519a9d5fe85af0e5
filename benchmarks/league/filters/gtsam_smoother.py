"""A smoother of gtsam: a gyro preintegrated between ten attitudes a second, gravity and field there, slow biases."""

from __future__ import annotations

import gtsam
import numpy as np
from gtsam.symbol_shorthand import B, R
from scipy.spatial.transform import Rotation

from league.contender import Filter
from league.readings import UP, Readings

SPAN = 10
"""Readings from one attitude to the next."""
BIAS_SPAN = 10
"""Attitudes that share a bias."""


def estimate(given: Readings, gyro: float = 1e-3, bias: float = 1e-4, vectors: float = 0.02) -> Rotation:
    """Noise of gyro (rad/s/√Hz), of a bias from one second to the next (rad/s), and of both directions (rad)."""
    parameters = gtsam.PreintegratedRotationParams()
    parameters.setGyroscopeCovariance(np.eye(3) * gyro**2)
    direction = gtsam.noiseModel.Isotropic.Sigma(2, vectors)
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    nodes = range(0, len(given.t_ns), SPAN)
    begin = gtsam.Rot3(given.first_attitude.as_matrix())
    for i, k in enumerate(nodes):
        for reference, reading in ((UP, given.acc[k]), (given.field, given.mag[k])):
            graph.add(gtsam.AttitudeFactorRot3(R(i), gtsam.Unit3(reference), direction, gtsam.Unit3(reading)))
        if i % BIAS_SPAN == 0:
            values.insert(B(i // BIAS_SPAN), np.zeros(3))
            if i:
                wander = gtsam.noiseModel.Isotropic.Sigma(3, bias)
                graph.add(gtsam.BetweenFactorVector(B(i // BIAS_SPAN - 1), B(i // BIAS_SPAN), np.zeros(3), wander))
        if i:
            integral = gtsam.PreintegratedAhrsMeasurements(parameters, np.zeros(3))
            for reading in given.gyro[k - SPAN + 1 : k + 1]:
                integral.integrateMeasurement(reading, given.dt)
            graph.add(gtsam.AHRSFactor(R(i - 1), R(i), B((i - 1) // BIAS_SPAN), integral))
            begin = begin.compose(integral.deltaRij())
        values.insert(R(i), begin)
    found = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    out = []
    for k in range(len(given.t_ns)):
        i = k // SPAN
        if k % SPAN == 0:
            attitude = Rotation.from_matrix(found.atRot3(R(i)).matrix())
        else:
            drift = found.atVector(B(i // BIAS_SPAN))
            attitude = attitude * Rotation.from_rotvec((given.gyro[k] - drift) * given.dt)
        out.append(attitude.as_quat())
    return Rotation.from_quat(out)


GRID = {"gyro": (1e-3, 1e-2), "bias": (1e-4,), "vectors": (0.02, 0.1, 0.5)}
FILTERS = (Filter("gtsam", "AHRSFactor (batch)", estimate, GRID, sees_future=True, advice="wired to a graph here"),)
