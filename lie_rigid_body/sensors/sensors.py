"""The sensors of a scenario: which there are, and what they are like."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, cast

from lie_rigid_body.errors import ParameterError
from lie_rigid_body.parameters import Value, read_table, require_frame_name
from lie_rigid_body.sensors.imu import ImuModel
from lie_rigid_body.sensors.magnetometer import MagnetometerModel
from lie_rigid_body.sensors.sensor_parameters import SENSOR_PARAMETERS

SLOWEST_RATE: Final = 1e-6


@dataclass(frozen=True)
class Sensors:
    """The sensors on the body. Build it with `from_parameters`, which validates.

    Parameters
    ----------
    imu : ImuModel or None
    magnetometer : MagnetometerModel or None
        None: there is none.
    """

    imu: ImuModel | None
    magnetometer: MagnetometerModel | None

    @classmethod
    def from_parameters(cls, given: Mapping[str, object] | None = None) -> Sensors:
        """The sensors of the given parameters, the rest at their defaults, validated as a whole.

        Parameters
        ----------
        given : mapping of str to object, optional
            Values of ``SENSOR_PARAMETERS``, as a YAML file or a ROS parameter gives them.

        Returns
        -------
        Sensors

        Raises
        ------
        ParameterError
            Naming the parameter, its value, its limit and the remedy; also for a sensor that is off.
        """
        values = read_table(SENSOR_PARAMETERS, given or {})
        require_frame_name("imu_frame", cast(str, values["imu_frame"]))
        imu, magnetometer = ImuModel.from_values(values), MagnetometerModel.from_values(values)
        return cls(
            imu if _is_on("imu_rate", values) else None,
            magnetometer if _is_on("magnetometer_rate", values) else None,
        )


def _is_on(name: str, values: Mapping[str, Value]) -> bool:
    rate = cast(float, values[name])
    if 0.0 < rate < SLOWEST_RATE:
        raise ParameterError(name, f"{rate:g} is below {SLOWEST_RATE:g} samples per second: give more, or 0 for none")
    return rate > 0.0
