"""Message types as a bag describes them: names, definitions, and the quality of service of their publishers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Final

POSE_STAMPED: Final = "geometry_msgs/msg/PoseStamped"
TWIST_STAMPED: Final = "geometry_msgs/msg/TwistStamped"
BARE_TWIST: Final = "geometry_msgs/msg/Twist"
STRING: Final = "std_msgs/msg/String"
IMU: Final = "sensor_msgs/msg/Imu"
MAGNETIC_FIELD: Final = "sensor_msgs/msg/MagneticField"
POSE_WITH_COVARIANCE_STAMPED: Final = "geometry_msgs/msg/PoseWithCovarianceStamped"
VECTOR3_STAMPED: Final = "geometry_msgs/msg/Vector3Stamped"
# what only others write
QUATERNION_STAMPED: Final = "geometry_msgs/msg/QuaternionStamped"
ODOMETRY: Final = "nav_msgs/msg/Odometry"
TRANSFORM_STAMPED: Final = "geometry_msgs/msg/TransformStamped"
TF_MESSAGE: Final = "tf2_msgs/msg/TFMessage"

# Each definition as an MCAP schema wants it: fields only, and the types they are made of by name.
_FIELDS: Final = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/Pose": "Point position\nQuaternion orientation\n",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\nPose pose\n",
    "geometry_msgs/PoseWithCovariance": "Pose pose\nfloat64[36] covariance\n",
    "geometry_msgs/PoseWithCovarianceStamped": "std_msgs/Header header\nPoseWithCovariance pose\n",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    "geometry_msgs/Twist": "Vector3 linear\nVector3 angular\n",
    "geometry_msgs/TwistStamped": "std_msgs/Header header\nTwist twist\n",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/Vector3Stamped": "std_msgs/Header header\nVector3 vector\n",
    "sensor_msgs/Imu": (
        "std_msgs/Header header\n"
        "geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
        "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
        "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"
    ),
    "sensor_msgs/MagneticField": (
        "std_msgs/Header header\ngeometry_msgs/Vector3 magnetic_field\nfloat64[9] magnetic_field_covariance\n"
    ),
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "std_msgs/String": "string data\n",
}
_NUMBER: Final = "float64"
"""Type of the numbers of messages, perhaps with a length in brackets behind it."""


def definition(message_type: str) -> str:
    """The ``ros2msg`` text of a message type, followed by the types it is made of.

    Parameters
    ----------
    message_type : str
        One of the names of this module.

    Returns
    -------
    str
    """
    name = message_type.replace("/msg/", "/")
    return _FIELDS[name] + "".join(f"{'=' * 80}\nMSG: {part}\n{_FIELDS[part]}" for part in _parts(name))


def _parts(name: str) -> dict[str, None]:
    """Names of the types that a type is made of, each once and before its own parts."""
    found = dict[str, None]()
    for kind, _ in _fields(name):
        if kind in _FIELDS:
            found |= {kind: None, **_parts(kind)}
    return found


def _fields(name: str) -> Iterator[tuple[str, str]]:
    """Types, with their packages but for numbers and texts, and names of the fields of a type."""
    for line in _FIELDS.get(name, "").splitlines():
        kind, field, *_ = line.split()
        yield f"{name.partition('/')[0]}/{kind}" if kind[0].isupper() else kind, field


@lru_cache(maxsize=64)
def places(message_type: str) -> Mapping[str, range]:
    """Places of each field's float64 numbers among all float64 numbers of a message, by names with dots between them.

    Parameters
    ----------
    message_type : str
        One of the names of this module.

    Returns
    -------
    mapping of str to range
        The empty name has all places.
    """
    found = dict[str, range]()

    def add(kind: str, name: str, first: int) -> int:
        end = first
        if kind.startswith(_NUMBER):
            end += int(kind.removeprefix(_NUMBER).strip("[]") or 1)
        for part, field in _fields(kind):
            end = add(part, f"{name}.{field}".lstrip("."), end)
        found[name] = range(first, end)
        return end

    add(message_type.replace("/msg/", "/"), "", 0)
    return found


def offered_qos_profiles(*, latched: bool, depth: int) -> str:
    """Channel metadata from which ``ros2 bag play`` takes its quality of service: a YAML list with one profile.

    Parameters
    ----------
    latched : bool
        Whether late subscribers get the last message: transient local, else volatile.
    depth : int
        Depth of the history.

    Returns
    -------
    str
    """
    forever = "{sec: 9223372036, nsec: 854775807}"
    return (
        "- history: keep_last\n"
        f"  depth: {depth}\n"
        "  reliability: reliable\n"
        f"  durability: {'transient_local' if latched else 'volatile'}\n"
        f"  deadline: {forever}\n"
        f"  lifespan: {forever}\n"
        "  liveliness: automatic\n"
        f"  liveliness_lease_duration: {forever}\n"
        "  avoid_ros_namespace_conventions: false"
    )
