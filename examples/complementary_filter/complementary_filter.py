"""A complementary filter of attitude and gyro bias.

R. Mahony, T. Hamel, J.-M. Pflimlin, IEEE Transactions on Automatic Control 53 (2008) 1203.
"""

import numpy as np
from scipy.spatial.transform import Rotation

UP = np.array([0.0, 0.0, 1.0])


def estimate(t_ns, gyro, specific_force, field, world_field, gain=1.0, bias_gain=0.1):
    """World-from-body quaternions, x y z w, one a reading.

    Stamps are in ns, the readings in rad/s, m/s² and T on the body's axes; the field of the world is known, in T.
    """
    north = np.asarray(world_field) / np.linalg.norm(world_field)
    up_seen = specific_force / np.linalg.norm(specific_force, axis=1, keepdims=True)
    north_seen = field / np.linalg.norm(field, axis=1, keepdims=True)
    attitude, _ = Rotation.align_vectors([UP, north], [up_seen[0], north_seen[0]])
    bias, found = np.zeros(3), [attitude]
    for k, dt in enumerate(np.diff(t_ns) / 1e9, start=1):
        # a reading of the gyro is the mean rate over the step that ends with it
        attitude = attitude * Rotation.from_rotvec((gyro[k] - bias) * dt)
        up, north_expected = attitude.inv().apply([UP, north])
        error = np.cross(up_seen[k], up) + np.cross(north_seen[k], north_expected)
        attitude = attitude * Rotation.from_rotvec(gain * dt * error)
        bias = bias - bias_gain * dt * error
        found.append(attitude)
    return Rotation.concatenate(found).as_quat()
