"""A complementary filter of attitude and gyro bias.

R. Mahony, T. Hamel, J.-M. Pflimlin, IEEE Transactions on Automatic Control 53 (2008) 1203.
"""

import numpy as np
from scipy.spatial.transform import Rotation

UP = np.array([0.0, 0.0, 1.0])


class ComplementaryFilter:
    """The filter, reading by reading; the field of the world is known, in T."""

    def __init__(self, world_field, gain=1.0, bias_gain=0.1):
        self.north = np.asarray(world_field) / np.linalg.norm(world_field)
        self.gain, self.bias_gain = gain, bias_gain
        self.attitude, self.bias, self.t_ns = None, np.zeros(3), 0

    def update(self, t_ns, gyro, specific_force, field):
        """World-from-body quaternion, x y z w, after a reading at a stamp, ns: rad/s, m/s² and T on the body's axes."""
        up_seen, north_seen = specific_force / np.linalg.norm(specific_force), field / np.linalg.norm(field)
        if self.attitude is None:
            self.attitude, _ = Rotation.align_vectors([UP, self.north], [up_seen, north_seen])
        else:
            dt = (t_ns - self.t_ns) / 1e9
            # a reading of the gyro is the mean rate over the step that ends with it
            self.attitude = self.attitude * Rotation.from_rotvec((gyro - self.bias) * dt)
            up, north = self.attitude.inv().apply([UP, self.north])
            error = np.cross(up_seen, up) + np.cross(north_seen, north)
            self.attitude = self.attitude * Rotation.from_rotvec(self.gain * dt * error)
            self.bias = self.bias - self.bias_gain * dt * error
        self.t_ns = t_ns
        return self.attitude.as_quat()


def estimate(t_ns, gyro, specific_force, field, world_field):
    """World-from-body quaternions, one a reading."""
    found = ComplementaryFilter(world_field)
    return np.array([found.update(*reading) for reading in zip(t_ns, gyro, specific_force, field, strict=True)])
