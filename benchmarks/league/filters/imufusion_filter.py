"""The AHRS of imufusion (x-io): degrees, units of g; earth axes east, north (magnetic), up."""

from __future__ import annotations

import imufusion
import numpy as np
from scipy.spatial.transform import Rotation

from league.contender import Filter
from league.readings import Readings, attitudes, magnetic_enu


def estimate(given: Readings, **settings: float) -> Rotation:
    """Reading by reading."""
    ahrs = imufusion.Ahrs()
    chosen = imufusion.AhrsSettings()
    chosen.sample_rate, chosen.convention = given.rate, imufusion.CONVENTION_ENU
    for name, value in settings.items():
        setattr(chosen, name, value)
    ahrs.set_settings(chosen)
    readings = zip(np.degrees(given.gyro), given.acc / 9.80665, given.mag * 1e6, strict=True)
    return magnetic_enu(given, attitudes([ahrs.update(*reading).get_quaternion() for reading in readings]))


FILTERS = (
    Filter(
        "imufusion",
        "Ahrs",
        estimate,
        {
            "gain": (0.1, 0.5, 1.0),
            "acceleration_rejection": (0.0, 10.0, 20.0),
            "magnetic_rejection": (0.0, 10.0, 20.0),
            "rejection_timeout": (1.0, 5.0),
        },
        advice="its `Bias`, which corrects the gyro at rest, is a class of its own and is not used here",
    ),
)
